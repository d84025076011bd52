//! Leaves that fall, and the limbs behind them.
//!
//! Leaves vanish in the order in which they turn; what is wood by its colour stays, but for specks
//! that hang on nothing. Behind it stand limbs grown into the crown's own outline, as deep as it is
//! wide, by space colonisation ([`crate::branches::skeleton`]) with the thickness of the pipe
//! model, in the colours of the trunk.

use super::colors;
use super::leaves::{Leaves, light};
use crate::base::{Cancel, Cancelled, Random, Seed};
use crate::branches::limbs::{Girth, girth};
use crate::branches::skeleton::{Reach, Skeleton, colonise};
use crate::raster::{Image, Straight, labelled_components};
use crate::segment::Label;
use crate::variation::Tree;
use crate::variation::noise::Noise;
use glam::{Vec2, Vec3};

/// Height of a crown in metres: only proportions count.
const CROWN_M: f32 = 10.0;

/// Points that want a twig.
const POINTS: usize = 1700;

/// Smallest remaining speck, as a share of the crown's pixels: smaller ones fall with the leaves.
const SPECK: f64 = 0.0004;

/// Colours of bark where the picture shows too little of its own.
const BARK: [[f64; 3]; 3] = [
    [44.0, 37.0, 32.0],
    [94.0, 83.0, 72.0],
    [156.0, 145.0, 130.0],
];

/// Fewest trunk pixels that tell the bark's colours.
const LEAST_BARK: usize = 150;

/// Takes the leaves off `tree`, that share of them.
pub(super) fn undress(
    tree: &mut Tree,
    leaves: &Leaves,
    amount: f64,
    seed: Seed,
    cancel: &Cancel,
) -> Result<(), Cancelled> {
    let bark = bark(tree);
    let stem = Stem::of(tree, leaves);
    let skeleton = limbs(leaves, &stem, seed, cancel)?;
    let mut limbs = Image::filled(tree.image.width(), tree.image.height(), Straight([0; 4]));
    paint(&mut limbs, &skeleton, &stem, &bark, seed);
    if amount < 1.0 {
        colors::turn(tree, leaves, super::Season::Autumn, 1.0, None, seed, cancel)?;
    }
    drop_leaves(tree, leaves, amount, seed);
    for (pixel, limb) in tree.image.pixels_mut().iter_mut().zip(limbs.pixels()) {
        *pixel = pixel.over(*limb);
    }
    for (label, pixel) in tree.labels.pixels_mut().iter_mut().zip(tree.image.pixels()) {
        if *label == Label::Background && pixel.alpha() >= 128 {
            *label = Label::Crown;
        }
    }
    Ok(())
}

/// Makes leaves clear in the order in which they turn, then the specks that are left.
fn drop_leaves(tree: &mut Tree, leaves: &Leaves, amount: f64, seed: Seed) {
    let fallen = colors::turned_shares(tree, leaves, amount, seed);
    let pixels = tree.image.pixels_mut().iter_mut().zip(&fallen);
    for ((pixel, fallen), share) in pixels.zip(leaves.share.pixels()) {
        let leaf = ((f64::from(*share) - 0.12) / 0.3).clamp(0.0, 1.0);
        pixel.0[3] = (f64::from(pixel.alpha()) * (1.0 - fallen * leaf) + 0.5) as u8;
    }
    let seen = tree.image.map(|pixel| pixel.alpha() >= 72);
    let parts = labelled_components(&seen);
    let mut sizes = std::collections::BTreeMap::new();
    for part in parts.pixels() {
        *sizes.entry(*part).or_insert(0usize) += 1;
    }
    let crown = leaves
        .share
        .pixels()
        .iter()
        .filter(|share| **share > 0.0)
        .count();
    let least = ((SPECK * crown as f64) as usize).max(12);
    let labels = tree.labels.pixels().iter();
    let parts = parts.pixels().iter().zip(seen.pixels()).zip(labels);
    for (pixel, ((part, seen), label)) in tree.image.pixels_mut().iter_mut().zip(parts) {
        let is_speck = !seen || sizes[part] < least;
        if *label != Label::Trunk && is_speck {
            pixel.0[3] = 0;
        }
    }
}

/// Colours of the trunk from shade to light.
fn bark(tree: &Tree) -> [[f64; 3]; 3] {
    let pixels = tree.image.pixels().iter().zip(tree.labels.pixels());
    let mut trunk: Vec<Straight> = pixels
        .filter(|(pixel, label)| **label == Label::Trunk && pixel.alpha() == 255)
        .map(|(pixel, _)| *pixel)
        .collect();
    if trunk.len() < LEAST_BARK {
        return BARK;
    }
    trunk.sort_by_key(|pixel| (light(*pixel), pixel.0));
    let mean = |from: f64, to: f64| {
        let at = |share: f64| (share * trunk.len() as f64) as usize;
        let part = &trunk[at(from)..at(to).max(at(from) + 1)];
        [0, 1, 2].map(|c| {
            part.iter().map(|pixel| f64::from(pixel.0[c])).sum::<f64>() / part.len() as f64
        })
    };
    [mean(0.05, 0.2), mean(0.4, 0.6), mean(0.85, 0.97)]
}

/// Where limbs begin.
struct Stem {
    /// Pixels of a metre.
    scale: f32,
    /// The place in the picture where the crown's stem begins.
    foot: Vec2,
    radius_m: f32,
    /// The lowest limb, in metres above the foot.
    bare_m: f32,
    /// How far the stem goes straight on, in metres.
    leader_m: f32,
}

impl Stem {
    fn of(tree: &Tree, leaves: &Leaves) -> Self {
        let bounds = leaves.bounds;
        let scale = bounds.height as f32 / CROWN_M;
        let low = bounds.y + bounds.height;
        // Rows of trunk below the upper fifth of the crown's lower half: the stem where it enters.
        let row = |y: u32| -> Option<(f32, f32)> {
            let labels = tree.labels.row(y);
            let trunk = labels
                .iter()
                .enumerate()
                .filter(|(_, l)| **l == Label::Trunk);
            let (mut sum, mut count) = (0.0f32, 0.0f32);
            for (x, _) in trunk {
                sum += x as f32;
                count += 1.0;
            }
            (count > 0.0).then(|| (sum / count, count))
        };
        let rows: Vec<(u32, (f32, f32))> = (bounds.y + bounds.height / 2..tree.labels.height())
            .filter_map(|y| Some((y, row(y)?)))
            .collect();
        let wide = |width: f32| width * 10.0 > bounds.width as f32 * 0.2;
        let entry = rows
            .iter()
            .find(|(_, (_, width))| wide(*width))
            .or(rows.first());
        let (foot, radius_px) = match entry {
            Some(&(y, (x, width))) => (Vec2::new(x, y as f32 + 2.0), 0.5 * width),
            None => {
                let middle = bounds.x as f32 + 0.5 * bounds.width as f32;
                (Vec2::new(middle, low as f32), bounds.height as f32 / 44.0)
            }
        };
        let slender = bounds.height as f32 / bounds.width as f32;
        let above = (foot.y - bounds.y as f32) / scale;
        Self {
            scale,
            foot,
            radius_m: (0.92 * radius_px / scale).clamp(0.07, 0.42),
            bare_m: 0.04 * above,
            leader_m: above * if slender > 1.5 { 0.8 } else { 0.3 },
        }
    }

    fn pixel_from_tree(&self, p: Vec3) -> Vec2 {
        self.foot + Vec2::new(p.x, -p.y) * self.scale
    }
}

/// Grows limbs into the crown.
fn limbs(leaves: &Leaves, stem: &Stem, seed: Seed, cancel: &Cancel) -> Result<Skeleton, Cancelled> {
    let mut random = seed.derive("limbs", 0).random();
    let points = points(leaves, stem, &mut random);
    let mut skeleton = Skeleton::default();
    let mut last = skeleton.grow(Vec3::ZERO, None);
    let step = 0.2;
    let mut lean = Vec3::ZERO;
    for i in 1..=(stem.leader_m / step) as usize {
        lean += Vec3::new(
            random.between(-0.004, 0.004) as f32,
            0.0,
            random.between(-0.004, 0.004) as f32,
        );
        let position = Vec3::new(0.0, i as f32 * step, 0.0) + lean * i as f32;
        last = skeleton.grow(position, Some(last));
    }
    let reach = Reach {
        step_m: step,
        kill_m: 0.32,
        influence_m: 6.0,
        tropism: Vec3::new(0.0, 0.12, 0.0),
        bare_m: stem.bare_m,
        crook: 0.26,
    };
    colonise(&mut skeleton, &points, &reach, &mut random, cancel)?;
    skeleton.relax(2);
    twigs(&mut skeleton, &mut random);
    Ok(skeleton)
}

/// Points in the crown, more of them near its surface.
fn points(leaves: &Leaves, stem: &Stem, random: &mut Random) -> Vec<Vec3> {
    let bounds = leaves.bounds;
    let rows: Vec<Option<(f32, f32)>> = (bounds.y..bounds.y + bounds.height)
        .map(|y| {
            let row = leaves.share.row(y);
            let first = row.iter().position(|share| *share > 0.0)?;
            let last = row.iter().rposition(|share| *share > 0.0)?;
            Some((first as f32, last as f32))
        })
        .collect();
    let mut points = Vec::with_capacity(POINTS);
    for _ in 0..40 * POINTS {
        if points.len() == POINTS {
            break;
        }
        let x = bounds.x + random.below(bounds.width as usize) as u32;
        let y = bounds.y + random.below(bounds.height as usize) as u32;
        let (deep, wish) = (random.between(-1.0, 1.0) as f32, random.unit() as f32);
        let Some((first, last)) = rows[(y - bounds.y) as usize] else {
            continue;
        };
        if leaves.share.at(x, y) <= 0.0 {
            continue;
        }
        let half = (0.5 * (last - first)).max(1.0);
        let aside = (x as f32 - 0.5 * (first + last)) / half;
        let depth = deep * (1.0 - aside * aside).max(0.0).sqrt();
        let outside = aside * aside + depth * depth;
        if wish > 0.25 + 0.75 * outside {
            continue;
        }
        let point = Vec3::new(
            (x as f32 - stem.foot.x) / stem.scale,
            (stem.foot.y - y as f32) / stem.scale,
            depth * half / stem.scale,
        );
        // What hangs below the lowest limb is reached from afar or not at all: no brush at its height.
        if point.y > stem.bare_m + 0.12 * Vec2::new(point.x, point.z).length() {
            points.push(point);
        }
    }
    points
}

/// Lets fine twigs grow from every tip, and again from those.
fn twigs(skeleton: &mut Skeleton, random: &mut Random) {
    for (count, length) in [(3, 0.42), (3, 0.26)] {
        let children = skeleton.children();
        let tips: Vec<u32> = (0..children.len() as u32)
            .filter(|&node| children[node as usize].is_empty())
            .collect();
        for tip in tips {
            let from = skeleton.nodes[tip as usize].position;
            let along = skeleton.direction(tip);
            for _ in 0..count {
                let mut side = || random.between(-0.9, 0.9) as f32;
                let aside = Vec3::new(side(), 0.6 * side() + 0.2, side());
                let direction = (along + aside).normalize_or(along);
                let reach = length * random.between(0.6, 1.1) as f32;
                let middle = skeleton.grow(from + direction * (0.5 * reach), Some(tip));
                let bend = Vec3::new(0.0, 0.08 * reach, 0.0);
                skeleton.grow(from + direction * reach + bend, Some(middle));
            }
        }
    }
}

/// Draws the limbs, the farthest first.
fn paint(
    image: &mut Image<Straight>,
    skeleton: &Skeleton,
    stem: &Stem,
    bark: &[[f64; 3]; 3],
    seed: Seed,
) {
    /// Radius of the thinnest twigs.
    const TIP_M: f32 = 0.0042;
    let girth: Girth = girth(skeleton, stem.radius_m, TIP_M);
    let depth = |index: &usize| skeleton.nodes[*index].position.z;
    let mut order: Vec<usize> = (1..skeleton.nodes.len()).collect();
    order.sort_by(|a, b| depth(a).total_cmp(&depth(b)).then(a.cmp(b)));
    let grain = Noise::new(&mut seed.derive("bark", 0).random());
    for index in order {
        let node = skeleton.nodes[index];
        let Some(parent) = node.parent.map(|parent| parent as usize) else {
            continue;
        };
        let thin = girth.radius_m[index];
        let piece = Piece {
            ends: [skeleton.nodes[parent].position, node.position]
                .map(|place| stem.pixel_from_tree(place)),
            radii: [girth.radius_m[parent].min(1.3 * thin), thin].map(|r| r * stem.scale),
            // What stands behind is seen through more twigs and less light.
            light: 0.86 + 0.14 * (node.position.z / (0.4 * CROWN_M)).clamp(-1.0, 1.0),
        };
        piece.draw(image, bark, &grain);
    }
}

/// A tapered piece of wood in the picture.
struct Piece {
    ends: [Vec2; 2],
    radii: [f32; 2],
    light: f32,
}

impl Piece {
    fn draw(&self, image: &mut Image<Straight>, bark: &[[f64; 3]; 3], grain: &Noise) {
        let [from, to] = self.ends;
        let room = Vec2::splat(self.radii[0].max(self.radii[1]) + 1.5);
        let (low, high) = (from.min(to) - room, from.max(to) + room);
        let last = Vec2::new(image.width() as f32 - 1.0, image.height() as f32 - 1.0);
        let (low, high) = (low.max(Vec2::ZERO), high.min(last));
        if low.x > high.x || low.y > high.y {
            return;
        }
        let axis = to - from;
        let squared = axis.length_squared().max(1e-6);
        let across = Vec2::new(-axis.y, axis.x) / squared.sqrt();
        for y in low.y as u32..=high.y as u32 {
            for x in low.x as u32..=high.x as u32 {
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
                let place = [f64::from(x) * 0.35, f64::from(y) * 0.12];
                let rough = grain.at(place) as f32 - 0.5;
                let rank = 0.46 + 0.38 * facing + 0.3 * rough * (radius / 3.0).min(1.0);
                let rank = f64::from((rank * self.light).clamp(0.0, 1.0));
                let [r, g, b] = colors::ramp_of(bark[0], bark[1], bark[2], rank);
                let own = Straight([r, g, b, (255.0 * cover + 0.5) as u8]);
                image.set(x, y, own.over(image.at(x, y)));
            }
        }
    }
}
