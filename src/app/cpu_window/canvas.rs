//! A picture of what egui wants shown, drawn by the processor.
//!
//! It is what `egui_wgpu` draws: triangles with premultiplied colours, blended in gamma space, their
//! corners snapped to 1/256 of a pixel, pixels on a common edge drawn once (the rule of the top and left
//! edge). The picture is cut into bands; those in which nothing changed since the last time are kept.

use super::fill::{Band, Batch};
use super::pixel::pixel;
use super::textures::Textures;
use egui::epaint::{Primitive, Vertex};
use egui::{ClippedPrimitive, Mesh, Rect, TextureId};
use rayon::prelude::*;
use std::ops::Range;

/// Rows of a band: few enough that a stroke or a spinner changes little, enough that a shape is not
/// taken up too often.
const BAND: usize = 24;

/// The picture, `0xffRRGGBB` a pixel, rows from the top.
pub struct Canvas {
    /// Threads of its own: those of the jobs may be busy for seconds. None where there are none to be had.
    threads: Option<rayon::ThreadPool>,
    size: (u32, u32),
    pixels: Vec<u32>,
    /// What the bands were drawn from.
    drawn: Vec<u64>,
}

/// A shape of a batch: two triangles that make a rectangle along the axes, or one triangle.
#[derive(Clone, Copy)]
pub(super) struct Shape {
    batch: u32,
    first: u32,
    is_rect: bool,
}

impl Default for Canvas {
    /// A picture without pixels.
    fn default() -> Self {
        Self {
            threads: rayon::ThreadPoolBuilder::new().build().ok(),
            size: (0, 0),
            pixels: Vec::new(),
            drawn: Vec::new(),
        }
    }
}

impl Canvas {
    /// Width and height, pixels.
    pub fn size(&self) -> (u32, u32) {
        self.size
    }

    /// The pixels, row by row.
    pub fn pixels(&self) -> &[u32] {
        &self.pixels
    }

    /// Draws `primitives` onto `ground`, `size` pixels, and returns how many rows were drawn anew.
    /// Callbacks cannot be drawn; meshes without a texture are left out.
    pub fn draw(
        &mut self,
        size: (u32, u32),
        pixels_per_point: f32,
        primitives: &[ClippedPrimitive],
        textures: &Textures,
        ground: u32,
    ) -> usize {
        let (width, height) = (size.0 as usize, size.1 as usize);
        if width == 0 || height == 0 {
            return 0;
        }
        let bands = height.div_ceil(BAND);
        if self.size != size {
            self.size = size;
            self.pixels = vec![0; width * height];
            self.drawn = vec![0; bands];
        }
        let batches = batches(size, pixels_per_point, primitives, textures);
        let shapes = shapes(&batches, bands);
        let bands = self
            .pixels
            .chunks_mut(width * BAND)
            .zip(&mut self.drawn)
            .zip(shapes)
            .enumerate();
        let mut changed = Vec::new();
        for (number, ((pixels, drawn), shapes)) in bands {
            let content = content(&batches, &shapes, ground);
            if std::mem::replace(drawn, content) != content {
                changed.push((Band::new(pixels, width, number * BAND), shapes));
            }
        }
        let rows = changed.iter().map(|(band, _)| band.rows()).sum();
        let draw = |(band, shapes): &mut (Band<'_>, Vec<Shape>)| {
            draw_band(band, &batches, shapes, ground);
        };
        match &self.threads {
            Some(threads) => threads.install(|| changed.par_iter_mut().for_each(draw)),
            None => changed.iter_mut().for_each(draw),
        }
        rows
    }
}

fn draw_band(band: &mut Band<'_>, batches: &[Batch<'_>], shapes: &[Shape], ground: u32) {
    band.clear(ground);
    for shape in shapes {
        let batch = &batches[shape.batch as usize];
        let corner = |at| &batch.mesh.vertices[batch.mesh.indices[at] as usize];
        let first = shape.first as usize;
        match shape.is_rect {
            true => band.rectangle(batch, corner(first), corner(first + 5)),
            false => band.triangle(batch, [first, first + 1, first + 2].map(corner)),
        }
    }
}

/// The meshes that can be seen.
fn batches<'a>(
    size: (u32, u32),
    pixels_per_point: f32,
    primitives: &'a [ClippedPrimitive],
    textures: &'a Textures,
) -> Vec<Batch<'a>> {
    let batch = |clipped: &'a ClippedPrimitive| {
        let Primitive::Mesh(mesh) = &clipped.primitive else {
            return None;
        };
        let (columns, rows) = clip(clipped.clip_rect, pixels_per_point, size);
        if columns.is_empty() || rows.is_empty() || !mesh.is_valid() {
            return None;
        }
        Some(Batch {
            mesh,
            texture: textures.get(mesh.texture_id)?,
            columns,
            rows,
            pixels_per_point: f64::from(pixels_per_point),
        })
    };
    primitives.iter().filter_map(batch).collect()
}

/// The columns and rows of pixels inside `clip`, as `egui_wgpu` rounds them.
fn clip(clip: Rect, pixels_per_point: f32, size: (u32, u32)) -> (Range<i64>, Range<i64>) {
    let pixel = |points: f32, most: u32| {
        let pixel = (f64::from(points) * f64::from(pixels_per_point)).round();
        pixel.clamp(0.0, f64::from(most)) as i64
    };
    let columns = pixel(clip.min.x, size.0)..pixel(clip.max.x, size.0);
    let rows = pixel(clip.min.y, size.1)..pixel(clip.max.y, size.1);
    (columns, rows)
}

/// The shapes of each band, in the order that they are drawn in.
fn shapes(batches: &[Batch<'_>], bands: usize) -> Vec<Vec<Shape>> {
    let mut of_bands = vec![Vec::new(); bands];
    for (number, batch) in batches.iter().enumerate() {
        let mesh = batch.mesh;
        let mut first = 0;
        while first + 3 <= mesh.indices.len() {
            let is_rect = is_rectangle(mesh, first);
            let count = if is_rect { 6 } else { 3 };
            let corners = mesh.indices[first..first + count].iter();
            let heights = corners.map(|&at| mesh.vertices[at as usize].pos.y);
            let (top, bottom) = heights.fold((f32::MAX, f32::MIN), |(top, bottom), y| {
                (top.min(y), bottom.max(y))
            });
            let rows = batch.rows_between(top, bottom);
            if !rows.is_empty() {
                let shape = Shape {
                    batch: number as u32,
                    first: first as u32,
                    is_rect,
                };
                let (from, to) = (rows.start as usize / BAND, (rows.end - 1) as usize / BAND);
                for band in &mut of_bands[from..=to] {
                    band.push(shape);
                }
            }
            first += count;
        }
    }
    of_bands
}

/// Whether the two triangles at `first` are a rectangle along the axes, of one colour, that shows a
/// rectangle of the texture: text and pictures are.
fn is_rectangle(mesh: &Mesh, first: usize) -> bool {
    let Some(&[a, b, c, d, e, f]) = mesh.indices.get(first..first + 6) else {
        return false;
    };
    if (c, b) != (d, e) {
        return false;
    }
    let [lt, rt, lb, rb] = [a, b, c, f].map(|at| mesh.vertices[at as usize]);
    let is_one_color = lt.color == rt.color && lt.color == lb.color && lt.color == rb.color;
    let is_upright = |at: fn(&Vertex) -> egui::Pos2| {
        let (lt, rt, lb, rb) = (at(&lt), at(&rt), at(&lb), at(&rb));
        lt.x == lb.x && rt.x == rb.x && lt.y == rt.y && lb.y == rb.y
    };
    let is_ordered = lt.pos.x <= rb.pos.x && lt.pos.y <= rb.pos.y;
    is_one_color && is_ordered && is_upright(|v| v.pos) && is_upright(|v| v.uv)
}

/// Tells contents of a band apart.
fn content(batches: &[Batch<'_>], shapes: &[Shape], ground: u32) -> u64 {
    let mut mixed = Mixed(u64::from(ground));
    let mut last = None;
    for shape in shapes {
        let batch = &batches[shape.batch as usize];
        if last != Some(shape.batch) {
            last = Some(shape.batch);
            for side in [&batch.columns, &batch.rows] {
                mixed.add(side.start as u64);
                mixed.add(side.end as u64);
            }
            let (kind, number) = match batch.mesh.texture_id {
                TextureId::Managed(number) => (0, number),
                TextureId::User(number) => (1, number),
            };
            mixed.add(kind);
            mixed.add(number);
            mixed.add(batch.texture.version);
            mixed.add(batch.pixels_per_point.to_bits());
        }
        let count = if shape.is_rect { 6 } else { 3 };
        let first = shape.first as usize;
        for &at in &batch.mesh.indices[first..first + count] {
            let Vertex { pos, uv, color } = batch.mesh.vertices[at as usize];
            mixed.add(u64::from(pos.x.to_bits()) << 32 | u64::from(pos.y.to_bits()));
            mixed.add(u64::from(uv.x.to_bits()) << 32 | u64::from(uv.y.to_bits()));
            mixed.add(u64::from(pixel(color)));
        }
    }
    mixed.0
}

/// A number of many: another one for certain when one of them changes, and as good as for certain when
/// more do. (The standard library's takes longer than the drawing.)
struct Mixed(u64);

impl Mixed {
    #[inline(always)]
    fn add(&mut self, word: u64) {
        // An odd factor, so that no two states become one: the golden section of 2⁶⁴.
        self.0 = (self.0.rotate_left(29) ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::epaint::{ImageDelta, textures::TexturesDelta};
    use egui::{Color32, ColorImage, Pos2, TextureOptions, pos2};

    const GROUND: u32 = 0xff00_0000;
    const HALF_WHITE: Color32 = Color32::from_rgba_premultiplied(128, 128, 128, 128);

    fn with_texture(image: ColorImage, options: TextureOptions) -> Textures {
        let mut textures = Textures::default();
        let mut delta = TexturesDelta::default();
        delta.push(TextureId::default(), ImageDelta::full(image, options));
        textures.set(&mut delta);
        textures
    }

    fn white() -> Textures {
        with_texture(
            ColorImage::filled([1, 1], Color32::WHITE),
            TextureOptions::LINEAR,
        )
    }

    /// Triangles of one colour over all of the picture.
    fn clipped(corners: &[Pos2], color: Color32) -> ClippedPrimitive {
        let mut mesh = Mesh::default();
        for (number, corner) in corners.iter().enumerate() {
            mesh.colored_vertex(*corner, color);
            mesh.indices.push(number as u32);
        }
        ClippedPrimitive {
            clip_rect: Rect::EVERYTHING,
            primitive: Primitive::Mesh(mesh),
        }
    }

    fn drawn(size: (u32, u32), primitives: &[ClippedPrimitive], textures: &Textures) -> Vec<u32> {
        let mut canvas = Canvas::default();
        canvas.draw(size, 1.0, primitives, textures, GROUND);
        canvas.pixels
    }

    #[test]
    fn triangles_around_a_corner_cover_each_pixel_once() {
        let mut random = crate::base::Seed(3).random();
        for round in 0..200 {
            let mut at = || {
                pos2(
                    random.between(0.0, 40.0) as f32,
                    random.between(0.0, 30.0) as f32,
                )
            };
            let (middle, mut corners) = (at(), Vec::new());
            let around = [
                pos2(0.0, 0.0),
                pos2(40.0, 0.0),
                pos2(40.0, 30.0),
                pos2(0.0, 30.0),
            ];
            for side in 0..4 {
                let (a, b) = (around[side], around[(side + 1) % 4]);
                // Either order of the clock.
                let ends = if round % 2 == 0 { [a, b] } else { [b, a] };
                corners.extend([middle, ends[0], ends[1]]);
            }
            let pixels = drawn((40, 30), &[clipped(&corners, HALF_WHITE)], &white());
            assert!(
                pixels.iter().all(|pixel| *pixel == 0xff80_8080),
                "{middle:?}"
            );
        }
    }

    #[test]
    fn rectangles_and_their_triangles_are_the_same_pixels() {
        let mut random = crate::base::Seed(4).random();
        let image = ColorImage::from_rgba_unmultiplied(
            [4, 4],
            &(0..64).map(|byte| byte * 4).collect::<Vec<u8>>(),
        );
        for options in [TextureOptions::LINEAR, TextureOptions::NEAREST] {
            let textures = with_texture(image.clone(), options);
            for _ in 0..100 {
                let mut at = || {
                    pos2(
                        random.between(-4.0, 24.0) as f32,
                        random.between(-4.0, 24.0) as f32,
                    )
                };
                let (rect, uv) = (
                    Rect::from_two_pos(at(), at()),
                    Rect::from_two_pos(at(), at()),
                );
                let uv = Rect::from_min_max(uv.min * 0.04, uv.max * 0.04);
                let mut mesh = Mesh::default();
                mesh.add_rect_with_uv(rect, uv, Color32::from_rgb(255, 200, 255));
                assert!(is_rectangle(&mesh, 0));
                let whole = ClippedPrimitive {
                    clip_rect: Rect::EVERYTHING,
                    primitive: Primitive::Mesh(mesh.clone()),
                };
                // In another order they are two triangles.
                mesh.indices = vec![0, 1, 2, 3, 2, 1];
                assert!(!is_rectangle(&mesh, 0));
                let halves = ClippedPrimitive {
                    clip_rect: Rect::EVERYTHING,
                    primitive: Primitive::Mesh(mesh),
                };
                let whole = drawn((20, 20), &[whole], &textures);
                let halves = drawn((20, 20), &[halves], &textures);
                let apart = whole.iter().zip(&halves).filter(|(one, other)| {
                    let (one, other) = (one.to_be_bytes(), other.to_be_bytes());
                    one.iter().zip(other).any(|(a, b)| a.abs_diff(b) > 1)
                });
                // Sums in another order may fall on the other side of a texel's edge.
                assert!(apart.count() <= 2, "{rect:?} {uv:?}");
            }
        }
    }

    #[test]
    fn nothing_is_drawn_outside_of_the_clip_rectangle() {
        let corners = [
            pos2(-100.0, -100.0),
            pos2(500.0, -100.0),
            pos2(-100.0, 500.0),
        ];
        let mut primitive = clipped(&corners, Color32::RED);
        primitive.clip_rect = Rect::from_min_max(pos2(2.4, 3.6), pos2(5.5, 6.0));
        let pixels = drawn((8, 8), &[primitive], &white());
        for (at, pixel) in pixels.iter().enumerate() {
            let is_inside = (2..6).contains(&(at % 8)) && (4..6).contains(&(at / 8));
            assert_eq!(*pixel == 0xffff_0000, is_inside, "{at}");
        }
    }

    #[test]
    fn a_picture_shows_its_texels_one_by_one() {
        let image = ColorImage::example();
        let [width, height] = image.size;
        let expected: Vec<u32> = image.pixels.iter().map(|color| pixel(*color)).collect();
        let textures = with_texture(image, TextureOptions::LINEAR);
        let mut mesh = Mesh::default();
        let size = egui::vec2(width as f32, height as f32);
        let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        mesh.add_rect_with_uv(Rect::from_min_size(Pos2::ZERO, size), uv, Color32::WHITE);
        let primitive = ClippedPrimitive {
            clip_rect: Rect::EVERYTHING,
            primitive: Primitive::Mesh(mesh),
        };
        let pixels = drawn((width as u32, height as u32), &[primitive], &textures);
        let is_opaque = |pixel: &u32| *pixel >= 0xff00_0000;
        for (pixel, texel) in pixels
            .iter()
            .zip(&expected)
            .filter(|(_, texel)| is_opaque(texel))
        {
            assert_eq!(pixel, texel);
        }
    }

    #[test]
    fn only_bands_that_change_are_drawn_again() {
        let corners = |y: f32| [pos2(0.0, y), pos2(9.0, y), pos2(0.0, y + 4.0)];
        let scene = |color| {
            [
                clipped(&corners(2.0), Color32::RED),
                clipped(&corners(60.0), color),
            ]
        };
        let mut textures = white();
        let mut canvas = Canvas::default();
        let mut draw = |scene: &[ClippedPrimitive], textures: &Textures| {
            let rows = canvas.draw((10, 80), 1.0, scene, textures, GROUND);
            (rows, canvas.pixels.clone())
        };
        assert_eq!(draw(&scene(Color32::RED), &textures).0, 80);
        assert_eq!(draw(&scene(Color32::RED), &textures).0, 0);
        let (rows, pixels) = draw(&scene(Color32::BLUE), &textures);
        assert_eq!(rows, BAND);
        assert_eq!(pixels, drawn((10, 80), &scene(Color32::BLUE), &textures));
        // A part of a texture changes.
        let mut delta = TexturesDelta::default();
        let patch = ColorImage::filled([1, 1], Color32::GREEN);
        let patch = ImageDelta::partial([0, 0], patch, TextureOptions::LINEAR);
        delta.push(TextureId::default(), patch);
        textures.set(&mut delta);
        let (rows, pixels) = draw(&scene(Color32::WHITE), &textures);
        assert!(rows > 0);
        assert_eq!(pixels[61 * 10], 0xff00_ff00);
        // One that does not fit is left out; one that is freed is not shown.
        let mut delta = TexturesDelta::default();
        let patch = ColorImage::filled([2, 1], Color32::RED);
        let patch = ImageDelta::partial([0, 0], patch, TextureOptions::LINEAR);
        delta.push(TextureId::default(), patch);
        delta.free(TextureId::default());
        textures.set(&mut delta);
        textures.free(&mut delta);
        let (_, pixels) = draw(&scene(Color32::WHITE), &textures);
        assert!(pixels.iter().all(|pixel| *pixel == GROUND));
    }

    #[test]
    fn broken_meshes_and_places_are_no_panic() {
        let wild = [
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::MAX,
            1e9,
            -1e9,
            0.0,
        ];
        let mut scene = Vec::new();
        for (number, x) in wild.into_iter().enumerate() {
            let y = wild[(number * 3 + 1) % wild.len()];
            let corners = [
                pos2(x, y),
                pos2(y, x),
                pos2(5.0, x),
                pos2(x, 5.0),
                pos2(y, 5.0),
                pos2(3.0, 3.0),
            ];
            let mut one = clipped(&corners, HALF_WHITE);
            if let Primitive::Mesh(mesh) = &mut one.primitive {
                mesh.vertices[number % 6].uv = pos2(x, y);
                mesh.indices.push(0);
            }
            scene.push(one);
        }
        let mut outside = clipped(&[Pos2::ZERO; 3], HALF_WHITE);
        if let Primitive::Mesh(mesh) = &mut outside.primitive {
            mesh.indices[1] = 77;
        }
        scene.push(outside);
        assert_eq!(drawn((10, 10), &scene, &white()).len(), 100);
        assert!(drawn((0, 10), &scene, &white()).is_empty());
    }
}
