// What is behind the trees; src/render/cpu/backdrop.rs is its twin.

fn behind(ray: vec3<f32>) -> vec3<f32> {
    if frame.backdrop == 1u {
        // Paper that is lit from above and curves up behind.
        let upward = clamp(0.5 + 0.5 * ray.y, 0.0, 1.0);
        return vec3(0.50, 0.51, 0.52) + vec3(0.34, 0.35, 0.37) * upward;
    }
    let horizon = vec3(0.80, 0.88, 0.96);
    if ray.y < 0.0 {
        let haze = 1.0 / (1.0 - 30.0 * ray.y);
        return vec3(0.145, 0.165, 0.075) * (1.0 - haze) + horizon * haze;
    }
    let haze = 1.0 / (1.0 + 9.0 * ray.y);
    return vec3(0.20, 0.38, 0.72) * (1.0 - haze) + horizon * haze;
}

@fragment
fn sample(@builtin(position) place: vec4<f32>) -> @location(0) vec4<f32> {
    if frame.view != 0u || frame.backdrop == 0u {
        return vec4(0.0);
    }
    return vec4(behind(ray_through(place.xy)), 1.0);
}
