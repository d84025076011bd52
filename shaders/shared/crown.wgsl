// The crown: its packed cubemaps (src/render/packed_cube.rs) and the surface they stand for.

struct CrownNumbers {
    radius_range: vec2<f32>,
    radius_size: u32,
    radius_levels: u32,
    surface_size: u32,
    surface_levels: u32,
    mean_radius: f32,
    center_height: f32,
    // From the centre to the foot of the stem, and its radius, metres; 0: no stem.
    stem: vec4<f32>,
    // Side of a texel of the radii, as a share of their rectangle.
    radius_texel: vec2<f32>,
    // Height by width; leaves are spread over a ball drawn out so.
    slender: f32,
    // Side of leaves, as a share of that in a closed crown.
    leaf_side: f32,
}

// An instance; src/render/frame.rs has the struct, InstanceNumbers.
struct Crown {
    @location(1) center: vec3<f32>,
    @location(2) scale: f32,
    @location(3) turn: vec2<f32>,
    @location(4) fade: f32,
    @location(5) dither: u32,
    @location(6) tint: vec3<f32>,
    @location(7) finest_level: f32,
}

@group(1) @binding(0) var<uniform> crown: CrownNumbers;
// Layer: face. Distance from the centre, metres.
@group(1) @binding(1) var radius_texture: texture_2d_array<f32>;
// Layer: face. Linear colour (decoded on reading), and the share of the sky that is seen.
@group(1) @binding(2) var surface_texture: texture_2d_array<f32>;
// Takes texels as they are.
@group(1) @binding(3) var texels: sampler;

// Where four texels stand, and how much of the right and the lower ones to take.
struct Place {
    face: u32,
    corner: vec2<u32>,
    share: vec2<f32>,
}

// The corner of a level in the rectangle of a face.
fn level_corner(size: u32, level: u32) -> vec2<u32> {
    if level == 0u {
        return vec2(0u, 0u);
    }
    return vec2(size + 2u, size - (size >> (level - 1u)) + 2u * (level - 1u));
}

// Where a direction, of any length but 0, goes through a level.
fn place_of(direction: vec3<f32>, size: u32, level: u32) -> Place {
    let length = abs(direction);
    var face: u32;
    var u: f32;
    var v: f32;
    if length.x >= length.y && length.x >= length.z {
        face = select(1u, 0u, direction.x > 0.0);
        u = select(direction.z, -direction.z, direction.x > 0.0) / length.x;
        v = -direction.y / length.x;
    } else if length.y >= length.z {
        face = select(3u, 2u, direction.y > 0.0);
        u = direction.x / length.y;
        v = select(-direction.z, direction.z, direction.y > 0.0) / length.y;
    } else {
        face = select(5u, 4u, direction.z > 0.0);
        u = select(-direction.x, direction.x, direction.z > 0.0) / length.z;
        v = -direction.y / length.z;
    }
    let side = size >> level;
    let half_side = f32(side) * 0.5;
    let at = vec2((u + 1.0) * half_side + 0.5, (v + 1.0) * half_side + 0.5);
    let texel = min(vec2<u32>(at), vec2(side, side));
    return Place(face, level_corner(size, level) + texel, at - vec2<f32>(texel));
}

// The distance from the centre to the surface in a direction, bilinear.
fn radius_at(direction: vec3<f32>, level: u32) -> f32 {
    let place = place_of(direction, crown.radius_size, level);
    // The corner that four texels share: they are read at once.
    let middle = vec2<f32>(place.corner + vec2(1u)) * crown.radius_texel;
    let four = textureGather(0, radius_texture, texels, middle, place.face);
    let upper = four.w + (four.z - four.w) * place.share.x;
    let lower = four.x + (four.y - four.x) * place.share.x;
    return upper + (lower - upper) * place.share.y;
}

// Linear colour and openness in a direction at a level, bilinear.
fn surface_at(direction: vec3<f32>, level: u32) -> vec4<f32> {
    let place = place_of(direction, crown.surface_size, level);
    let a = textureLoad(surface_texture, place.corner, place.face, 0);
    let b = textureLoad(surface_texture, place.corner + vec2(1u, 0u), place.face, 0);
    let c = textureLoad(surface_texture, place.corner + vec2(0u, 1u), place.face, 0);
    let d = textureLoad(surface_texture, place.corner + vec2(1u, 1u), place.face, 0);
    let upper = a + (b - a) * place.share.x;
    let lower = c + (d - c) * place.share.x;
    return upper + (lower - upper) * place.share.y;
}

// The same between levels.
fn surface_between(direction: vec3<f32>, level: f32) -> vec4<f32> {
    let whole = u32(level);
    let near = surface_at(direction, whole);
    let far = surface_at(direction, min(whole + 1u, crown.surface_levels - 1u));
    return near + (far - near) * (level - f32(whole));
}

// Two unit vectors at right angles to a unit vector (Duff et al. 2017).
struct Tangents {
    right: vec3<f32>,
    up: vec3<f32>,
}

fn tangents_of(direction: vec3<f32>) -> Tangents {
    let side = select(-1.0, 1.0, direction.z >= 0.0);
    let a = -1.0 / (side + direction.z);
    let b = direction.x * direction.y * a;
    return Tangents(
        vec3(1.0 + side * direction.x * direction.x * a, side * b, -side * direction.x),
        vec3(b, side + direction.y * direction.y * a, -direction.y),
    );
}

// The outward unit normal of the surface in the direction of a unit vector, where its radius is
// `here`: d - grad r / r.
fn normal_from(direction: vec3<f32>, here: f32, level: u32) -> vec3<f32> {
    let step = 2.0 / f32(crown.radius_size >> level);
    let tangents = tangents_of(direction);
    let right = tangents.right * step;
    let up = tangents.up * step;
    let across = radius_at(direction + right, level) - radius_at(direction - right, level);
    let along = radius_at(direction + up, level) - radius_at(direction - up, level);
    let outward = direction * (here * (2.0 * step)) - tangents.right * across - tangents.up * along;
    return outward * (1.0 / sqrt(dot(outward, outward)));
}

// A level as a number, so that a sample has a texel of the level at least.
fn level_for(size: u32, levels: u32, radius_samples: f32) -> f32 {
    let texels = f32(size) * 0.63661977 / radius_samples;
    return min(log2(max(texels, 1.0)), f32(levels - 1u));
}

// The radius of a crown in samples, seen from its surface rather than its centre.
fn radius_in_samples(eye: vec3<f32>) -> f32 {
    let most = crown.radius_range.y;
    let distance = max(sqrt(dot(eye, eye)) - most * 0.5, most * 0.05);
    return most / (distance * frame.sample_size);
}

// The level of smooth shape, without leaves.
fn smooth_level() -> u32 {
    return max(crown.radius_levels, 2u) - 2u;
}

// The share of the sun that reaches a point of the crown's frame through the crown.
fn sunlit_at(from_point: vec3<f32>, toward: vec3<f32>, level: u32) -> f32 {
    let most = crown.radius_range.y;
    var lit = 1.0;
    var distance = 0.03 * most;
    for (var i = 0u; i < frame.shadow_steps; i++) {
        let point = from_point + toward * distance;
        let out = sqrt(dot(point, point));
        if out > most {
            break;
        }
        let above = out - radius_at(point, level);
        lit = min(lit, clamp(0.5 + above / (0.3 * distance), 0.0, 1.0));
        distance *= frame.shadow_growth;
    }
    return lit;
}
