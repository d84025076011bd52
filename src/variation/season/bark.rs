//! Limbs drawn as wood: tapered, lit from the upper left, in the colours of the trunk that the picture shows.

use super::colors::{Ramp, ramp_of};
use super::growth::{CROWN_M, Stem};
use super::leaves::{is_green_leaf, light};
use crate::base::{Cancel, Cancelled, Seed};
use crate::branches::limbs::girth;
use crate::branches::skeleton::Skeleton;
use crate::raster::{Image, Straight};
use crate::segment::Label;
use crate::variation::Tree;
use crate::variation::noise::Noise;
use glam::Vec2;
use rayon::prelude::*;

/// Radius of the thinnest twigs.
const TIP_M: f32 = 0.0042;

/// Radii up to which wood has the colour of twigs and from which that of the trunk.
const TWIG_M: [f32; 2] = [0.015, 0.09];

/// Height above the neck over which the shade that lies on the trunk there fades, in metres.
const SHADED_M: f32 = 2.5;

/// Colours of bark where the picture shows too little of its own.
const BARK: Ramp = [
    [44.0, 37.0, 32.0],
    [94.0, 83.0, 72.0],
    [156.0, 145.0, 130.0],
];

/// Fewest trunk pixels that tell the bark's colours.
const LEAST_BARK: usize = 150;

/// How the wood of a tree looks.
pub(super) struct Bark {
    trunk: Ramp,
    /// Twigs are no lighter than [`BARK`], as those of birches are not.
    twigs: Ramp,
    /// Light of the trunk about its neck, as a share of that of all of it.
    shade: f32,
}

impl Bark {
    pub(super) fn of(tree: &Tree, stem: &Stem) -> Self {
        let width = tree.image.width() as usize;
        let pixels = tree.image.pixels().iter().zip(tree.labels.pixels());
        let pixels = pixels.enumerate();
        let trunk: Vec<(usize, Straight)> = pixels
            .filter(|(_, (pixel, label))| {
                **label == Label::Trunk && pixel.alpha() == 255 && !is_green_leaf(**pixel)
            })
            .map(|(at, (pixel, _))| (at / width, *pixel))
            .collect();
        if trunk.len() < LEAST_BARK {
            return Self {
                trunk: BARK,
                twigs: BARK,
                shade: 1.0,
            };
        }
        let mean = |rows: std::ops::Range<f32>| {
            let near = trunk.iter().filter(|(y, _)| rows.contains(&(*y as f32)));
            let (sum, count) = near.fold((0.0, 0.0), |(sum, count), (_, pixel)| {
                (sum + f32::from(light(*pixel)), count + 1.0)
            });
            (count > 0.0).then_some(sum / count)
        };
        let neck = 0.0..stem.foot.y;
        let shade = mean(neck).zip(mean(0.0..f32::INFINITY));
        let ramp = ramp(trunk.into_iter().map(|(_, pixel)| pixel).collect());
        let is_light = ramp[1].iter().sum::<f64>() > BARK[1].iter().sum();
        Self {
            trunk: ramp,
            twigs: if is_light { BARK } else { ramp },
            shade: shade.map_or(1.0, |(neck, all)| (neck / all.max(1.0)).clamp(0.4, 1.2)),
        }
    }

    /// The colour of wood of that radius where light has this rank.
    fn color(&self, radius_m: f32, rank: f64) -> [u8; 3] {
        let [thin, thick] = TWIG_M;
        let share = f64::from(((radius_m - thin) / (thick - thin)).clamp(0.0, 1.0));
        let ramp = [0, 1, 2].map(|step| {
            let (twig, trunk) = (self.twigs[step], self.trunk[step]);
            [0, 1, 2].map(|c| twig[c] + (trunk[c] - twig[c]) * share)
        });
        ramp_of(&ramp, rank)
    }
}

/// The colours of `pixels` from shade to light.
fn ramp(mut pixels: Vec<Straight>) -> Ramp {
    pixels.sort_by_key(|pixel| (light(*pixel), pixel.0));
    let mean = |from: f64, to: f64| {
        let at = |share: f64| (share * pixels.len() as f64) as usize;
        let part = &pixels[at(from)..at(to).max(at(from) + 1)];
        [0, 1, 2].map(|c| {
            part.iter().map(|pixel| f64::from(pixel.0[c])).sum::<f64>() / part.len() as f64
        })
    };
    [mean(0.05, 0.2), mean(0.4, 0.6), mean(0.85, 0.97)]
}

/// Draws the limbs, the farthest first.
///
/// # Errors
/// [`Cancelled`].
pub(super) fn paint(
    image: &mut Image<Straight>,
    skeleton: &Skeleton,
    stem: &Stem,
    bark: &Bark,
    seed: Seed,
    cancel: &Cancel,
) -> Result<(), Cancelled> {
    /// Rows that are drawn together.
    const BAND: usize = 32;
    let radius_m = girth(skeleton, stem.radius_m, TIP_M).radius_m;
    let depth = |index: &usize| skeleton.nodes[*index].position.z;
    let mut order: Vec<usize> = (1..skeleton.nodes.len()).collect();
    order.sort_by(|a, b| depth(a).total_cmp(&depth(b)).then(a.cmp(b)));
    let grain = Noise::new(&mut seed.derive("bark", 0).random());
    let piece = |index: usize| {
        let node = skeleton.nodes[index];
        let parent = node.parent? as usize;
        let thin = radius_m[index];
        let above = (stem.above_neck_m(node.position) / SHADED_M).clamp(0.0, 1.0);
        let shade = bark.shade + (1.0 - bark.shade) * above;
        // What stands behind is seen through more twigs and less light.
        let light = 0.86 + 0.14 * (node.position.z / (0.4 * CROWN_M)).clamp(-1.0, 1.0);
        Some(Piece {
            ends: [skeleton.nodes[parent].position, node.position]
                .map(|place| stem.pixel_from_tree(place)),
            radii: [radius_m[parent].min(1.3 * thin), thin].map(|r| r * stem.scale),
            scale: stem.scale,
            light: light * shade,
        })
    };
    let pieces: Vec<Piece> = order.into_iter().filter_map(piece).collect();
    let width = image.width() as usize;
    let bands = image.pixels_mut().par_chunks_mut(BAND * width).enumerate();
    bands.try_for_each(|(band, pixels)| {
        cancel.check()?;
        for piece in &pieces {
            piece.draw((BAND * band, pixels), width, bark, &grain);
        }
        Ok(())
    })
}

/// A tapered piece of wood in the picture.
struct Piece {
    ends: [Vec2; 2],
    radii: [f32; 2],
    /// Pixels of a metre.
    scale: f32,
    light: f32,
}

impl Piece {
    /// Draws what lies in the rows `pixels` of a picture, the first of which is the row `top`.
    fn draw(
        &self,
        (top, pixels): (usize, &mut [Straight]),
        width: usize,
        bark: &Bark,
        grain: &Noise,
    ) {
        let [from, to] = self.ends;
        let room = Vec2::splat(self.radii[0].max(self.radii[1]) + 1.5);
        let (low, high) = (from.min(to) - room, from.max(to) + room);
        let end = Vec2::new(width as f32, (top + pixels.len() / width) as f32);
        let (low, high) = (low.max(Vec2::new(0.0, top as f32)), high.min(end - 1.0));
        if low.x > high.x || low.y > high.y {
            return;
        }
        let axis = to - from;
        let squared = axis.length_squared().max(1e-6);
        let across = Vec2::new(-axis.y, axis.x) / squared.sqrt();
        for y in low.y as usize..=high.y as usize {
            let mut grain = grain.row(y as f64 * 0.12);
            for x in low.x as usize..=high.x as usize {
                let offset = Vec2::new(x as f32, y as f32) - from;
                let t = (offset.dot(axis) / squared).clamp(0.0, 1.0);
                let radius = self.radii[0] + (self.radii[1] - self.radii[0]) * t;
                let aside = offset - axis * t;
                let distance = aside.length();
                let cover =
                    (radius.max(0.5) + 0.5 - distance).clamp(0.0, 1.0) * (2.0 * radius).min(1.0);
                if cover <= 0.0 {
                    continue;
                }
                // Light from the upper left.
                let facing =
                    aside.dot(across) / radius.max(0.5) * across.dot(Vec2::new(-0.6, -0.8));
                let rough = grain.at(x as f64 * 0.35) as f32 - 0.5;
                let rank = 0.46 + 0.38 * facing + 0.3 * rough * (radius / 3.0).min(1.0);
                let rank = f64::from((rank * self.light).clamp(0.0, 1.0));
                let [r, g, b] = bark.color(radius / self.scale, rank);
                let own = Straight([r, g, b, (255.0 * cover + 0.5) as u8]);
                let pixel = &mut pixels[(y - top) * width + x];
                *pixel = own.over(*pixel);
            }
        }
    }
}
