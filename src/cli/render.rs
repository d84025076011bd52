//! `boscage render`: a crown's folder → pictures of it.

use super::failure::Failure;
use super::input::read_crown_and_record;
use super::options::BackendName;
use super::output::recipe;
use super::session::Session;
use super::{Job, Stages};
use crate::base::{Cancel, Digest, Seed};
use crate::batch::export_crown::leaf_of;
use crate::branches::leaf_name::LeafName;
use crate::export::CrownRecord;
use crate::pipeline::{CrownSettings, k_on_mesh};
use crate::raster::{Compression, Image, Straight, encode_png};
use crate::render::{
    Backend, LeafClip, LeafSet, LeafSettings, Mode, Occlusion, PreparedCrown, PreparedMesh,
    RenderSettings, Renderer, SceneView, View,
};
use crate::scene::{Backdrop, Camera, Crown, CrownInstance, Light, Trunk};
use clap::{Args, ValueEnum};
use serde::Deserialize;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Draw a crown
///
/// Reads the folder that `boscage crown` wrote. With --frames it draws a turntable: --out
/// tree.png makes tree_0000.png, tree_0001.png and so on.
#[derive(Debug, Args)]
#[command(after_help = "Example: boscage render oak --yaw 30 --pitch 10 --out oak.png")]
pub(super) struct Flags {
    /// The folder of a crown
    crown: PathBuf,
    /// The form in which the crown is drawn
    #[arg(long, value_enum, default_value_t, value_name = "MODE")]
    mode: ModeName,
    /// Around the tree, degrees: 0 sees it as the photograph, 90 from its right
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true, value_name = "DEG", value_parser = angle)]
    yaw: f64,
    /// Above the horizon, degrees, -89.9 to 89.9
    #[arg(long, default_value_t = 6.0, allow_negative_numbers = true, value_name = "DEG", value_parser = pitch)]
    pitch: f64,
    /// From the eye to the middle of the tree, metres [default: the whole tree shows]
    #[arg(long, value_name = "M", value_parser = length)]
    distance: Option<f64>,
    /// Width and height of the picture, pixels
    #[arg(long, num_args = 2, value_names = ["W", "H"], default_values_t = [1024, 1024], value_parser = clap::value_parser!(u32).range(1..=8192))]
    size: Vec<u32>,
    /// Who draws: the graphics card or the processor
    #[arg(long, value_enum, default_value_t, value_name = "NAME")]
    backend: BackendName,
    /// Pictures of one turn around the tree
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=9999))]
    frames: u32,
    /// What stands behind
    #[arg(long, value_enum, default_value_t, value_name = "NAME")]
    backdrop: BackdropName,
    /// What the picture shows
    #[arg(long, value_enum, default_value_t, value_name = "NAME")]
    view: ViewName,
    /// What makes the inside darker: baked occlusion, or the terms of the thesis
    #[arg(long, value_enum, default_value_t, value_name = "NAME")]
    occlusion: OcclusionName,
    /// The leaves of the form with leaves [default: the crown's own]
    #[arg(long, value_enum, value_name = "SHAPE")]
    leaf: Option<LeafName>,
    /// Cut leaves off at the crown's surface, as the thesis does
    #[arg(long)]
    cut_leaves: bool,
    /// Leave out the stem
    #[arg(long)]
    no_trunk: bool,
    /// Samples along each side of a pixel
    #[arg(long, default_value_t = 3, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4))]
    samples: u32,
    /// Where the sun stands around the tree, degrees, as --yaw
    #[arg(long, default_value_t = Light::default().sun_yaw_deg, allow_negative_numbers = true, value_name = "DEG", value_parser = angle)]
    sun_yaw: f64,
    /// How high the sun stands, degrees
    #[arg(long, default_value_t = Light::default().sun_pitch_deg, allow_negative_numbers = true, value_name = "DEG", value_parser = pitch)]
    sun_pitch: f64,
}

/// Squares along a side of a face of the surface's mesh.
const CELLS: u32 = 96;

/// What a picture is made of, made once for all pictures.
struct Things {
    crowns: [PreparedCrown; 1],
    meshes: Vec<PreparedMesh>,
    leaves: LeafSet,
}

#[derive(Debug, Clone, Copy, Default, ValueEnum)]
enum ModeName {
    /// The relief of the crown
    #[default]
    Relief,
    /// Twigs with leaves
    Leaves,
    /// Triangles of its surface
    Mesh,
    /// Triangles of the base mesh, coloured by their distance from the centre
    Base,
    /// The base mesh, coloured by how much it stretches the photograph: dark not at all, yellow
    /// eight times and more
    Stretch,
    /// The base mesh, coloured by k, how steeply it leaves the silhouette: dark 0, yellow the
    /// steepest of this crown
    K,
    /// Leaves when near, relief when far
    Auto,
}

#[derive(Debug, Clone, Copy, Default, ValueEnum)]
enum BackdropName {
    /// Light grey paper
    #[default]
    Studio,
    /// Open ground under a sky
    Sky,
    /// Nothing: the picture is clear there
    Clear,
}

#[derive(Debug, Clone, Copy, Default, ValueEnum)]
enum OcclusionName {
    #[default]
    Baked,
    Terms,
}

#[derive(Debug, Clone, Copy, Default, ValueEnum)]
enum ViewName {
    #[default]
    Picture,
    Steps,
    Normals,
    Depth,
    RadiusError,
    Wireframe,
}

/// A number of degrees.
fn angle(text: &str) -> Result<f64, String> {
    number(text, "a number of degrees", |degrees| {
        degrees.abs() <= 36_000.0
    })
}

/// Degrees above the horizon.
fn pitch(text: &str) -> Result<f64, String> {
    number(text, "degrees from -89.9 to 89.9", |degrees| {
        degrees.abs() <= 89.9
    })
}

/// A length in metres.
fn length(text: &str) -> Result<f64, String> {
    number(text, "metres from 0.001 to 1000000", |metres| {
        (1e-3..=1e6).contains(&metres)
    })
}

fn number(text: &str, what: &str, good: impl Fn(f64) -> bool) -> Result<f64, String> {
    let number: Option<f64> = text.parse().ok();
    let checked = number.filter(|&number| number.is_finite() && good(number));
    checked.ok_or_else(|| format!("expected {what}"))
}

impl Job for Flags {
    fn stages(&self) -> Stages {
        &[("read", 1.0), ("prepare", 1.0), ("render", 8.0)]
    }

    fn run(&self, session: &Session<'_>) -> Result<(), Failure> {
        let frames = self.frames(session.options.out()?);
        let shard = session.options.shard;
        let ours: Vec<&(u32, PathBuf)> = frames
            .iter()
            .filter(|(index, _)| shard.contains(u64::from(*index)))
            .collect();
        session.output.check(ours.iter().map(|(_, path)| path))?;
        let stage = session.progress.stage("read", 1);
        let (crown, record, digest) = read_crown_and_record(&self.crown)?;
        stage.advance();
        drop(stage);
        let wanted: Vec<(u32, &Path, Digest)> = ours
            .iter()
            .map(|(index, path)| (*index, path.as_path(), self.recipe(digest, *index)))
            .filter(|(_, path, recipe)| !session.output.is_ready(path, *recipe))
            .collect();
        let k = self.k(&crown, &record, session.cancel)?;
        let leaf = self.leaf.unwrap_or_else(|| leaf_of(&record));
        let drawn_by = self.make(session, (&crown, leaf, k.as_deref()), &wanted)?;
        session.print_json(|| {
            let files: Vec<String> = ours
                .iter()
                .map(|(_, path)| path.display().to_string())
                .collect();
            json!({
                "crown": self.crown.display().to_string(),
                "outputs": files,
                "renderer": drawn_by,
                "k": k.as_deref().map(range),
                "camera": camera_json(&self.camera(&crown)),
                "seconds": session.seconds(),
            })
        })
    }
}

/// The smallest and largest of `values`.
fn range(values: &[f64]) -> [f64; 2] {
    let around = |[low, high]: [f64; 2], &value: &f64| [low.min(value), high.max(value)];
    values.iter().fold([f64::INFINITY, 0.0], around)
}

fn camera_json(camera: &Camera) -> serde_json::Value {
    json!({
        "target_m": camera.target_m.to_array(),
        "distance_m": camera.distance_m,
        "yaw_deg": camera.yaw_deg,
        "pitch_deg": camera.pitch_deg,
        "fov_y_deg": camera.fov_y_deg,
    })
}

impl Flags {
    /// The pictures and their files.
    fn frames(&self, out: &Path) -> Vec<(u32, PathBuf)> {
        if self.frames == 1 {
            return vec![(0, out.to_owned())];
        }
        let stem = out.file_stem().unwrap_or_default().to_string_lossy();
        let named = |index: u32| out.with_file_name(format!("{stem}_{index:04}.png"));
        (0..self.frames)
            .map(|index| (index, named(index)))
            .collect()
    }

    /// What goes into picture `index`. The renderer is part of it: two of them differ in the last
    /// bits.
    fn recipe(&self, crown: Digest, index: u32) -> Digest {
        let settings = format!("{self:?} {index}");
        recipe("render")
            .with(crown.bytes())
            .with(settings.as_bytes())
            .finish()
    }

    fn camera(&self, crown: &Crown) -> Camera {
        let aspect = f64::from(self.size[0]) / f64::from(self.size[1]);
        let (center, radius) = crown.tree_bounds();
        let framed = Camera::framing(center, radius, (self.yaw, self.pitch), aspect);
        Camera {
            distance_m: self.distance.unwrap_or(framed.distance_m),
            ..framed
        }
    }

    fn settings(&self) -> RenderSettings {
        RenderSettings {
            size: (self.size[0], self.size[1]),
            fineness: self.samples,
            mode: match self.mode {
                ModeName::Relief => Mode::Relief,
                ModeName::Leaves => Mode::Leaves,
                ModeName::Mesh | ModeName::Base | ModeName::Stretch | ModeName::K => Mode::Mesh,
                ModeName::Auto => Mode::Switched,
            },
            view: match self.view {
                ViewName::Picture => View::Picture,
                ViewName::Steps => View::Steps,
                ViewName::Normals => View::Normals,
                ViewName::Depth => View::Depth,
                ViewName::RadiusError => View::RadiusError,
                ViewName::Wireframe => View::Wireframe,
            },
            leaves: LeafSettings {
                clip: if self.cut_leaves {
                    LeafClip::Fragment
                } else {
                    LeafClip::Center
                },
                ..LeafSettings::default()
            },
            occlusion: match self.occlusion {
                OcclusionName::Baked => Occlusion::Baked,
                OcclusionName::Terms => Occlusion::Terms,
            },
            ..RenderSettings::default()
        }
    }

    fn renderer(&self, session: &Session<'_>) -> Result<Renderer, Failure> {
        match self.backend.forced() {
            Some(backend) => Ok(Renderer::new(backend)?),
            None => Ok(Renderer::new(Backend::Gpu).or_else(|error| {
                session
                    .progress
                    .warn(&format!("{error}; drawing on the processor"));
                Renderer::new(Backend::Cpu)
            })?),
        }
    }

    /// The crown, with its stem unless that is left out.
    fn prepared(&self, crown: &Crown, cancel: &Cancel) -> Result<PreparedCrown, Failure> {
        let prepared = PreparedCrown::new(crown, cancel)?;
        Ok(match self.no_trunk {
            true => prepared,
            false => prepared.on_stem(&Trunk::under(crown)),
        })
    }

    /// k at each vertex of the base mesh, if that is to be drawn.
    fn k(
        &self,
        crown: &Crown,
        record: &CrownRecord,
        cancel: &Cancel,
    ) -> Result<Option<Vec<f64>>, Failure> {
        if !matches!(self.mode, ModeName::K) {
            return Ok(None);
        }
        let refused = |reason: &dyn std::fmt::Display| Failure::of(self.crown.display(), reason);
        if record.recipe.get("regions").is_some() {
            return Err(refused(
                &"its regions have a k each; draw it in another mode",
            ));
        }
        let of_recipe = record.recipe.get("settings").unwrap_or(&Value::Null);
        let settings = CrownSettings::deserialize(of_recipe);
        let settings =
            settings.map_err(|error| refused(&format!("its record tells no k: {error}")))?;
        match k_on_mesh(&crown.base_mesh, settings.k.as_ref(), cancel) {
            Ok(k) => Ok(Some(k)),
            Err(error) if error.is_cancelled() => Err(Failure::Cancelled),
            Err(error) => Err(refused(&error)),
        }
    }

    /// The triangles of the picture: the stem, and the crown's surface where that is asked for.
    fn meshes(&self, crown: &Crown, k: Option<&[f64]>) -> Vec<PreparedMesh> {
        let mut meshes = Vec::new();
        if !self.no_trunk {
            meshes.push(PreparedMesh::of_trunk(&Trunk::under(crown), crown));
        }
        match self.mode {
            ModeName::Mesh => meshes.push(PreparedMesh::of_crown(crown, CELLS)),
            ModeName::Base => meshes.push(PreparedMesh::of_base(crown)),
            ModeName::Stretch => meshes.push(PreparedMesh::of_stretch(crown)),
            ModeName::K => {
                let heat = |k| PreparedMesh::heat_map(&crown.base_mesh, k, (0.0, range(k)[1]));
                meshes.extend(k.map(heat));
            }
            ModeName::Relief | ModeName::Leaves | ModeName::Auto => {}
        }
        meshes
    }

    /// Draws and writes the pictures that are wanted; says who drew them.
    fn make(
        &self,
        session: &Session<'_>,
        (crown, leaf, k): (&Crown, LeafName, Option<&[f64]>),
        wanted: &[(u32, &Path, Digest)],
    ) -> Result<Option<String>, Failure> {
        if wanted.is_empty() {
            return Ok(None);
        }
        let stage = session.progress.stage("prepare", 1);
        let mut renderer = self.renderer(session)?;
        let things = Things {
            crowns: [self.prepared(crown, session.cancel)?],
            meshes: self.meshes(crown, k),
            leaves: LeafSet::new(leaf, Seed(session.options.seed)),
        };
        stage.advance();
        drop(stage);
        let stage = session.progress.stage("render", wanted.len() as u64);
        for &(index, path, recipe) in wanted {
            let picture = self.picture(session, crown, &things, &mut renderer, index)?;
            let png = encode_png(&picture, Compression::Fast);
            session.cancel.check()?;
            session.output.write_item(path, png, recipe)?;
            stage.advance();
        }
        Ok(Some(renderer.name()))
    }

    /// Picture `index` of the turntable. When the graphics card gives up half-way and any renderer
    /// would do, the processor draws on.
    fn picture(
        &self,
        session: &Session<'_>,
        crown: &Crown,
        things: &Things,
        renderer: &mut Renderer,
        index: u32,
    ) -> Result<Image<Straight>, Failure> {
        let light = Light {
            sun_yaw_deg: self.sun_yaw,
            sun_pitch_deg: self.sun_pitch,
            ..Light::default()
        };
        let camera = self.camera(crown).on_turntable(index, self.frames);
        let view = SceneView {
            crowns: &things.crowns,
            meshes: &things.meshes,
            leaves: &things.leaves,
            instances: &[CrownInstance::plain(0)],
            camera: &camera,
            light: &light,
            backdrop: match self.backdrop {
                BackdropName::Studio => Backdrop::Studio,
                BackdropName::Sky => Backdrop::Sky,
                BackdropName::Clear => Backdrop::Clear,
            },
        };
        let settings = self.settings();
        match renderer.picture(&view, &settings, session.cancel) {
            Err(error) if error.is_of_device() && self.backend == BackendName::Auto => {
                let warning = format!("{error}; drawing on the processor");
                session.progress.warn(&warning);
                *renderer = Renderer::new(Backend::Cpu)?;
                Ok(renderer.picture(&view, &settings, session.cancel)?)
            }
            outcome => Ok(outcome?),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Typed {
        #[command(flatten)]
        flags: Flags,
    }

    fn typed(words: &str) -> Result<Flags, clap::Error> {
        let words = std::iter::once("render").chain(words.split(' '));
        Typed::try_parse_from(words).map(|typed| typed.flags)
    }

    #[test]
    fn frames_are_numbered_beside_the_file_that_was_named() {
        let flags = typed("oak --frames 3").unwrap();
        let frames = flags.frames(Path::new("a/oak.png"));
        assert_eq!(frames[2], (2, PathBuf::from("a/oak_0002.png")));
        let one = typed("oak").unwrap().frames(Path::new("a/oak.png"));
        assert_eq!(one, [(0, PathBuf::from("a/oak.png"))]);
    }

    #[test]
    fn angles_and_lengths_that_make_no_view_are_refused() {
        assert!(typed("oak --yaw -30 --pitch -45.5 --distance 3").is_ok());
        for bad in [
            "--pitch 90",
            "--distance 0",
            "--yaw nan",
            "--size 0 5",
            "--frames 0",
        ] {
            assert!(typed(&format!("oak {bad}")).is_err(), "{bad}");
        }
    }
}
