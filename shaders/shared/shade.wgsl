// Light on a surface; src/render/cpu/shade.rs is its twin.

struct Lit {
    albedo: vec3<f32>,
    normal: vec3<f32>,
    open: f32,
    sunlit: f32,
    height: f32,
    depth: f32,
}

// How far the sun reaches around a tuft of leaves.
const WRAP: f32 = 0.35;

// Height and radial depth as a factor (thesis 5.3).
fn terms(place: Lit) -> f32 {
    let height = 0.55 + 0.45 * clamp(place.height, 0.0, 1.0);
    let depth = clamp((place.depth - 0.55) / 0.55, 0.0, 1.0);
    return height * (0.35 + 0.65 * depth * depth);
}

// The light that a place sends to the eye.
fn shaded(place: Lit) -> vec3<f32> {
    let upward = 0.5 + 0.5 * place.normal.y;
    let sky = frame.ground * (1.0 - upward) + frame.sky * upward;
    let facing = dot(place.normal, frame.toward_sun);
    let wrapped = max((facing + WRAP) / (1.0 + WRAP), 0.0);
    var open = place.open;
    var sunlit = place.sunlit;
    if frame.occlusion != 0u {
        open = terms(place);
        sunlit = open;
    }
    return place.albedo * (sky * open + frame.sun * (wrapped * sunlit));
}
