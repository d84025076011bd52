//! Smart select: a few strokes inside and outside, and the outline between them is found.
//!
//! On a small version of the photograph two colour models, one of what is inside and one of what is
//! outside, and the contrast between neighbours give each division into inside and outside a cost;
//! the cheapest is a minimum cut. The models are learned again from it, and so on a few times. The
//! outline is then made finer level by level, each time by a cut in a narrow band around it, so that
//! a photograph of 8192² costs little more than a small one.
//!
//! This work is based on: C. Rother, V. Kolmogorov & A. Blake, *"GrabCut": Interactive Foreground
//! Extraction using Iterated Graph Cuts*, SIGGRAPH 2004; and H. Lombaert, Y. Sun, L. Grady & C. Xu, *A
//! Multilevel Banded Graph Cuts Method for Fast Image Segmentation*, ICCV 2005. Departures: strokes
//! instead of a rectangle; colours count where they are; what is nearer to strokes of one kind leans that way, for trees stand
//! before trees of their own colour; pieces that no inside stroke touches are dropped.
//!
//! Limits: details thinner than about 1/400 of the photograph are found only where they hang on
//! something thicker. Colours of clear pixels count as black.

use super::color_model::{ColorModel, Place};
use super::tiled::TiledMask;
use crate::base::{Cancel, Cancelled};
use crate::raster::{Image, Mask, Straight, labelled_components};
use crate::solve::{Edge, HARD, Network};
use std::borrow::Cow;

/// In hints: this pixel is inside.
pub const INSIDE: u8 = 1;

/// In hints: this pixel is outside.
pub const OUTSIDE: u8 = 2;

/// Longest side of the version that is cut as a whole, pixels.
const COARSE_SIDE: u32 = 400;

/// Times that colours are learned from the last cut; later ones change single pixels.
const ROUNDS: usize = 4;

/// What it costs to part two neighbours of equal colour, in units of the logarithm of a likelihood.
/// GrabCut's 50 makes crowns smooth as balloons.
const SMOOTHNESS: f64 = 5.0;

/// What nearness to strokes counts at most.
const NEARNESS: f64 = 1.5;

/// Largest difference of the two models' costs: one odd pixel shall not decide over many.
const MOST_DIFFERENCE: f64 = 8.0;

/// Whole numbers for a unit of cost.
const UNIT: f64 = 256.0;

/// The neighbours that edges are made to; the other four make theirs to us.
const FORWARD: [(i64, i64); 4] = [(1, 0), (0, 1), (1, 1), (-1, 1)];

/// A version of the photograph, with its hints.
struct Level<'a> {
    photo: Cow<'a, Image<Straight>>,
    hints: Cow<'a, Image<u8>>,
}

/// What is inside according to `hints`: [`INSIDE`] and [`OUTSIDE`] where strokes are, 0 elsewhere.
///
/// The border of the photograph stands in for outside strokes where there are none. Without inside
/// strokes nothing is selected. Pixels under strokes are always as they say.
///
/// # Errors
/// [`Cancelled`].
///
/// # Panics
/// When photograph and hints differ in size.
pub fn smart_selection(
    photo: &Image<Straight>,
    hints: &TiledMask,
    cancel: &Cancel,
) -> Result<TiledMask, Cancelled> {
    let (width, height) = (photo.width(), photo.height());
    assert_eq!(
        (width, height),
        (hints.width(), hints.height()),
        "hints of the photograph"
    );
    if hints.count(|hint| hint == INSIDE) == 0 {
        return Ok(TiledMask::filled(width, height, 0));
    }
    let full = hints.image();
    let mut levels = vec![Level {
        photo: Cow::Borrowed(photo),
        hints: Cow::Borrowed(&full),
    }];
    while let Some(last) = levels.last()
        && last.photo.width().max(last.photo.height()) > COARSE_SIDE
    {
        cancel.check()?;
        let half = halved(last);
        levels.push(half);
    }
    let mut levels = levels.into_iter().rev();
    let Some(coarsest) = levels.next() else {
        unreachable!("there is the photograph itself");
    };
    let (mut inside, models) = cut_whole(&coarsest, cancel)?;
    for level in levels {
        inside = refined(&level, &inside, &models, cancel)?;
    }
    Ok(TiledMask::from_mask(&inside, 1))
}

/// The colour models of inside and outside.
struct Models {
    inside: ColorModel,
    outside: ColorModel,
}

impl Models {
    /// How much more it costs to call a colour outside than inside.
    fn lean(&self, photo: &Image<Straight>, x: u32, y: u32) -> f64 {
        let (color, place) = (color(photo.at(x, y)), place(photo, x, y));
        let difference = self.outside.cost(color, place) - self.inside.cost(color, place);
        difference.clamp(-MOST_DIFFERENCE, MOST_DIFFERENCE)
    }
}

/// The cheapest division of a whole level, and the colours of its two sides.
fn cut_whole(level: &Level<'_>, cancel: &Cancel) -> Result<(Mask, Models), Cancelled> {
    let (photo, hints) = (&*level.photo, &*level.hints);
    let nearness = nearness(hints);
    let all: Vec<Vec<u32>> = (0..photo.height())
        .map(|_| (0..photo.width()).collect())
        .collect();
    let mut inside = hints.map(|&hint| hint == INSIDE);
    let mut models = models(photo, |x, y| match hints.at(x, y) {
        INSIDE => Some(true),
        OUTSIDE => Some(false),
        _ => None,
    });
    for _ in 0..ROUNDS {
        let lean = |x: u32, y: u32| models.lean(photo, x, y) + nearness.at(x, y);
        let new = cut(level, &inside, &all, lean, cancel)?;
        let is_stable = new == inside;
        inside = new;
        if is_stable {
            break;
        }
        models = self::models(photo, |x, y| Some(inside.at(x, y)));
    }
    keep_touched(&mut inside, hints);
    Ok((inside, models))
}

/// The division of the next finer level, from that of the coarser one.
fn refined(
    level: &Level<'_>,
    coarse: &Mask,
    models: &Models,
    cancel: &Cancel,
) -> Result<Mask, Cancelled> {
    let (width, height) = (level.photo.width(), level.photo.height());
    let parent = |x: u32, y: u32| {
        (
            (x / 2).min(coarse.width() - 1),
            (y / 2).min(coarse.height() - 1),
        )
    };
    let mut inside = Image::filled(width, height, false);
    for y in 0..height {
        for (x, pixel) in (0..).zip(inside.row_mut(y)) {
            let (px, py) = parent(x, y);
            *pixel = coarse.at(px, py);
        }
    }
    cancel.check()?;
    let near = near_outline(coarse);
    let in_row = |y: u32| (0..width).filter(move |&x| y < height && x < width);
    let band = (0..height).map(|y| {
        in_row(y)
            .filter(|&x| {
                let (px, py) = parent(x, y);
                near.at(px, py)
            })
            .collect()
    });
    let band: Vec<Vec<u32>> = band.collect();
    let lean = |x: u32, y: u32| models.lean(&level.photo, x, y);
    cut(level, &inside, &band, lean, cancel)
}

/// The cheapest division in which only the pixels of `free` (columns in each row, ascending) may be
/// other than in `inside`; `lean` tells what it costs more to be outside.
fn cut(
    level: &Level<'_>,
    inside: &Mask,
    free: &[Vec<u32>],
    lean: impl Fn(u32, u32) -> f64,
    cancel: &Cancel,
) -> Result<Mask, Cancelled> {
    let (photo, hints) = (&*level.photo, &*level.hints);
    let mut first = vec![0];
    first.extend(free.iter().scan(0, |sum, row| {
        *sum += row.len();
        Some(*sum)
    }));
    let count = first[free.len()];
    let node = |x: i64, y: i64| {
        let row = free.get(usize::try_from(y).ok()?)?;
        let place = row.binary_search(&u32::try_from(x).ok()?).ok()?;
        Some(first[y as usize] + place)
    };
    let softness = softness(photo, free);
    // What the fixed neighbours of a free pixel cost it: positive towards inside.
    let mut pull = vec![0.0; count];
    let mut edges = Vec::new();
    for (y, row) in (0i64..).zip(free) {
        if y % 64 == 0 {
            cancel.check()?;
        }
        for (&column, own) in row.iter().zip(first[y as usize]..) {
            let x = i64::from(column);
            let here = photo.at(column, y as u32);
            for (dx, dy) in FORWARD
                .into_iter()
                .chain(FORWARD.map(|(dx, dy)| (-dx, -dy)))
            {
                let Some(there) = photo.get(x + dx, y + dy) else {
                    continue;
                };
                let length = if dx != 0 && dy != 0 {
                    std::f64::consts::SQRT_2
                } else {
                    1.0
                };
                let apart = libm::exp(-difference(here, there) * softness);
                let cost = SMOOTHNESS * apart / length;
                match node(x + dx, y + dy) {
                    Some(other) if other > own => {
                        let capacity = (cost * UNIT) as i32;
                        let (a, b) = (own as u32, other as u32);
                        edges.push(Edge {
                            a,
                            b,
                            forward: capacity,
                            backward: capacity,
                        });
                    }
                    Some(_) => {}
                    None if inside.at((x + dx) as u32, (y + dy) as u32) => pull[own] += cost,
                    None => pull[own] -= cost,
                }
            }
        }
    }
    let mut network = Network::new(count, &edges);
    drop(edges);
    let pixels = (0u32..)
        .zip(free)
        .flat_map(|(y, row)| row.iter().map(move |&x| (x, y)));
    for ((x, y), (index, pull)) in pixels.clone().zip(pull.iter().enumerate()) {
        let lean = ((lean(x, y) + pull) * UNIT) as i32;
        match hints.at(x, y) {
            INSIDE => network.join_source(index, HARD),
            OUTSIDE => network.join_sink(index, HARD),
            _ if lean > 0 => network.join_source(index, lean),
            _ => network.join_sink(index, -lean),
        }
    }
    let cut = network.min_cut(cancel)?;
    let mut new = inside.clone();
    for ((x, y), is_inside) in pixels.zip(cut.on_source_side) {
        new.set(x, y, is_inside);
    }
    Ok(new)
}

/// A colour and where it is.
type Sample = ([u8; 3], Place);

/// The models of the pixels that `side` calls inside and outside; the border of the photograph
/// stands in where the outside has none.
fn models(photo: &Image<Straight>, side: impl Fn(u32, u32) -> Option<bool>) -> Models {
    let (mut inside, mut outside, mut border) = (Vec::new(), Vec::new(), Vec::new());
    for y in 0..photo.height() {
        for (x, &pixel) in (0..).zip(photo.row(y)) {
            let at_border = x == 0 || y == 0 || x + 1 == photo.width() || y + 1 == photo.height();
            let sample = (color(pixel), place(photo, x, y));
            match side(x, y) {
                Some(true) => inside.push(sample),
                Some(false) => outside.push(sample),
                None if at_border => border.push(sample),
                None => {}
            }
        }
    }
    // Strokes may leave nothing to the other side: then everything is like everything.
    let everything = [([128; 3], [0.5; 2])];
    let fit = |samples: &[Sample], instead: &[Sample]| {
        ColorModel::fit(samples)
            .or_else(|| ColorModel::fit(instead))
            .or_else(|| ColorModel::fit(&everything))
            .unwrap_or_else(|| unreachable!("a sample gives a model"))
    };
    Models {
        inside: fit(&inside, &[]),
        outside: fit(&outside, &border),
    }
}

/// How much nearer each pixel is to inside strokes than to outside ones, −[`NEARNESS`] to it.
fn nearness(hints: &Image<u8>) -> Image<f64> {
    let has_outside = hints.pixels().contains(&OUTSIDE);
    let (right, bottom) = (hints.width() - 1, hints.height() - 1);
    let to_inside = distances(hints, |_, _, hint| hint == INSIDE);
    let to_outside = distances(hints, |x, y, hint| {
        let at_border = x == 0 || y == 0 || x == right || y == bottom;
        if has_outside {
            hint == OUTSIDE
        } else {
            at_border && hint != INSIDE
        }
    });
    let pairs = to_inside.iter().zip(&to_outside);
    let nearness = pairs.map(|(&i, &o)| {
        let (i, o) = (f64::from(i), f64::from(o));
        NEARNESS * (o - i) / (o + i).max(1.0)
    });
    Image::from_pixels(hints.width(), hints.height(), nearness.collect())
}

/// Steps to the four neighbours from each pixel to the nearest one that is wanted; very many when
/// none is.
fn distances(hints: &Image<u8>, wanted: impl Fn(u32, u32, u8) -> bool) -> Vec<u32> {
    let (width, height) = (hints.width() as usize, hints.height() as usize);
    let far = (width + height) as u32;
    let mut steps = vec![far; width * height];
    for y in 0..height {
        for x in 0..width {
            let at = y * width + x;
            let left = if x > 0 { steps[at - 1] + 1 } else { far };
            let above = if y > 0 { steps[at - width] + 1 } else { far };
            let own = wanted(x as u32, y as u32, hints.at(x as u32, y as u32));
            steps[at] = if own { 0 } else { far.min(left).min(above) };
        }
    }
    for y in (0..height).rev() {
        for x in (0..width).rev() {
            let at = y * width + x;
            let right = if x + 1 < width {
                steps[at + 1] + 1
            } else {
                far
            };
            let below = if y + 1 < height {
                steps[at + width] + 1
            } else {
                far
            };
            steps[at] = steps[at].min(right).min(below);
        }
    }
    steps
}

/// Drops the pieces that no inside stroke touches.
fn keep_touched(inside: &mut Mask, hints: &Image<u8>) {
    let pieces = labelled_components(inside);
    let count = pieces.pixels().iter().max().copied().unwrap_or(0) as usize;
    let mut is_touched = vec![false; count + 1];
    for (&piece, &hint) in pieces.pixels().iter().zip(hints.pixels()) {
        is_touched[piece as usize] |= hint == INSIDE;
    }
    for (pixel, &piece) in inside.pixels_mut().iter_mut().zip(pieces.pixels()) {
        *pixel = *pixel && is_touched[piece as usize];
    }
}

/// The pixels that have both sides among themselves and their eight neighbours.
fn near_outline(inside: &Mask) -> Mask {
    let mut near = inside.map(|_| false);
    for y in 0..inside.height() {
        for x in 0..inside.width() {
            let own = inside.at(x, y);
            let around = FORWARD
                .into_iter()
                .chain(FORWARD.map(|(dx, dy)| (-dx, -dy)));
            let mut sides = around.map(|(dx, dy)| inside.get(i64::from(x) + dx, i64::from(y) + dy));
            if sides.any(|side| side.is_some_and(|side| side != own)) {
                near.set(x, y, true);
            }
        }
    }
    near
}

/// The β of GrabCut: one over twice the mean squared difference of neighbours among the free pixels.
fn softness(photo: &Image<Straight>, free: &[Vec<u32>]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for (y, row) in (0i64..).zip(free) {
        for &x in row {
            for (dx, dy) in [(1, 0), (0, 1)] {
                if let Some(there) = photo.get(i64::from(x) + dx, y + dy) {
                    sum += difference(photo.at(x, y as u32), there);
                    count += 1.0;
                }
            }
        }
    }
    count / (2.0 * sum + 1.0)
}

/// The squared distance of two colours.
fn difference(a: Straight, b: Straight) -> f64 {
    let (a, b) = (color(a), color(b));
    let squares = a
        .into_iter()
        .zip(b)
        .map(|(a, b)| f64::from(a.abs_diff(b)).powi(2));
    squares.sum()
}

fn place(photo: &Image<Straight>, x: u32, y: u32) -> Place {
    let share = |at: u32, side: u32| (at as f32 + 0.5) / side as f32;
    [share(x, photo.width()), share(y, photo.height())]
}

fn color(pixel: Straight) -> [u8; 3] {
    let [r, g, b, _] = pixel.premultiplied().0;
    [r, g, b]
}

/// A level at half the size: means of four pixels, and the hint that most of the four have.
fn halved(level: &Level<'_>) -> Level<'static> {
    let (photo, hints) = (&*level.photo, &*level.hints);
    let (width, height) = (photo.width().div_ceil(2), photo.height().div_ceil(2));
    let (right, bottom) = (photo.width() - 1, photo.height() - 1);
    let mut small = Image::filled(width, height, Straight([0; 4]));
    let mut small_hints = Image::filled(width, height, 0);
    for y in 0..height {
        for x in 0..width {
            let (left, top) = (2 * x, 2 * y);
            let four = [(0, 0), (1, 0), (0, 1), (1, 1)]
                .map(|(dx, dy)| ((left + dx).min(right), (top + dy).min(bottom)));
            let mean = std::array::from_fn(|c| {
                let sum: u32 = four
                    .iter()
                    .map(|&(x, y)| u32::from(photo.at(x, y).0[c]))
                    .sum();
                ((sum + 2) / 4) as u8
            });
            small.set(x, y, Straight(mean));
            let count = |hint| {
                four.iter()
                    .filter(|&&(x, y)| hints.at(x, y) == hint)
                    .count()
            };
            // A thin stroke must not get lost.
            let hint = match (count(INSIDE), count(OUTSIDE)) {
                (0, 0) => 0,
                (inside, outside) if inside > outside => INSIDE,
                _ => OUTSIDE,
            };
            small_hints.set(x, y, hint);
        }
    }
    Level {
        photo: Cow::Owned(small),
        hints: Cow::Owned(small_hints),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Seed;
    use crate::raster::Rect;

    /// A disc of noisy green on noisy blue, with a stroke inside and one outside.
    fn disc(side: u32, radius: i64) -> (Image<Straight>, TiledMask, Mask) {
        let mut random = Seed(11).random();
        let middle = i64::from(side) / 2;
        let inside = |x: u32, y: u32| {
            (i64::from(x) - middle).pow(2) + (i64::from(y) - middle).pow(2) < radius * radius
        };
        let mut photo = Image::filled(side, side, Straight([0; 4]));
        let mut truth = Image::filled(side, side, false);
        for y in 0..side {
            for x in 0..side {
                let noise = random.below(50) as u8;
                let green = Straight([40 + noise, 110 + noise, 30 + noise, 255]);
                let blue = Straight([120 + noise, 150 + noise, 190 + noise, 255]);
                photo.set(x, y, if inside(x, y) { green } else { blue });
                truth.set(x, y, inside(x, y));
            }
        }
        let mut hints = TiledMask::filled(side, side, 0);
        let stroke = |y| Rect {
            x: side / 2 - 9,
            y,
            width: 18,
            height: 4,
        };
        hints.edit(stroke(side / 2), |_, _, row| row.fill(INSIDE));
        hints.edit(stroke(5), |_, _, row| row.fill(OUTSIDE));
        (photo, hints, truth)
    }

    #[test]
    fn a_disc_is_found_at_any_size() {
        for (side, radius) in [(90, 30), (401, 130), (1000, 320)] {
            let (photo, hints, truth) = disc(side, radius);
            let found = smart_selection(&photo, &hints, &Cancel::new()).unwrap();
            let found = found.mask(|label| label == 1);
            let pairs = found.pixels().iter().zip(truth.pixels());
            let wrong = pairs.filter(|(a, b)| a != b).count();
            // Less than a quarter of a pixel along the outline.
            assert!((wrong as i64) < 2 * radius, "{wrong} of {side}²");
        }
    }

    #[test]
    fn strokes_are_always_right_and_none_means_nothing() {
        let (photo, mut hints, _) = disc(120, 40);
        let wedge = Rect {
            x: 58,
            y: 30,
            width: 6,
            height: 6,
        };
        hints.edit(wedge, |_, _, row| row.fill(OUTSIDE));
        let found = smart_selection(&photo, &hints, &Cancel::new()).unwrap();
        for y in 0..120 {
            for x in 0..120 {
                match hints.at(x, y) {
                    INSIDE => assert_eq!(found.at(x, y), 1),
                    OUTSIDE => assert_eq!(found.at(x, y), 0),
                    _ => {}
                }
            }
        }
        let none = TiledMask::filled(120, 120, 0);
        assert_eq!(smart_selection(&photo, &none, &Cancel::new()), Ok(none));
    }

    #[test]
    fn a_raised_flag_stops_the_search() {
        let (photo, hints, _) = disc(90, 30);
        let cancel = Cancel::new();
        cancel.cancel();
        assert_eq!(smart_selection(&photo, &hints, &cancel), Err(Cancelled));
    }
}
