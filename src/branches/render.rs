//! From a grown tree to its picture: parallel projection along z, daylight, bark and leaves.
//!
//! Light is computed in linear reflectance once for each leaf half and for each sample of wood:
//! sun by Lambert's cosine, sky by openness, both weakened by the crown ([`LightGrid`]); a leaf
//! that turns its back to the sun glows with what passes through it. Then a soft shoulder and the
//! sRGB curve.

use super::bark::Bark;
use super::canvas::{Canvas, Dab, FINENESS, Part};
use super::foliage::{Leaf, LeafTint, Leafage};
use super::light::{Daylight, LightGrid};
use super::ornament::Ornament;
use super::shadow::ShadowMap;
use super::spline::Limb;
use super::sprite::Sprite;
use super::wood::{paint_twigs, paint_wood};
use crate::base::{Cancel, Cancelled};
use glam::{Vec2, Vec3};

/// Share of colour that survives haze and lens: photographs of trees are never as green as paint.
const COLOURFULNESS: f32 = 0.97;

/// A tree ready to be painted.
pub struct Subject<'a> {
    /// The wood.
    pub limbs: &'a [Limb],
    /// The leaves.
    pub leafage: &'a Leafage,
    /// Blossom or fruit.
    pub ornaments: Option<Ornaments<'a>>,
    /// Their picture.
    pub sprite: &'a Sprite,
    /// Their colours.
    pub tint: &'a LeafTint,
    /// The bark.
    pub bark: &'a Bark,
    /// Sun and sky.
    pub daylight: &'a Daylight,
    /// What of them reaches a place on average.
    pub light: &'a LightGrid,
    /// What the sun sees.
    pub shadows: &'a ShadowMap,
    /// Length of a leaf in metres.
    pub leaf_m: f32,
    /// Radius of the stem in metres.
    pub stem_m: f32,
    /// The tree's height in metres.
    pub height_m: f32,
    /// Height in metres below which thick wood counts as trunk.
    pub crown_base_m: f32,
}

/// Blossom or fruit in place.
pub struct Ornaments<'a> {
    /// Where they hang.
    pub leaves: &'a [Leaf],
    /// Their picture.
    pub sprite: Sprite,
    /// What they are.
    pub ornament: &'a Ornament,
}

impl Subject<'_> {
    /// Share of the sun, 0..1, at `place`: what the crown lets through on average, and whether this
    /// very place is hidden.
    pub(super) fn sun_at(&self, place: Vec3, average: f32) -> f32 {
        /// Weight of the single shadow against the mean of the crown.
        const SINGLE: f32 = 0.62;
        let lit = self.shadows.lit(place, 0.7 * self.leaf_m);
        average + (lit - average) * SINGLE
    }
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
    /// The view that fits a tree between `low` and `high` (metres) into a picture of `width` ×
    /// `height` pixels, its foot in the middle of the lower edge.
    pub fn fitted((low, high): (Vec2, Vec2), (width, height): (u32, u32)) -> Self {
        /// Clear margin at the top and the sides, a share of the side.
        const MARGIN: f32 = 0.012;
        let half_m = high.x.max(-low.x).max(0.05);
        let upright = height as f32 * (1.0 - MARGIN) / high.y;
        let across = width as f32 * (0.5 - MARGIN) / half_m;
        let scale_px = upright.min(across);
        Self {
            scale: scale_px * FINENESS as f32,
            left_m: -0.5 * width as f32 / scale_px,
            top_m: height as f32 / scale_px,
        }
    }

    /// Pixels of a metre.
    pub fn pixels_of_metre(&self) -> f32 {
        self.scale / FINENESS as f32
    }

    pub(super) fn samples_from_tree(&self, p: Vec3) -> Vec2 {
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
    let leaves = &subject.leafage.leaves;
    paint_leaves(
        canvas,
        view,
        subject,
        (leaves, subject.sprite, &palette),
        cancel,
    )?;
    if let Some(ornaments) = &subject.ornaments {
        let [main, other] = ornaments.ornament.colours.map(linear);
        let palette = Palette {
            main,
            other,
            through: other * 0.5,
        };
        let stamps = (ornaments.leaves, &ornaments.sprite, &palette);
        paint_leaves(canvas, view, subject, stamps, cancel)?;
    }
    Ok(())
}

fn paint_leaves(
    canvas: &mut Canvas,
    view: &View,
    subject: &Subject<'_>,
    (leaves, sprite, palette): (&[Leaf], &Sprite, &Palette),
    cancel: &Cancel,
) -> Result<(), Cancelled> {
    for batch in leaves.chunks(4096) {
        cancel.check()?;
        for leaf in batch {
            paint_leaf(canvas, view, subject, (sprite, palette), leaf);
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
        Self {
            main: linear(tint.main),
            other: linear(tint.other),
            through: linear(tint.through),
        }
    }
}

/// Linear reflectance of an sRGB colour.
fn linear(colour: [u8; 3]) -> Vec3 {
    linear_from_srgb(Vec3::from_array(colour.map(f32::from)))
}

fn paint_leaf(
    canvas: &mut Canvas,
    view: &View,
    subject: &Subject<'_>,
    (sprite, palette): (&Sprite, &Palette),
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
    stamp.press(canvas, sprite, &halves);
}

/// One half of a blade: its colour, sRGB 0..255, and its normal.
struct Half {
    colour: Vec3,
    normal: Vec3,
}

/// The two halves of a blade, folded a little along its midrib.
fn leaf_halves(subject: &Subject<'_>, palette: &Palette, leaf: &Leaf) -> [Half; 2] {
    let place = leaf.base + leaf.along * 0.5;
    let reached = subject.light.at(place + leaf.outward * 0.12);
    let albedo = palette.main.lerp(palette.other, leaf.tone) * leaf.light;
    let across = leaf.across.normalize_or(Vec3::X);
    let facing = if leaf.normal.z < 0.0 {
        -leaf.normal
    } else {
        leaf.normal
    };
    let Daylight {
        to_sun,
        sun,
        sky,
        stray,
    } = *subject.daylight;
    [-0.38, 0.38].map(|fold| {
        let normal = (facing + across * fold).normalize_or(Vec3::Z);
        let clump = (normal * 0.6 + leaf.outward * 0.5).normalize_or(normal);
        let sunny = subject.sun_at(place + leaf.across * (0.6 * fold), reached.sun);
        let cosine = 0.55 * normal.dot(to_sun) + 0.45 * clump.dot(to_sun);
        let direct = albedo * sun * (cosine.max(0.0) * sunny);
        let passed = palette.through * sun * ((0.15 - normal.dot(to_sun)).max(0.0) * sunny * 0.55);
        let open = reached.sky * (0.62 + 0.38 * clump.y);
        let diffuse = albedo * (sky * open + stray);
        let gloss = sky * (0.020 * reached.sky * (0.5 + 0.5 * normal.y));
        Half {
            colour: shown(direct + passed + diffuse + gloss),
            normal,
        }
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
    fn press(&self, canvas: &mut Canvas, sprite: &Sprite, halves: &[Half; 2]) {
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
                    let half = &halves[usize::from(v > 0.5)];
                    let dab = Dab {
                        colour: bytes(half.colour * (f32::from(shade) / 128.0)),
                        part: Part::Crown,
                        normal: half.normal,
                    };
                    canvas.put(x, y, depth, &dab);
                }
            }
        }
    }
}

/// Columns and rows of the canvas between two corners; `None` when they are all outside.
pub(super) fn covered(
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

/// Linear reflectance from sRGB in 0..255: a cubic within 0.002 of the standard's curve, with no
/// power function, which would take a third of all time.
pub(super) fn linear_from_srgb(srgb: Vec3) -> Vec3 {
    let c = srgb * (1.0 / 255.0);
    c * (c * (c * 0.305_306 + 0.682_171) + 0.012_523)
}

/// sRGB in 0..255 from linear light, with a shoulder that keeps highlights below white.
pub(super) fn shown(light: Vec3) -> Vec3 {
    let grey = Vec3::splat(light.dot(Vec3::new(0.25, 0.62, 0.13)));
    let light = grey.lerp(light, COLOURFULNESS);
    let channel = |c: f32| {
        let soft = c * (1.0 + 0.12 * c) / (1.0 + 0.55 * c);
        let root = soft.clamp(0.0, 1.0).sqrt();
        let fourth = root.sqrt();
        // A fit of the standard's curve by roots, within one level from 15 up.
        255.0 * (0.585_122 * root + 0.783_140 * fourth - 0.368_263 * fourth.sqrt())
    };
    Vec3::new(channel(light.x), channel(light.y), channel(light.z))
}

pub(super) fn bytes(colour: Vec3) -> [u8; 3] {
    colour.to_array().map(|c| (c + 0.5).clamp(0.0, 255.0) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curves_keep_dark_below_light_and_ends_in_place() {
        assert_eq!(linear_from_srgb(Vec3::ZERO), Vec3::ZERO);
        assert!((linear_from_srgb(Vec3::splat(255.0)).x - 1.0).abs() < 1e-4);
        assert_eq!(bytes(shown(Vec3::ZERO)), [0; 3]);
        let levels: Vec<u8> = (0..100)
            .map(|i| bytes(shown(Vec3::splat(i as f32 * 0.03)))[0])
            .collect();
        assert!(levels.windows(2).all(|pair| pair[0] <= pair[1]));
    }

    #[test]
    fn a_fitted_view_holds_the_tree_with_its_foot_in_the_middle_of_the_lower_edge() {
        let size = (150, 200);
        for (low, high) in [
            (Vec2::new(-2.0, 0.0), Vec2::new(3.0, 18.0)),
            (Vec2::new(-9.0, 0.0), Vec2::new(3.0, 5.0)),
        ] {
            let view = View::fitted((low, high), size);
            let foot = view.samples_from_tree(Vec3::ZERO);
            let middle = Vec2::new((75 * FINENESS) as f32, (200 * FINENESS) as f32);
            assert!(foot.distance(middle) < 0.01);
            let corner = view.samples_from_tree(Vec3::new(low.x, high.y, 0.0));
            assert!(corner.min_element() > 0.0);
            let right = view.samples_from_tree(Vec3::new(high.x, 1.0, 0.0)).x;
            assert!(right < 150.0 * FINENESS as f32);
        }
    }
}
