// The leaf crown (thesis 5.2); src/render/cpu/leaves.rs is its twin.
//
// Six corners a leaf, all leaves of a crown in one instance. Leaves are parallel to the picture's
// plane: each is a square on the screen with one depth. Fronds and boughs are long instead, from the crown's
// heart or its axis to its surface, bent upwards.

// Points of the unit ball, best prefix first, in rows of 64.
@group(2) @binding(0) var points: texture_2d<f32>;
// Layer: twig. Shade and coverage.
@group(2) @binding(1) var atlas: texture_2d_array<f32>;

// Layer: direction towards the eye. Indices of points, the nearest first, in rows of 64; those of
// 64 points, of 128, and so on (src/render/gpu/leaf_order.rs).
@group(2) @binding(2) var orders: texture_2d_array<u32>;

struct Leaf {
    @builtin(position) clip: vec4<f32>,
    // Centre and half the side, samples; level of the twig's picture.
    @location(0) @interpolate(flat) place: vec4<f32>,
    @location(1) @interpolate(flat) spin: vec2<f32>,
    @location(2) @interpolate(flat) ids: vec3<u32>,
    // Linear colour; share of the light from all around.
    @location(3) @interpolate(flat) albedo: vec4<f32>,
    // Normal of the crown, world; share of the sun.
    @location(4) @interpolate(flat) normal: vec4<f32>,
    // From the centre of the crown, in its frame; metres for a sample.
    @location(5) @interpolate(flat) point: vec4<f32>,
    @location(6) @interpolate(flat) turn: vec2<f32>,
    // Share of the samples; how far the leaf may reach beyond the surface, as a factor.
    @location(7) @interpolate(flat) fade: vec2<f32>,
    // Halves of the side by halves of the width; how far the middle of a rib lies aside of its ends, in
    // halves of the width.
    @location(8) @interpolate(flat) shape: vec2<f32>,
}

// Share of the leaves that are growing.
const GROWING: f32 = 0.15;
const DEEPEST: f32 = 0.64;
const DRAWN_BACK: f32 = 0.12;
// The outline is made by what stands out of the mean surface.
const STANDS_OUT: f32 = 1.07;
// How far a free leaf may reach beyond the surface, in radii; such a leaf is drawn whole.
const FREEST: f32 = 0.6;
// Radii of a crown, pixels, at which its leaves keep to the surface, and are free of it.
const KEPT_RADIUS: f32 = 100.0;
const FREE_RADIUS: f32 = 320.0;
const SPREAD: f32 = 0.55;
// Long leaves: the shortest that one looks that points at the eye, by its width; how much wider they are at
// most where there are fewer; share of a bough's width that all have; how much less far
// the innermost boughs reach; how far normals of boughs turn upwards.
const SHORTEST: f32 = 0.5;
const WIDEST: f32 = 1.6;
const EVEN: f32 = 0.18;
const INNER: f32 = 0.4;
const FLAT: f32 = 0.7;
const FROM_AXIS: u32 = 2u;
// How boughs rise at the foot and at the top of a crown, and how far below the surface the uppermost leave the
// axis, and the share of them next to it that is not drawn (src/render/ribs.rs).
const RISES: vec2<f32> = vec2(-0.3, 0.95);
const LEADER: f32 = 0.45;
const HIDDEN: f32 = 0.4;

fn nothing() -> Leaf {
    var leaf: Leaf;
    // Behind the eye: no corner of it is drawn.
    leaf.clip = vec4(0.0, 0.0, -1.0, 1.0);
    return leaf;
}

// The order for an eye in a direction: of a face of the cube, or of a corner.
fn order_toward(eye: vec3<f32>) -> u32 {
    let far = abs(eye);
    let most = max(far.x, max(far.y, far.z));
    if far.x + far.y + far.z > 1.7320508 * most {
        return 6u + u32(eye.x > 0.0) + 2u * u32(eye.y > 0.0) + 4u * u32(eye.z > 0.0);
    }
    if far.x == most {
        return select(1u, 0u, eye.x > 0.0);
    }
    if far.y == most {
        return select(3u, 2u, eye.y > 0.0);
    }
    return select(5u, 4u, eye.z > 0.0);
}

// Where the bough whose tip is there begins, from the centre of the crown.
fn bough_root(tip: vec3<f32>) -> vec3<f32> {
    let height = clamp(tip.y / crown.radius_range.y, -1.0, 1.0);
    let rise = RISES.x + (RISES.y - RISES.x) * (0.5 + 0.5 * height);
    let aside = sqrt(tip.x * tip.x + tip.z * tip.z);
    let upper = max(height, 0.0);
    let below = aside * rise + LEADER * crown.mean_radius * (upper * upper);
    let axis = vec3(0.0, tip.y - below, 0.0);
    return axis + (tip - axis) * HIDDEN;
}

@vertex
fn corner(@builtin(vertex_index) vertex: u32, in: Crown) -> Leaf {
    let eye = local_from_world(in.turn, frame.eye - in.center) * (1.0 / in.scale);
    let entry = vertex / 6u;
    let index = textureLoad(orders, vec2(entry % 64u, entry / 64u), order_toward(eye), 0).x;
    let radius_samples = radius_in_samples(eye);
    let size = textureDimensions(points);
    let wanted = clamp(
        radius_samples * frame.leaves_a_sample,
        frame.least_leaves,
        frame.most_leaves,
    );
    let count = min(wanted, f32(frame.point_count));
    if f32(index) >= count || in.fade <= 0.0 {
        return nothing();
    }
    let ball = textureLoad(points, vec2(index % size.x, index / size.x), 0).xyz;
    let salt = hash(index ^ in.dither);
    let grown = clamp((count - f32(index)) / (GROWING * count), 0.0, 1.0);
    let vary = 0.8 + 0.4 * hashed(salt ^ 1u);
    let side = crown.mean_radius * crown.leaf_side;
    let half_m = frame.leaf_size * side * grown * vary / sqrt(count);
    let share = sqrt(dot(ball, ball));
    let drawn_out = vec3(ball.x, ball.y * crown.slender, ball.z);
    let direction = drawn_out * (1.0 / max(sqrt(dot(drawn_out, drawn_out)), 1e-6));
    let shape_level = max(crown.radius_levels, 4u) - 4u;
    let reach = radius_at(direction, max(crown.radius_levels, 6u) - 6u);
    var share_out = min(0.6 + 0.4 * vary, 1.0);
    if frame.ribs == FROM_AXIS {
        let inner = hashed(salt ^ 4u);
        share_out -= INNER * inner * inner;
    }
    let tip = direction * (STANDS_OUT * reach * share_out);
    var root = vec3(0.0);
    if frame.ribs == FROM_AXIS {
        root = bough_root(tip);
    }
    let rib = (tip - root) * grown;
    var point = ball * crown.radius_range.y;
    if frame.ribs != 0u {
        point = root + rib * 0.5;
    } else if frame.leaf_clip == 0u {
        let out = STANDS_OUT * reach * (DEEPEST + (1.0 - DEEPEST) * share) - DRAWN_BACK * half_m;
        point = direction * max(out, 0.0);
    }
    // A long leaf is dark at its stalk by its picture.
    let depth_share = select(share_out, sqrt(dot(point, point)) / reach, frame.ribs == 0u);
    if depth_share > 1.0 && frame.leaf_clip == 1u && depth_share * reach - half_m * 1.5 > reach {
        return nothing();
    }
    let seen = in.center + world_from_local(in.turn, point) * in.scale - frame.eye;
    let away = dot(seen, frame.forward);
    if away <= frame.near || half_m <= 0.0 {
        return nothing();
    }
    let metres = away * frame.sample_size;
    let samples = in.scale / metres;
    var half_side = half_m * in.scale / metres;
    let across = dot(seen, frame.right) / (away * frame.tan_x);
    let upward = dot(seen, frame.up) / (away * frame.tan_y);
    let angle = hashed(salt ^ 2u) * 6.2831853;
    let surface = surface_at(direction, max(crown.surface_levels, 3u) - 3u);
    // Shade is that of the surface above the leaf: within the crown nothing would be lit.
    let normal_local = normal_from(direction, reach, shape_level);
    let above = direction * reach + normal_local * (0.05 * crown.mean_radius);
    let inside = clamp(depth_share - 0.45, 0.0, 0.45) / 0.45;
    let bright = 1.1 + 0.2 * hashed(salt ^ 3u);
    var facing = normal_local;
    if frame.ribs == FROM_AXIS {
        facing += vec3(0.0, FLAT, 0.0);
    }
    var out: Leaf;
    out.spin = vec2(cos(angle), sin(angle));
    out.shape = vec2(1.0, 0.0);
    if frame.ribs != 0u {
        let world_rib = world_from_local(in.turn, rib) * samples;
        let screen = vec2(dot(world_rib, frame.right), -dot(world_rib, frame.up));
        let length = sqrt(dot(screen, screen));
        var full = reach;
        if frame.ribs == FROM_AXIS {
            let own = sqrt(dot(rib, rib));
            full = own + (crown.mean_radius * grown - own) * EVEN;
        }
        let wider = min(sqrt(f32(frame.point_count) / count), WIDEST) * crown.leaf_side;
        let half_width = 0.5 * frame.rib_slender * (samples * full * wider);
        half_side = max(0.5 * length, SHORTEST * half_width);
        let axis = screen / max(length, 1e-6);
        let aside = sqrt(world_rib.x * world_rib.x + world_rib.z * world_rib.z);
        // The arch goes up on the screen; what of it is across the rib bends the leaf.
        let bend = -frame.rib_arch * aside * frame.up.y * axis.x / max(half_width, 1e-6);
        out.shape = vec2(half_side / max(half_width, 1e-6), bend);
        out.spin = vec2(-axis.y, -axis.x);
    }
    let wide = half_side / sqrt(out.shape.x);
    let texels = f32(textureDimensions(atlas).x) / max(2.0 * wide, 1.0);
    let level = min(log2(max(texels, 1.0)), f32(textureNumLevels(atlas) - 1u));
    let place = vec2((across + 1.0) * 0.5 * frame.size.x, (1.0 - upward) * 0.5 * frame.size.y);
    let toward_sun = local_from_world(in.turn, frame.toward_sun);
    out.place = vec4(place, half_side, level);
    out.ids = vec3(salt % textureNumLayers(atlas), salt, in.dither);
    out.albedo = vec4(surface.rgb * in.tint * bright, surface.a * (0.35 + 0.65 * inside));
    out.normal = vec4(
        world_from_local(in.turn, facing),
        sunlit_at(above, toward_sun, shape_level) * (0.25 + 0.75 * inside),
    );
    out.point = vec4(point, metres / in.scale);
    out.turn = in.turn;
    let free = clamp(
        (radius_samples * frame.pixels_a_sample - KEPT_RADIUS) / (FREE_RADIUS - KEPT_RADIUS),
        0.0,
        1.0,
    );
    let bound = select(1.0, 1.0 + FREEST * free, frame.leaf_clip == 0u);
    out.fade = vec2(in.fade, bound);
    var across_side = vec2(half_side, 0.0);
    var down_side = vec2(0.0, half_side);
    if frame.ribs != 0u {
        let wide_side = half_side * (1.0 + abs(out.shape.y)) / out.shape.x;
        across_side = vec2(out.spin.x, -out.spin.y) * wide_side;
        down_side = vec2(out.spin.y, out.spin.x) * half_side;
    }
    out.clip = corner_of(vertex % 6u, place, across_side, down_side, away);
    return out;
}

// A corner of a rectangle on the screen with those half sides, in clip coordinates.
fn corner_of(
    index: u32,
    place: vec2<f32>,
    across: vec2<f32>,
    down: vec2<f32>,
    away: f32,
) -> vec4<f32> {
    let right = index == 1u || index == 2u || index == 4u;
    let below = index == 2u || index == 4u || index == 5u;
    let offset = across * select(-1.0, 1.0, right) + down * select(-1.0, 1.0, below);
    let at = (place + offset) / frame.size * 2.0 - vec2(1.0);
    return vec4(at.x * away, -at.y * away, frame.near, away);
}

// Shade and coverage of a twig, bilinear; clear outside.
fn twig_at(twig: u32, level: u32, u: f32, v: f32) -> vec2<f32> {
    let size = f32(textureDimensions(atlas, level).x);
    let at = vec2(u * size - 0.5, v * size - 0.5);
    let corner = floor(at);
    let share = at - corner;
    let a = twig_texel(twig, level, corner);
    let b = twig_texel(twig, level, corner + vec2(1.0, 0.0));
    let c = twig_texel(twig, level, corner + vec2(0.0, 1.0));
    let d = twig_texel(twig, level, corner + vec2(1.0, 1.0));
    let upper = a + (b - a) * share.x;
    let lower = c + (d - c) * share.x;
    return upper + (lower - upper) * share.y;
}

fn twig_texel(twig: u32, level: u32, at: vec2<f32>) -> vec2<f32> {
    let size = f32(textureDimensions(atlas, level).x);
    if any(at < vec2(0.0)) || any(at >= vec2(size)) {
        return vec2(128.0 / 255.0, 0.0);
    }
    return textureLoad(atlas, vec2<i32>(at), i32(twig), i32(level)).xy;
}

@fragment
fn sample(leaf: Leaf) -> @location(0) vec4<f32> {
    let place = leaf.clip.xy;
    let half_side = leaf.place.z;
    let level = leaf.place.w;
    let across = (place.x - leaf.place.x) / half_side;
    let down = (place.y - leaf.place.y) / half_side;
    // A long leaf's picture is clear at its edges.
    if frame.ribs == 0u && (abs(across) > 1.0 || abs(down) > 1.0) {
        discard;
    }
    if leaf.fade.x < 1.0 && pattern(place, leaf.ids.z) >= leaf.fade.x {
        discard;
    }
    let along = leaf.spin.y * across + leaf.spin.x * down;
    let bent = leaf.shape.y * (1.0 - along * along);
    let u = 0.5 + 0.5 * ((leaf.spin.x * across - leaf.spin.y * down) * leaf.shape.x - bent);
    let v = 0.5 + 0.5 * along;
    let whole = u32(level);
    let near = twig_at(leaf.ids.x, whole, u, v);
    let far = twig_at(leaf.ids.x, min(whole + 1u, textureNumLevels(atlas) - 1u), u, v);
    let twig = near + (far - near) * (level - f32(whole));
    // Sharp edges where a leaf's texels are large, noise where they are smaller than a sample.
    let noise = (pattern(place, leaf.ids.y) - 0.5) * 0.8 * min(level, 1.0);
    if twig.y < 0.5 + noise {
        discard;
    }
    let aside = frame.right * across - frame.up * down;
    if leaf.fade.y < 1.0 + FREEST {
        let metres = leaf.point.w;
        let point = leaf.point.xyz + local_from_world(leaf.turn, aside) * (half_side * metres);
        let samples = crown.radius_range.y / metres;
        let radius_level = u32(level_for(crown.radius_size, crown.radius_levels, samples));
        if sqrt(dot(point, point)) > radius_at(point, radius_level) * leaf.fade.y {
            discard;
        }
    }
    let turned = leaf.normal.xyz + aside * SPREAD;
    let normal = turned * (1.0 / sqrt(dot(turned, turned)));
    switch frame.view {
        case 0u: {}
        case 2u: {
            return vec4(normal * 0.5 + vec3(0.5), 1.0);
        }
        case 3u: {
            return vec4(vec3(1.0 / (1.0 + frame.near / leaf.clip.z)), 1.0);
        }
        default: {
            return vec4(0.0, 0.0, 0.0, 1.0);
        }
    }
    var lit: Lit;
    lit.albedo = leaf.albedo.rgb * (twig.x * (255.0 / 128.0));
    lit.normal = normal;
    lit.open = leaf.albedo.a;
    lit.sunlit = leaf.normal.w;
    lit.height = 0.5 + 0.5 * leaf.point.y / crown.radius_range.y;
    lit.depth = 1.0;
    lit.ray = ray_through(place);
    lit.thin = 1.0;
    return vec4(shaded(lit), 1.0);
}
