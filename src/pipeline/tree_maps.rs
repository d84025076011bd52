//! Maps of a flat picture of a tree: how far each pixel stands out, where its surface faces, how open
//! it is to the sky, how much light comes through from behind.
//!
//! The tree's own outline, holes between its leaves closed, is inflated (`crown::Inflation`), and
//! the picture's relief (`crown::relief`) is laid on top. Normals come from the slopes of the sum,
//! so a flat card looks round when the light moves; openness is how little of the sky the
//! neighbourhood hides (its height above the mean around, at three widths, and which way it faces); translucency falls with
//! the thickness and follows the brightness of the leaf.
//!
//! Limits: both are computed on a grid of [`GRID`] pixels and interpolated, which serves branches
//! and boughs; single leaves get their tilt from the luminance of the full picture. Light that is
//! painted into the picture is not taken out of its colours.

use crate::base::{Cancel, Cancelled, Progress};
use crate::crown::{Domain, Inflation, InflationError, ReliefSettings, luminance, relief};
use crate::raster::{Image, Mask, Straight, closed_and_filled, opaque_bounds, scaled};
use rayon::prelude::*;

/// Longer side of the grid that is inflated. 192 takes 0.1 s; finer changes no picture one can tell.
const GRID: u32 = 192;

/// Gaps up to twice this many grid pixels wide are closed before inflating, or every bough would be
/// a sausage of its own.
const CLOSING_PX: u8 = 5;

/// How far the silhouette pulls: a disc becomes a dome as high as its radius at 2.08.
const K: f64 = 2.08;

/// Height of the relief from darkest to lightest, as a share of the tree's longer side.
const RELIEF: f32 = 0.05;

/// Height of single leaves, from darkest to lightest, as a share of the tree's longer side.
const LEAVES: f32 = 0.004;

/// How much of the sky a surface misses that faces straight down, its own hollows apart.
const FACING_DOWN: f32 = 0.4;

/// What 255 in a depth map means, as a share of the longer side of what shows in the picture.
pub const DEPTH_SHARE: f64 = 0.5;

/// The steepest slope of the inflated surface, where it meets the outline: 72° from the viewer.
const STEEPEST: f32 = 3.0;

/// The maps of one picture, each as large as it.
#[derive(Debug, Clone, PartialEq)]
pub struct TreeMaps {
    /// Tangent space, x to the right, y **up**, z towards the viewer: 128 is 0.
    pub normal: Image<Straight>,
    /// Distance from the picture's plane towards the viewer: 0 at the outline, 255 is
    /// [`DEPTH_SHARE`] of the tree's longer side.
    pub depth: Image<u8>,
    /// Openness to the sky: 0 closed, 255 open.
    pub ao: Image<u8>,
    /// Share of the light from behind that comes through: 0 none, 255 all.
    pub translucency: Image<u8>,
}

/// The maps of `image`, a tree on clear ground. Pixels that do not show get values too, those of the
/// inflated outline or, beyond it, of the plane.
///
/// # Errors
/// [`Cancelled`].
pub fn tree_maps(image: &Image<Straight>, cancel: &Cancel) -> Result<TreeMaps, Cancelled> {
    let (width, height) = (image.width(), image.height());
    let scale = (f64::from(GRID) / f64::from(width.max(height))).min(1.0);
    // A frame of clear pixels: the ring around the mask must lie on the grid.
    let small = scaled(&image.premultiplied(), scale).straight();
    let small = framed(&small);
    cancel.check()?;
    let seen = small.map(|pixel| pixel.alpha() >= 64);
    let mask = closed_and_filled(&seen, CLOSING_PX);
    let Some(bounds) = opaque_bounds(&mask) else {
        return Ok(flat(width, height));
    };
    let inflated = inflated(&mask, cancel)?;
    let longer = bounds.width.max(bounds.height) as f32;
    let bumps = relief(&opaque(&small), &mask, &ReliefSettings::default(), cancel)?;
    let thickness = Field::of(&inflated, width, height);
    let bumps = bumps.map(|&height| height * RELIEF * longer);
    let openness = openness(&bumps, longer);
    let surface = Image::from_pixels(
        inflated.width(),
        inflated.height(),
        inflated
            .pixels()
            .iter()
            .zip(bumps.pixels())
            .map(|(a, b)| a + b)
            .collect(),
    );
    cancel.check()?;
    let surface = Field::of(&surface, width, height);
    let openness = Field::of(&openness, width, height);
    cancel.check()?;
    Ok(TreeMaps::of(
        image,
        &thickness,
        &surface,
        &openness,
        longer / scale as f32,
    ))
}

impl TreeMaps {
    fn of(
        image: &Image<Straight>,
        thickness: &Field<'_>,
        surface: &Field<'_>,
        openness: &Field<'_>,
        longer_px: f32,
    ) -> Self {
        let (width, height) = (image.width(), image.height());
        let per_pixel = surface.pixel();
        let highest = DEPTH_SHARE as f32 * longer_px;
        let leaf = LEAVES * longer_px;
        let lights = lights(image);
        let mut normal = Image::filled(width, height, Straight([128, 128, 255, 255]));
        let mut others = vec![[0u8; 3]; normal.pixels().len()];
        let rows = normal.pixels_mut().par_chunks_mut(width as usize);
        rows.zip(others.par_chunks_mut(width as usize))
            .enumerate()
            .for_each(|(y, (normals, others))| {
                let y = y as u32;
                let (surface, thickness) = (surface.row(y), thickness.row(y));
                let openness = openness.row(y);
                for (x, &pixel) in image.row(y).iter().enumerate() {
                    let [dx, dy] = surface.slope(x);
                    let [lx, ly] = light_slope(&lights, x as u32, y);
                    let slope = limited([dx + leaf * lx, dy + leaf * ly]);
                    normals[x] = encoded_normal(slope);
                    let height = surface.at(x) * per_pixel;
                    let light = luminance(pixel);
                    let depth = thickness.at(x) * per_pixel / longer_px;
                    // A quarter of the tree's width lets a third through.
                    let through = libm::expf(-4.0 * depth) * (0.35 + 0.65 * light);
                    let byte = |v: f32| (255.0 * v + 0.5).clamp(0.0, 255.0) as u8;
                    // What faces down sees the ground, not the sky.
                    let up = f32::from(normals[x].0[1]) / 127.5 - 1.0;
                    let open = openness.at(x) * (1.0 - FACING_DOWN * (1.0 - up) / 2.0);
                    others[x] = [byte(height / highest), byte(open), byte(through)];
                }
            });
        let channel = |c: usize| {
            Image::from_pixels(width, height, others.iter().map(|texel| texel[c]).collect())
        };
        Self {
            depth: channel(0),
            ao: channel(1),
            translucency: channel(2),
            normal,
        }
    }
}

/// Maps of nothing.
fn flat(width: u32, height: u32) -> TreeMaps {
    TreeMaps {
        normal: Image::filled(width, height, Straight([128, 128, 255, 255])),
        depth: Image::filled(width, height, 0),
        ao: Image::filled(width, height, 255),
        translucency: Image::filled(width, height, 255),
    }
}

/// Room around the small picture: what closing adds, and the ring.
const FRAME: u32 = CLOSING_PX as u32 + 2;

fn framed(image: &Image<Straight>) -> Image<Straight> {
    let (width, height) = (image.width(), image.height());
    let mut out = Image::filled(width + 2 * FRAME, height + 2 * FRAME, Straight([0; 4]));
    for y in 0..height {
        let columns = FRAME as usize..(FRAME + width) as usize;
        out.row_mut(y + FRAME)[columns].copy_from_slice(image.row(y));
    }
    out
}

/// The picture without alpha: gaps and soft edges get the colour that one sees in gaps.
fn opaque(image: &Image<Straight>) -> Image<Straight> {
    let gap = colour_of_gaps(image);
    image.map(|pixel| {
        let alpha = f32::from(pixel.alpha()) / 255.0;
        let mixed = |c: usize| (f32::from(pixel.0[c]) * alpha + gap[c] * (1.0 - alpha) + 0.5) as u8;
        Straight([mixed(0), mixed(1), mixed(2), 255])
    })
}

/// The mean colour, somewhat darkened: what one sees in the gaps of a crown.
fn colour_of_gaps(image: &Image<Straight>) -> [f32; 3] {
    const GAP: f32 = 0.6;
    let (mut sums, mut weight) = ([0.0f32; 3], 0.0f32);
    for pixel in image.pixels() {
        let alpha = f32::from(pixel.alpha());
        weight += alpha;
        for (sum, &value) in sums.iter_mut().zip(&pixel.0) {
            *sum += alpha * f32::from(value);
        }
    }
    sums.map(|sum| GAP * sum / weight.max(1.0))
}

/// Height of the inflated mask, in grid pixels; 0 outside.
fn inflated(mask: &Mask, cancel: &Cancel) -> Result<Image<f32>, Cancelled> {
    let mut heights = Image::filled(mask.width(), mask.height(), 0.0f32);
    let sheet = Domain::new(mask)
        .and_then(|domain| Inflation::new(domain, Progress::silent(), cancel))
        .and_then(|inflation| {
            let k = vec![K; inflation.domain().ring().len()];
            inflation.sheet(&k, cancel)
        });
    match sheet {
        Ok(sheet) => {
            for (&(x, y), position) in sheet.domain.pixels().iter().zip(&sheet.positions) {
                heights.set(x, y, position.z as f32);
            }
            Ok(heights)
        }
        Err(InflationError::Cancelled(cancelled)) => Err(cancelled),
        Err(error) => unreachable!("a mask with pixels and a finite k: {error}"),
    }
}

/// How open each place of the relief is: 1 on bulges, less in hollows, seen at three widths.
fn openness(surface: &Image<f32>, longer: f32) -> Image<f32> {
    let mut open = surface.map(|_| 1.0f32);
    for share in [0.01f32, 0.03, 0.08] {
        let radius = ((share * longer) as u32).max(1);
        let mean = box_mean(&box_mean(surface, radius), radius);
        let heights = surface.pixels().iter().zip(mean.pixels());
        for (open, (height, mean)) in open.pixels_mut().iter_mut().zip(heights) {
            // A tenth of the radius below the mean around hides a third of the sky.
            let sunk = ((mean - height) / radius as f32).max(0.0);
            *open *= 1.0 / (1.0 + 5.0 * sunk);
        }
    }
    open
}

/// Mean over squares of side 2 · `radius` + 1, cut at the image's edges.
fn box_mean(image: &Image<f32>, radius: u32) -> Image<f32> {
    let across = |image: &Image<f32>| {
        let mut out = Image::filled(image.height(), image.width(), 0.0f32);
        for y in 0..image.height() {
            let row = image.row(y);
            for x in 0..image.width() {
                let from = x.saturating_sub(radius) as usize;
                let to = ((x + radius + 1) as usize).min(row.len());
                let sum: f32 = row[from..to].iter().sum();
                // Transposed, so that doing it twice does both axes.
                out.set(y, x, sum / (to - from) as f32);
            }
        }
        out
    };
    across(&across(image))
}

/// Heights on the framed grid, to be read row by row at the pixels of the full picture.
///
/// Between grid pixels they are a cubic B-spline, smooth in its slopes. Its weights are separable:
/// those along a row are found once, those down once a row.
struct Field<'a> {
    heights: &'a Image<f32>,
    /// Grid pixels for one picture pixel, across and down.
    scale: [f32; 2],
    across: Vec<Taps>,
    down: Vec<Taps>,
}

/// The grid pixels along one axis that a picture pixel is read from.
#[derive(Clone, Copy)]
struct Taps {
    at: [u32; 4],
    /// Their shares in the height.
    value: [f32; 4],
    /// Their shares in its slope along the axis.
    slope: [f32; 4],
}

/// Those of each of `pixels` picture pixels, `scale` grid pixels apart, on a framed grid of `grid`.
fn taps(pixels: u32, scale: f32, grid: u32) -> Vec<Taps> {
    let tap = |pixel: u32| {
        let place = (pixel as f32 + 0.5) * scale - 0.5 + FRAME as f32;
        let whole = place.floor();
        let at = |i: i64| (whole as i64 - 1 + i).clamp(0, i64::from(grid) - 1) as u32;
        Taps {
            at: [at(0), at(1), at(2), at(3)],
            value: b_spline(place - whole),
            slope: b_spline_slope(place - whole),
        }
    };
    (0..pixels).map(tap).collect()
}

impl<'a> Field<'a> {
    fn of(heights: &'a Image<f32>, width: u32, height: u32) -> Self {
        let scale = |grid: u32, full: u32| (grid - 2 * FRAME) as f32 / full as f32;
        let scale = [
            scale(heights.width(), width),
            scale(heights.height(), height),
        ];
        Self {
            heights,
            scale,
            across: taps(width, scale[0], heights.width()),
            down: taps(height, scale[1], heights.height()),
        }
    }

    /// Picture pixels for one grid pixel.
    fn pixel(&self) -> f32 {
        2.0 / (self.scale[0] + self.scale[1])
    }

    /// Row `y` of the picture.
    fn row(&self, y: u32) -> FieldRow<'_> {
        let taps = &self.down[y as usize];
        let mixed = |weights: &[f32; 4]| {
            let [a, b, c, d] = taps.at.map(|row| self.heights.row(row));
            let columns = a.iter().zip(b).zip(c).zip(d);
            let sum = |(((a, b), c), d): (((&f32, &f32), &f32), &f32)| {
                a * weights[0] + b * weights[1] + c * weights[2] + d * weights[3]
            };
            columns.map(sum).collect()
        };
        FieldRow {
            across: &self.across,
            value: mixed(&taps.value),
            slope: mixed(&taps.slope),
        }
    }
}

/// A row of the picture: one entry a grid column.
struct FieldRow<'a> {
    across: &'a [Taps],
    /// Heights.
    value: Vec<f32>,
    /// Slopes downwards.
    slope: Vec<f32>,
}

impl FieldRow<'_> {
    /// Height at picture pixel `x`, in grid pixels.
    fn at(&self, x: usize) -> f32 {
        let taps = &self.across[x];
        weighted(&self.value, taps.at, taps.value)
    }

    /// Slopes along x and y (down) at picture pixel `x`: no unit.
    fn slope(&self, x: usize) -> [f32; 2] {
        let taps = &self.across[x];
        [
            weighted(&self.value, taps.at, taps.slope),
            weighted(&self.slope, taps.at, taps.value),
        ]
    }
}

fn weighted(values: &[f32], at: [u32; 4], weights: [f32; 4]) -> f32 {
    let [a, b, c, d] = at.map(|i| values[i as usize]);
    a * weights[0] + b * weights[1] + c * weights[2] + d * weights[3]
}

fn b_spline(t: f32) -> [f32; 4] {
    let s = 1.0 - t;
    [
        s * s * s / 6.0,
        (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
        (3.0 * s * s * s - 6.0 * s * s + 4.0) / 6.0,
        t * t * t / 6.0,
    ]
}

fn b_spline_slope(t: f32) -> [f32; 4] {
    let s = 1.0 - t;
    [
        -0.5 * s * s,
        1.5 * t * t - 2.0 * t,
        2.0 * s - 1.5 * s * s,
        0.5 * t * t,
    ]
}

/// Luminance of each pixel, no number where it does not show.
fn lights(image: &Image<Straight>) -> Image<f32> {
    image.map(|&pixel| {
        if pixel.alpha() >= 128 {
            luminance(pixel)
        } else {
            f32::NAN
        }
    })
}

/// Slope of the luminance across a pixel, 0 where one side does not show.
fn light_slope(lights: &Image<f32>, x: u32, y: u32) -> [f32; 2] {
    let at = |x: u32, y: u32| {
        let is_inside = x < lights.width() && y < lights.height();
        if is_inside { lights.at(x, y) } else { f32::NAN }
    };
    let between = |a: f32, b: f32| {
        let slope = (b - a) / 2.0;
        if slope.is_nan() { 0.0 } else { slope }
    };
    // One to the left of the first wraps round to far outside.
    [
        between(at(x.wrapping_sub(1), y), at(x + 1, y)),
        between(at(x, y.wrapping_sub(1)), at(x, y + 1)),
    ]
}

/// A slope no steeper than [`STEEPEST`], bent smoothly towards it.
fn limited([x, y]: [f32; 2]) -> [f32; 2] {
    let steep = (x * x + y * y).sqrt();
    let factor = 1.0 / (1.0 + (steep / STEEPEST) * (steep / STEEPEST)).sqrt();
    [x * factor, y * factor]
}

/// The normal of a surface that rises by `dx` to the right and by `dy` downwards.
fn encoded_normal([dx, dy]: [f32; 2]) -> Straight {
    let length = (dx * dx + dy * dy + 1.0).sqrt();
    let byte = |v: f32| ((v / length + 1.0) * 127.5 + 0.5).clamp(0.0, 255.0) as u8;
    // The picture's y points down, the map's up.
    Straight([byte(-dx), byte(dy), byte(1.0), 255])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disc() -> Image<Straight> {
        let mut image = Image::filled(256, 256, Straight([0; 4]));
        for y in 0..256u32 {
            for x in 0..256u32 {
                if (f64::from(x) - 127.5).hypot(f64::from(y) - 127.5) < 100.0 {
                    image.set(x, y, Straight([90, 140, 60, 255]));
                }
            }
        }
        image
    }

    #[test]
    fn a_flat_disc_becomes_a_dome() {
        let maps = tree_maps(&disc(), &Cancel::new()).unwrap();
        let normal = |x, y| maps.normal.at(x, y).0.map(|v| f64::from(v) / 127.5 - 1.0);
        let middle = normal(128, 128);
        assert!(middle[2] > 0.97, "{middle:?}");
        assert!(normal(210, 128)[0] > 0.5, "right faces right");
        assert!(normal(46, 128)[0] < -0.5, "left faces left");
        assert!(normal(128, 46)[1] > 0.5, "top faces up");
        assert!(normal(128, 210)[1] < -0.5, "bottom faces down");
        // As high as its radius, to a tenth.
        let top = maps.depth.at(128, 128);
        assert!((230..=255).contains(&top), "{top}");
        assert!(maps.depth.at(40, 128) < 90);
        assert!(maps.translucency.at(36, 128) > maps.translucency.at(128, 128));
    }

    #[test]
    fn an_empty_picture_is_flat() {
        let image = Image::filled(9, 7, Straight([0; 4]));
        let maps = tree_maps(&image, &Cancel::new()).unwrap();
        assert!(
            maps.normal
                .pixels()
                .iter()
                .all(|p| p.0 == [128, 128, 255, 255])
        );
    }
}
