//! A scene resolved into the numbers that both renderers read.
//!
//! The structs are those of `shaders/shared/frame.wgsl`, member for member; a test compares the
//! layouts.

use super::leaf_set::LeafSet;
use super::mesh::PreparedMesh;
use super::prepared::PreparedCrown;
use super::ribs::RibsFrom;
use super::settings::{Mode, RenderSettings};
use crate::scene::{Backdrop, Camera, CrownInstance, Light};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// What a picture is made of.
#[derive(Debug, Clone, Copy)]
pub struct SceneView<'a> {
    /// The crowns there are.
    pub crowns: &'a [PreparedCrown],
    /// Where they stand.
    pub instances: &'a [CrownInstance],
    /// Triangles, in the world: stems, surfaces.
    pub meshes: &'a [PreparedMesh],
    /// What leaf crowns are drawn with.
    pub leaves: &'a LeafSet,
    /// From where the picture is taken.
    pub camera: &'a Camera,
    /// What lights it.
    pub light: &'a Light,
    /// What is behind.
    pub backdrop: Backdrop,
}

/// What is the same for all that is drawn in a picture.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Frame {
    /// Clip coordinates of a world position, column by column; depth reversed and infinite.
    pub clip_from_world: [[f32; 4]; 4],
    /// The eye, metres.
    pub eye: [f32; 3],
    /// Distance of the near plane, metres.
    pub near: f32,
    /// The view's axis to the right.
    pub right: [f32; 3],
    /// Tangent of half the angle across.
    pub tan_x: f32,
    /// The view's axis up.
    pub up: [f32; 3],
    /// Tangent of half the angle up.
    pub tan_y: f32,
    /// The view's axis into the picture.
    pub forward: [f32; 3],
    /// Height of a sample at the distance of 1.
    pub sample_size: f32,
    /// Unit vector towards the sun.
    pub toward_sun: [f32; 3],
    /// Factor before the tone curve.
    pub exposure: f32,
    /// Light of the sun.
    pub sun: [f32; 3],
    /// Linear steps for each sample of a crown's radius.
    pub steps_a_sample: f32,
    /// Light of the sky.
    pub sky: [f32; 3],
    /// Least linear steps through a crown.
    pub least_steps: f32,
    /// Light of the ground.
    pub ground: [f32; 3],
    /// Most linear steps through a crown.
    pub most_steps: f32,
    /// Width and height in samples.
    pub size: [f32; 2],
    /// Halvings after the linear search.
    pub halvings: u32,
    /// Steps towards the sun.
    pub shadow_steps: u32,
    /// [`super::View`].
    pub view: u32,
    /// [`super::Occlusion`].
    pub occlusion: u32,
    /// [`super::Shortcut`].
    pub shortcut: u32,
    /// [`Backdrop`]: 0 clear, 1 studio, 2 sky.
    pub backdrop: u32,
    /// Leaves for each sample of a crown's radius.
    pub leaves_a_sample: f32,
    /// Least leaves of a crown.
    pub least_leaves: f32,
    /// Most leaves of a crown.
    pub most_leaves: f32,
    /// Half the side of a leaf's picture, in radii of the crown, times the root of their number.
    pub leaf_size: f32,
    /// [`super::LeafClip`].
    pub leaf_clip: u32,
    /// Samples along each side of a pixel.
    pub fineness: u32,
    /// Leaves there are.
    pub point_count: u32,
    /// Pixels of the picture as it is shown, along a side of a sample.
    pub pixels_a_sample: f32,
    /// How much further each step towards the sun goes than the one before.
    pub shadow_growth: f32,
    /// Where the ribs of long leaves begin: 0 leaves are not long, 1 at the crown's heart, 2 on its axis.
    pub ribs: u32,
    /// Width of long leaves by their length.
    pub rib_slender: f32,
    /// Height of their arch by how far they reach aside.
    pub rib_arch: f32,
}

/// What is the same for all instances of a crown.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct CrownNumbers {
    /// R_min and R_max, metres.
    pub radius_range: [f32; 2],
    /// Texels along a side of a face of the radius cubemap.
    pub radius_size: u32,
    /// Levels of the radius cubemap.
    pub radius_levels: u32,
    /// Texels along a side of a face of the colours.
    pub surface_size: u32,
    /// Levels of the colours.
    pub surface_levels: u32,
    /// Mean radius, metres.
    pub mean_radius: f32,
    /// Height of the centre above the tree's base, metres.
    pub center_height: f32,
    /// From the centre to the foot of the stem, and the stem's radius, metres; 0: no stem.
    pub stem: [f32; 4],
    /// Side of a texel of the radii, as a share of their rectangle.
    pub radius_texel: [f32; 2],
    /// Height by width: leaves are spread over a ball drawn out so.
    pub slender: f32,
    /// Side of leaves, as a share of that in a closed crown.
    pub leaf_side: f32,
}

/// One crown of the picture.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct InstanceNumbers {
    /// The centre of the crown, metres, world.
    pub center: [f32; 3],
    /// Size.
    pub scale: f32,
    /// Cosine and sine of the turn around the vertical axis.
    pub turn: [f32; 2],
    /// Share of the fragments that relief leaves to the leaves, 0 … 1.
    pub fade: f32,
    /// Seed of the dither pattern.
    pub dither: u32,
    /// Factor on the colours.
    pub tint: [f32; 3],
    /// Finest level of the crown that is drawn: a core is smooth, or its relief would stand out
    /// between the leaves.
    pub finest_level: f32,
}

impl Frame {
    /// The numbers of a picture.
    pub fn new(view: &SceneView<'_>, settings: &RenderSettings) -> Self {
        let fine = settings.fineness;
        let (width, height) = settings.drawn_size();
        let size = [width * fine, height * fine].map(|side| side as f32);
        let pixels_a_sample = settings.size.1 as f32 / size[1];
        let axes = view.camera.axes();
        let (tan_x, tan_y) = view
            .camera
            .half_extent(f64::from(settings.size.0) / f64::from(settings.size.1));
        let light = view.light;
        let ribs = view.leaves.ribs;
        Self {
            clip_from_world: clip_from_world(view.camera, (tan_x, tan_y)),
            eye: view.camera.eye_m().as_vec3().to_array(),
            near: view.camera.near_m() as f32,
            right: axes.right.as_vec3().to_array(),
            tan_x: tan_x as f32,
            up: axes.up.as_vec3().to_array(),
            tan_y: tan_y as f32,
            forward: axes.forward.as_vec3().to_array(),
            sample_size: (2.0 * tan_y) as f32 / size[1],
            toward_sun: light.toward_sun().as_vec3().to_array(),
            exposure: light.exposure,
            sun: light.sun,
            // Finer samples of the same picture need no more steps.
            steps_a_sample: settings.relief.steps_a_pixel / fine as f32,
            sky: light.sky,
            least_steps: settings.relief.least_steps as f32,
            ground: light.ground,
            most_steps: settings.relief.most_steps as f32,
            size,
            halvings: settings.relief.halvings,
            shadow_steps: settings.relief.shadow_steps,
            view: settings.view as u32,
            occlusion: settings.occlusion as u32,
            shortcut: settings.relief.shortcut as u32,
            backdrop: match view.backdrop {
                Backdrop::Clear => 0,
                Backdrop::Studio => 1,
                Backdrop::Sky => 2,
            },
            leaves_a_sample: settings.leaves.leaves_a_pixel * pixels_a_sample,
            least_leaves: settings.leaves.least as f32,
            most_leaves: settings.leaves.most as f32,
            leaf_size: settings.leaves.size,
            leaf_clip: settings.leaves.clip as u32,
            fineness: fine,
            point_count: view.leaves.points.len() as u32,
            pixels_a_sample,
            shadow_growth: shadow_growth(settings.relief.shadow_steps),
            ribs: ribs.map_or(0, |ribs| ribs.from as u32),
            rib_slender: ribs.map_or(0.0, |ribs| ribs.slender),
            rib_arch: ribs.map_or(0.0, |ribs| ribs.arch),
        }
    }

    /// The unit vector from the eye through a place of the picture, in samples from the left and
    /// top.
    #[inline(always)]
    pub(crate) fn ray(&self, x: f32, y: f32) -> Vec3 {
        let across = (2.0 * x / self.size[0] - 1.0) * self.tan_x;
        let upward = (1.0 - 2.0 * y / self.size[1]) * self.tan_y;
        let through = Vec3::from(self.forward)
            + Vec3::from(self.right) * across
            + Vec3::from(self.up) * upward;
        through * (1.0 / through.dot(through).sqrt())
    }
}

/// The first and the last step towards the sun are so far apart, as a factor, whatever their
/// number: a picture with few steps has the shadows of one with many, but coarser.
const SHADOW_REACH: f32 = 28.0;

fn shadow_growth(steps: u32) -> f32 {
    libm::powf(SHADOW_REACH, 1.0 / (steps.max(2) - 1) as f32)
}

/// The crowns of a picture by the passes that draw them, each with the index of its crown.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Resolved {
    /// For the relief pass: whole crowns, and the cores of leaf crowns.
    pub(crate) relief: Vec<(usize, InstanceNumbers)>,
    /// For the leaf pass.
    pub(crate) leaves: Vec<(usize, InstanceNumbers)>,
    /// Each crown once, for its shadow.
    pub(crate) shadows: Vec<(usize, InstanceNumbers)>,
}

/// Size and brightness of the dark core within a leaf crown, near and far. One does not look through
/// a dense crown, and its few hundred leaves alone would leave gaps. A larger core shows between the
/// outermost leaves, which is what is wanted far away, where relief takes over.
const NEAR_CORE: [f32; 2] = [0.66, 0.22];
const FAR_CORE: [f32; 2] = [0.985, 0.9];

/// Finest level of a near core.
const CORE_LEVEL: f32 = 3.0;
/// Size of the near core among boughs, by that among leaves: they let one see further in.
const BOUGH_CORE: f32 = 0.75;

/// Cover up to which leaves are so small that sky shows between them as in the picture, and from which on a
/// crown is closed.
const OPEN: [f32; 2] = [0.72, 0.9];

/// How often a line of sight through the middle of a closed crown meets a leaf.
const LAYERS: f32 = 3.0;

/// The area of leaves that cover so much of a crown, as a share of that in a closed one: by the law of Beer
/// and Lambert, ln(1 − cover) / −[`LAYERS`].
pub(crate) fn leaf_area(cover: f32) -> f32 {
    let closed = ((cover - OPEN[0]) / (OPEN[1] - OPEN[0])).clamp(0.0, 1.0);
    let open = (-libm::logf(1.0 - cover.clamp(0.1, 0.9)) / LAYERS).min(1.0);
    open + closed * (1.0 - open)
}

/// Least area of leaves that hides what is within: below it a crown has no core.
const HIDING: f32 = 0.75;

/// Radii of a crown, in pixels, at which its leaves keep to the surface as relief does, and at
/// which they are free of it.
const KEPT_RADIUS: f32 = 100.0;
const FREE_RADIUS: f32 = 320.0;

/// How free leaves are of the surface, 0 … 1, in a crown with a radius of so many pixels.
#[inline(always)]
pub(crate) fn leaf_freedom(radius_pixels: f32) -> f32 {
    ((radius_pixels - KEPT_RADIUS) / (FREE_RADIUS - KEPT_RADIUS)).clamp(0.0, 1.0)
}

/// The most leaves that the leaf pass will draw of a crown: what its shader counts, a little more,
/// and rounded up to a power of two.
pub(crate) fn leaf_bound(
    view: &SceneView<'_>,
    settings: &RenderSettings,
    (crown, numbers): &(usize, InstanceNumbers),
) -> u32 {
    let pixels = radius_pixels(view, settings, &view.crowns[*crown], numbers);
    let wanted = 1.01 * pixels * settings.leaves.leaves_a_pixel + 1.0;
    let most = settings.leaves.most.min(view.leaves.points.len() as u32);
    (wanted.max(settings.leaves.least as f32) as u32)
        .checked_next_power_of_two()
        .map_or(most, |bound| bound.min(most))
}

/// The radius of a crown on the screen, pixels.
fn radius_pixels(
    view: &SceneView<'_>,
    settings: &RenderSettings,
    crown: &PreparedCrown,
    numbers: &InstanceNumbers,
) -> f32 {
    let radius = f64::from(crown.radius_range.1 * numbers.scale);
    let center = glam::Vec3::from(numbers.center).as_dvec3();
    let distance = (center.distance(view.camera.eye_m()) - 0.5 * radius).max(0.05 * radius);
    let (_, half_up) = view.camera.half_extent(1.0);
    let pixel = 2.0 * half_up / f64::from(settings.size.1);
    (radius / (distance * pixel)) as f32
}

impl Resolved {
    /// Which crown is drawn how. A crown that changes its form is drawn by both passes, each taking
    /// its share of the samples.
    pub(crate) fn new(view: &SceneView<'_>, settings: &RenderSettings) -> Self {
        let mut resolved = Self::default();
        let eye = view.camera.eye_m();
        for (index, instance) in view.instances.iter().enumerate() {
            let crown = instance.crown;
            let mut numbers = InstanceNumbers::new(instance, &view.crowns[crown]);
            numbers.dither = (index as u32).wrapping_mul(0x9e37_79b1);
            resolved.shadows.push((crown, numbers));
            numbers.fade = match settings.mode {
                Mode::Relief => 0.0,
                Mode::Leaves => 1.0,
                Mode::Switched => {
                    let center = glam::Vec3::from(numbers.center).as_dvec3();
                    settings
                        .switch
                        .leaf_share(center.distance(eye), instance.switch_at)
                }
                Mode::Mesh => continue,
            };
            if numbers.fade < 1.0 {
                resolved.relief.push((crown, numbers));
            }
            if numbers.fade > 0.0 {
                resolved.leaves.push((crown, numbers));
                let prepared = &view.crowns[crown];
                let freedom = leaf_freedom(radius_pixels(view, settings, prepared, &numbers));
                let near_size = match view.leaves.ribs.map(|ribs| ribs.from) {
                    // Between fronds one sees others, or the sky.
                    Some(RibsFrom::Heart) => None,
                    Some(RibsFrom::Axis) => Some(BOUGH_CORE),
                    None => Some(1.0),
                };
                if let Some(size) = near_size.filter(|_| leaf_area(prepared.cover) >= HIDING) {
                    let mut core = numbers.core(freedom);
                    core.scale *= 1.0 - (1.0 - size) * freedom;
                    resolved.relief.push((crown, core));
                }
            }
        }
        // A crown's own after one another, so that the card changes crowns seldom.
        for list in [
            &mut resolved.relief,
            &mut resolved.leaves,
            &mut resolved.shadows,
        ] {
            list.sort_by_key(|(crown, _)| *crown);
        }
        resolved
    }
}

/// Columns of the matrix from world to clip coordinates.
fn clip_from_world(camera: &Camera, (tan_x, tan_y): (f64, f64)) -> [[f32; 4]; 4] {
    let axes = camera.axes();
    let eye = camera.eye_m();
    let near = camera.near_m();
    let rows = [axes.right / tan_x, axes.up / tan_y, axes.forward];
    let column = |i: usize| [rows[0][i], rows[1][i], 0.0, rows[2][i]].map(|x| x as f32);
    let shift = [
        -rows[0].dot(eye),
        -rows[1].dot(eye),
        near,
        -rows[2].dot(eye),
    ];
    [column(0), column(1), column(2), shift.map(|x| x as f32)]
}

impl CrownNumbers {
    /// The numbers of a crown.
    pub fn new(crown: &PreparedCrown) -> Self {
        let (width, height) = crown.radius.rectangle();
        Self {
            radius_range: crown.radius_range.into(),
            radius_size: crown.radius.size(),
            radius_levels: crown.radius.levels(),
            surface_size: crown.surface.size(),
            surface_levels: crown.surface.levels(),
            mean_radius: crown.mean_radius,
            center_height: crown.center.y,
            stem: crown.stem,
            radius_texel: [width, height].map(|side| 1.0 / side as f32),
            slender: crown.slender,
            leaf_side: leaf_area(crown.cover).sqrt(),
        }
    }
}

impl InstanceNumbers {
    /// The numbers of an instance of `crown`.
    pub fn new(instance: &CrownInstance, crown: &PreparedCrown) -> Self {
        let yaw = instance.yaw_deg.to_radians();
        let turn = [libm::cos(yaw), libm::sin(yaw)];
        let center = crown.center.as_dvec3() * instance.scale;
        let turned = glam::DVec3::new(
            turn[0] * center.x + turn[1] * center.z,
            center.y,
            turn[0] * center.z - turn[1] * center.x,
        );
        Self {
            center: (instance.base_m + turned).as_vec3().to_array(),
            scale: instance.scale as f32,
            turn: turn.map(|x| x as f32),
            fade: 0.0,
            dither: 0,
            tint: instance.tint,
            finest_level: 0.0,
        }
    }

    /// The core of a leaf crown whose leaves are so free of its surface.
    fn core(self, freedom: f32) -> Self {
        let [size, light] = [0, 1].map(|i| FAR_CORE[i] + (NEAR_CORE[i] - FAR_CORE[i]) * freedom);
        Self {
            scale: self.scale * size,
            tint: self.tint.map(|channel| channel * light),
            fade: 0.0,
            finest_level: CORE_LEVEL * freedom,
            ..self
        }
    }

    /// `world`, a direction, in the frame of the crown.
    #[inline(always)]
    pub(crate) fn local(&self, world: Vec3) -> Vec3 {
        let [cos, sin] = self.turn;
        Vec3::new(
            cos * world.x - sin * world.z,
            world.y,
            sin * world.x + cos * world.z,
        )
    }

    /// `local`, a direction in the frame of the crown, in that of the world.
    #[inline(always)]
    pub(crate) fn world(&self, local: Vec3) -> Vec3 {
        let [cos, sin] = self.turn;
        Vec3::new(
            cos * local.x + sin * local.z,
            local.y,
            cos * local.z - sin * local.x,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec3, Mat4, Vec4};

    #[test]
    fn what_a_ray_meets_is_projected_where_the_ray_went_through() {
        let camera = Camera {
            target_m: DVec3::new(1.0, 4.0, -2.0),
            distance_m: 12.0,
            yaw_deg: 37.0,
            pitch_deg: 21.0,
            fov_y_deg: 40.0,
        };
        let view = SceneView {
            crowns: &[],
            instances: &[],
            meshes: &[],
            leaves: &LeafSet::default(),
            camera: &camera,
            light: &Light::default(),
            backdrop: Backdrop::Clear,
        };
        let settings = RenderSettings {
            size: (300, 200),
            fineness: 1,
            ..RenderSettings::default()
        };
        let frame = Frame::new(&view, &settings);
        let matrix = Mat4::from_cols_array_2d(&frame.clip_from_world);
        for (x, y, distance) in [(150.0, 100.0, 3.0), (10.5, 33.0, 40.0), (299.0, 1.0, 7.0)] {
            let point = Vec3::from(frame.eye) + frame.ray(x, y) * distance;
            let clip = matrix * Vec4::new(point.x, point.y, point.z, 1.0);
            let found = (
                (clip.x / clip.w + 1.0) * 150.0,
                (1.0 - clip.y / clip.w) * 100.0,
            );
            assert!((found.0 - x).abs() < 1e-2 && (found.1 - y).abs() < 1e-2);
            let deep = (point - Vec3::from(frame.eye)).dot(Vec3::from(frame.forward));
            assert!((clip.z / clip.w - frame.near / deep).abs() < 1e-5);
        }
    }

    #[test]
    fn the_frame_of_a_crown_turns_with_it() {
        let mut numbers: InstanceNumbers = Zeroable::zeroed();
        numbers.turn = [0.0, 1.0];
        // A quarter turn brings the front, +Z, to +X.
        assert_eq!(numbers.world(Vec3::Z), Vec3::X);
        assert_eq!(numbers.local(Vec3::X), Vec3::Z);
    }
}
