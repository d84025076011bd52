// The relief crown (thesis 5.1); src/render/cpu/relief.rs is its twin.
//
// The proxy's far side is drawn, so that an eye within the proxy sees the crown too.

struct March {
    @builtin(position) clip: vec4<f32>,
    // The eye in the frame of the crown, in its metres.
    @location(0) @interpolate(flat) eye: vec3<f32>,
    // Linear steps through the diameter.
    @location(1) @interpolate(flat) steps: f32,
    @location(2) @interpolate(flat) turn: vec2<f32>,
    @location(3) @interpolate(flat) scale: f32,
    @location(4) @interpolate(flat) surface_level: f32,
    @location(5) @interpolate(flat) tint: vec3<f32>,
    @location(6) @interpolate(flat) radius_level: u32,
    @location(7) @interpolate(flat) fade: f32,
    @location(8) @interpolate(flat) dither: u32,
}

struct Seen {
    @location(0) light: vec4<f32>,
    @builtin(frag_depth) depth: f32,
}

struct Hit {
    found: bool,
    distance: f32,
    reads: u32,
}

// Distance of the corners of the icosahedron around the unit ball.
const PROXY: f32 = 1.258409;

@vertex
fn corner(@location(0) position: vec3<f32>, in: Crown) -> March {
    let most = crown.radius_range.y;
    let world = in.center + position * (most * in.scale);
    let eye = local_from_world(in.turn, frame.eye - in.center) * (1.0 / in.scale);
    let radius_samples = radius_in_samples(eye);
    var out: March;
    out.clip = frame.clip_from_world * vec4(world, 1.0);
    out.eye = eye;
    let steps = clamp(radius_samples * frame.steps_a_sample, frame.least_steps, frame.most_steps);
    // A coarse level has no detail to step over.
    out.steps = max(steps / (1.0 + in.finest_level), frame.least_steps);
    out.turn = in.turn;
    out.scale = in.scale;
    out.surface_level = max(
        level_for(crown.surface_size, crown.surface_levels, radius_samples),
        min(in.finest_level, f32(crown.surface_levels - 1u)),
    );
    out.tint = in.tint;
    out.radius_level = u32(max(
        level_for(crown.radius_size, crown.radius_levels, radius_samples),
        min(in.finest_level, f32(crown.radius_levels - 1u)),
    ));
    out.fade = in.fade;
    out.dither = in.dither;
    return out;
}

fn is_inside(point: vec3<f32>, level: u32) -> bool {
    return sqrt(dot(point, point)) < radius_at(point, level);
}

// Where a ray of the crown's frame meets the surface first.
fn hit_of(eye: vec3<f32>, ray: vec3<f32>, steps: f32, level: u32) -> Hit {
    let least = crown.radius_range.x;
    let most = crown.radius_range.y;
    let miss = Hit(false, 0.0, 0u);
    let along = dot(eye, ray);
    let nearest = eye - ray * along;
    let aside = dot(nearest, nearest);
    let reach = select(most, most * PROXY, frame.shortcut == 0u);
    let room = reach * reach - aside;
    if room < 0.0 {
        return miss;
    }
    let half_way = sqrt(room);
    let start = max(-along - half_way, 0.0);
    var end = half_way - along;
    if end <= start {
        return miss;
    }
    let core = least * least - aside;
    let meets_core = core > 0.0 && frame.shortcut != 0u;
    if meets_core {
        end = min(end, max(-along - sqrt(core), start));
    }
    var reads = 0u;
    var low = start;
    var high = end;
    if !(meets_core && frame.shortcut == 2u) {
        let count = max(ceil((end - start) / (2.0 * most) * steps), 4.0);
        let step = (end - start) / count;
        var found = false;
        for (var i = 1u; i <= u32(count); i++) {
            let distance = start + step * f32(i);
            reads++;
            if is_inside(eye + ray * distance, level) {
                high = distance;
                low = distance - step;
                found = true;
                break;
            }
        }
        if !found {
            if !meets_core {
                return Hit(false, 0.0, reads);
            }
            low = end - step;
        }
    }
    for (var i = 0u; i < frame.halvings; i++) {
        let middle = 0.5 * (low + high);
        reads++;
        if is_inside(eye + ray * middle, level) {
            high = middle;
        } else {
            low = middle;
        }
    }
    return Hit(true, 0.5 * (low + high), reads);
}

// What the eye sees of a hit: light, or what the debug view shows.
fn seen(march: March, hit: Hit, point: vec3<f32>, ray: vec3<f32>) -> vec3<f32> {
    let distance = sqrt(dot(point, point));
    let direction = point * (1.0 / distance);
    let most = crown.radius_range.y;
    let normal_local = normal_from(direction, distance, march.radius_level);
    let normal = world_from_local(march.turn, normal_local);
    switch frame.view {
        case 1u: {
            return vec3(f32(hit.reads) / (frame.most_steps + f32(frame.halvings)));
        }
        case 2u: {
            return normal * 0.5 + vec3(0.5);
        }
        case 3u: {
            return vec3(1.0 / (1.0 + hit.distance * march.scale));
        }
        case 4u: {
            let error = abs(distance - radius_at(direction, march.radius_level));
            return vec3(error * 100.0 / most);
        }
        default: {}
    }
    let surface = surface_between(direction, march.surface_level);
    let toward_sun = local_from_world(march.turn, frame.toward_sun);
    let shadow_level = min(march.radius_level + 1u, crown.radius_levels - 1u);
    var place: Lit;
    place.albedo = surface.rgb * march.tint;
    place.normal = normal;
    place.open = surface.a;
    place.sunlit = sunlit_at(point + normal_local * (0.02 * most), toward_sun, shadow_level);
    place.height = 0.5 + 0.5 * point.y / most;
    place.depth = 1.0;
    if frame.occlusion != 0u {
        place.depth = distance / radius_at(direction, smooth_level());
    }
    place.ray = ray;
    place.thin = 1.0;
    return shaded(place);
}

@fragment
fn sample(march: March) -> Seen {
    if pattern(march.clip.xy, march.dither) < march.fade {
        discard;
    }
    let world = ray_through(march.clip.xy);
    let ray = local_from_world(march.turn, world);
    let hit = hit_of(march.eye, ray, march.steps, march.radius_level);
    if !hit.found {
        discard;
    }
    let depth = frame.near / (hit.distance * march.scale * dot(world, frame.forward));
    if depth > 1.0 {
        discard;
    }
    let light = seen(march, hit, march.eye + ray * hit.distance, world);
    return Seen(vec4(light, 1.0), depth);
}
