//! A rectangle of pixels, and the two meanings an RGBA pixel can have.

use super::rect::Rect;
use bytemuck::{Pod, Zeroable};

/// An RGBA pixel whose colour does not depend on its alpha: what image files hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
#[repr(transparent)]
pub struct Straight(pub [u8; 4]);

/// An RGBA pixel whose colour is already multiplied by its alpha: what may be averaged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
#[repr(transparent)]
pub struct Premultiplied(pub [u8; 4]);

impl Straight {
    /// The same pixel with its colour multiplied by its alpha, rounded to nearest.
    ///
    /// ```
    /// use boscage::raster::{Premultiplied, Straight};
    /// assert_eq!(Straight([200, 100, 0, 128]).premultiplied(), Premultiplied([100, 50, 0, 128]));
    /// ```
    #[inline]
    pub fn premultiplied(self) -> Premultiplied {
        let [r, g, b, a] = self.0;
        let scaled = |c: u8| ((u32::from(c) * u32::from(a) + 127) / 255) as u8;
        Premultiplied([scaled(r), scaled(g), scaled(b), a])
    }

    /// The alpha, 0 (clear) to 255 (opaque).
    #[inline]
    pub fn alpha(self) -> u8 {
        self.0[3]
    }

    /// Rec. 709 luma of the stored colour, 0 … 255; alpha has no part in it.
    #[inline]
    pub fn luma(self) -> f32 {
        let [r, g, b, _] = self.0.map(f32::from);
        0.2126 * r + 0.7152 * g + 0.0722 * b
    }

    /// This pixel laid over `under`.
    ///
    /// ```
    /// use boscage::raster::Straight;
    /// let half = Straight([200, 0, 0, 128]);
    /// assert_eq!(half.over(Straight([0, 0, 0, 0])), half);
    /// assert_eq!(half.over(Straight([0, 0, 0, 255])), Straight([100, 0, 0, 255]));
    /// ```
    pub fn over(self, under: Self) -> Self {
        let [a, b] = [self, under].map(|pixel| f32::from(pixel.alpha()) / 255.0);
        let alpha = a + b * (1.0 - a);
        if alpha <= 0.0 {
            return Self([0; 4]);
        }
        let mixed = |c: usize| {
            let value = f32::from(self.0[c]) * a + f32::from(under.0[c]) * b * (1.0 - a);
            (value / alpha + 0.5) as u8
        };
        Self([mixed(0), mixed(1), mixed(2), (255.0 * alpha + 0.5) as u8])
    }
}

impl Premultiplied {
    /// The same pixel with its alpha divided out, rounded to nearest; clear pixels become black.
    #[inline]
    pub fn straight(self) -> Straight {
        let [r, g, b, a] = self.0;
        if a == 0 {
            return Straight([0; 4]);
        }
        let alpha = u32::from(a);
        let divided = |c: u8| ((u32::from(c) * 255 + alpha / 2) / alpha).min(255) as u8;
        Straight([divided(r), divided(g), divided(b), a])
    }

    /// The alpha, 0 (clear) to 255 (opaque).
    #[inline]
    pub fn alpha(self) -> u8 {
        self.0[3]
    }
}

/// `width` × `height` pixels in rows from the top; neither side is ever 0.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image<P> {
    width: u32,
    height: u32,
    pixels: Vec<P>,
}

impl<P: Copy> Image<P> {
    /// An image of one colour.
    ///
    /// # Panics
    /// When a side is 0.
    pub fn filled(width: u32, height: u32, pixel: P) -> Self {
        Self::from_pixels(width, height, vec![pixel; width as usize * height as usize])
    }

    /// An image from its pixels, row by row from the top.
    ///
    /// # Panics
    /// When a side is 0 or `pixels` has another length than `width` × `height`.
    pub fn from_pixels(width: u32, height: u32, pixels: Vec<P>) -> Self {
        assert!(width > 0 && height > 0, "an image has no empty side");
        assert_eq!(
            pixels.len(),
            width as usize * height as usize,
            "pixels must fill {width}×{height}"
        );
        Self {
            width,
            height,
            pixels,
        }
    }

    /// Pixels in a row.
    #[inline]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Number of rows.
    #[inline]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All of the picture.
    pub fn rect(&self) -> Rect {
        Rect {
            x: 0,
            y: 0,
            width: self.width,
            height: self.height,
        }
    }

    /// All pixels, row by row from the top.
    #[inline]
    pub fn pixels(&self) -> &[P] {
        &self.pixels
    }

    /// All pixels, to be changed.
    #[inline]
    pub fn pixels_mut(&mut self) -> &mut [P] {
        &mut self.pixels
    }

    /// The pixels, taken out.
    pub fn into_pixels(self) -> Vec<P> {
        self.pixels
    }

    /// Row `y`.
    #[inline]
    pub fn row(&self, y: u32) -> &[P] {
        let start = y as usize * self.width as usize;
        &self.pixels[start..start + self.width as usize]
    }

    /// Row `y`, to be changed.
    #[inline]
    pub fn row_mut(&mut self, y: u32) -> &mut [P] {
        let start = y as usize * self.width as usize;
        &mut self.pixels[start..start + self.width as usize]
    }

    /// The pixel at (x, y), which must be inside.
    #[inline]
    pub fn at(&self, x: u32, y: u32) -> P {
        self.row(y)[x as usize]
    }

    /// The pixel at (x, y), or `None` outside.
    #[inline]
    pub fn get(&self, x: i64, y: i64) -> Option<P> {
        let inside =
            (0..i64::from(self.width)).contains(&x) && (0..i64::from(self.height)).contains(&y);
        inside.then(|| self.at(x as u32, y as u32))
    }

    /// Changes the pixel at (x, y), which must be inside.
    #[inline]
    pub fn set(&mut self, x: u32, y: u32, pixel: P) {
        self.row_mut(y)[x as usize] = pixel;
    }

    /// The image with `change` applied to each pixel.
    pub fn map<Q: Copy>(&self, change: impl FnMut(&P) -> Q) -> Image<Q> {
        Image::from_pixels(
            self.width,
            self.height,
            self.pixels.iter().map(change).collect(),
        )
    }

    /// The part of the image with its top-left corner at (`x`, `y`).
    ///
    /// # Panics
    /// When the part is empty or reaches outside.
    pub fn cropped(&self, x: u32, y: u32, width: u32, height: u32) -> Self {
        let columns = x as usize..(x + width) as usize;
        let pixels = (y..y + height)
            .flat_map(|row| &self.row(row)[columns.clone()])
            .copied()
            .collect();
        Self::from_pixels(width, height, pixels)
    }
}

impl Image<Straight> {
    /// The image with colours multiplied by alpha.
    pub fn premultiplied(&self) -> Image<Premultiplied> {
        self.map(|pixel| pixel.premultiplied())
    }
}

impl Image<Premultiplied> {
    /// The image with alpha divided out of the colours.
    pub fn straight(&self) -> Image<Straight> {
        self.map(|pixel| pixel.straight())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opaque_pixels_survive_the_round_trip_exactly() {
        for value in 0..=255 {
            let pixel = Straight([value, 255 - value, 3, 255]);
            assert_eq!(pixel.premultiplied().straight(), pixel);
        }
    }

    #[test]
    fn no_round_trip_is_off_by_more_than_the_alpha_allows() {
        for alpha in 1..=255u8 {
            for value in 0..=255u8 {
                let back = Straight([value, 0, 0, alpha]).premultiplied().straight().0[0];
                let allowed = 127.5 / f64::from(alpha) + 0.5;
                assert!((f64::from(back) - f64::from(value)).abs() <= allowed);
            }
        }
    }

    #[test]
    fn cropping_takes_rows_and_columns() {
        let image = Image::from_pixels(3, 2, vec![1, 2, 3, 4, 5, 6]);
        assert_eq!(image.cropped(1, 0, 2, 2).pixels(), &[2, 3, 5, 6]);
        assert_eq!(image.get(-1, 0), None);
        assert_eq!(image.get(2, 1), Some(6));
    }
}
