//! The leaf crown: `shaders/leaves.wgsl` on the processor.
//!
//! Leaves are pictures of twigs parallel to the picture's plane, so each is a square on the screen
//! with one depth. Their number follows the crown's size on the screen, and their size follows
//! their number, so that they cover the crown alike; the last ones grow from nothing.
//!
//! A palm has fronds instead, and a conifer boughs: long pictures that go from the crown's heart or its axis to
//! its surface, so each is turned on the screen as its rib runs there, as long as that looks from the eye, and
//! bent upwards by an arch.

use super::crown::{level_for, radius_in_samples, sunlit_at, surface_at};
use super::dither::{hash, hashed, pattern};
use super::shade::{Place, shaded};
use super::{Band, Drawn};
use crate::render::LeafSet;
use crate::render::frame::{CrownNumbers, Frame, InstanceNumbers, leaf_freedom};
use crate::render::leaf_atlas::{LeafAtlas, VARIANTS};
use crate::render::ribs::{self, RibsFrom, bough_root};
use crate::render::surface::normal_from;
use glam::Vec3;

/// Share of the leaves that are growing.
const GROWING: f32 = 0.15;
/// How far within the ball a leaf's share of the radius goes: the inside is hidden.
const DEEPEST: f32 = 0.64;
/// How far leaves are drawn back from the surface, in halves of their side.
const DRAWN_BACK: f32 = 0.12;
/// The outline is made by what stands out of the mean surface, which leaves are placed by.
const STANDS_OUT: f32 = 1.07;
/// How far a free leaf may reach beyond the surface, in radii; such a leaf is drawn whole.
const FREEST: f32 = 0.6;
/// How much a twig's normals spread, as those of a ball would.
const SPREAD: f32 = 0.55;
/// Shortest that a long leaf looks that points at the eye, by its width.
const SHORTEST: f32 = 0.5;
/// Of [`ribs`], at the shader's precision.
const WIDEST: f32 = ribs::WIDEST as f32;
const EVEN: f32 = ribs::EVEN as f32;
const INNER: f32 = ribs::INNER as f32;
/// How far normals of boughs are turned upwards: they lie flat.
const FLAT: f32 = 0.7;
const FROM_AXIS: u32 = RibsFrom::Axis as u32;

/// A leaf on the screen.
pub(super) struct Leaf {
    /// Centre, samples.
    x: f32,
    y: f32,
    depth: f32,
    laid: Laid,
    variant: u32,
    /// Level of the twig's picture.
    level: f32,
    salt: u32,
    albedo: Vec3,
    /// Normal of the crown, world.
    normal: Vec3,
    open: f32,
    sunlit: f32,
    /// From the centre of the crown, in its frame, metres; and metres for a sample at that distance.
    point: Vec3,
    metres_a_sample: f32,
    /// How far the leaf may reach beyond the surface, as a factor on its radius.
    bound: f32,
}

/// The leaves of an instance that are before the eye.
pub(super) fn leaves(frame: &Frame, drawn: &Drawn<'_>, set: &LeafSet) -> Vec<Leaf> {
    let LeafSet { points, atlas, .. } = set;
    let instance = &drawn.instance;
    if instance.fade <= 0.0 {
        return Vec::new();
    }
    let offset = Vec3::from(frame.eye) - Vec3::from(instance.center);
    let eye = instance.local(offset) * (1.0 / instance.scale);
    let radius_samples = radius_in_samples(frame, &drawn.numbers, eye);
    let count = (radius_samples * frame.leaves_a_sample)
        .clamp(frame.least_leaves, frame.most_leaves)
        .min(points.len() as f32);
    let made = points[..count.ceil() as usize].iter().enumerate();
    made.filter_map(|(index, &[x, y, z, _])| {
        let numbered = (index as u32, count, radius_samples);
        let ball = (Vec3::new(x, y, z), points.len());
        leaf(frame, (drawn, atlas), ball, numbered)
    })
    .collect()
}

/// Leaf `index` of `count`, at `ball` in the unit ball, of a crown with a radius of `crown_samples`; with the
/// number of leaves there are.
fn leaf(
    frame: &Frame,
    (drawn, atlas): (&Drawn<'_>, &LeafAtlas),
    (ball, points): (Vec3, usize),
    (index, count, crown_samples): (u32, f32, f32),
) -> Option<Leaf> {
    let (numbers, instance) = (&drawn.numbers, &drawn.instance);
    let radius = &drawn.crown.radius;
    let salt = hash(index ^ instance.dither);
    let grown = ((count - index as f32) / (GROWING * count)).clamp(0.0, 1.0);
    let vary = 0.8 + 0.4 * hashed(salt ^ 1);
    let side = numbers.mean_radius * numbers.leaf_side;
    let half_m = frame.leaf_size * side * grown * vary / count.sqrt();
    let share = ball.dot(ball).sqrt();
    let drawn_out = Vec3::new(ball.x, ball.y * numbers.slender, ball.z);
    let direction = drawn_out * (1.0 / drawn_out.dot(drawn_out).sqrt().max(1e-6));
    let shape_level = numbers.radius_levels.max(4) - 4;
    let reach = radius.sampled(direction, numbers.radius_levels.max(6) - 6);
    let surface = direction * (STANDS_OUT * reach);
    let rib = Rib::new(frame, numbers, surface, (salt, vary, grown));
    let point = if frame.ribs != 0 {
        rib.root + rib.along * 0.5
    } else if frame.leaf_clip == 0 {
        let out = STANDS_OUT * reach * (DEEPEST + (1.0 - DEEPEST) * share) - DRAWN_BACK * half_m;
        direction * out.max(0.0)
    } else {
        ball * numbers.radius_range[1]
    };
    // A long leaf is dark at its stalk by its picture.
    let depth_share = if frame.ribs == 0 {
        point.dot(point).sqrt() / reach
    } else {
        rib.out
    };
    if depth_share > 1.0 && frame.leaf_clip == 1 && depth_share * reach - half_m * 1.5 > reach {
        return None;
    }
    let center = Vec3::from(instance.center) + instance.world(point) * instance.scale;
    let seen = center - Vec3::from(frame.eye);
    let away = seen.dot(Vec3::from(frame.forward));
    if away <= frame.near || half_m <= 0.0 {
        return None;
    }
    let metres_a_sample = away * frame.sample_size;
    let angle = hashed(salt ^ 2) * std::f32::consts::TAU;
    let samples = instance.scale / metres_a_sample;
    let laid = if frame.ribs == 0 {
        Laid::leaf(half_m * instance.scale / metres_a_sample, angle)
    } else {
        let wider = (points as f32 / count).sqrt().min(WIDEST) * numbers.leaf_side;
        rib.laid(frame, drawn, (samples, reach, grown), wider)
    };
    let across = seen.dot(Vec3::from(frame.right)) / (away * frame.tan_x);
    let upward = seen.dot(Vec3::from(frame.up)) / (away * frame.tan_y);
    let color_level = numbers.surface_levels.max(3) - 3;
    let (albedo, open) = surface_at(&drawn.crown.surface, direction, color_level);
    // Shade is that of the surface above the leaf: within the crown nothing would be lit.
    let normal_local = normal_from(radius, direction, reach, shape_level);
    let above = direction * reach + normal_local * (0.05 * numbers.mean_radius);
    let flat = if frame.ribs == FROM_AXIS { FLAT } else { 0.0 };
    let facing = normal_local + Vec3::new(0.0, flat, 0.0);
    let inside = (depth_share - 0.45).clamp(0.0, 0.45) / 0.45;
    let bright = 1.1 + 0.2 * hashed(salt ^ 3);
    let texels = atlas.size() as f32 / (2.0 * laid.half / laid.stretch.sqrt()).max(1.0);
    Some(Leaf {
        x: (across + 1.0) * 0.5 * frame.size[0],
        y: (1.0 - upward) * 0.5 * frame.size[1],
        depth: frame.near / away,
        laid,
        variant: salt % VARIANTS,
        level: libm::log2f(texels.max(1.0)).min((atlas.level_count() - 1) as f32),
        salt,
        albedo: albedo * Vec3::from(instance.tint) * bright,
        normal: instance.world(facing),
        open: open * (0.35 + 0.65 * inside),
        sunlit: sunlit_at(frame, drawn, above, shape_level) * (0.25 + 0.75 * inside),
        point,
        metres_a_sample: metres_a_sample / instance.scale,
        bound: match frame.leaf_clip {
            1 => 1.0,
            _ => 1.0 + FREEST * leaf_freedom(crown_samples * frame.pixels_a_sample),
        },
    })
}

/// The rib of a long leaf.
struct Rib {
    /// Where it begins, from the centre of the crown.
    root: Vec3,
    /// From there to its tip.
    along: Vec3,
    /// How far out its tip is, as a share of the crown's radius.
    out: f32,
}

impl Rib {
    /// The rib towards `surface`, of a leaf of that salt and size that has grown so far.
    #[inline(always)]
    fn new(
        frame: &Frame,
        numbers: &CrownNumbers,
        surface: Vec3,
        (salt, vary, grown): (u32, f32, f32),
    ) -> Self {
        let mut out = (0.6 + 0.4 * vary).min(1.0);
        let mut root = Vec3::ZERO;
        if frame.ribs == FROM_AXIS {
            let inner = hashed(salt ^ 4);
            out -= INNER * inner * inner;
            root = bough_root(surface * out, numbers.radius_range[1], numbers.mean_radius);
        }
        Self {
            root,
            along: (surface * out - root) * grown,
            out,
        }
    }

    /// How its leaf, `wider` than usual, lies on the screen, with so many samples for a metre of the crown, which
    /// reaches so far there.
    #[inline(always)]
    fn laid(
        &self,
        frame: &Frame,
        drawn: &Drawn<'_>,
        (samples, reach, grown): (f32, f32, f32),
        wider: f32,
    ) -> Laid {
        let length = if frame.ribs == FROM_AXIS {
            let own = self.along.dot(self.along).sqrt();
            own + (drawn.numbers.mean_radius * grown - own) * EVEN
        } else {
            reach
        };
        let along = drawn.instance.world(self.along) * samples;
        Laid::along(frame, along, samples * length * wider)
    }
}

/// How a leaf lies on the screen.
struct Laid {
    /// Half the side, samples.
    half: f32,
    /// Cosine and sine of its turn.
    spin: (f32, f32),
    /// How far it reaches to the right and down, in halves of its side.
    extent: (f32, f32),
    /// Halves of its side by halves of its width.
    stretch: f32,
    /// How far the middle of its rib lies aside of the ends, in halves of the width.
    bend: f32,
}

impl Laid {
    /// A square twig, turned by `angle`.
    fn leaf(half: f32, angle: f32) -> Self {
        Self {
            half,
            spin: (libm::cosf(angle), libm::sinf(angle)),
            extent: (1.0, 1.0),
            stretch: 1.0,
            bend: 0.0,
        }
    }

    /// A long leaf whose rib is `rib`, world, in samples, as wide as one of the length `full`.
    fn along(frame: &Frame, rib: Vec3, full: f32) -> Self {
        let (right, up) = (Vec3::from(frame.right), Vec3::from(frame.up));
        let (x, y) = (rib.dot(right), -rib.dot(up));
        let length = (x * x + y * y).sqrt();
        let half_width = 0.5 * frame.rib_slender * full;
        let half = (0.5 * length).max(SHORTEST * half_width);
        let (x, y) = (x / length.max(1e-6), y / length.max(1e-6));
        let aside = (rib.x * rib.x + rib.z * rib.z).sqrt();
        // The arch goes up on the screen; what of it is across the rib bends the leaf.
        let bend = -frame.rib_arch * aside * up.y * x / half_width.max(1e-6);
        let stretch = half / half_width.max(1e-6);
        let wide = (1.0 + bend.abs()) / stretch;
        Self {
            half,
            spin: (-y, -x),
            extent: (y.abs() * wide + x.abs(), x.abs() * wide + y.abs()),
            stretch,
            bend,
        }
    }
}

/// Draws leaves into a band.
pub(super) fn draw(
    frame: &Frame,
    drawn: &Drawn<'_>,
    leaves: &[Leaf],
    atlas: &LeafAtlas,
    band: &mut Band<'_>,
) {
    for leaf in leaves {
        let (wide, high) = (
            leaf.laid.half * leaf.laid.extent.0,
            leaf.laid.half * leaf.laid.extent.1,
        );
        let top = (leaf.y - high).max(band.rows.0 as f32) as u32;
        let bottom = (leaf.y + high + 1.0).clamp(0.0, band.rows.1 as f32) as u32;
        let left = (leaf.x - wide).max(0.0) as u32;
        let right = (leaf.x + wide + 1.0).clamp(0.0, band.width as f32) as u32;
        for y in top..bottom {
            for x in left..right {
                if !band.shows(x, y, leaf.depth) {
                    continue;
                }
                if let Some(light) = sample(frame, drawn, leaf, atlas, (x, y)) {
                    band.put(x, y, leaf.depth, [light.x, light.y, light.z, 1.0]);
                }
            }
        }
    }
}

/// The light of a leaf in a sample, where it covers it.
#[inline(always)]
fn sample(
    frame: &Frame,
    drawn: &Drawn<'_>,
    leaf: &Leaf,
    atlas: &LeafAtlas,
    (x, y): (u32, u32),
) -> Option<Vec3> {
    let InstanceNumbers { fade, dither, .. } = drawn.instance;
    let across = (x as f32 + 0.5 - leaf.x) / leaf.laid.half;
    let down = (y as f32 + 0.5 - leaf.y) / leaf.laid.half;
    let (wide, high) = leaf.laid.extent;
    if across.abs() > wide || down.abs() > high || pattern(x, y, dither) >= fade {
        return None;
    }
    let along = leaf.laid.spin.1 * across + leaf.laid.spin.0 * down;
    let bent = leaf.laid.bend * (1.0 - along * along);
    let u = 0.5
        + 0.5 * ((leaf.laid.spin.0 * across - leaf.laid.spin.1 * down) * leaf.laid.stretch - bent);
    let v = 0.5 + 0.5 * along;
    let whole = leaf.level as u32;
    let near = atlas.sampled(leaf.variant, whole, u, v);
    let far = atlas.sampled(leaf.variant, (whole + 1).min(atlas.level_count() - 1), u, v);
    let part = leaf.level - whole as f32;
    let shade = near.0 + (far.0 - near.0) * part;
    let coverage = near.1 + (far.1 - near.1) * part;
    // Sharp edges where a leaf's texels are large, noise where they are smaller than a sample.
    let noise = (pattern(x, y, leaf.salt) - 0.5) * 0.8 * leaf.level.min(1.0);
    if coverage < 0.5 + noise {
        return None;
    }
    let aside = Vec3::from(frame.right) * across - Vec3::from(frame.up) * down;
    if leaf.bound < 1.0 + FREEST {
        let local = drawn.instance.local(aside) * (leaf.laid.half * leaf.metres_a_sample);
        let place = leaf.point + local;
        let level = level_for(
            drawn.numbers.radius_size,
            drawn.numbers.radius_levels,
            drawn.numbers.radius_range[1] / leaf.metres_a_sample,
        ) as u32;
        if place.dot(place).sqrt() > drawn.crown.radius.sampled(place, level) * leaf.bound {
            return None;
        }
    }
    let turned = leaf.normal + aside * SPREAD;
    let normal = turned * (1.0 / turned.dot(turned).sqrt());
    if frame.view != 0 {
        return Some(match frame.view {
            2 => normal * 0.5 + Vec3::splat(0.5),
            3 => Vec3::splat(1.0 / (1.0 + frame.near / leaf.depth)),
            _ => Vec3::ZERO,
        });
    }
    Some(shaded(
        frame,
        &Place {
            albedo: leaf.albedo * (shade * (255.0 / 128.0)),
            normal,
            open: leaf.open,
            sunlit: leaf.sunlit,
            height: 0.5 + 0.5 * leaf.point.y / drawn.numbers.radius_range[1],
            depth: 1.0,
            ray: frame.ray(x as f32 + 0.5, y as f32 + 0.5),
            thin: 1.0,
        },
    ))
}
