// What is the same for all that is drawn in a picture. The structs are those of
// src/render/frame.rs, member for member; a test compares the layouts.

struct Frame {
    clip_from_world: mat4x4<f32>,
    eye: vec3<f32>,
    near: f32,
    right: vec3<f32>,
    tan_x: f32,
    up: vec3<f32>,
    tan_y: f32,
    forward: vec3<f32>,
    sample_size: f32,
    toward_sun: vec3<f32>,
    exposure: f32,
    sun: vec3<f32>,
    steps_a_sample: f32,
    sky: vec3<f32>,
    least_steps: f32,
    ground: vec3<f32>,
    most_steps: f32,
    size: vec2<f32>,
    halvings: u32,
    shadow_steps: u32,
    view: u32,
    occlusion: u32,
    shortcut: u32,
    backdrop: u32,
    leaves_a_sample: f32,
    least_leaves: f32,
    most_leaves: f32,
    leaf_size: f32,
    leaf_clip: u32,
    fineness: u32,
    point_count: u32,
    pixels_a_sample: f32,
    shadow_growth: f32,
    ribs: u32,
    rib_slender: f32,
    rib_arch: f32,
}

@group(0) @binding(0) var<uniform> frame: Frame;

// The unit vector from the eye through a place of the picture, in samples from the left and top.
fn ray_through(place: vec2<f32>) -> vec3<f32> {
    let across = (2.0 * place.x / frame.size.x - 1.0) * frame.tan_x;
    let upward = (1.0 - 2.0 * place.y / frame.size.y) * frame.tan_y;
    let through = frame.forward + frame.right * across + frame.up * upward;
    return through * (1.0 / sqrt(dot(through, through)));
}

// A world direction in the frame of a crown that is turned about the vertical axis.
fn local_from_world(turn: vec2<f32>, world: vec3<f32>) -> vec3<f32> {
    return vec3(
        turn.x * world.x - turn.y * world.z,
        world.y,
        turn.y * world.x + turn.x * world.z,
    );
}

// The way back.
fn world_from_local(turn: vec2<f32>, local: vec3<f32>) -> vec3<f32> {
    return vec3(
        turn.x * local.x + turn.y * local.z,
        local.y,
        turn.x * local.z - turn.y * local.x,
    );
}

// A number from 0 to 1 for a sample of the picture: what shows of something that fades. Whole
// numbers only, so that both renderers draw the same.
fn pattern(place: vec2<f32>, salt: u32) -> f32 {
    return hashed(u32(place.x) * 0x9e3779b1u ^ hash(u32(place.y) * 0x85ebca77u ^ salt));
}

// A number from 0 to 1 for a whole number.
fn hashed(value: u32) -> f32 {
    return f32(hash(value) >> 8u) * (1.0 / 16777216.0);
}

// A permutation of the whole numbers (Wellons, lowbias32).
fn hash(value: u32) -> u32 {
    var x = value;
    x = (x ^ (x >> 16u)) * 0x7feb352du;
    x = (x ^ (x >> 15u)) * 0x846ca68bu;
    return x ^ (x >> 16u);
}
