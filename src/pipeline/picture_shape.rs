//! The shape that a picture would give to new trees, in pixels of the picture: what the canvas draws
//! over it, so that a mask can be corrected where the shape is wrong.
//!
//! The same steps as for an exemplar (normalise, segment, outline, pins, resample), on what is opaque in
//! the picture and labelled in the mask. A mask with a trunk says itself what is trunk; otherwise the
//! segmenter does.

use crate::base::{Cancel, Progress};
use crate::contour::PinnedContour;
use crate::geometry::Point;
use crate::paint::{BACKGROUND, TRUNK, TiledMask};
use crate::raster::{Image, Straight};
use crate::segment::{Label, Segmenter};
use crate::variation::{ExemplarError, ExemplarSettings, Outlined, Placement, normalized};

/// Outline, pins and baseline of a tree, in pixels of its picture, centres at whole numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct PictureShape {
    /// The resampled outline, closed, counter-clockwise as seen on screen.
    pub contour: Vec<Point>,
    /// B, the foot of the tree.
    pub bottom: Point,
    /// L and R, where the sides of the trunk meet the crown, if a trunk shows.
    pub sides: Option<[Point; 2]>,
    /// The row where the crown begins above the trunk.
    pub baseline_y: Option<f64>,
}

/// The shape of the tree in `picture`, cut out by `mask` unless that is empty.
///
/// # Errors
/// [`ExemplarError`]: nothing or everything is opaque, or `cancel` was raised.
///
/// # Panics
/// When the mask is of another size.
pub fn picture_shape(
    picture: &Image<Straight>,
    mask: &TiledMask,
    segmenter: &dyn Segmenter,
    cancel: &Cancel,
) -> Result<PictureShape, ExemplarError> {
    let settings = ExemplarSettings::default();
    let cut = cut_out(picture, mask);
    cancel.check()?;
    if cut.pixels().iter().all(|pixel| pixel.alpha() == 255) {
        return Err(ExemplarError::NoBackground);
    }
    let normalized = normalized(&cut, settings.size, settings.threshold)?;
    cancel.check()?;
    let labels = if mask.count(|label| label == TRUNK) > 0 {
        normalized
            .placement
            .placed(&mask.labels(), Label::Background)
    } else {
        segmenter.segment(&normalized.image.straight(), cancel)?
    };
    let outlined = Outlined::new(&normalized, Progress::silent());
    cancel.check()?;
    let (pins, baseline_y) = outlined.pins(&labels);
    let contour = PinnedContour::resampled(&outlined.longest, pins, settings.points);
    let on_picture = |point| on_picture(&normalized.placement, point);
    Ok(PictureShape {
        bottom: on_picture(contour.bottom()),
        sides: pins
            .has_trunk()
            .then(|| [contour.left(), contour.right()].map(on_picture)),
        baseline_y: baseline_y.map(|y| on_picture(Point::new(0.0, y)).y),
        contour: contour.points.into_iter().map(on_picture).collect(),
    })
}

/// `picture`, clear where `mask` is background, if that labels anything.
fn cut_out(picture: &Image<Straight>, mask: &TiledMask) -> Image<Straight> {
    let mut cut = picture.clone();
    if mask.count(|label| label != BACKGROUND) == 0 {
        return cut;
    }
    let labels = mask.image();
    for (pixel, &label) in cut.pixels_mut().iter_mut().zip(labels.pixels()) {
        if label == BACKGROUND {
            *pixel = Straight([0; 4]);
        }
    }
    cut
}

/// A place in the normalised picture as a place in the picture itself.
fn on_picture(placement: &Placement, point: Point) -> Point {
    let corner = Point::new(f64::from(placement.crop.x), f64::from(placement.crop.y));
    let half = Point::splat(0.5);
    (point + half - placement.offset) / placement.scale + corner - half
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paint::CROWN;
    use crate::segment::Classical;

    /// A crown of 200 × 150 pixels at (60, 40) on a trunk of 20 × 90.
    fn tree() -> Image<u8> {
        let mut labels = Image::filled(320, 300, BACKGROUND);
        for y in 40..280 {
            for x in 60..260 {
                if y < 190 {
                    labels.set(x, y, CROWN);
                } else if (150..170).contains(&x) {
                    labels.set(x, y, TRUNK);
                }
            }
        }
        labels
    }

    #[test]
    fn a_masked_photograph_has_the_shape_of_its_mask() {
        let photo = Image::filled(320, 300, Straight([90, 120, 60, 255]));
        let mask = TiledMask::from_image(&tree());
        let shape = picture_shape(&photo, &mask, &Classical, &Cancel::new()).unwrap();
        assert!((shape.bottom - Point::new(159.5, 279.0)).length() < 12.0);
        assert!((shape.baseline_y.unwrap() - 190.0).abs() < 3.0);
        let [left, right] = shape.sides.unwrap();
        assert!((left - Point::new(150.0, 190.0)).length() < 4.0, "{left}");
        assert!((right - Point::new(169.0, 190.0)).length() < 4.0, "{right}");
        let on_border = |p: &Point| {
            let near = |a: f64, b: f64| (a - b).abs() < 1.5;
            near(p.x, 60.0)
                || near(p.x, 259.0)
                || near(p.y, 40.0)
                || near(p.y, 189.0)
                || near(p.x, 150.0)
                || near(p.x, 169.0)
                || near(p.y, 279.0)
        };
        assert!(shape.contour.iter().all(on_border));
    }

    #[test]
    fn a_photograph_without_mask_has_no_shape() {
        let photo = Image::filled(64, 64, Straight([90, 120, 60, 255]));
        let mask = TiledMask::filled(64, 64, BACKGROUND);
        let shape = picture_shape(&photo, &mask, &Classical, &Cancel::new());
        assert_eq!(shape, Err(ExemplarError::NoBackground));
    }
}
