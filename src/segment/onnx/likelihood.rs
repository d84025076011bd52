//! A network's answer as likelihoods, and how much they are worth.
//!
//! The last bits of an answer depend on processor and runtime. They are rounded away here, before
//! anything is decided: a logit to a sixteenth, far coarser than they differ, far finer than a
//! network is sure. Everything later is computed from the rounded numbers in one order.

use super::super::SegmentError;
use super::card::{Activation, Card, Certainty, Class};
use super::guided::PLANES;
use crate::raster::{Image, Rect};

/// Steps of a rounded logit in 1.
const LOGIT_STEPS: f32 = 16.0;

/// Largest difference of logits that is told from larger ones, in steps: e⁻¹⁶.
const MOST_STEPS: i32 = 256;

/// Steps of a rounded likelihood in 1, where a model gives likelihoods itself.
const LIKELIHOOD_STEPS: f32 = 256.0;

/// Planes of the likelihoods.
pub(super) const TRUNK: usize = 0;
pub(super) const CROWN: usize = 1;

/// Likelihood of trunk and of crown for each pixel of the input; what is left is background.
///
/// # Errors
/// [`SegmentError::Model`] when a number is none.
pub(super) fn likelihoods(
    answer: &[f32],
    card: &Card,
) -> Result<Image<[f32; PLANES]>, SegmentError> {
    if answer.iter().any(|value| value.is_nan()) {
        let reason = "it gives numbers that are no numbers";
        return Err(SegmentError::Model(reason.to_owned()));
    }
    let [height, width] = card.input.size;
    let count = width as usize * height as usize;
    let plane = |class| &answer[card.plane(class) * count..][..count];
    let planes = [Class::Background, Class::Trunk, Class::Crown].map(plane);
    let pixels = (0..count).map(|i| planes.map(|plane| plane[i]));
    let pixels: Vec<[f32; PLANES]> = match card.output.activation {
        Activation::Logits => {
            let odds = odds();
            let temperature = card.calibration.temperature;
            pixels
                .map(|logits| of_logits(logits, temperature, &odds))
                .collect()
        }
        Activation::Softmax => pixels.map(of_likelihoods).collect(),
    };
    Ok(Image::from_pixels(width, height, pixels))
}

/// The odds of a class whose rounded logit is so many steps below the largest.
fn odds() -> Vec<f32> {
    let steps = 0..=MOST_STEPS;
    steps
        .map(|step| libm::expf(-(step as f32) / LOGIT_STEPS))
        .collect()
}

fn of_logits(logits: [f32; 3], temperature: f32, odds: &[f32]) -> [f32; PLANES] {
    // Far from the largest number an i32 holds.
    let rounded = logits.map(|logit| (logit / temperature * LOGIT_STEPS).clamp(-1e6, 1e6).round());
    let rounded = rounded.map(|steps| steps as i32);
    let most = rounded.into_iter().max().unwrap_or(0);
    let [background, trunk, crown] = rounded.map(|own| odds[(most - own).min(MOST_STEPS) as usize]);
    let sum = background + trunk + crown;
    [trunk / sum, crown / sum]
}

fn of_likelihoods(likelihoods: [f32; 3]) -> [f32; PLANES] {
    let [background, trunk, crown] =
        likelihoods.map(|own| (own.clamp(0.0, 1.0) * LIKELIHOOD_STEPS).round());
    let sum = (background + trunk + crown).max(1.0);
    [trunk / sum, crown / sum]
}

/// Makes of `likelihoods` what they are where it is known that there is a tree.
pub(super) fn of_opaque(likelihoods: &mut Image<[f32; PLANES]>) {
    for own in likelihoods.pixels_mut() {
        let sum = own[TRUNK] + own[CROWN];
        *own = if sum > 0.0 {
            own.map(|likelihood| likelihood / sum)
        } else {
            [0.0, 1.0]
        };
    }
}

/// How certain the network was within `inner`, where the picture lies. Pixels that are background with
/// the likelihood `sure_background` have no part in it.
pub(super) fn certainty(
    likelihoods: &Image<[f32; PLANES]>,
    inner: Rect,
    sure_background: f32,
) -> Certainty {
    let (mut overall, mut trunks) = (Mean::default(), Mean::default());
    for y in inner.y..inner.y + inner.height {
        let columns = inner.x as usize..(inner.x + inner.width) as usize;
        for &[trunk, crown] in &likelihoods.row(y)[columns] {
            let background = 1.0 - trunk - crown;
            let most = trunk.max(crown).max(background);
            if background < sure_background {
                overall.add(most);
            }
            if trunk >= most {
                trunks.add(trunk);
            }
        }
    }
    Certainty {
        overall: overall.or(0.0),
        trunk: trunks.or(0.5),
    }
}

#[derive(Default)]
struct Mean {
    sum: f64,
    count: u32,
}

impl Mean {
    fn add(&mut self, value: f32) {
        self.sum += f64::from(value);
        self.count += 1;
    }

    /// The mean, or `none` of nothing.
    fn or(&self, none: f32) -> f32 {
        match self.count {
            0 => none,
            count => (self.sum / f64::from(count)) as f32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn card(activation: &str) -> Card {
        let card = format!(
            r#"{{"format":1,"input":{{"name":"x","size":[32,32],"channels":["r","g","b"]}},
            "output":{{"name":"y","classes":["crown","background","trunk"],"activation":"{activation}"}},
            "calibration":{{"temperature":2}}}}"#
        );
        Card::from_json(card.as_bytes()).unwrap()
    }

    /// An answer of the same numbers everywhere, in the card's order.
    fn answer(numbers: [f32; 3]) -> Vec<f32> {
        numbers.iter().flat_map(|&n| vec![n; 32 * 32]).collect()
    }

    fn first(numbers: [f32; 3], activation: &str) -> [f32; PLANES] {
        likelihoods(&answer(numbers), &card(activation))
            .unwrap()
            .at(0, 0)
    }

    #[test]
    fn logits_are_softened_by_the_temperature() {
        let [trunk, crown] = first([2.0, 0.0, 4.0], "logits");
        let e = std::f32::consts::E;
        let sum = e + 1.0 + e * e;
        assert!((crown - e / sum).abs() < 1e-6 && (trunk - e * e / sum).abs() < 1e-6);
    }

    #[test]
    fn the_last_bits_have_no_say() {
        let one = first([0.3, 0.7, -1.1], "logits");
        assert_eq!(one, first([0.3 + 1e-5, 0.7 - 1e-5, -1.1 + 1e-5], "logits"));
        assert_eq!(
            first([0.25, 0.5, 0.25], "softmax"),
            first([0.2501, 0.4999, 0.25], "softmax")
        );
    }

    #[test]
    fn numbers_without_end_are_likelihoods_and_no_numbers_are_refused() {
        assert!(first([f32::INFINITY, 0.0, 0.0], "logits")[CROWN] > 0.999);
        let background = first([0.0, f32::MAX, f32::NEG_INFINITY], "logits");
        assert!(background.iter().all(|own| *own < 1e-6));
        assert!(likelihoods(&answer([f32::NAN, 0.0, 0.0]), &card("logits")).is_err());
    }

    #[test]
    fn an_opaque_pixel_is_tree() {
        let mut own = Image::from_pixels(3, 1, vec![[0.1, 0.3], [0.0, 0.0], [0.5, 0.5]]);
        of_opaque(&mut own);
        let [tree, nothing, _] = own.pixels() else {
            unreachable!("three pixels");
        };
        assert!((tree[0] - 0.25).abs() < 1e-6 && *nothing == [0.0, 1.0]);
    }

    #[test]
    fn certainty_is_that_of_what_may_be_tree() {
        let pixels = vec![[0.0, 0.02], [0.1, 0.7], [0.8, 0.2], [0.3, 0.3]];
        let own = Image::from_pixels(4, 1, pixels);
        let inner = |width| Rect {
            x: 0,
            y: 0,
            width,
            height: 1,
        };
        let whole = certainty(&own, inner(4), 0.9);
        assert!((whole.overall - (0.7 + 0.8 + 0.4) / 3.0).abs() < 1e-6);
        assert!((whole.trunk - 0.8).abs() < 1e-6);
        assert_eq!(
            certainty(&own, inner(1), 0.9),
            Certainty {
                overall: 0.0,
                trunk: 0.5
            }
        );
    }
}
