// From light to a picture; src/render/cpu/tone.rs is its twin.

// Light of the samples, premultiplied by coverage.
@group(1) @binding(0) var samples: texture_2d<f32>;

// Narkowicz's fit of the ACES curve.
fn filmic(light: vec3<f32>) -> vec3<f32> {
    let x = light * 0.72;
    let curve = (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14);
    return clamp(curve, vec3(0.0), vec3(1.0));
}

fn srgb(linear: vec3<f32>) -> vec3<f32> {
    let value = clamp(linear, vec3(0.0), vec3(1.0));
    let curved = 1.055 * pow(value, vec3(1.0 / 2.4)) - 0.055;
    return select(curved, value * 12.92, value <= vec3(0.0031308));
}

// The pixel's colour as sRGB values, and its alpha, straight.
fn toned(pixel: vec2<u32>) -> vec4<f32> {
    var light = vec3(0.0);
    var coverage = 0.0;
    for (var y = 0u; y < frame.fineness; y++) {
        for (var x = 0u; x < frame.fineness; x++) {
            let at = pixel * frame.fineness + vec2(x, y);
            // Samples are clear or opaque, so premultiplied light is light.
            let one = textureLoad(samples, at, 0);
            let curved = filmic(one.rgb * frame.exposure);
            light += select(clamp(one.rgb, vec3(0.0), vec3(1.0)), curved, frame.view == 0u);
            coverage += one.a;
        }
    }
    if coverage == 0.0 {
        return vec4(0.0);
    }
    let count = f32(frame.fineness * frame.fineness);
    return vec4(srgb(light / coverage), coverage / count);
}

// For files.
@fragment
fn sample(@builtin(position) place: vec4<f32>) -> @location(0) vec4<f32> {
    return toned(vec2<u32>(place.xy));
}

// For windows, which mix sRGB values that are multiplied by alpha.
@fragment
fn premultiplied(@builtin(position) place: vec4<f32>) -> @location(0) vec4<f32> {
    let straight = toned(vec2<u32>(place.xy));
    return vec4(straight.rgb * straight.a, straight.a);
}
