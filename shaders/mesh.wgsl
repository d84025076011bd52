// Triangles with colours at their corners; src/render/cpu/mesh.rs is its twin.

struct Vertex {
    @location(0) position: vec3<f32>,
    @location(1) open: f32,
    @location(2) normal: vec3<f32>,
    @location(3) sunlit: f32,
    @location(4) color: vec3<f32>,
}

struct Corner {
    @builtin(position) clip: vec4<f32>,
    @location(0) normal: vec3<f32>,
    @location(1) color: vec3<f32>,
    // Share of the light from all around, of the sun; distance.
    @location(2) light: vec3<f32>,
    // 1 at the corner of its own, 0 at the opposite edge.
    @location(3) shares: vec3<f32>,
}

@vertex
fn corner(@builtin(vertex_index) index: u32, in: Vertex) -> Corner {
    var out: Corner;
    out.clip = frame.clip_from_world * vec4(in.position, 1.0);
    out.normal = in.normal;
    out.color = in.color;
    out.light = vec3(in.open, in.sunlit, out.clip.w);
    let own = index % 3u;
    out.shares = vec3(f32(own == 0u), f32(own == 1u), f32(own == 2u));
    return out;
}

@fragment
fn sample(in: Corner) -> @location(0) vec4<f32> {
    let normal = in.normal * (1.0 / max(sqrt(dot(in.normal, in.normal)), 1e-12));
    // In every branch alike: derivatives need all neighbours.
    let gone = length(vec2(dpdx(in.shares.x), dpdy(in.shares.x)));
    let going = length(vec2(dpdx(in.shares.y), dpdy(in.shares.y)));
    let went = length(vec2(dpdx(in.shares.z), dpdy(in.shares.z)));
    let edges = in.shares / max(vec3(gone, going, went), vec3(1e-6));
    var lit: Lit;
    lit.albedo = in.color;
    lit.normal = normal;
    lit.open = in.light.x;
    lit.sunlit = in.light.y;
    lit.height = in.light.x;
    lit.depth = 1.0;
    lit.ray = vec3(0.0);
    lit.thin = 0.0;
    let light = shaded(lit);
    switch frame.view {
        case 1u, 4u: {
            return vec4(0.0, 0.0, 0.0, 1.0);
        }
        case 2u: {
            return vec4(normal * 0.5 + vec3(0.5), 1.0);
        }
        case 3u: {
            return vec4(vec3(1.0 / (1.0 + in.light.z)), 1.0);
        }
        case 5u: {
            let on_line = min(edges.x, min(edges.y, edges.z)) < 0.7;
            return vec4(select(min(light, vec3(1.0)), vec3(0.0), on_line), 1.0);
        }
        default: {
            return vec4(light, 1.0);
        }
    }
}
