//! All exemplars at one size: cropped to the tree, made square, resized (TV §4.1).

use super::ExemplarError;
use crate::geometry::Point;
use crate::raster::{Image, Mask, Premultiplied, Rect, Straight, dilated, opaque_bounds, resized};
use serde::{Deserialize, Serialize};

/// Alpha up to which a pixel counts as background. Real cut-outs carry a haze of alpha 2, 5 or 8
/// over their whole background; a leaf's soft edge loses nothing visible below 12.
const HAZE: u8 = 12;

/// How far from an opaque pixel soft alpha may reach, in source pixels: the antialiased edge of a
/// leaf does, a soft ground shadow does not.
const SOFT_EDGE_PX: u8 = 3;

/// Where the tree went in the normalised picture.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Placement {
    /// Side of the normalised picture, in pixels.
    pub size: u32,
    /// The opaque part of the original picture.
    pub crop: Rect,
    /// Normalised pixels for one original pixel.
    pub scale: f64,
    /// Normalised position (x, y), in pixels from the top-left *corner*, of the crop's corner: the
    /// tree stands centred on the bottom edge.
    pub offset: Point,
}

impl Placement {
    fn new(crop: Rect, size: u32) -> Self {
        let scale = f64::from(size) / f64::from(crop.width.max(crop.height));
        let (width, height) = Self::resized_sides(crop, scale);
        let offset = Point::new(f64::from((size - width) / 2), f64::from(size - height));
        Self {
            size,
            crop,
            scale,
            offset,
        }
    }

    /// `original`, something told of each pixel of the original picture (labels, say), brought to
    /// the normalised frame by its nearest pixels; `outside` where no tree was put.
    pub fn placed<P: Copy>(&self, original: &Image<P>, outside: P) -> Image<P> {
        let (width, height) = Self::resized_sides(self.crop, self.scale);
        let (left, top) = (self.offset.x as u32, self.offset.y as u32);
        // The pixel of `source` whose area holds the centre of pixel `at` of `target`.
        let nearest = |at: u32, source: u32, target: u32| {
            ((2 * u64::from(at) + 1) * u64::from(source) / (2 * u64::from(target))) as u32
        };
        let mut placed = Image::filled(self.size, self.size, outside);
        for y in 0..height {
            let from = original.row(self.crop.y + nearest(y, self.crop.height, height));
            for x in 0..width {
                let column = self.crop.x + nearest(x, self.crop.width, width);
                placed.set(left + x, top + y, from[column as usize]);
            }
        }
        placed
    }

    fn resized_sides(crop: Rect, scale: f64) -> (u32, u32) {
        let side = |pixels: u32| ((f64::from(pixels) * scale).round() as u32).max(1);
        (side(crop.width), side(crop.height))
    }
}

/// A picture of a tree that fills a square: black and transparent where no tree is.
#[derive(Debug, Clone, PartialEq)]
pub struct Normalized {
    /// Where the tree went.
    pub placement: Placement,
    /// The picture.
    pub image: Image<Premultiplied>,
    /// Its opaque pixels.
    pub mask: Mask,
}

/// `picture` cropped to its pixels of alpha above `threshold` (0 to 1), haze and soft shadows
/// removed, resized so that the longer side is `size`, centred on the bottom edge of a square.
///
/// Departures from the paper: alpha stays soft at the edges of leaves instead of becoming binary;
/// the padding goes to the sides and the top, so that all trees stand on one ground.
///
/// # Errors
/// [`ExemplarError::Transparent`].
pub fn normalized(
    picture: &Image<Straight>,
    size: u32,
    threshold: f64,
) -> Result<Normalized, ExemplarError> {
    let opaque = picture.map(|pixel| is_opaque(pixel.alpha(), threshold));
    let crop = opaque_bounds(&opaque).ok_or(ExemplarError::Transparent)?;
    let placement = Placement::new(crop, size);
    let clean = without_haze(picture, &opaque);
    let (width, height) = Placement::resized_sides(crop, placement.scale);
    let tree = resized(&clean, crop, width, height);
    let (left, top) = (placement.offset.x as u32, placement.offset.y as u32);
    let mut image = Image::filled(size, size, Premultiplied::default());
    for y in 0..height {
        let row = &mut image.row_mut(top + y)[left as usize..(left + width) as usize];
        row.copy_from_slice(tree.row(y));
    }
    let mask = image.map(|pixel| is_opaque(pixel.alpha(), threshold));
    if mask.count() == 0 {
        // A few opaque pixels that a strong reduction averaged away.
        return Err(ExemplarError::Transparent);
    }
    Ok(Normalized {
        placement,
        image,
        mask,
    })
}

fn is_opaque(alpha: u8, threshold: f64) -> bool {
    f64::from(alpha) > threshold * 255.0
}

/// `picture` premultiplied, with all alpha cleared that is haze or far from opaque pixels.
fn without_haze(picture: &Image<Straight>, opaque: &Mask) -> Image<Premultiplied> {
    let near = dilated(opaque, SOFT_EDGE_PX);
    let pixels = picture
        .pixels()
        .iter()
        .zip(near.pixels())
        .map(|(pixel, &near)| {
            if near && pixel.alpha() > HAZE {
                pixel.premultiplied()
            } else {
                Premultiplied::default()
            }
        });
    Image::from_pixels(picture.width(), picture.height(), pixels.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tree_fills_the_square_and_stands_on_its_bottom_edge() {
        let mut picture = Image::filled(30, 20, Straight([90, 90, 90, 5]));
        for y in 4..12 {
            for x in 10..14 {
                picture.set(x, y, Straight([10, 200, 10, 255]));
            }
        }
        let found = normalized(&picture, 64, 0.5).unwrap();
        assert_eq!(
            found.placement.crop,
            Rect {
                x: 10,
                y: 4,
                width: 4,
                height: 8
            }
        );
        assert_eq!(found.placement.scale, 8.0);
        assert_eq!(found.placement.offset, Point::new(16.0, 0.0));
        assert_eq!(
            found.image.at(15, 63),
            Premultiplied::default(),
            "haze is gone"
        );
        assert_eq!(found.image.at(16, 63), Premultiplied([10, 200, 10, 255]));
        assert_eq!(found.mask.count(), 32 * 64);
    }

    #[test]
    fn labels_go_where_their_pixels_went() {
        let mut picture = Image::filled(9, 9, Straight([0; 4]));
        let mut labels = Image::filled(9, 9, 0u8);
        for (x, y, label) in [(4, 2, 7), (4, 3, 8), (4, 4, 9), (4, 5, 9)] {
            picture.set(x, y, Straight([50, 50, 50, 255]));
            labels.set(x, y, label);
        }
        let placement = normalized(&picture, 8, 0.5).unwrap().placement;
        let placed = placement.placed(&labels, 1);
        let column: Vec<u8> = (0..8).map(|y| placed.at(3, y)).collect();
        assert_eq!(column, [7, 7, 8, 8, 9, 9, 9, 9]);
        assert_eq!((placed.at(2, 0), placed.at(5, 7)), (1, 1));
    }

    #[test]
    fn a_transparent_picture_is_refused() {
        let picture = Image::filled(3, 3, Straight([0, 0, 0, 100]));
        assert_eq!(
            normalized(&picture, 64, 0.5),
            Err(ExemplarError::Transparent)
        );
    }
}
