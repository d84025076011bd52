//! Triangles and rectangles, row by row.

use super::pixel::{WHITE, over, pixel, product};
use super::textures::{TEXEL, Texture};
use egui::epaint::Vertex;
use egui::{Color32, Mesh, Pos2, TextureFilter};
use std::ops::Range;

/// Parts of a pixel that corners are snapped to.
const PARTS: i64 = 256;

/// Farthest from the picture's corner that a place may be, parts of a pixel: products stay exact.
const FARTHEST: i64 = PARTS << 20;

/// A mesh, and where in the picture it may be seen.
pub(super) struct Batch<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) texture: &'a Texture,
    /// Pixels inside the clip rectangle.
    pub(super) columns: Range<i64>,
    pub(super) rows: Range<i64>,
    pub(super) pixels_per_point: f64,
}

impl Batch<'_> {
    /// Snapped, parts of a pixel.
    fn place(&self, points: f32) -> i64 {
        let parts = f64::from(points) * self.pixels_per_point * PARTS as f64;
        (parts.round() as i64).clamp(-FARTHEST, FARTHEST)
    }

    fn corner(&self, corner: Pos2) -> (i64, i64) {
        (self.place(corner.x), self.place(corner.y))
    }

    /// The rows of the picture whose middles lie between two heights, points.
    pub(super) fn rows_between(&self, top: f32, bottom: f32) -> Range<i64> {
        let rows = first_from(self.place(top))..first_from(self.place(bottom) + 1);
        rows.start.max(self.rows.start)..rows.end.min(self.rows.end)
    }
}

/// The first pixel whose middle is at `place` or behind it.
fn first_from(place: i64) -> i64 {
    (place - PARTS / 2 + PARTS - 1).div_euclid(PARTS)
}

/// Middle of a pixel, parts of one.
fn middle(pixel: i64) -> i64 {
    pixel * PARTS + PARTS / 2
}

/// A quantity that is linear on a triangle: its value in the middle of the picture's first pixel and
/// what it grows by to the right and downwards.
#[derive(Clone, Copy)]
struct Slope {
    origin: f64,
    across: f64,
    down: f64,
}

impl Slope {
    fn at(&self, column: i64, row: i64) -> f64 {
        self.origin + self.across * column as f64 + self.down * row as f64
    }
}

/// Three corners in the order of the clock, parts of a pixel, and twice the area.
struct Corners {
    at: [(i64, i64); 3],
    area: f64,
}

impl Corners {
    fn slope(&self, values: [f64; 3]) -> Slope {
        let [a, b, c] = self.at;
        let (one, two) = (values[1] - values[0], values[2] - values[0]);
        let side = |from: i64, to: i64| (to - from) as f64;
        let scale = PARTS as f64 / self.area;
        let across = (one * side(a.1, c.1) - two * side(a.1, b.1)) * scale;
        let down = (two * side(a.0, b.0) - one * side(a.0, c.0)) * scale;
        let pixels = |place: i64| (middle(0) - place) as f64 / PARTS as f64;
        Slope {
            origin: values[0] + across * pixels(a.0) + down * pixels(a.1),
            across,
            down,
        }
    }

    /// The columns of `row` that are inside; pixels on an edge belong to what lies right of it or below.
    fn span(&self, row: i64) -> Range<i64> {
        let y = middle(row);
        let (mut from, mut to) = (i64::MIN, i64::MAX);
        for side in 0..3 {
            let (a, b) = (self.at[side], self.at[(side + 1) % 3]);
            let (dx, dy) = (b.0 - a.0, b.1 - a.1);
            let is_top_or_left = dy < 0 || (dy == 0 && dx > 0);
            // Inside where dx (y - a.y) - dy (x - a.x) is above 0, or 0 on a top or left edge.
            let reach = dx * (y - a.1) + dy * a.0 - i64::from(!is_top_or_left);
            match dy {
                ..0 => from = from.max(first_from(-reach.div_euclid(-dy))),
                0 if reach < 0 => return 0..0,
                0 => {}
                1.. => to = to.min(first_from(reach.div_euclid(dy) + 1)),
            }
        }
        from..to
    }
}

/// Some rows of the picture.
pub(super) struct Band<'a> {
    pixels: &'a mut [u32],
    width: usize,
    top: i64,
}

impl<'a> Band<'a> {
    /// Rows of `width` pixels, the first of which is row `top` of the picture.
    pub(super) fn new(pixels: &'a mut [u32], width: usize, top: usize) -> Self {
        let top = top as i64;
        Self { pixels, width, top }
    }

    /// How many rows there are.
    pub(super) fn rows(&self) -> usize {
        self.pixels.len() / self.width
    }

    /// Takes off all that was drawn.
    pub(super) fn clear(&mut self, ground: u32) {
        self.pixels.fill(ground);
    }

    fn rows_of(&self, rows: Range<i64>) -> Range<i64> {
        rows.start.max(self.top)..rows.end.min(self.top + self.rows() as i64)
    }

    /// The pixels of `row`, which is one of the band, in `columns`, which are not empty.
    fn span(&mut self, row: i64, columns: &Range<i64>) -> &mut [u32] {
        let begin = (row - self.top) as usize * self.width;
        &mut self.pixels[begin + columns.start as usize..begin + columns.end as usize]
    }

    /// A rectangle between its first and last corner.
    pub(super) fn rectangle(&mut self, batch: &Batch<'_>, first: &Vertex, last: &Vertex) {
        let ((left, top), (right, bottom)) = (batch.corner(first.pos), batch.corner(last.pos));
        let columns =
            first_from(left).max(batch.columns.start)..first_from(right).min(batch.columns.end);
        let rows = first_from(top).max(batch.rows.start)..first_from(bottom).min(batch.rows.end);
        let rows = self.rows_of(rows);
        if columns.is_empty() || rows.is_empty() {
            return;
        }
        let color = pixel(first.color);
        if first.uv == last.uv {
            let texel = texel_at(batch.texture, first.uv);
            return self.plain(rows, |_| columns.clone(), product(texel, color));
        }
        let along = |from: i64, to: i64, values: (f32, f32), texels: f64| {
            let step = f64::from(values.1 - values.0) * texels * PARTS as f64 / (to - from) as f64;
            let origin = (middle(0) - from) as f64 / PARTS as f64;
            (f64::from(values.0) * texels + step * origin, step)
        };
        let (width, height) = batch.texture.size();
        let (u, across) = along(left, right, (first.uv.x, last.uv.x), width);
        let (v, down) = along(top, bottom, (first.uv.y, last.uv.y), height);
        let u = Slope {
            origin: u,
            across,
            down: 0.0,
        };
        let v = Slope {
            origin: v,
            across: 0.0,
            down,
        };
        self.textured(rows, |_| columns.clone(), batch.texture, (u, v), color);
    }

    /// A triangle, its corners in any order.
    pub(super) fn triangle(&mut self, batch: &Batch<'_>, corners: [&Vertex; 3]) {
        let Some((place, corners)) = in_order(batch, corners) else {
            return;
        };
        let heights = place.at.map(|(_, y)| y);
        let top = heights.into_iter().min().unwrap_or_default();
        let bottom = heights.into_iter().max().unwrap_or_default();
        let rows =
            first_from(top).max(batch.rows.start)..first_from(bottom + 1).min(batch.rows.end);
        let rows = self.rows_of(rows);
        let columns = |row: i64| {
            let span = place.span(row);
            span.start.max(batch.columns.start)..span.end.min(batch.columns.end)
        };
        let [a, b, c] = corners;
        let is_one_color = a.color == b.color && a.color == c.color;
        let is_one_texel = a.uv == b.uv && a.uv == c.uv;
        let (width, height) = batch.texture.size();
        let u = || place.slope(corners.map(|corner| f64::from(corner.uv.x) * width));
        let v = || place.slope(corners.map(|corner| f64::from(corner.uv.y) * height));
        match (is_one_color, is_one_texel) {
            (true, true) => {
                let texel = texel_at(batch.texture, a.uv);
                self.plain(rows, columns, product(texel, pixel(a.color)));
            }
            (true, false) => {
                self.textured(rows, columns, batch.texture, (u(), v()), pixel(a.color));
            }
            (false, _) => {
                let channels = slopes(&place, corners.map(|corner| corner.color));
                let texel = texel_at(batch.texture, a.uv);
                let texels = (!is_one_texel).then(|| (u(), v()));
                self.shaded(rows, columns, channels, batch.texture, texels, texel);
            }
        }
    }

    /// Pixels that are all alike.
    fn plain(&mut self, rows: Range<i64>, columns: impl Fn(i64) -> Range<i64>, color: u32) {
        if color == 0 {
            return;
        }
        for row in rows {
            let columns = columns(row);
            if columns.is_empty() {
                continue;
            }
            let span = self.span(row, &columns);
            if color >= 0xff00_0000 {
                span.fill(color);
            } else {
                for below in span {
                    *below = over(*below, color);
                }
            }
        }
    }

    /// Pixels of one colour that show places of a texture.
    fn textured(
        &mut self,
        rows: Range<i64>,
        columns: impl Fn(i64) -> Range<i64>,
        texture: &Texture,
        (u, v): (Slope, Slope),
        color: u32,
    ) {
        let filter = texture.filter(texels_a_pixel(&u, &v));
        let is_level = fixed(v.across) == 0;
        for row in rows {
            let columns = columns(row);
            if columns.is_empty() {
                continue;
            }
            let span = self.span(row, &columns);
            let mut at = (
                fixed(u.at(columns.start, row)),
                fixed(v.at(columns.start, row)),
            );
            let step = (fixed(u.across), fixed(v.across));
            let level = is_level.then(|| texture.row(at.1));
            match (level, filter) {
                (Some(texels), TextureFilter::Linear) => {
                    if let Some(texels) = texels.exact(at.0, step.0, span.len()) {
                        let mut texels = texels.iter();
                        lay(span, color, || texels.next().copied().unwrap_or_default());
                    } else if texels.is_inside(
                        at.0,
                        at.0.saturating_add(step.0.saturating_mul(span.len() as i64 - 1)),
                    ) {
                        lay(span, color, || {
                            texels.linear_inside(next(&mut at.0, step.0))
                        });
                    } else {
                        lay(span, color, || texels.linear(next(&mut at.0, step.0)));
                    }
                }
                (Some(texels), TextureFilter::Nearest) => {
                    lay(span, color, || texels.nearest(next(&mut at.0, step.0)));
                }
                (None, TextureFilter::Linear) => lay(span, color, || {
                    texture.linear(next(&mut at.0, step.0), next(&mut at.1, step.1))
                }),
                (None, TextureFilter::Nearest) => lay(span, color, || {
                    texture.nearest(next(&mut at.0, step.0), next(&mut at.1, step.1))
                }),
            }
        }
    }

    /// Pixels whose colour changes, which show `texel`, or places of the texture.
    fn shaded(
        &mut self,
        rows: Range<i64>,
        columns: impl Fn(i64) -> Range<i64>,
        channels: [Slope; 4],
        texture: &Texture,
        texels: Option<(Slope, Slope)>,
        texel: u32,
    ) {
        let filter = texels.map(|(u, v)| texture.filter(texels_a_pixel(&u, &v)));
        let steps = channels.map(|channel| channel.across as f32);
        for row in rows {
            let columns = columns(row);
            if columns.is_empty() {
                continue;
            }
            let mut values = channels.map(|channel| channel.at(columns.start, row) as f32 + 0.5);
            for (column, below) in (columns.start..).zip(self.span(row, &columns)) {
                // Numbers outside of a byte become its ends.
                let [alpha, red, green, blue] = values.map(|value| value as u8);
                let color = u32::from_be_bytes([alpha, red, green, blue]);
                let texel = texels.zip(filter).map_or(texel, |((u, v), filter)| {
                    let (u, v) = (fixed(u.at(column, row)), fixed(v.at(column, row)));
                    match filter {
                        TextureFilter::Linear => texture.linear(u, v),
                        TextureFilter::Nearest => texture.nearest(u, v),
                    }
                });
                *below = over(*below, product(texel, color));
                for (value, step) in values.iter_mut().zip(steps) {
                    *value += step;
                }
            }
        }
    }
}

/// Lays texels of one colour over pixels.
#[inline(always)]
fn lay(span: &mut [u32], color: u32, mut texel: impl FnMut() -> u32) {
    if color == WHITE {
        for below in span {
            *below = over(*below, texel());
        }
    } else {
        for below in span {
            *below = over(*below, product(texel(), color));
        }
    }
}

/// The value, which then grows by `step`.
#[inline(always)]
fn next(value: &mut i64, step: i64) -> i64 {
    let now = *value;
    *value = now.wrapping_add(step);
    now
}

/// A number of texels as textures take it; broken ones are some number.
fn fixed(texels: f64) -> i64 {
    (texels * TEXEL as f64) as i64
}

/// The corners in the order of the clock; `None` when they enclose nothing.
fn in_order<'a>(batch: &Batch<'_>, corners: [&'a Vertex; 3]) -> Option<(Corners, [&'a Vertex; 3])> {
    let [a, b, c] = corners;
    let at = corners.map(|corner| batch.corner(corner.pos));
    let area =
        (at[1].0 - at[0].0) * (at[2].1 - at[0].1) - (at[1].1 - at[0].1) * (at[2].0 - at[0].0);
    let (at, corners) = match area {
        0 => return None,
        1.. => (at, corners),
        ..0 => ([at[0], at[2], at[1]], [a, c, b]),
    };
    let area = area.abs() as f64;
    Some((Corners { at, area }, corners))
}

/// Alpha, red, green and blue.
fn slopes(place: &Corners, colors: [Color32; 3]) -> [Slope; 4] {
    let channels = colors.map(|color| {
        let [red, green, blue, alpha] = color.to_array();
        [alpha, red, green, blue].map(f64::from)
    });
    std::array::from_fn(|i| place.slope(channels.map(|color| color[i])))
}

/// The texel that all corners show.
fn texel_at(texture: &Texture, uv: Pos2) -> u32 {
    let (width, height) = texture.size();
    let (u, v) = (f64::from(uv.x) * width, f64::from(uv.y) * height);
    match texture.filter(0.0) {
        TextureFilter::Linear => texture.linear(fixed(u), fixed(v)),
        TextureFilter::Nearest => texture.nearest(fixed(u), fixed(v)),
    }
}

/// How many texels a step to the next pixel is, along the side where they are more.
fn texels_a_pixel(u: &Slope, v: &Slope) -> f64 {
    let across = u.across * u.across + v.across * v.across;
    let down = u.down * u.down + v.down * v.down;
    across.max(down).sqrt()
}
