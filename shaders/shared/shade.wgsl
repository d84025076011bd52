// Light on a surface; src/render/cpu/shade.rs is its twin.

struct Lit {
    albedo: vec3<f32>,
    normal: vec3<f32>,
    open: f32,
    sunlit: f32,
    height: f32,
    depth: f32,
    // From the eye.
    ray: vec3<f32>,
    // 1 for leaves, 0 for what no light passes.
    thin: f32,
}

// How far the sun reaches around a tuft of leaves.
const WRAP: f32 = 0.35;
// The light that a leaf lets through: its tint, how far it reaches around, the share of it that
// goes everywhere, and its strength.
const PASSED: vec3<f32> = vec3(1.15, 1.25, 0.45);
const PASSED_WRAP: f32 = 0.25;
const PASSED_EVEN: f32 = 0.15;
const PASSED_STRENGTH: f32 = 1.1;

// Height and radial depth as a factor (thesis 5.3).
fn terms(place: Lit) -> f32 {
    let height = 0.55 + 0.45 * clamp(place.height, 0.0, 1.0);
    let depth = clamp((place.depth - 0.55) / 0.55, 0.0, 1.0);
    return height * (0.35 + 0.65 * depth * depth);
}

// The light of the sun that comes through leaves from behind.
fn passed(place: Lit, facing: f32) -> vec3<f32> {
    let behind = max((PASSED_WRAP - facing) / (1.0 + PASSED_WRAP), 0.0);
    let ahead = max(dot(place.ray, frame.toward_sun), 0.0);
    let lobe = PASSED_EVEN + (1.0 - PASSED_EVEN) * (ahead * ahead * ahead);
    let strength = PASSED_STRENGTH * place.thin * (behind * lobe * sqrt(place.sunlit));
    return PASSED * frame.sun * strength;
}

// The light that a place sends to the eye.
fn shaded(place: Lit) -> vec3<f32> {
    let upward = 0.5 + 0.5 * place.normal.y;
    let sky = frame.ground * (1.0 - upward) + frame.sky * upward;
    let facing = dot(place.normal, frame.toward_sun);
    let wrapped = max((facing + WRAP) / (1.0 + WRAP), 0.0);
    if frame.occlusion != 0u {
        let share = terms(place);
        return place.albedo * (sky * share + frame.sun * (wrapped * share));
    }
    let light = sky * place.open + frame.sun * (wrapped * place.sunlit);
    return place.albedo * (light + passed(place, facing));
}
