//! Changing the size of a picture.

use super::{Image, Premultiplied, Rect};
use fast_image_resize as fir;

/// The part `crop` of `image`, resized to `width` × `height` pixels.
///
/// Catmull–Rom, widened to the size of a target pixel when the picture gets smaller, so that small
/// leaves neither alias nor ring. Edges map to edges: the centre of target pixel x lies at
/// `(x + 0.5) · crop.width / width − 0.5` pixels of the crop.
///
/// # Panics
/// When `crop` is empty or reaches outside, or a target side is 0.
pub fn resized(
    image: &Image<Premultiplied>,
    crop: Rect,
    width: u32,
    height: u32,
) -> Image<Premultiplied> {
    let bug = "the crop is inside the image and no side is empty";
    let source = fir::images::ImageRef::new(
        image.width(),
        image.height(),
        bytemuck::cast_slice(image.pixels()),
        fir::PixelType::U8x4,
    )
    .expect(bug);
    let mut target = fir::images::Image::new(width, height, fir::PixelType::U8x4);
    let options = fir::ResizeOptions::new()
        .resize_alg(fir::ResizeAlg::Convolution(fir::FilterType::CatmullRom))
        .use_alpha(false)
        .crop(
            f64::from(crop.x),
            f64::from(crop.y),
            f64::from(crop.width),
            f64::from(crop.height),
        );
    fir::Resizer::new()
        .resize(&source, &mut target, &options)
        .expect(bug);
    let pixels = target
        .buffer()
        .chunks_exact(4)
        .map(|p| {
            // A filter with negative lobes may leave a colour above its alpha.
            let alpha = p[3];
            Premultiplied([p[0].min(alpha), p[1].min(alpha), p[2].min(alpha), alpha])
        })
        .collect();
    Image::from_pixels(width, height, pixels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_picture_stays_flat_and_colour_stays_below_alpha() {
        let mut image = Image::filled(8, 8, Premultiplied([100, 50, 20, 200]));
        let all = Rect {
            x: 0,
            y: 0,
            width: 8,
            height: 8,
        };
        let grown = resized(&image, all, 21, 13);
        assert!(
            grown
                .pixels()
                .iter()
                .all(|&p| p == Premultiplied([100, 50, 20, 200]))
        );
        image.set(3, 3, Premultiplied([255, 255, 255, 255]));
        image.set(4, 3, Premultiplied([0; 4]));
        let grown = resized(&image, all, 40, 40);
        assert!(grown.pixels().iter().all(|p| p.0[0] <= p.0[3]));
    }

    #[test]
    fn the_same_size_changes_nothing() {
        let pixels = (0..64)
            .map(|i| Premultiplied([i, i / 2, 0, i * 2]))
            .collect();
        let image = Image::from_pixels(8, 8, pixels);
        assert_eq!(
            resized(
                &image,
                Rect {
                    x: 0,
                    y: 0,
                    width: 8,
                    height: 8
                },
                8,
                8
            ),
            image
        );
    }
}
