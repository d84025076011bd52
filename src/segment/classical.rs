//! The segmenter that needs no model.

use super::colour::Likelihood;
use super::sketch::{OPAQUE, Sketch, Span};
use super::stem::{Follow, Stem, followed};
use super::{Label, Labels, SegmentError, Segmenter};
use crate::base::Cancel;
use crate::raster::{Image, Straight};

/// Part of the height, from the ground, in which a foot is looked for.
const FOOT_BAND: f64 = 0.1;
/// Widest foot, as part of the tree's width.
const WIDEST_FOOT: f64 = 0.45;
/// Narrowest foot, as part of the tree's longest side.
const NARROWEST_FOOT: f64 = 0.015;

/// Finds trunk and crown by shape and colour alone.
#[derive(Debug, Clone, Copy, Default)]
pub struct Classical;

impl Segmenter for Classical {
    fn name(&self) -> &'static str {
        "classical"
    }

    fn segment(&self, image: &Image<Straight>, cancel: &Cancel) -> Result<Labels, SegmentError> {
        cancel.check()?;
        let Some(sketch) = Sketch::of(image) else {
            return Ok(Image::filled(image.width(), image.height(), Label::Background));
        };
        cancel.check()?;
        let trunk = trunk(&sketch);
        cancel.check()?;
        Ok(painted(image, &sketch, &trunk))
    }
}

fn trunk(sketch: &Sketch) -> Vec<Span> {
    let Some(foot) = foot(sketch) else {
        return Vec::new();
    };
    let plain = Follow {
        bark: None,
        forks: true,
    };
    let stem = followed(sketch, foot, plain);
    let bark = likelihood(sketch, &stem);
    let distinct = bark.overlap() < 0.6;
    let full = followed(
        sketch,
        foot,
        Follow {
            bark: distinct.then_some(&bark),
            forks: distinct,
        },
    );
    if std::env::var("SEGDBG").is_ok() {
        eprintln!(
            "foot {foot:?} of {}x{} plain top {} overlap {:.3} full top {}",
            sketch.width(),
            sketch.height(),
            stem.top(),
            bark.overlap(),
            full.top()
        );
    }
    let mut spans = full.spans;
    spans.extend(below(sketch, foot));
    spans
}

fn likelihood(sketch: &Sketch, stem: &Stem) -> Likelihood {
    let mut in_stem = sketch.mask.map(|_| false);
    for span in &stem.spans {
        in_stem.row_mut(span.y)[span.left as usize..span.right as usize].fill(true);
    }
    let opaque = || {
        let pixels = sketch.image.pixels().iter().zip(sketch.mask.pixels());
        pixels.zip(in_stem.pixels()).filter(|((_, m), _)| **m)
    };
    Likelihood::learned(
        opaque().filter(|(_, s)| **s).map(|((p, _), _)| *p),
        opaque().filter(|(_, s)| !**s).map(|((p, _), _)| *p),
    )
}

fn foot(sketch: &Sketch) -> Option<Span> {
    let bottom = sketch.height() - 1;
    let band = (FOOT_BAND * f64::from(sketch.height())) as u32;
    let longest = f64::from(sketch.width().max(sketch.height()));
    let middle = centroid_x(sketch);
    let mut best: Option<(f64, Span)> = None;
    for y in (bottom - band..=bottom).rev() {
        for &run in &sketch.runs[y as usize] {
            let width = f64::from(run.width());
            if width > WIDEST_FOOT * f64::from(sketch.width()) || width < NARROWEST_FOOT * longest {
                continue;
            }
            let stem = followed(
                sketch,
                run,
                Follow {
                    bark: None,
                    forks: true,
                },
            );
            let aside = (run.centre() - middle) / (0.2 * f64::from(sketch.width()));
            let score = f64::from(stem.area()) / (1.0 + aside * aside);
            if best.is_none_or(|(s, _)| score > s) {
                best = Some((score, run));
            }
        }
    }
    best.map(|(_, run)| run)
}

fn centroid_x(sketch: &Sketch) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for run in sketch.runs.iter().flatten() {
        sum += run.centre() * f64::from(run.width());
        count += f64::from(run.width());
    }
    sum / count
}

fn below(sketch: &Sketch, foot: Span) -> Vec<Span> {
    let mut spans = Vec::new();
    let mut last = vec![foot];
    for y in foot.y + 1..sketch.height() {
        let row: Vec<Span> = sketch.runs[y as usize]
            .iter()
            .copied()
            .filter(|r| last.iter().any(|l| l.meets(*r)))
            .filter(|r| r.width() < 3 * foot.width())
            .collect();
        spans.extend_from_slice(&row);
        last = row;
    }
    spans
}

fn painted(image: &Image<Straight>, sketch: &Sketch, trunk: &[Span]) -> Labels {
    let mut small = sketch.mask.map(|_| false);
    for span in trunk {
        small.row_mut(span.y)[span.left as usize..span.right as usize].fill(true);
    }
    let crop = sketch.crop;
    let mut labels = image.map(|p| {
        if p.alpha() >= OPAQUE {
            Label::Crown
        } else {
            Label::Background
        }
    });
    for y in 0..crop.height {
        let sy = (2 * y + 1) * sketch.height() / (2 * crop.height);
        for x in 0..crop.width {
            let sx = (2 * x + 1) * sketch.width() / (2 * crop.width);
            if small.at(sx, sy) && labels.at(crop.x + x, crop.y + y) == Label::Crown {
                labels.set(crop.x + x, crop.y + y, Label::Trunk);
            }
        }
    }
    labels
}
