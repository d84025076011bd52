//! From a grown tree to its picture: parallel projection along z, daylight, bark and leaves.
//!
//! Light is computed in linear reflectance once for each leaf half and for each sample of wood:
//! sun by Lambert's cosine, sky by openness, both weakened by the crown ([`LightGrid`]); a leaf
//! that turns its back to the sun glows with what passes through it. Then a soft shoulder and the
//! sRGB curve.

use super::bark::Bark;
use super::canvas::{Canvas, FINENESS, Part};
use super::foliage::{Leaf, LeafTint, Leafage};
use super::light::{LightGrid, Reached, TO_SUN};
use super::limbs::Girth;
use super::noise::{noise2, ramp};
use super::skeleton::Skeleton;
use super::sprite::Sprite;
use crate::base::{Cancel, Cancelled};
use glam::{Vec2, Vec3};

/// Sunlight, linear, a little warm.
const SUN: Vec3 = Vec3::new(2.70, 2.46, 2.02);
/// Light of the whole sky, linear, a little blue.
const SKY: Vec3 = Vec3::new(0.62, 0.72, 0.86);
/// Light that has wandered through the crown: keeps the deepest shade from being black.
const STRAY: Vec3 = Vec3::new(0.050, 0.060, 0.040);

/// Share of colour that survives haze and lens: photographs of trees are never as green as paint.
const COLOURFULNESS: f32 = 0.91;

/// A tree ready to be painted.
pub struct Subject<'a> {
    /// The wood.
    pub skeleton: &'a Skeleton,
    /// Its thickness.
    pub girth: &'a Girth,
    /// The leaves.
    pub leafage: &'a Leafage,
    /// Their picture.
    pub sprite: &'a Sprite,
    /// Their colours.
    pub tint: &'a LeafTint,
    /// The bark.
    pub bark: &'a Bark,
    /// The light.
    pub light: &'a LightGrid,
    /// The tree's height in metres.
    pub height_m: f32,
    /// Height in metres below which thick wood counts as trunk.
    pub crown_base_m: f32,
}

/// Where the picture's samples lie in the tree's frame.
#[derive(Debug, Clone, Copy)]
pub struct View {
    /// Samples of a metre.
    pub scale: f32,
    /// x of the picture's left edge in metres.
    pub left_m: f32,
    /// y of the picture's top edge in metres.
    pub top_m: f32,
}

impl View {
    fn samples_from_tree(&self, p: Vec3) -> Vec2 {
        Vec2::new(
            (p.x - self.left_m) * self.scale,
            (self.top_m - p.y) * self.scale,
        )
    }
}

/// Paints the whole subject.
///
/// # Errors
/// [`Cancelled`].
pub fn paint(
    canvas: &mut Canvas,
    view: &View,
    subject: &Subject<'_>,
    cancel: &Cancel,
) -> Result<(), Cancelled> {
    paint_wood(canvas, view, subject);
    cancel.check()?;
    paint_twigs(canvas, view, subject);
    let palette = Palette::new(subject.tint);
    for batch in subject.leafage.leaves.chunks(4096) {
        cancel.check()?;
        for leaf in batch {
            paint_leaf(canvas, view, subject, &palette, leaf);
        }
    }
    Ok(())
}

/// A tint in linear light.
struct Palette {
    main: Vec3,
    other: Vec3,
    through: Vec3,
}

impl Palette {
    fn new(tint: &LeafTint) -> Self {
        let linear = |c: [u8; 3]| linear_from_srgb(Vec3::from_array(c.map(f32::from)));
        Self {
            main: linear(tint.main),
            other: linear(tint.other),
            through: linear(tint.through),
        }
    }
}

fn paint_leaf(
    canvas: &mut Canvas,
    view: &View,
    subject: &Subject<'_>,
    palette: &Palette,
    leaf: &Leaf,
) {
    let base = view.samples_from_tree(leaf.base);
    let along = Vec2::new(leaf.along.x, -leaf.along.y) * view.scale;
    let across = Vec2::new(leaf.across.x, -leaf.across.y) * view.scale;
    let area = along.perp_dot(across);
    if area.abs() < 0.3 {
        return;
    }
    let halves = leaf_halves(subject, palette, leaf);
    let stamp = Stamp {
        corner: base - across * 0.5,
        along,
        across,
        inverse_area: 1.0 / area,
        depth: leaf.base.z - leaf.across.z * 0.5,
        rise: (leaf.along.z, leaf.across.z),
    };
    stamp.press(canvas, subject.sprite, halves);
}

/// Colours of the two halves of a blade, folded a little along its midrib; sRGB 0..255.
fn leaf_halves(subject: &Subject<'_>, palette: &Palette, leaf: &Leaf) -> [Vec3; 2] {
    let place = leaf.base + leaf.along * 0.5;
    let reached = subject.light.at(place + leaf.outward * 0.12);
    let albedo = palette.main.lerp(palette.other, leaf.tone) * leaf.light;
    let across = leaf.across.normalize_or(Vec3::X);
    let facing = if leaf.normal.z < 0.0 {
        -leaf.normal
    } else {
        leaf.normal
    };
    [-0.38, 0.38].map(|fold| {
        let normal = (facing + across * fold).normalize_or(Vec3::Z);
        let clump = (normal * 0.6 + leaf.outward * 0.5).normalize_or(normal);
        let cosine = 0.55 * normal.dot(TO_SUN) + 0.45 * clump.dot(TO_SUN);
        let direct = albedo * SUN * (cosine.max(0.0) * reached.sun);
        let passed =
            palette.through * SUN * ((0.15 - normal.dot(TO_SUN)).max(0.0) * reached.sun * 0.55);
        let open = reached.sky * (0.62 + 0.38 * clump.y);
        let diffuse = albedo * (SKY * open + STRAY);
        let gloss = SKY * (0.016 * reached.sky * (0.5 + 0.5 * normal.y));
        shown(direct + passed + diffuse + gloss)
    })
}

/// A parallelogram that a sprite is pressed into.
struct Stamp {
    corner: Vec2,
    along: Vec2,
    across: Vec2,
    inverse_area: f32,
    depth: f32,
    rise: (f32, f32),
}

impl Stamp {
    fn press(&self, canvas: &mut Canvas, sprite: &Sprite, halves: [Vec3; 2]) {
        let far = self.corner + self.along + self.across;
        let (one, two) = (self.corner + self.along, self.corner + self.across);
        let low = self.corner.min(far).min(one).min(two);
        let high = self.corner.max(far).max(one).max(two);
        let Some((columns, rows)) = covered(canvas, low, high) else {
            return;
        };
        for y in rows {
            for x in columns.clone() {
                let offset = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) - self.corner;
                let u = offset.perp_dot(self.across) * self.inverse_area;
                let v = self.along.perp_dot(offset) * self.inverse_area;
                if !(0.0..1.0).contains(&u) || !(0.0..1.0).contains(&v) {
                    continue;
                }
                let depth = self.depth + self.rise.0 * u + self.rise.1 * v;
                if !canvas.sees(x, y, depth) {
                    continue;
                }
                let shade = sprite.shade(u, v);
                if shade > 0 {
                    let colour = halves[usize::from(v > 0.5)] * (f32::from(shade) / 128.0);
                    canvas.put(x, y, depth, bytes(colour), Part::Crown);
                }
            }
        }
    }
}

/// A tapered, straight piece of wood between two points.
struct Piece {
    from: Vec3,
    to: Vec3,
    /// Radii at both ends in metres.
    radius_m: (f32, f32),
    /// Length of wood from the root to `from`, in metres.
    path_m: f32,
    part: Part,
    salt: u32,
}

fn paint_wood(canvas: &mut Canvas, view: &View, subject: &Subject<'_>) {
    let stem_m = subject.girth.radius_m.first().copied().unwrap_or(0.1);
    for (index, node) in subject.skeleton.nodes.iter().enumerate() {
        let Some(parent) = node.parent else { continue };
        let from = subject.skeleton.nodes[parent as usize].position;
        let radius = |node: usize, y: f32| subject.girth.radius_m[node] * flare(y, stem_m);
        // A branch starts no thicker than twice its own radius inside its parent.
        let thin = radius(index, node.position.y);
        let thick = radius(parent as usize, from.y).min(thin * 1.25);
        let low = from.y.min(node.position.y) < subject.crown_base_m;
        let piece = Piece {
            from,
            to: node.position,
            radius_m: (thick, thin),
            path_m: subject.girth.path_m[parent as usize],
            part: if low && thin > 0.22 * stem_m {
                Part::Trunk
            } else {
                Part::Crown
            },
            salt: 0,
        };
        paint_piece(canvas, view, subject, &piece);
    }
    paint_roots(canvas, view, subject, stem_m);
}

/// Widening of the stem towards the ground.
fn flare(y: f32, stem_m: f32) -> f32 {
    1.0 + 0.42 * libm::expf(-y.max(0.0) / (1.9 * stem_m))
}

/// Root spurs that run from the foot into the ground.
fn paint_roots(canvas: &mut Canvas, view: &View, subject: &Subject<'_>, stem_m: f32) {
    if stem_m < 0.09 {
        return;
    }
    for spur in 0..7u32 {
        let chance = |salt: u32| noise2(spur as f32 * 5.13 + 0.4, stem_m * 50.0, salt);
        let angle = spur as f32 * 0.93 + 0.4 * chance(77);
        let out = Vec3::new(libm::cosf(angle), 0.0, libm::sinf(angle)) * stem_m;
        let up = Vec3::Y * stem_m;
        let reach = 1.65 + 0.45 * chance(78);
        let points = [
            (out * 0.42 + up * (2.5 + 0.6 * chance(79)), 0.50),
            (out * 0.78 + up * 0.95, 0.36),
            (out * reach - up * 0.12, 0.24),
        ];
        for pair in points.windows(2) {
            let piece = Piece {
                from: pair[0].0,
                to: pair[1].0,
                radius_m: (stem_m * pair[0].1, stem_m * pair[1].1),
                path_m: spur as f32 * 0.7,
                part: Part::Trunk,
                salt: spur,
            };
            paint_piece(canvas, view, subject, &piece);
        }
    }
}

fn paint_twigs(canvas: &mut Canvas, view: &View, subject: &Subject<'_>) {
    for twig in &subject.leafage.twigs {
        let piece = Piece {
            from: twig.from,
            to: twig.to,
            radius_m: (0.006, 0.003),
            path_m: 0.0,
            part: Part::Crown,
            salt: 0,
        };
        paint_piece(canvas, view, subject, &piece);
    }
}

fn paint_piece(canvas: &mut Canvas, view: &View, subject: &Subject<'_>, piece: &Piece) {
    /// Thinnest radius in samples: thinner wood would break into dots.
    const THINNEST: f32 = 0.75;
    let (from, to) = (
        view.samples_from_tree(piece.from),
        view.samples_from_tree(piece.to),
    );
    let radius = (
        (piece.radius_m.0 * view.scale).max(THINNEST),
        (piece.radius_m.1 * view.scale).max(THINNEST),
    );
    let widest = Vec2::splat(radius.0.max(radius.1) + 1.0);
    let Some((columns, rows)) = covered(canvas, from.min(to) - widest, from.max(to) + widest)
    else {
        return;
    };
    let axis = to - from;
    let length_squared = axis.length_squared().max(1e-6);
    let wood = Wood::new(view, subject, piece);
    for y in rows {
        for x in columns.clone() {
            let offset = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) - from;
            let t = (offset.dot(axis) / length_squared).clamp(0.0, 1.0);
            let here = radius.0 + (radius.1 - radius.0) * t;
            let aside = offset - axis * t;
            let across = aside.length() / here;
            if across >= 1.0 {
                continue;
            }
            let toward = (1.0 - across * across).sqrt();
            let depth = piece.from.z + (piece.to.z - piece.from.z) * t + toward * here / view.scale;
            if canvas.sees(x, y, depth) {
                let normal = Vec3::new(aside.x / here, -aside.y / here, toward);
                let along = offset.dot(axis) / length_squared;
                canvas.put(x, y, depth, wood.colour(normal, t, along), piece.part);
            }
        }
    }
}

/// What the samples of one piece of wood have in common.
struct Wood<'a> {
    subject: &'a Subject<'a>,
    piece: &'a Piece,
    ends: [Reached; 2],
    length_m: f32,
    right: Vec3,
    fine: bool,
}

impl<'a> Wood<'a> {
    fn new(view: &View, subject: &'a Subject<'a>, piece: &'a Piece) -> Self {
        let toward = Vec3::Z * 0.3;
        let axis = piece.to - piece.from;
        Self {
            subject,
            piece,
            ends: [piece.from, piece.to].map(|end| subject.light.at(end + toward)),
            length_m: axis.length(),
            right: axis.cross(Vec3::Z).normalize_or(Vec3::X),
            fine: piece.radius_m.0 * view.scale > 2.5,
        }
    }

    /// sRGB colour of a sample with the unit normal `normal`.
    fn colour(&self, normal: Vec3, t: f32, along: f32) -> [u8; 3] {
        let radius_m = self.piece.radius_m.0 + (self.piece.radius_m.1 - self.piece.radius_m.0) * t;
        let place = self.piece.from.lerp(self.piece.to, t);
        let along_m = self.piece.path_m + along * self.length_m;
        let around = normal.dot(self.right).clamp(-1.0, 1.0);
        let relief = if self.fine {
            let around_m = libm::asinf(around) * radius_m + self.piece.salt as f32 * 3.7;
            self.subject.bark.relief(around_m, along_m, radius_m)
        } else {
            1.0
        };
        let bark = self.subject.bark.colour(place.y / self.subject.height_m);
        let albedo = linear_from_srgb(bark * relief.clamp(0.1, 1.6).sqrt());
        let (a, b) = (self.ends[0], self.ends[1]);
        let sun = a.sun + (b.sun - a.sun) * t;
        let sky = a.sky + (b.sky - a.sky) * t;
        // Sun flecks wander over shaded wood.
        let wander = noise2(place.x * 5.0 + around, along_m * 3.0, 55);
        let fleck = 1.0 + (ramp(-0.3, 0.4, wander) - 0.6) * 1.7 * sun * (1.0 - sun);
        let cosine = (normal.dot(TO_SUN) * 0.9 + 0.1).max(0.0);
        let foot = 0.6 + 0.4 * ramp(0.0, 0.05, place.y / self.subject.height_m);
        let light = SUN * (cosine * sun * fleck * 0.8)
            + SKY * (sky * (0.68 + 0.25 * normal.y + 0.4 * normal.z)) * foot
            + STRAY;
        bytes(shown(albedo * light * relief.clamp(0.55, 1.25)))
    }
}

/// Columns and rows of the canvas between two corners; `None` when they are all outside.
fn covered(
    canvas: &Canvas,
    low: Vec2,
    high: Vec2,
) -> Option<(std::ops::Range<usize>, std::ops::Range<usize>)> {
    let side = |low: f32, high: f32, size: usize| {
        let start = libm::floorf(low).max(0.0) as usize;
        let end = (libm::ceilf(high).max(0.0) as usize).min(size);
        (start < end).then_some(start..end)
    };
    Some((
        side(low.x, high.x, canvas.width())?,
        side(low.y, high.y, canvas.height())?,
    ))
}

/// Linear reflectance from sRGB in 0..255, by a plain power of 2.2.
fn linear_from_srgb(srgb: Vec3) -> Vec3 {
    let power = |c: f32| libm::powf((c / 255.0).max(0.0), 2.2);
    Vec3::new(power(srgb.x), power(srgb.y), power(srgb.z))
}

/// sRGB in 0..255 from linear light, with a shoulder that keeps highlights below white.
fn shown(light: Vec3) -> Vec3 {
    let grey = Vec3::splat(light.dot(Vec3::new(0.25, 0.62, 0.13)));
    let light = grey.lerp(light, COLOURFULNESS);
    let channel = |c: f32| {
        let soft = c * (1.0 + 0.12 * c) / (1.0 + 0.55 * c);
        255.0 * libm::powf(soft.clamp(0.0, 1.0), 1.0 / 2.2)
    };
    Vec3::new(channel(light.x), channel(light.y), channel(light.z))
}

fn bytes(colour: Vec3) -> [u8; 3] {
    colour.to_array().map(|c| (c + 0.5).clamp(0.0, 255.0) as u8)
}

/// The view that fits a tree between `low` and `high` (metres) into `height_px` rows, and the
/// number of columns it needs.
pub fn fitted(low: Vec2, high: Vec2, height_px: u32) -> (View, u32) {
    /// Clear margin at the top and the sides, a share of the height.
    const MARGIN: f32 = 0.012;
    let scale_px = height_px as f32 * (1.0 - MARGIN) / high.y;
    let margin_m = MARGIN * height_px as f32 / scale_px;
    let width_px = libm::ceilf((high.x - low.x + 2.0 * margin_m) * scale_px).max(1.0);
    let view = View {
        scale: scale_px * FINENESS as f32,
        left_m: low.x - margin_m,
        top_m: high.y + margin_m,
    };
    (view, width_px as u32)
}
