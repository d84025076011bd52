// What is behind the trees; src/render/cpu/backdrop.rs is its twin.

@vertex
fn corner(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    // One triangle that covers the picture.
    let x = f32((index << 1u) & 2u);
    let y = f32(index & 2u);
    return vec4(2.0 * x - 1.0, 1.0 - 2.0 * y, 0.0, 1.0);
}

fn behind(ray: vec3<f32>) -> vec3<f32> {
    if frame.backdrop == 1u {
        // Paper that is lit from above and curves up behind.
        let upward = clamp(0.5 + 0.5 * ray.y, 0.0, 1.0);
        return vec3(0.50, 0.51, 0.52) + vec3(0.34, 0.35, 0.37) * upward;
    }
    let upward = max(ray.y, 0.0);
    let haze = 1.0 / (1.0 + 9.0 * upward);
    return vec3(0.20, 0.38, 0.72) * (1.0 - haze) + vec3(0.80, 0.88, 0.96) * haze;
}

@fragment
fn sample(@builtin(position) place: vec4<f32>) -> @location(0) vec4<f32> {
    if frame.view != 0u || frame.backdrop == 0u {
        return vec4(0.0);
    }
    return vec4(behind(ray_through(place.xy)), 1.0);
}
