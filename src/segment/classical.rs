//! The segmenter that needs no model: colour, width profile and height.
//!
//! A trunk is narrow, keeps its width, stands on the ground below the middle of the tree and
//! mostly has another colour than the crown. So: reduce the picture to a sketch of 384 pixels;
//! look for feet near the ground; learn bark and crown colours from a first stem that is
//! followed by its width alone; follow it again with the colours; everything else that is opaque
//! is crown. A picture without such a stem (shrubs, photographs without alpha) is all crown.
//!
//! Written for this project; the idea of a width profile is the obvious one, the paper (Argudo,
//! Andújar & Chica 2017, *Tree Variations*, §4.3) uses a fully convolutional network instead.
//!
//! Limits: trunks seen only in glimpses between hanging foliage (willows) or behind a low branch
//! (firs) are not found; of a tree without leaves the trunk ends at the first branch that is not a
//! twig.

use super::foot::{feet, roots};
use super::sketch::{OPAQUE, Sketch, Span};
use super::stem::{Guide, stem};
use super::{Label, Labels, Provenance, SegmentError, Segmented, Segmenter, Source};
use crate::base::Cancel;
use crate::raster::{Image, Straight};

/// Finds trunk and crown by shape and colour alone.
///
/// ```
/// use boscage::base::Cancel;
/// use boscage::raster::{Image, Straight};
/// use boscage::segment::{Classical, Segmenter, trunk_count};
/// let mut tree = Image::filled(40, 60, Straight([0; 4]));
/// for y in 0..60 {
///     for x in if y < 40 { 0..40 } else { 18..22 } {
///         tree.set(x, y, Straight([40, 120, 30, 255]));
///     }
/// }
/// let labels = Classical.segment(&tree, &Cancel::new()).unwrap();
/// assert_eq!(trunk_count(&labels), 20 * 4);
/// ```
#[derive(Debug, Clone, Copy, Default)]
pub struct Classical;

impl Segmenter for Classical {
    fn name(&self) -> &'static str {
        "classical"
    }

    fn key(&self) -> String {
        "classical 1".to_owned()
    }

    fn segmented(
        &self,
        image: &Image<Straight>,
        cancel: &Cancel,
    ) -> Result<Segmented, SegmentError> {
        Ok(Segmented {
            labels: labelled(image, cancel)?,
            provenance: Provenance {
                source: Source::Classical,
                confidence: None,
                reason: None,
            },
        })
    }
}

fn labelled(image: &Image<Straight>, cancel: &Cancel) -> Result<Labels, SegmentError> {
    cancel.check()?;
    let mut labels = image.map(|pixel| {
        if pixel.alpha() >= OPAQUE {
            Label::Crown
        } else {
            Label::Background
        }
    });
    let Some(sketch) = Sketch::of(image) else {
        return Ok(labels);
    };
    cancel.check()?;
    let trunk = trunk(&sketch);
    cancel.check()?;
    if !trunk.is_empty() {
        paint(&mut labels, &sketch, &trunk);
    }
    Ok(labels)
}

/// The spans of all trunks, in no order.
fn trunk(sketch: &Sketch) -> Vec<Span> {
    let mut spans = Vec::new();
    for foot in feet(sketch) {
        let guide = if foot.bark.is_distinct() {
            Guide::Bark(&foot.bark)
        } else {
            Guide::Bare
        };
        spans.extend(stem(sketch, foot.span, guide));
        spans.extend(roots(sketch, foot.span));
    }
    spans
}

/// Makes the crown pixels of `labels` that lie on the trunk trunk.
fn paint(labels: &mut Labels, sketch: &Sketch, trunk: &[Span]) {
    let small = grown(&grown(&sketch_labels(sketch, trunk)));
    let crop = sketch.crop;
    // Centre of each pixel, in pixels of the sketch.
    let column = |x: u32| (2 * x + 1) * sketch.width() / (2 * crop.width);
    let row = |y: u32| (2 * y + 1) * sketch.height() / (2 * crop.height);
    for y in 0..crop.height {
        let from = small.row(row(y));
        let left = crop.x as usize;
        let to = &mut labels.row_mut(crop.y + y)[left..left + crop.width as usize];
        for (x, label) in (0u32..).zip(to) {
            if *label == Label::Crown && from[column(x) as usize] == Label::Trunk {
                *label = Label::Trunk;
            }
        }
    }
}

fn sketch_labels(sketch: &Sketch, trunk: &[Span]) -> Labels {
    let on_trunk = sketch.covered(trunk);
    let pixels = sketch.mask.pixels().iter().zip(on_trunk.pixels());
    let labels = pixels.map(|(&opaque, &on_trunk)| match (on_trunk, opaque) {
        (true, _) => Label::Trunk,
        (false, true) => Label::Crown,
        (false, false) => Label::Background,
    });
    Image::from_pixels(sketch.width(), sketch.height(), labels.collect())
}

/// The labels with every background pixel beside the tree given to the class that more of its
/// eight neighbours have, trunk in a draw.
///
/// A sketch pixel that is half air is background, yet opaque pixels of the picture lie in it: left
/// to the crown they would fringe the trunk down to the ground.
fn grown(labels: &Labels) -> Labels {
    let mut grown = labels.clone();
    for y in 0..labels.height() {
        for x in 0..labels.width() {
            if labels.at(x, y) == Label::Background {
                grown.set(x, y, majority_around(labels, x, y));
            }
        }
    }
    grown
}

fn majority_around(labels: &Labels, x: u32, y: u32) -> Label {
    let (mut trunk, mut crown) = (0, 0);
    for dy in -1..=1 {
        for dx in -1..=1 {
            match labels.get(i64::from(x) + dx, i64::from(y) + dy) {
                Some(Label::Trunk) => trunk += 1,
                Some(Label::Crown) => crown += 1,
                _ => {}
            }
        }
    }
    match (trunk, crown) {
        (0, 0) => Label::Background,
        _ if trunk >= crown => Label::Trunk,
        _ => Label::Crown,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::segment::{crown_baseline, crown_count, trunk_count};

    const LEAF: Straight = Straight([40, 120, 30, 255]);
    const BARK: Straight = Straight([90, 60, 40, 255]);

    fn fill(
        image: &mut Image<Straight>,
        x: std::ops::Range<u32>,
        y: std::ops::Range<u32>,
        pixel: Straight,
    ) {
        for y in y {
            image.row_mut(y)[x.start as usize..x.end as usize].fill(pixel);
        }
    }

    fn segmented(image: &Image<Straight>) -> Labels {
        Classical.segment(image, &Cancel::new()).unwrap()
    }

    #[test]
    fn a_block_on_a_post_is_found_at_every_size() {
        for scale in [1, 2, 7, 10] {
            let mut image = Image::filled(100 * scale, 100 * scale, Straight([0; 4]));
            fill(&mut image, 10 * scale..90 * scale, 0..60 * scale, LEAF);
            fill(
                &mut image,
                46 * scale..54 * scale,
                60 * scale..100 * scale,
                BARK,
            );
            let labels = segmented(&image);
            let baseline = crown_baseline(&labels).unwrap();
            assert!(
                baseline.abs_diff(60 * scale - 1) <= scale.div_ceil(3),
                "{scale}: {baseline}"
            );
            let expected = (8 * 40 * scale * scale) as usize;
            assert!(trunk_count(&labels).abs_diff(expected) * 20 <= expected);
        }
    }

    #[test]
    fn two_posts_are_two_trunks() {
        let mut image = Image::filled(200, 200, Straight([0; 4]));
        fill(&mut image, 10..190, 0..100, LEAF);
        fill(&mut image, 70..80, 100..200, BARK);
        fill(&mut image, 120..130, 100..200, BARK);
        assert_eq!(trunk_count(&segmented(&image)), 2 * 10 * 100);
    }

    #[test]
    fn what_has_no_stem_is_all_crown() {
        let opaque = Image::filled(120, 80, LEAF);
        assert_eq!(crown_count(&segmented(&opaque)), 120 * 80);
        let mut bush = Image::filled(100, 100, Straight([0; 4]));
        fill(&mut bush, 10..90, 20..100, LEAF);
        assert_eq!(trunk_count(&segmented(&bush)), 0);
    }

    #[test]
    fn empty_and_tiny_pictures_are_no_trouble() {
        let empty = Image::filled(5, 4, Straight([9, 9, 9, 8]));
        assert_eq!(crown_count(&segmented(&empty)), 0);
        for (width, height) in [(1, 1), (1, 300), (300, 1), (2, 3)] {
            let labels = segmented(&Image::filled(width, height, LEAF));
            let opaque = crown_count(&labels) + trunk_count(&labels);
            assert_eq!(opaque, (width * height) as usize);
        }
    }

    #[test]
    fn a_raised_flag_stops_it() {
        let cancel = Cancel::new();
        cancel.cancel();
        let result = Classical.segment(&Image::filled(5, 5, LEAF), &cancel);
        assert!(matches!(result, Err(SegmentError::Cancelled(_))));
    }
}
