// One triangle that covers the picture.

@vertex
fn corner(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let x = f32((index << 1u) & 2u);
    let y = f32(index & 2u);
    return vec4(2.0 * x - 1.0, 1.0 - 2.0 * y, 0.0, 1.0);
}
