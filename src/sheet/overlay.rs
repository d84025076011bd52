//! A tree with all that was found on it: borders, outline, cage, baseline, pins.

use super::paint::{Canvas, Rgba, closed, open};
use crate::contour::{Outlines, Pins};
use crate::geometry::Point;
use crate::raster::{Image, Premultiplied, Straight};

const GROUND: Rgba = [206, 204, 200, 255];
const BORDER: Rgba = [104, 102, 98, 255];
const LONGEST: Rgba = [24, 24, 26, 255];
const CONTOUR: Rgba = [0, 196, 222, 255];
const CAGE: Rgba = [222, 48, 40, 255];
const BASELINE: Rgba = [243, 146, 0, 255];
const WHITE: Rgba = [255, 255, 255, 255];

/// How much of the tree's own opacity is left under the lines.
const TREE_OPACITY: f64 = 0.62;

/// What to draw; all coordinates are pixels of [`Overlay::image`].
#[derive(Debug, Clone, Copy)]
pub struct Overlay<'a> {
    /// The normalised picture.
    pub image: &'a Image<Premultiplied>,
    /// All borders, drawn thin and grey.
    pub borders: &'a Outlines,
    /// The longest exterior border, drawn black.
    pub longest: &'a [Point],
    /// B, L and R on `longest`, drawn as black dots with a white rim.
    pub pins: Pins,
    /// C_r, the resampled outline, drawn cyan on the black.
    pub contour: &'a [Point],
    /// C_s, the cage, drawn red with its vertices.
    pub cage: &'a [Point],
    /// Row where the crown begins, drawn orange.
    pub baseline_y: Option<f64>,
}

/// The drawing. It is larger than the picture by a twentieth on all sides, since the cage reaches
/// beyond the picture.
pub fn overlay(drawn: &Overlay<'_>) -> Image<Straight> {
    let margin = margin_px(drawn.image.width());
    let side = drawn.image.width() + 2 * margin;
    // Pixel centres are whole numbers in our coordinates and halves on the canvas.
    let shift = Point::splat(f64::from(margin) + 0.5);
    let unit = (f64::from(drawn.image.width()) / 1024.0).max(0.5);
    let mut canvas = Canvas::new(side, side, GROUND);
    canvas.lay(
        drawn.image,
        i64::from(margin),
        i64::from(margin),
        TREE_OPACITY,
    );
    let line = |points| closed([points], 1.0, shift);
    let borders = drawn.borders.all.iter().map(|o| o.points.as_slice());
    canvas.stroke(closed(borders, 1.0, shift).as_ref(), 0.9 * unit, BORDER);
    canvas.stroke(line(drawn.longest).as_ref(), 3.2 * unit, LONGEST);
    canvas.stroke(line(drawn.contour).as_ref(), 1.5 * unit, CONTOUR);
    canvas.stroke(line(drawn.cage).as_ref(), 1.6 * unit, CAGE);
    for &vertex in drawn.cage {
        canvas.dot(vertex + shift, 2.6 * unit, CAGE);
    }
    if let Some(y) = drawn.baseline_y {
        draw_baseline(&mut canvas, y + shift.y, f64::from(side), unit);
    }
    let pins = [drawn.pins.left, drawn.pins.right, drawn.pins.bottom];
    for pin in pins.map(|index| drawn.longest[index] + shift) {
        canvas.dot(pin, 9.5 * unit, WHITE);
        canvas.dot(pin, 7.0 * unit, LONGEST);
    }
    canvas.into_image()
}

/// Width in pixels of the ground around a picture of `size` pixels: the cage reaches a hundredth
/// of the size beyond it, and more where a contour bulges.
fn margin_px(size: u32) -> u32 {
    (size / 20).max(8)
}

/// A dashed line from edge to edge, light beneath so that it shows on foliage.
fn draw_baseline(canvas: &mut Canvas, y: f64, width: f64, unit: f64) {
    let (dash, gap) = (18.0 * unit, 10.0 * unit);
    let count = (width / (dash + gap)).ceil() as u32;
    for i in 0..count {
        let start = f64::from(i) * (dash + gap) + gap / 2.0;
        let ends = [Point::new(start, y), Point::new(start + dash, y)];
        canvas.stroke(open(&ends).as_ref(), 4.4 * unit, [255, 255, 255, 170]);
        canvas.stroke(open(&ends).as_ref(), 2.6 * unit, BASELINE);
    }
}
