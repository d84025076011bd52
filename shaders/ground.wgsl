// The shadow of a crown on the ground; src/render/cpu/ground.rs is its twin.
//
// A rectangle on the ground that holds the shadow and the darker ground beneath the crown; what is
// drawn covers the ground with black in part.

struct Corner {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) center: vec4<f32>,
    @location(1) @interpolate(flat) turn: vec2<f32>,
}

// The lowest sun that casts a shadow, as a sine.
const LOWEST: f32 = 0.12;
// How far the ground beneath the crown is darker, in radii.
const BENEATH: f32 = 1.7;
// Most steps through the crown.
const STEPS: u32 = 20u;

@vertex
fn corner(@builtin(vertex_index) index: u32, in: Crown) -> Corner {
    let most = crown.radius_range.y * in.scale;
    let high = crown.center_height * in.scale;
    let rise = max(frame.toward_sun.y, LOWEST);
    let flat_sun = frame.toward_sun.xz;
    let along = flat_sun / max(sqrt(dot(flat_sun, flat_sun)), 1e-6);
    let shift = -sqrt(dot(flat_sun, flat_sun)) / rise * high;
    let low = min(-BENEATH * most, shift - most / rise);
    let end = max(BENEATH * most, shift + most / rise);
    let right = index == 1u || index == 2u || index == 4u;
    let below = index == 2u || index == 4u || index == 5u;
    let forth = select(low, end, right);
    let aside = select(-BENEATH, BENEATH, below) * most;
    let at = vec2(in.center.x, in.center.z) + along * forth + vec2(-along.y, along.x) * aside;
    var out: Corner;
    out.clip = frame.clip_from_world * vec4(at.x, in.center.y - high, at.y, 1.0);
    out.center = vec4(in.center, in.scale);
    out.turn = in.turn;
    return out;
}

// The share of the sun that reaches a point of the crown's frame below the crown.
fn sun_below(point: vec3<f32>, toward: vec3<f32>) -> f32 {
    let most = crown.radius_range.y;
    let level = min(1u, crown.radius_levels - 1u);
    let along = dot(point, toward);
    let nearest = point - toward * along;
    let room = most * most - dot(nearest, nearest);
    let half_way = sqrt(max(room, 0.0));
    let start = max(-along - half_way, 0.0);
    let end = half_way - along;
    if room <= 0.0 || end <= start {
        return 1.0;
    }
    var lit = 1.0;
    let steps = clamp(2u * frame.shadow_steps, 4u, STEPS);
    for (var i = 0u; i < steps; i++) {
        let distance = start + (end - start) * ((f32(i) + 0.5) / f32(steps));
        let there = point + toward * distance;
        let above = sqrt(dot(there, there)) - radius_at(there, level);
        let width = 0.05 * distance + 0.02 * most;
        lit = min(lit, clamp(0.5 + above / width, 0.0, 1.0));
    }
    return lit;
}

// The share of the sun that the stem lets by: from how near the way to the sun comes to its axis.
fn sun_beside_stem(point: vec3<f32>, toward: vec3<f32>) -> f32 {
    let foot = crown.stem.xyz;
    let radius = crown.stem.w;
    if radius <= 0.0 {
        return 1.0;
    }
    // The axis goes from the foot to the centre, the origin.
    let high = dot(foot, foot);
    let from_foot = point - foot;
    let slant = -dot(toward, foot);
    let up = -dot(foot, from_foot);
    let ahead = dot(toward, from_foot);
    let room = max(high - slant * slant, 1e-4 * high);
    let along = (slant * up - high * ahead) / room;
    let share = clamp((up + slant * along) / high, 0.0, 1.0);
    let axis = foot * (1.0 - share);
    let distance = max(dot(axis - point, toward), 0.0);
    let apart = point + toward * distance - axis;
    let thick = radius * (1.0 - 0.5 * share);
    let width = 0.02 * distance + 0.3 * radius;
    return clamp(0.5 + (sqrt(dot(apart, apart)) - thick) / width, 0.0, 1.0);
}

@fragment
fn sample(in: Corner) -> @location(0) vec4<f32> {
    let ray = ray_through(in.clip.xy);
    let ground = in.center.y - crown.center_height * in.center.w;
    let distance = (ground - frame.eye.y) / ray.y;
    if frame.view != 0u || frame.backdrop == 0u || frame.eye.y <= ground || distance <= 0.0 {
        discard;
    }
    let world = frame.eye + ray * distance - in.center.xyz;
    let point = local_from_world(in.turn, world) * (1.0 / in.center.w);
    let most = crown.radius_range.y;
    let mean = crown.mean_radius;
    var lit = 1.0;
    if frame.toward_sun.y >= LOWEST {
        let toward = local_from_world(in.turn, frame.toward_sun);
        lit = min(sun_below(point, toward), sun_beside_stem(point, toward));
    }
    let flat_distance = sqrt(point.x * point.x + point.z * point.z);
    let window = clamp((BENEATH - flat_distance / most) / (BENEATH - 0.8), 0.0, 1.0);
    let far = dot(point, point);
    let covered = min(mean * mean * crown.center_height / (far * sqrt(far)), 1.0) * window;
    let foot = flat_distance / (0.09 * mean);
    let beside = window / (1.0 + foot * foot);
    let left = (1.0 - 0.52 * (1.0 - lit)) * (1.0 - 0.45 * covered) * (1.0 - 0.5 * beside);
    return vec4(0.0, 0.0, 0.0, 1.0 - left);
}
