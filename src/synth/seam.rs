//! The best seam between two pictures that overlap: where to go from one to the other so that the
//! change is seen least.
//!
//! Source: V. Kwatra, A. Schödl, I. Essa, G. Turk & A. Bobick, *Graphcut Textures: Image and Video
//! Synthesis Using Graph Cuts*, SIGGRAPH 2003, sections 3 and 3.2. Going from A to B between the
//! neighbours s and t costs |A(s) − B(s)| + |A(t) − B(t)|, summed over red, green and blue;
//! optionally divided by the gradients of both pictures along the step, because a seam hides along
//! an edge that is there anyway. The cheapest set of such steps is a minimum cut.
//!
//! Departures: sums of absolute differences, not Euclidean norms (as the thesis's implementation);
//! gradients are summed over the channels and have [`GRADIENT_FLOOR`] added, so that flat places
//! cost something finite.

use crate::base::{Cancel, Cancelled};
use crate::raster::{Image, Mask, Straight};
use crate::solve::{HARD, Network};

/// Which of the two pictures a pixel must come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Side {
    /// The cheaper one.
    #[default]
    Either,
    /// The first.
    First,
    /// The second.
    Second,
}

/// What a step from one picture to the other costs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum StepCost {
    /// How much the pictures differ on both sides of it.
    #[default]
    Difference,
    /// The same, divided by the gradients of both pictures along it.
    DifferenceByGradient,
}

/// Where one picture ends and the other begins.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Seam {
    /// `true` where the pixel comes from the second picture.
    pub from_second: Mask,
    /// What its steps cost together; between pictures of one size and for one [`StepCost`] lower is
    /// better.
    pub cost: i64,
}

/// What is added to a gradient before a difference is divided by it: a sum of four differences of
/// three channels, 0 … 3,060. Lower, and noise in shadows looks like an edge; higher, and nothing
/// does.
const GRADIENT_FLOOR: i32 = 48;

/// The unit of costs that are divided: [`GRADIENT_FLOOR`] · this keeps a flat place's cost within
/// a factor of one of the undivided cost.
const DIVIDED_UNIT: i32 = 64;

/// The cheapest seam between `first` and `second`, pictures of the same place; alpha counts for
/// nothing. `side(x, y)` says which pixels are settled; unless both pictures have some, there is
/// no seam and all open pixels come from the second.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
///
/// # Panics
/// When the pictures have different sizes.
///
/// ```
/// use boscage::base::Cancel;
/// use boscage::raster::{Image, Straight};
/// use boscage::synth::{Side, StepCost, seam};
/// let row = |values: [u8; 5]| {
///     Image::from_pixels(5, 1, values.map(|v| Straight([v, v, v, 255])).to_vec())
/// };
/// // They agree in columns 2 and 3: there the seam is free.
/// let (a, b) = (row([10, 80, 40, 40, 90]), row([70, 20, 40, 40, 10]));
/// let ends = |x, _| [Side::First, Side::Either, Side::Either, Side::Either, Side::Second][x as usize];
/// let seam = seam(&a, &b, ends, StepCost::Difference, &Cancel::new()).unwrap();
/// assert_eq!(seam.cost, 0);
/// assert_eq!(seam.from_second.pixels(), &[false, false, false, true, true]);
/// ```
pub fn seam(
    first: &Image<Straight>,
    second: &Image<Straight>,
    mut side: impl FnMut(u32, u32) -> Side,
    cost: StepCost,
    cancel: &Cancel,
) -> Result<Seam, Cancelled> {
    let (width, height) = (first.width(), first.height());
    assert_eq!(
        (width, height),
        (second.width(), second.height()),
        "pictures of one place"
    );
    let step = |s: (u32, u32), t: (u32, u32)| {
        let at = |(x, y): (u32, u32)| [first.at(x, y), second.at(x, y)];
        step_cost(at(s), at(t), cost)
    };
    let right = |x, y| step((x, y), (x + 1, y));
    let down = |x, y| step((x, y), (x, y + 1));
    let mut network = Network::grid(width, height, right, down);
    for y in 0..height {
        for x in 0..width {
            let node = y as usize * width as usize + x as usize;
            match side(x, y) {
                Side::Either => {}
                Side::First => network.join_source(node, HARD),
                Side::Second => network.join_sink(node, HARD),
            }
        }
    }
    let cut = network.min_cut(cancel)?;
    let from_second = cut.on_source_side.iter().map(|&first| !first).collect();
    Ok(Seam {
        from_second: Image::from_pixels(width, height, from_second),
        cost: cut.flow,
    })
}

/// What it costs to go from one picture to the other between two neighbours; of each neighbour the
/// two colours that meet there.
#[inline]
pub(super) fn step_cost(s: [Straight; 2], t: [Straight; 2], cost: StepCost) -> i32 {
    let difference = distance(s[0], s[1]) + distance(t[0], t[1]);
    match cost {
        StepCost::Difference => difference,
        StepCost::DifferenceByGradient => {
            let gradient = 2 * (distance(s[0], t[0]) + distance(s[1], t[1]));
            difference * DIVIDED_UNIT / (gradient + GRADIENT_FLOOR)
        }
    }
}

/// The sum of the absolute differences of red, green and blue: 0 … 765.
#[inline]
pub(super) fn distance(a: Straight, b: Straight) -> i32 {
    let channel = |c: usize| i32::from(a.0[c]) - i32::from(b.0[c]);
    channel(0).abs() + channel(1).abs() + channel(2).abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Seed;

    fn noise(seed: u64, width: u32, height: u32) -> Image<Straight> {
        let mut random = Seed(seed).random();
        let pixels = (0..width * height)
            .map(|_| {
                let [r, g, b, ..] = random.bits().to_le_bytes();
                Straight([r, g, b, 255])
            })
            .collect();
        Image::from_pixels(width, height, pixels)
    }

    /// The cost of a seam, counted step by step.
    fn counted(a: &Image<Straight>, b: &Image<Straight>, seam: &Seam, cost: StepCost) -> i64 {
        let at = |x, y| [a.at(x, y), b.at(x, y)];
        let second = &seam.from_second;
        let mut sum = 0;
        for y in 0..a.height() {
            for x in 0..a.width() {
                for (x1, y1) in [(x + 1, y), (x, y + 1)] {
                    let inside = x1 < a.width() && y1 < a.height();
                    if inside && second.at(x, y) != second.at(x1, y1) {
                        sum += i64::from(step_cost(at(x, y), at(x1, y1), cost));
                    }
                }
            }
        }
        sum
    }

    #[test]
    fn a_seam_costs_what_its_steps_cost_and_keeps_what_is_settled() {
        let (a, b) = (noise(1, 20, 31), noise(2, 20, 31));
        let side = |x: u32, y: u32| match (x, y) {
            (0, _) => Side::First,
            (19, _) => Side::Second,
            (10, 10) => Side::Second,
            _ => Side::Either,
        };
        for cost in [StepCost::Difference, StepCost::DifferenceByGradient] {
            let seam = seam(&a, &b, side, cost, &Cancel::new()).unwrap();
            assert_eq!(seam.cost, counted(&a, &b, &seam, cost));
            assert!(seam.from_second.at(10, 10) && seam.from_second.at(19, 5));
            assert!(!seam.from_second.at(0, 30));
        }
    }

    #[test]
    fn equal_pictures_are_joined_for_nothing() {
        let a = noise(3, 9, 9);
        let side = |x: u32, _| match x {
            0 => Side::First,
            8 => Side::Second,
            _ => Side::Either,
        };
        assert_eq!(
            seam(&a, &a, side, StepCost::Difference, &Cancel::new())
                .unwrap()
                .cost,
            0
        );
    }
}
