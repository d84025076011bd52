//! A picture as a network takes it: a fixed size, the picture's shape kept, centred, the rest padded.
//!
//! Every number of a plane is the mean of the picture's pixels that lie under it, colours weighted by
//! alpha (area averaging); a picture that is smaller than the input is interpolated linearly. Sums run
//! in one order, so that the input is the same, bit for bit, on every machine.

use super::card::{Card, Channel, Padding};
use crate::raster::{Image, Rect, Straight};
use rayon::prelude::*;

/// Where a picture lies in the input of a network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Letterbox {
    /// What part of the picture is shown.
    pub(super) crop: Rect,
    /// Where it lies in the input.
    pub(super) inner: Rect,
    /// Columns and rows of the input.
    pub(super) width: u32,
    pub(super) height: u32,
}

impl Letterbox {
    /// The part `crop` of a picture, as large as fits into `width` × `height`, in the middle.
    pub(super) fn new(crop: Rect, width: u32, height: u32) -> Self {
        let scale = (f64::from(width) / f64::from(crop.width))
            .min(f64::from(height) / f64::from(crop.height));
        let side = |length: u32, most: u32| {
            ((f64::from(length) * scale + 0.5).floor() as u32).clamp(1, most)
        };
        let (inner_width, inner_height) = (side(crop.width, width), side(crop.height, height));
        Self {
            crop,
            inner: Rect {
                x: (width - inner_width) / 2,
                y: (height - inner_height) / 2,
                width: inner_width,
                height: inner_height,
            },
            width,
            height,
        }
    }

    /// The column of the input, in pixels with their centres at whole numbers, that column `x` of the
    /// picture lies at; and likewise for rows.
    pub(super) fn column(&self, x: u32) -> f32 {
        let Self { crop, inner, .. } = self;
        place(x - crop.x, crop.width, inner.width) + inner.x as f32
    }

    pub(super) fn row(&self, y: u32) -> f32 {
        let Self { crop, inner, .. } = self;
        place(y - crop.y, crop.height, inner.height) + inner.y as f32
    }

    /// The picture at the input's size: colours straight, 0 to 1, clear where nothing is shown.
    pub(super) fn reduced(&self, picture: &Image<Straight>) -> Image<[f32; 4]> {
        let inner = averaged(picture, self.crop, self.inner.width, self.inner.height);
        let mut whole = Image::filled(self.width, self.height, [0.0; 4]);
        let columns = self.inner.x as usize..(self.inner.x + self.inner.width) as usize;
        for y in 0..self.inner.height {
            whole.row_mut(self.inner.y + y)[columns.clone()].copy_from_slice(inner.row(y));
        }
        whole
    }

    /// The input tensor of `reduced`, plane after plane.
    pub(super) fn tensor(
        &self,
        reduced: &Image<[f32; 4]>,
        card: &Card,
        has_alpha: bool,
    ) -> Vec<f32> {
        let count = reduced.pixels().len();
        let mut tensor = Vec::with_capacity(count * card.channels());
        let input = &card.input;
        let at = |x: u32, y: u32| match input.padding {
            Padding::Zero => reduced.at(x, y),
            Padding::Edge => {
                let Rect {
                    x: left,
                    y: top,
                    width,
                    height,
                } = self.inner;
                reduced.at(
                    x.clamp(left, left + width - 1),
                    y.clamp(top, top + height - 1),
                )
            }
        };
        for ((channel, mean), std) in input.channels.iter().zip(&input.mean).zip(&input.std) {
            for y in 0..self.height {
                for x in 0..self.width {
                    let [r, g, b, alpha] = at(x, y);
                    let value = match channel {
                        Channel::R => r,
                        Channel::G => g,
                        Channel::B => b,
                        Channel::A if has_alpha => alpha,
                        Channel::HasAlpha if has_alpha => 1.0,
                        Channel::A | Channel::HasAlpha => 0.0,
                    };
                    tensor.push((value - mean) / std);
                }
            }
        }
        tensor
    }
}

/// Where the centre of pixel `at` of `source` pixels lies among `target` pixels.
fn place(at: u32, source: u32, target: u32) -> f32 {
    ((f64::from(at) + 0.5) * f64::from(target) / f64::from(source) - 0.5) as f32
}

/// The part `crop` of `picture` at another size, straight, 0 to 1.
fn averaged(picture: &Image<Straight>, crop: Rect, width: u32, height: u32) -> Image<[f32; 4]> {
    let across: Vec<Taps> = (0..width).map(|x| Taps::of(x, crop.width, width)).collect();
    let columns = crop.x as usize..(crop.x + crop.width) as usize;
    // Premultiplied sums of the columns, for each row of the crop; then of the rows.
    let mut narrow = vec![[0.0f32; 4]; width as usize * crop.height as usize];
    narrow
        .par_chunks_mut(width as usize)
        .zip(crop.y..crop.y + crop.height)
        .for_each(|(out, y)| {
            let row = &picture.row(y)[columns.clone()];
            for (out, taps) in out.iter_mut().zip(&across) {
                // Not summed in place: fresh memory that is read before it is written costs twice.
                let mut sum = [0.0; 4];
                for (pixel, weight) in row[taps.first..].iter().zip(&taps.weights) {
                    let [r, g, b, a] = pixel.0.map(f32::from);
                    let share = weight * a;
                    sum[0] += share * r;
                    sum[1] += share * g;
                    sum[2] += share * b;
                    sum[3] += share;
                }
                *out = sum;
            }
        });
    let narrow = Image::from_pixels(width, crop.height, narrow);
    let mut pixels = Vec::with_capacity(width as usize * height as usize);
    for y in 0..height {
        let taps = Taps::of(y, crop.height, height);
        let mut sums = vec![[0.0f32; 4]; width as usize];
        for (row, weight) in (taps.first as u32..).zip(&taps.weights) {
            for (sum, value) in sums.iter_mut().zip(narrow.row(row)) {
                for (sum, value) in sum.iter_mut().zip(value) {
                    *sum += weight * value;
                }
            }
        }
        pixels.extend(sums.into_iter().map(straight));
    }
    Image::from_pixels(width, height, pixels)
}

/// Premultiplied sums in 8-bit units as straight colour and alpha, 0 to 1.
fn straight([r, g, b, a]: [f32; 4]) -> [f32; 4] {
    /// Less alpha than 8 bits can hold.
    const CLEAR: f32 = 0.25;
    if a < CLEAR {
        return [0.0; 4];
    }
    let colour = |sum: f32| (sum / (a * 255.0)).min(1.0);
    [colour(r), colour(g), colour(b), (a / 255.0).min(1.0)]
}

/// The source pixels under a target pixel, along one axis.
struct Taps {
    first: usize,
    /// Of sum 1.
    weights: Vec<f32>,
}

impl Taps {
    fn of(at: u32, source: u32, target: u32) -> Self {
        if source > target {
            Self::averaging(at, source, target)
        } else {
            Self::interpolating(at, source, target)
        }
    }

    /// The pixels from edge to edge, those at the edges by their shares: whole numbers of which each
    /// source pixel has `target` and each target pixel `source`.
    fn averaging(at: u32, source: u32, target: u32) -> Self {
        let [at, source, target] = [at, source, target].map(u64::from);
        let (from, to) = (at * source, (at + 1) * source);
        let (first, end) = (from / target, to.div_ceil(target));
        let share = |i: u64| ((i + 1) * target).min(to) - (i * target).max(from);
        Self {
            first: first as usize,
            weights: (first..end)
                .map(|i| share(i) as f32 / source as f32)
                .collect(),
        }
    }

    fn interpolating(at: u32, source: u32, target: u32) -> Self {
        let place = place(at, target, source).clamp(0.0, (source - 1) as f32);
        let first = place.floor().min(source.saturating_sub(2) as f32);
        let share = place - first;
        let weights = match source {
            1 => vec![1.0],
            _ => vec![1.0 - share, share],
        };
        Self {
            first: first as usize,
            weights,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn whole(width: u32, height: u32) -> Rect {
        Rect {
            x: 0,
            y: 0,
            width,
            height,
        }
    }

    fn grey(rows: &[&[u8]]) -> Image<Straight> {
        let pixels = rows.iter().flat_map(|row| row.iter());
        let pixels = pixels.map(|&v| Straight([v, v, v, 255])).collect();
        Image::from_pixels(rows[0].len() as u32, rows.len() as u32, pixels)
    }

    fn reds(image: &Image<[f32; 4]>) -> Vec<f32> {
        let reds = image.pixels().iter();
        reds.map(|pixel| (pixel[0] * 255.0 * 100.0).round() / 100.0)
            .collect()
    }

    #[test]
    fn a_picture_lies_in_the_middle_with_its_shape_kept() {
        let tall = Letterbox::new(whole(100, 400), 64, 64);
        assert_eq!(
            tall.inner,
            Rect {
                x: 24,
                y: 0,
                width: 16,
                height: 64
            }
        );
        let wide = Letterbox::new(whole(30, 10), 60, 40);
        assert_eq!(
            wide.inner,
            Rect {
                x: 0,
                y: 10,
                width: 60,
                height: 20
            }
        );
        let thread = Letterbox::new(whole(1, 5000), 32, 32);
        assert_eq!((thread.inner.width, thread.inner.height), (1, 32));
    }

    #[test]
    fn places_in_the_picture_are_places_in_the_input() {
        let crop = Rect {
            x: 10,
            y: 20,
            width: 40,
            height: 80,
        };
        let box_ = Letterbox::new(crop, 32, 32);
        assert_eq!(
            box_.inner,
            Rect {
                x: 8,
                y: 0,
                width: 16,
                height: 32
            }
        );
        // 2.5 pixels of the picture lie under one of the input.
        assert!((box_.column(10) - 7.7).abs() < 1e-5 && (box_.column(49) - 23.3).abs() < 1e-5);
        assert!((box_.row(20) + 0.3).abs() < 1e-5 && (box_.row(22) - 0.5).abs() < 1e-5);
    }

    #[test]
    fn pixels_are_averaged_by_area() {
        let row = grey(&[&[30, 60, 90]]);
        assert_eq!(reds(&averaged(&row, whole(3, 1), 1, 1)), [60.0]);
        // One and a half pixels each: (30 + 60/2) / 1.5 and (60/2 + 90) / 1.5.
        assert_eq!(reds(&averaged(&row, whole(3, 1), 2, 1)), [40.0, 80.0]);
        let column = grey(&[&[30], &[60], &[90]]);
        assert_eq!(reds(&averaged(&column, whole(1, 3), 1, 2)), [40.0, 80.0]);
    }

    #[test]
    fn small_pictures_are_interpolated() {
        let row = grey(&[&[0, 100]]);
        assert_eq!(
            reds(&averaged(&row, whole(2, 1), 4, 1)),
            [0.0, 25.0, 75.0, 100.0]
        );
        let one = grey(&[&[7]]);
        assert_eq!(reds(&averaged(&one, whole(1, 1), 2, 2)), [7.0; 4]);
    }

    #[test]
    fn what_is_clear_has_no_colour_and_no_part() {
        let pixels = vec![Straight([200, 0, 0, 255]), Straight([0, 0, 0, 0])];
        let edge = Image::from_pixels(2, 1, pixels);
        let [pixel] = averaged(&edge, whole(2, 1), 1, 1).pixels()[..] else {
            unreachable!("one pixel");
        };
        assert!((pixel[0] - 200.0 / 255.0).abs() < 1e-6 && (pixel[3] - 0.5).abs() < 1e-6);
        let clear = Image::filled(4, 4, Straight([255, 255, 255, 0]));
        assert_eq!(averaged(&clear, whole(4, 4), 2, 2).at(1, 1), [0.0; 4]);
    }
}
