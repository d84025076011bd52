//! Another individual of a bare tree: its limbs in each other's places.
//!
//! Twigs cut into cells, as foliage is ([`super::cells`]), lie about in pieces. So limbs are found with all their twigs
//! ([`super::followed`]); each is taken off whole and stands in the place of another of about its size: turned to its
//! direction, as long, from either side.

use super::Tree;
use super::cells::share_changed;
use super::followed::{FOLLOWED, Followed};
use super::habit::Habit;
use super::sway::between;
use crate::base::{Cancel, Cancelled, Random};
use crate::raster::{Image, Straight, closed_and_filled};
use crate::segment::Label;
use std::f64::consts::{PI, TAU};

/// Share of a crown's closed outline that its twigs cover, up to which it is bare. Of the 39 real trees bare ones have
/// 0.40 to 0.64, palms 0.69, others 0.73 and more.
const BARE: f64 = 0.66;

/// Gaps up to twice this wide, in cell sizes, are closed for that.
const CLOSED: f64 = 0.5;

/// How many times as large or long a limb may be as the one whose place it takes, or as small.
const LARGER: f64 = 2.2;
const LONGER: f64 = 1.4;

/// Farthest that a limb is turned for its place, and how much it is besides, radians at full strength.
const TURNED: f64 = 0.75;
const ASIDE: f64 = 0.22;

/// How much longer or shorter limbs grow, at full strength.
const GROWTH: f64 = 0.2;

/// Limbs that are tried for a place.
const TRIES: usize = 16;

/// Whether the crown of `tree` is bare twigs; `side` is the size of a cell, pixels.
pub(super) fn is_bare(tree: &Tree, side: f64) -> bool {
    let seen = tree.image.map(|pixel| pixel.alpha() >= 96);
    let reach = (CLOSED * side).clamp(1.0, 60.0) as u8;
    let closed = closed_and_filled(&seen, reach).count().max(1);
    (seen.count() as f64) < BARE * closed as f64
}

/// `tree` with limbs in each other's places, `strength` saying how many. The same draws are made whatever the
/// strength.
///
/// # Errors
/// [`Cancelled`].
pub(super) fn relimbed(
    tree: &Tree,
    habit: &Habit,
    strength: f64,
    random: &mut Random,
    cancel: &Cancel,
) -> Result<Tree, Cancelled> {
    let followed = Followed::of(tree, cancel)?;
    let limbs = followed.limbs();
    let of_pixel = followed.limb_of_pixels(tree);
    let frame = [tree.image.width(), tree.image.height()].map(f64::from);
    // The leader of a spire stays: it is its tip.
    let stays = |limb: &Limb| habit.is_straight() && limb.top <= habit.top() + 2.0;
    let mut made = tree.clone();
    for (pixel, label) in without_limbs(&mut made, &of_pixel) {
        (*pixel, *label) = (Straight([0; 4]), Label::Background);
    }
    for (number, limb) in limbs.iter().enumerate() {
        cancel.check()?;
        let changes = random.unit() < share_changed(strength) && !stays(limb);
        let own = Placed::own(limb, number, strength, random);
        let tries: Vec<[f64; 3]> = (0..TRIES)
            .map(|_| [random.unit(), random.unit(), random.between(-1.0, 1.0)])
            .collect();
        let others = tries.into_iter().filter_map(|[which, side, aside]| {
            let donor = (which * limbs.len() as f64) as usize;
            let aside = strength * ASIDE * aside;
            Placed::of(limb, &limbs[donor], donor, side < 0.5, aside)
        });
        let still = Placed::still(limb, number);
        let fits = |placed: &Placed| placed.is_within(&limbs[placed.donor], frame);
        let placed = others
            .filter(|_| changes)
            .chain([own])
            .find(fits)
            .unwrap_or(still);
        let placed = if stays(limb) { still } else { placed };
        placed.draw(&limbs[placed.donor], (tree, &of_pixel), &mut made);
    }
    Ok(made)
}

/// All pixels of limbs, and of nothing, that are no trunk: it stays whole.
fn without_limbs<'a>(
    tree: &'a mut Tree,
    of_pixel: &'a Image<u16>,
) -> impl Iterator<Item = (&'a mut Straight, &'a mut Label)> {
    let pixels = tree.image.pixels_mut().iter_mut();
    let pixels = pixels.zip(tree.labels.pixels_mut());
    let pixels = pixels.zip(of_pixel.pixels());
    pixels
        .filter(|((_, label), limb)| **limb > 0 && **label != Label::Trunk)
        .map(|(pixel, _)| pixel)
}

/// A limb with its twigs; lengths in pixels of the tree's picture.
pub(super) struct Limb {
    base: [f64; 2],
    /// Of its middle from its base: angle and distance.
    direction: f64,
    length: f64,
    pixels: usize,
    top: f64,
    /// Places of its pixels in the smaller picture.
    places: Vec<[f64; 2]>,
}

impl Limb {
    pub(super) fn new(places: Vec<[f64; 2]>, base: [f64; 2]) -> Self {
        let count = places.len().max(1) as f64;
        let middle = [0, 1].map(|axis| places.iter().map(|place| place[axis]).sum::<f64>() / count);
        let (dx, dy) = (middle[0] - base[0], middle[1] - base[1]);
        Self {
            base,
            direction: libm::atan2(dy, dx),
            length: dx.hypot(dy).max(1.0),
            pixels: places.len(),
            top: places
                .iter()
                .map(|place| place[1])
                .fold(f64::INFINITY, f64::min),
            places,
        }
    }
}

/// A limb in a place: which one, and how it is turned, grown and moved.
#[derive(Clone, Copy)]
struct Placed {
    donor: usize,
    is_mirrored: bool,
    scale: f64,
    sin: f64,
    cos: f64,
    base: [f64; 2],
}

impl Placed {
    fn new(donor: usize, is_mirrored: bool, scale: f64, turn: f64, base: [f64; 2]) -> Self {
        Self {
            donor,
            is_mirrored,
            scale,
            sin: libm::sin(turn),
            cos: libm::cos(turn),
            base,
        }
    }

    /// The limb as it is.
    fn still(limb: &Limb, number: usize) -> Self {
        Self::new(number, false, 1.0, 0.0, limb.base)
    }

    /// The limb in its own place, turned a little.
    fn own(limb: &Limb, number: usize, strength: f64, random: &mut Random) -> Self {
        let turn = strength * ASIDE * random.between(-1.0, 1.0);
        let scale = 1.0 + strength * GROWTH * random.between(-1.0, 1.0);
        Self::new(number, false, scale, turn, limb.base)
    }

    /// Limb `donor` in the place of `limb`; `None` where it is another kind of limb.
    fn of(limb: &Limb, from: &Limb, donor: usize, is_mirrored: bool, aside: f64) -> Option<Self> {
        let direction = if is_mirrored {
            PI - from.direction
        } else {
            from.direction
        };
        let turn = (limb.direction - direction + PI).rem_euclid(TAU) - PI;
        let scale = limb.length / from.length;
        let larger = limb.pixels as f64 / from.pixels.max(1) as f64;
        let is_like = |value: f64, most: f64| (1.0 / most..=most).contains(&value);
        let fits = turn.abs() <= TURNED && is_like(scale, LONGER) && is_like(larger, LARGER);
        let scale = scale * (1.0 + GROWTH / ASIDE * aside);
        fits.then(|| Self::new(donor, is_mirrored, scale, turn + aside, limb.base))
    }

    /// Where a place of the donor comes to stand.
    fn moved(&self, from: &Limb, [x, y]: [f64; 2]) -> [f64; 2] {
        let (dx, dy) = (x - from.base[0], y - from.base[1]);
        let dx = if self.is_mirrored { -dx } else { dx };
        [
            self.base[0] + self.scale * (self.cos * dx - self.sin * dy),
            self.base[1] + self.scale * (self.sin * dx + self.cos * dy),
        ]
    }

    /// The place of the donor that stands here.
    fn source(&self, from: &Limb, [x, y]: [f64; 2]) -> [f64; 2] {
        let (dx, dy) = (x - self.base[0], y - self.base[1]);
        let (u, v) = (
            (self.cos * dx + self.sin * dy) / self.scale,
            (self.cos * dy - self.sin * dx) / self.scale,
        );
        let u = if self.is_mirrored { -u } else { u };
        [from.base[0] + u, from.base[1] + v]
    }

    /// Its bounds, left, top, right, bottom.
    fn bounds(&self, from: &Limb) -> [f64; 4] {
        let mut bounds = [
            f64::INFINITY,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::NEG_INFINITY,
        ];
        for &place in &from.places {
            let [x, y] = self.moved(from, place);
            bounds = [
                bounds[0].min(x),
                bounds[1].min(y),
                bounds[2].max(x),
                bounds[3].max(y),
            ];
        }
        bounds
    }

    fn is_within(&self, from: &Limb, [width, height]: [f64; 2]) -> bool {
        let [left, top, right, bottom] = self.bounds(from);
        left > 1.0 && top > 1.0 && right < width - 2.0 && bottom < height - 2.0
    }

    /// Draws it before what is in `made`.
    fn draw(&self, from: &Limb, (tree, of_pixel): (&Tree, &Image<u16>), made: &mut Tree) {
        let (width, height) = (made.image.width(), made.image.height());
        let number = self.donor as u16 + 1;
        let reach = 2.0 + self.scale * f64::from(width.max(height)) / FOLLOWED;
        let [left, top, right, bottom] = self.bounds(from);
        let within = |value: f64, count: u32| value.clamp(0.0, f64::from(count)) as u32;
        for y in within(top - reach, height)..within(bottom + reach, height) {
            for x in within(left - reach, width)..within(right + reach, width) {
                let [u, v] = self.source(from, [f64::from(x), f64::from(y)]);
                let shown = between([u, v], |column, row| {
                    let is_of_limb = of_pixel.get(column, row) == Some(number);
                    tree.image.get(column, row).filter(|_| is_of_limb)
                });
                if shown.alpha() == 0 {
                    continue;
                }
                let place = made.image.at(x, y);
                made.image.set(x, y, shown.over(place));
                if shown.alpha() >= 96 {
                    let near = |value: f64| (value + 0.5).floor() as i64;
                    let label = tree.labels.get(near(u), near(v)).unwrap_or_default();
                    if label != Label::Background {
                        made.labels.set(x, y, label);
                    }
                }
            }
        }
    }
}
