//! Octahedral impostors: a tree from many sides in one atlas, from which a single quad shows it from
//! any side.
//!
//! Source: R. Brucks, *Octahedral Impostors* (2018). The directions of a sphere, or of its upper
//! half, are spread over a square by an octahedron; a grid over that square gives the directions of
//! the frames, of which a shader mixes the three around the direction of the eye.
//!
//! Conventions. Frames stand row by row from the top left; frame (i, j) of n × n is at
//! x = 2i/(n−1) − 1, y = 2j/(n−1) − 1. Hemisphere: c = (x + y, x − y)/2, direction
//! (c.x, 1 − |c.x| − |c.y|, c.y), normalised. Full: (x, 1 − |x| − |y|, y) and, where its y is below
//! 0, x and z folded over to ((1 − |z|)·sign x, (1 − |x|)·sign z). A frame is an orthographic view
//! along −direction; its right is +Y × direction (+X where the direction is vertical), its up is
//! direction × right. Albedo: colour and alpha, without light. Normals: in the tree's frame, n/2 +
//! 1/2; their alpha is 1 − depth.
//!
//! The frames are drawn from the finest level of a [`CrownModel`] by a plain rasteriser, not by the
//! renderers: these draw leaves that turn towards the eye, and an impostor must show what the model
//! that it stands in for shows.
//!
//! Limit: texels are covered by quarters.

use super::bleed::{bled, bled_from};
use super::crown_model::{CrownModel, ModelMaterial};
use super::mips::{ALPHA_CUTOFF, mips};
use super::model_mesh::ModelMesh;
use super::record::ImpostorRecord;
use crate::base::{Cancel, Cancelled};
use crate::raster::{Image, Straight};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Samples along a side of a texel.
const FINENESS: u32 = 2;

/// Empty texels around a tree in its frame: room for filters and for three smaller copies.
const MARGIN_PX: u32 = 4;

/// From which directions there are frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImpostorForm {
    /// From all around.
    Full,
    /// From the horizon and above: twice the frames for what stands on the ground.
    Hemisphere,
}

impl ImpostorForm {
    /// `full` or `hemisphere`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Full => "full",
            Self::Hemisphere => "hemisphere",
        }
    }
}

/// How an impostor is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImpostorSettings {
    /// From which directions.
    pub form: ImpostorForm,
    /// Frames along a side, at least 2.
    pub frames: u32,
    /// Side of a frame in pixels, at least 16.
    pub frame_px: u32,
}

/// An impostor.
#[derive(Debug, Clone, PartialEq)]
pub struct Impostor {
    /// Colour and alpha; colour bled under clear texels.
    pub albedo: Image<Straight>,
    /// Normal, and 1 − depth in alpha; continued where nothing shows.
    pub normal_depth: Image<Straight>,
    /// What the middle of every frame shows, metres.
    pub center_m: DVec3,
    /// Half the side of a frame, metres.
    pub half_m: f64,
    /// What depth is measured in: 0 is this far before the centre, 1 as far behind it, metres.
    pub depth_m: f64,
}

/// The direction towards the eye of frame (`i`, `j`) of `frames` × `frames`.
///
/// ```
/// use boscage::export::{ImpostorForm, frame_direction};
/// use glam::DVec3;
/// let corner = frame_direction(ImpostorForm::Hemisphere, 8, 0, 0);
/// assert!(corner.distance(-DVec3::X) < 1e-12, "corners are on the horizon");
/// let middle = frame_direction(ImpostorForm::Full, 9, 4, 4);
/// assert_eq!(middle, DVec3::Y);
/// ```
pub fn frame_direction(form: ImpostorForm, frames: u32, i: u32, j: u32) -> DVec3 {
    let [x, y] = [i, j].map(|at| 2.0 * f64::from(at) / f64::from(frames - 1) - 1.0);
    let direction = match form {
        ImpostorForm::Hemisphere => {
            let (x, z) = ((x + y) / 2.0, (x - y) / 2.0);
            DVec3::new(x, (1.0 - x.abs() - z.abs()).max(0.0), z)
        }
        ImpostorForm::Full => {
            let up = 1.0 - x.abs() - y.abs();
            if up >= 0.0 {
                DVec3::new(x, up, y)
            } else {
                let sign = |v: f64| if v < 0.0 { -1.0 } else { 1.0 };
                DVec3::new((1.0 - y.abs()) * sign(x), up, (1.0 - x.abs()) * sign(y))
            }
        }
    };
    direction.normalize()
}

/// Right and up of the frame that is seen from `direction`.
fn frame_axes(direction: DVec3) -> [DVec3; 2] {
    let right = DVec3::Y.cross(direction);
    let right = if right.length() < 1e-6 {
        DVec3::X
    } else {
        right.normalize()
    };
    [right, direction.cross(right)]
}

/// Picture with its smaller copies, and whether it is drawn without an alpha test.
struct Skin {
    levels: Vec<Image<Straight>>,
    is_solid: bool,
}

/// The impostor of `model`; `frame_done` is called after each frame.
///
/// # Errors
/// [`Cancelled`].
pub fn impostor(
    model: &CrownModel,
    settings: &ImpostorSettings,
    frame_done: impl Fn() + Sync,
    cancel: &Cancel,
) -> Result<Impostor, Cancelled> {
    let skins = skins(model, cancel)?;
    let (center_m, depth_m, half_m) = framing(model, settings);
    let scale = f64::from(FINENESS * settings.frame_px) / (2.0 * half_m);
    let frames: Vec<Texels> = (0..settings.frames * settings.frames)
        .into_par_iter()
        .map(|index| {
            let (i, j) = (index % settings.frames, index / settings.frames);
            let toward = frame_direction(settings.form, settings.frames, i, j);
            let view = View::new(toward, center_m, scale);
            let frame = Frame::of(model, &skins, &view, settings.frame_px, cancel)?;
            frame_done();
            // Samples are large: they go before the next frame is drawn.
            Ok(frame.texels(settings.frame_px, depth_m * scale))
        })
        .collect::<Result<_, Cancelled>>()?;
    let (albedo, normal_depth) = assembled(&frames, settings);
    Ok(Impostor {
        albedo,
        normal_depth,
        center_m,
        half_m,
        depth_m,
    })
}

/// `model` as seen from the front, without light: a square of `side_px` pixels, at least 16, with
/// alpha.
///
/// # Errors
/// [`Cancelled`].
pub fn portrait(
    model: &CrownModel,
    side_px: u32,
    cancel: &Cancel,
) -> Result<Image<Straight>, Cancelled> {
    let settings = ImpostorSettings {
        form: ImpostorForm::Full,
        frames: 1,
        frame_px: side_px,
    };
    let (center_m, depth_m, half_m) = framing(model, &settings);
    let scale = f64::from(FINENESS * side_px) / (2.0 * half_m);
    let view = View::new(DVec3::Z, center_m, scale);
    let skins = skins(model, cancel)?;
    let frame = Frame::of(model, &skins, &view, side_px, cancel)?;
    let texels = frame.texels(side_px, depth_m * scale);
    Ok(assembled(&[texels], &settings).0)
}

/// The materials of `model` with their smaller copies.
fn skins(model: &CrownModel, cancel: &Cancel) -> Result<Vec<Skin>, Cancelled> {
    let skin = |material: &ModelMaterial| {
        Ok(Skin {
            levels: mips(&material.picture, &[], cancel)?,
            is_solid: material.is_solid,
        })
    };
    model.materials.iter().map(skin).collect()
}

/// The middle of all frames, the radius of a ball around it that holds the tree, and half the side
/// of a frame; metres.
fn framing(model: &CrownModel, settings: &ImpostorSettings) -> (DVec3, f64, f64) {
    let [low, high] = model.bounds_m();
    let center_m = (low + high) / 2.0;
    let positions = model.levels[0].iter().flat_map(|(_, mesh)| &mesh.positions);
    let depth_m = positions
        .map(|&at| (place(at) - center_m).length())
        .fold(1e-6, f64::max);
    let frame_px = f64::from(settings.frame_px);
    let half_m = depth_m * frame_px / (frame_px - 2.0 * f64::from(MARGIN_PX));
    (center_m, depth_m, half_m)
}

impl ImpostorSettings {
    /// What a shader must know of the impostor of `model`.
    pub fn record(&self, model: &CrownModel) -> ImpostorRecord {
        let (center_m, depth_m, half_m) = framing(model, self);
        ImpostorRecord {
            form: self.form.name().to_owned(),
            frames: self.frames,
            frame_px: self.frame_px,
            center_m: center_m.to_array(),
            half_m,
            depth_m,
        }
    }
}

fn place([x, y, z]: [f32; 3]) -> DVec3 {
    DVec3::new(f64::from(x), f64::from(y), f64::from(z))
}

/// An orthographic view.
struct View {
    /// Right, up, towards the eye.
    axes: [DVec3; 3],
    center: DVec3,
    /// Samples a metre.
    scale: f64,
}

impl View {
    fn new(toward: DVec3, center: DVec3, scale: f64) -> Self {
        let [right, up] = frame_axes(toward);
        Self {
            axes: [right, up, toward],
            center,
            scale,
        }
    }
}

/// What a sample shows.
#[derive(Debug, Clone, Copy)]
struct Sample {
    /// Towards the eye from the centre, in sides of a sample.
    near: f32,
    color: [u8; 3],
    normal: [f32; 3],
}

/// The samples of a frame.
struct Frame {
    size: u32,
    samples: Vec<Sample>,
}

/// Colour with alpha, and normal with depth, of each texel of a frame; `None` where nothing shows.
type Texels = Vec<Option<(Straight, Straight)>>;

/// A corner on the screen: place in samples, nearness.
type Corner = [f64; 3];

impl Frame {
    fn new(size: u32) -> Self {
        let nothing = Sample {
            near: f32::NEG_INFINITY,
            color: [0; 3],
            normal: [0.0; 3],
        };
        Self {
            size,
            samples: vec![nothing; (size * size) as usize],
        }
    }

    /// The finest level of `model`, in a frame of `side_px` texels.
    fn of(
        model: &CrownModel,
        skins: &[Skin],
        view: &View,
        side_px: u32,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let mut frame = Self::new(side_px * FINENESS);
        for (material, mesh) in &model.levels[0] {
            cancel.check()?;
            frame.draw(view, mesh, &skins[*material]);
        }
        Ok(frame)
    }

    fn draw(&mut self, view: &View, mesh: &ModelMesh, skin: &Skin) {
        let half = f64::from(self.size) / 2.0;
        let seen = |at: &[f32; 3]| -> Corner {
            let [x, y, near] = view
                .axes
                .map(|axis| (place(*at) - view.center).dot(axis) * view.scale);
            [half + x, half - y, near]
        };
        let corners: Vec<Corner> = mesh.positions.iter().map(seen).collect();
        for triangle in mesh.indices.as_chunks::<3>().0 {
            self.fill(&corners, mesh, triangle.map(|i| i as usize), skin);
        }
    }

    fn fill(&mut self, corners: &[Corner], mesh: &ModelMesh, [a, b, c]: [usize; 3], skin: &Skin) {
        let flat = [a, b, c].map(|i| DVec2::new(corners[i][0], corners[i][1]));
        // y points down: a positive product is clockwise, which is a back.
        let area = (flat[1] - flat[0]).perp_dot(flat[2] - flat[0]);
        if area >= 0.0 {
            return;
        }
        let picture = skin.level([a, b, c].map(|i| mesh.uvs[i]), area);
        let range = |pick: fn(&DVec2) -> f64| {
            let low = flat.iter().map(pick).fold(f64::MAX, f64::min);
            let high = flat.iter().map(pick).fold(f64::MIN, f64::max);
            let last = f64::from(self.size);
            (low.clamp(0.0, last) as u32)..((high + 1.0).clamp(0.0, last) as u32)
        };
        let columns = range(|p| p.x);
        for y in range(|p| p.y) {
            for x in columns.clone() {
                let at = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let part = |p: DVec2, q: DVec2| (q - p).perp_dot(at - p) / area;
                let shares = [
                    part(flat[1], flat[2]),
                    part(flat[2], flat[0]),
                    part(flat[0], flat[1]),
                ];
                if shares.iter().any(|&share| share < 0.0) {
                    continue;
                }
                let near = mixed(shares, [a, b, c].map(|i| [corners[i][2]]))[0] as f32;
                let sample = &mut self.samples[(y * self.size + x) as usize];
                if near <= sample.near {
                    continue;
                }
                let uv = mixed(shares, [a, b, c].map(|i| mesh.uvs[i].map(f64::from)));
                let Straight([red, green, blue, alpha]) = nearest(picture, uv);
                if !skin.is_solid && alpha < ALPHA_CUTOFF {
                    continue;
                }
                let normal = mixed(shares, [a, b, c].map(|i| mesh.normals[i].map(f64::from)));
                *sample = Sample {
                    near,
                    color: [red, green, blue],
                    normal: normal.map(|v| v as f32),
                };
            }
        }
    }
}

impl Skin {
    /// The copy whose texels are nearest in size to the samples of a triangle of twice the area
    /// `area`, in samples.
    fn level(&self, uvs: [[f32; 2]; 3], area: f64) -> &Image<Straight> {
        let size = DVec2::new(
            f64::from(self.levels[0].width()),
            f64::from(self.levels[0].height()),
        );
        let [a, b, c] = uvs.map(|[u, v]| DVec2::new(f64::from(u), f64::from(v)) * size);
        let texels = (b - a).perp_dot(c - a).abs();
        let level = 0.5 * libm::log2((texels / area.abs()).max(1.0));
        &self.levels[(level.round() as usize).min(self.levels.len() - 1)]
    }
}

fn mixed<const N: usize>(shares: [f64; 3], values: [[f64; N]; 3]) -> [f64; N] {
    std::array::from_fn(|i| {
        shares[0] * values[0][i] + shares[1] * values[1][i] + shares[2] * values[2][i]
    })
}

fn nearest(picture: &Image<Straight>, [u, v]: [f64; 2]) -> Straight {
    let texel = |share: f64, count: u32| {
        let at = share * f64::from(count);
        at.clamp(0.0, f64::from(count - 1)) as u32
    };
    picture.at(texel(u, picture.width()), texel(v, picture.height()))
}

/// The atlases of albedo and of normal and depth.
fn assembled(frames: &[Texels], settings: &ImpostorSettings) -> (Image<Straight>, Image<Straight>) {
    let side = settings.frames * settings.frame_px;
    let mut albedo = Image::filled(side, side, Straight([0; 4]));
    let mut normals = Image::filled(side, side, Straight([128, 128, 128, 0]));
    for (index, frame) in (0u32..).zip(frames) {
        let left = index % settings.frames * settings.frame_px;
        let top = index / settings.frames * settings.frame_px;
        for y in 0..settings.frame_px {
            for x in 0..settings.frame_px {
                if let Some((color, normal)) = frame[(y * settings.frame_px + x) as usize] {
                    albedo.set(left + x, top + y, color);
                    normals.set(left + x, top + y, normal);
                }
            }
        }
    }
    let alpha = albedo.map(|texel| texel.alpha());
    (bled(&albedo), bled_from(&normals, &alpha))
}

impl Frame {
    /// All texels, row by row; the frame has `side_px` along a side.
    fn texels(&self, side_px: u32, depth: f64) -> Texels {
        let texel = |i: u32| self.texel(i % side_px, i / side_px, depth);
        (0..side_px * side_px).map(texel).collect()
    }

    /// Colour with alpha, and normal with depth, of a texel; `None` where nothing shows. `depth` is
    /// in sides of a sample.
    fn texel(&self, x: u32, y: u32, depth: f64) -> Option<(Straight, Straight)> {
        let (mut count, mut color, mut normal, mut near) = (0.0f64, [0.0; 3], DVec3::ZERO, 0.0);
        for row in y * FINENESS..(y + 1) * FINENESS {
            for column in x * FINENESS..(x + 1) * FINENESS {
                let sample = &self.samples[(row * self.size + column) as usize];
                if sample.near == f32::NEG_INFINITY {
                    continue;
                }
                count += 1.0;
                for (sum, channel) in color.iter_mut().zip(sample.color) {
                    *sum += f64::from(channel);
                }
                normal += place(sample.normal).normalize_or_zero();
                near += f64::from(sample.near);
            }
        }
        if count == 0.0 {
            return None;
        }
        let byte = |value: f64| value.round().clamp(0.0, 255.0) as u8;
        let [r, g, b] = color.map(|sum: f64| byte(sum / count));
        let alpha = byte(255.0 * count / f64::from(FINENESS * FINENESS));
        let toward = normal.normalize_or_zero().to_array();
        let [nx, ny, nz] = toward.map(|v| byte(127.5 * (v + 1.0)));
        let nearness = byte(127.5 * (near / count / depth + 1.0));
        Some((Straight([r, g, b, alpha]), Straight([nx, ny, nz, nearness])))
    }
}

/// A sample shader for Godot 4 that shows an impostor on a quad.
pub fn godot_shader() -> &'static str {
    include_str!("impostor/impostor.gdshader")
}

/// A sample module for three.js that shows an impostor on a quad.
pub fn three_module() -> &'static str {
    include_str!("impostor/impostor.js")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of 2 m whose right half is red, in the plane z = 0, facing +Z.
    fn card() -> CrownModel {
        let red = Straight([255, 0, 0, 255]);
        let green = Straight([0, 255, 0, 255]);
        let mesh = ModelMesh {
            positions: vec![
                [-1.0, 0.0, 0.0],
                [1.0, 0.0, 0.0],
                [1.0, 2.0, 0.0],
                [-1.0, 2.0, 0.0],
            ],
            normals: vec![[0.0, 0.0, 1.0]; 4],
            tangents: Vec::new(),
            uvs: vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]],
            wind: vec![[0.0; 3]; 4],
            indices: vec![0, 1, 2, 0, 2, 3],
        };
        CrownModel {
            name: "card".to_owned(),
            materials: vec![ModelMaterial {
                name: "card",
                picture: Image::from_pixels(2, 1, vec![green, red]),
                packed: None,
                is_solid: true,
            }],
            levels: vec![vec![(0, mesh)]],
        }
    }

    #[test]
    fn frames_show_their_side_the_right_way_round() {
        let settings = ImpostorSettings {
            form: ImpostorForm::Hemisphere,
            frames: 2,
            frame_px: 32,
        };
        let made = impostor(&card(), &settings, || (), &Cancel::new()).unwrap();
        assert_eq!(made.center_m, DVec3::Y);
        // Frame (1, 0) is seen from +Z, frame (0, 1) from -Z: there is only its back.
        assert!(frame_direction(settings.form, 2, 1, 0).distance(DVec3::Z) < 1e-12);
        let (left, right) = (made.albedo.at(43, 16), made.albedo.at(53, 16));
        assert_eq!(left, Straight([0, 255, 0, 255]));
        assert_eq!(right, Straight([255, 0, 0, 255]));
        assert_eq!(made.normal_depth.at(53, 16), Straight([128, 128, 255, 128]));
        assert_eq!(made.albedo.at(16, 48).alpha(), 0);
        // The card spans 2 m of the frame's 2 · half_m.
        let row = (32..64).filter(|&x| made.albedo.at(x, 16).alpha() > 127);
        let expected = 2.0 / (2.0 * made.half_m) * 32.0;
        // Pixels that are half covered count.
        let found = row.count() as f64;
        assert!((found - expected).abs() <= 1.5, "{found} {expected}");
    }

    #[test]
    fn directions_are_distinct_and_those_of_the_form() {
        for form in [ImpostorForm::Full, ImpostorForm::Hemisphere] {
            let mut lowest = 1.0f64;
            for i in 0..64 {
                let direction = frame_direction(form, 8, i % 8, i / 8);
                let [right, up] = frame_axes(direction);
                assert!((right.cross(up) - direction).length() < 1e-9);
                lowest = lowest.min(direction.y);
            }
            let expected = if form == ImpostorForm::Full {
                -1.0
            } else {
                0.0
            };
            assert!((lowest - expected).abs() < 1e-9, "{form:?}");
        }
    }
}
