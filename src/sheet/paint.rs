//! The few things that all drawings here are made of: a canvas, paths, colours.

use crate::geometry::Point;
use crate::raster::{Image, Premultiplied, Straight};
use std::ops::Range;
use tiny_skia::{
    FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, PremultipliedColorU8, Stroke,
    Transform,
};

/// An sRGB colour with its opacity, 0 to 255 each.
pub(super) type Rgba = [u8; 4];

/// A picture in the making; opaque from the start.
pub(super) struct Canvas {
    pixmap: Pixmap,
}

impl Canvas {
    /// A canvas of one colour.
    ///
    /// # Panics
    /// When a side is 0 or beyond what fits into memory: callers bound their sheets.
    pub(super) fn new(width: u32, height: u32, [r, g, b, a]: Rgba) -> Self {
        let mut pixmap = Pixmap::new(width, height)
            .unwrap_or_else(|| unreachable!("a sheet has sides, and is small"));
        pixmap.fill(tiny_skia::Color::from_rgba8(r, g, b, a));
        Self { pixmap }
    }

    /// Draws `path` as a line of `width` pixels with round joints.
    pub(super) fn stroke(&mut self, path: Option<&Path>, width: f64, color: Rgba) {
        let stroke = Stroke {
            width: width as f32,
            line_cap: LineCap::Round,
            line_join: LineJoin::Round,
            ..Stroke::default()
        };
        if let Some(path) = path {
            let identity = Transform::identity();
            self.pixmap
                .stroke_path(path, &paint(color), &stroke, identity, None);
        }
    }

    /// Fills `path`, also where it winds around a place more than once.
    pub(super) fn fill(&mut self, path: Option<&Path>, color: Rgba) {
        if let Some(path) = path {
            let identity = Transform::identity();
            self.pixmap
                .fill_path(path, &paint(color), FillRule::Winding, identity, None);
        }
    }

    /// A filled circle.
    pub(super) fn dot(&mut self, at: Point, radius: f64, color: Rgba) {
        let circle = PathBuilder::from_circle(at.x as f32, at.y as f32, radius as f32);
        self.fill(circle.as_ref(), color);
    }

    /// Lays `picture` over the canvas with its top-left corner at (`left`, `top`), its opacity
    /// multiplied by `opacity`, 0 to 1. What reaches outside is cut.
    pub(super) fn lay(
        &mut self,
        picture: &Image<Premultiplied>,
        left: i64,
        top: i64,
        opacity: f64,
    ) {
        let opacity = (opacity * 255.0).round() as u32;
        let width = i64::from(self.pixmap.width());
        let height = i64::from(self.pixmap.height());
        let pixels = self.pixmap.pixels_mut();
        for y in (0..i64::from(picture.height())).filter(|y| (0..height).contains(&(y + top))) {
            for (x, pixel) in (left..).zip(picture.row(y as u32)) {
                if pixel.alpha() > 0 && (0..width).contains(&x) {
                    let under = &mut pixels[((y + top) * width + x) as usize];
                    *under = over(*pixel, opacity, *under);
                }
            }
        }
    }

    /// Changes the colour of every pixel: `change(x, y, [r, g, b])` in 0 to 255, not rounded.
    pub(super) fn shade(&mut self, change: impl Fn(u32, u32, [f64; 3]) -> [f64; 3]) {
        let (width, height) = (self.pixmap.width(), self.pixmap.height());
        self.shade_part(0..width, 0..height, change);
    }

    /// The same for some columns and rows, which may lie outside.
    pub(super) fn shade_part(
        &mut self,
        columns: Range<u32>,
        rows: Range<u32>,
        change: impl Fn(u32, u32, [f64; 3]) -> [f64; 3],
    ) {
        let (width, height) = (self.pixmap.width(), self.pixmap.height());
        let pixels = self.pixmap.pixels_mut();
        for y in rows.start..rows.end.min(height) {
            for x in columns.start..columns.end.min(width) {
                let pixel = &mut pixels[(y * width + x) as usize];
                let old = [pixel.red(), pixel.green(), pixel.blue()].map(f64::from);
                let dither = threshold(x, y);
                let [r, g, b] =
                    change(x, y, old).map(|value| (value + dither).floor().clamp(0.0, 255.0) as u8);
                *pixel = opaque(r, g, b);
            }
        }
    }

    /// The finished picture.
    pub(super) fn into_image(self) -> Image<Straight> {
        let pixels = self.pixmap.pixels().iter().map(|pixel| {
            let straight = pixel.demultiply();
            Straight([
                straight.red(),
                straight.green(),
                straight.blue(),
                straight.alpha(),
            ])
        });
        let pixels = pixels.collect();
        Image::from_pixels(self.pixmap.width(), self.pixmap.height(), pixels)
    }
}

/// Where a value is rounded up at (x, y), 0 to 1: an ordered dither (Bayer 1973), so that soft
/// gradients show no bands and still compress well.
fn threshold(x: u32, y: u32) -> f64 {
    let mut rank = 0;
    for bit in 0..3 {
        let (x, y) = (x >> bit & 1, y >> bit & 1);
        rank = rank << 2 | (x ^ y) << 1 | y;
    }
    (f64::from(rank) + 0.5) / 64.0
}

fn over(pixel: Premultiplied, opacity: u32, under: PremultipliedColorU8) -> PremultipliedColorU8 {
    let keep = 255 - u32::from(pixel.alpha()) * opacity / 255;
    let mixed = |top: u8, bottom: u8| {
        ((u32::from(top) * opacity + u32::from(bottom) * keep + 127) / 255).min(255) as u8
    };
    let [r, g, b, _] = pixel.0;
    opaque(
        mixed(r, under.red()),
        mixed(g, under.green()),
        mixed(b, under.blue()),
    )
}

fn opaque(r: u8, g: u8, b: u8) -> PremultipliedColorU8 {
    PremultipliedColorU8::from_rgba(r, g, b, 255)
        .unwrap_or_else(|| unreachable!("no colour exceeds full opacity"))
}

fn paint([r, g, b, a]: Rgba) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(r, g, b, a);
    paint.anti_alias = true;
    paint
}

/// Closed polygons as one path, each point `p` drawn at `p · scale + shift`.
pub(super) fn closed<'a>(
    polygons: impl IntoIterator<Item = &'a [Point]>,
    scale: f64,
    shift: Point,
) -> Option<Path> {
    let mut builder = PathBuilder::new();
    for polygon in polygons {
        for (index, &point) in polygon.iter().enumerate() {
            let at = (point * scale + shift).as_vec2();
            if index == 0 {
                builder.move_to(at.x, at.y);
            } else {
                builder.line_to(at.x, at.y);
            }
        }
        builder.close();
    }
    builder.finish()
}

/// An open polyline.
pub(super) fn open(points: &[Point]) -> Option<Path> {
    let mut builder = PathBuilder::new();
    for (index, point) in points.iter().enumerate() {
        let at = point.as_vec2();
        if index == 0 {
            builder.move_to(at.x, at.y);
        } else {
            builder.line_to(at.x, at.y);
        }
    }
    builder.finish()
}
