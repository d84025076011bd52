//! The crown of the demo: a built-in sample becomes a crown in three dimensions, and a picture.

use super::failure::Failure;
use super::output::recipe;
use super::session::Session;
use crate::base::{Digest, Seed};
use crate::branches::leaf_name::LeafName;
use crate::branches::samples::{Sample, sample_named};
use crate::export::{crown_file_names, crown_files};
use crate::pipeline::{CrownError, CrownSettings, crown};
use crate::raster::{Compression, Mask, encode_png};
use crate::render::{
    Backend, LeafSet, Mode, PreparedCrown, PreparedMesh, RenderSettings, Renderer, SceneView,
};
use crate::scene::{Backdrop, Camera, Crown, CrownInstance, Light, Trunk};
use crate::segment::{Label, Segmenter as _, standard};
use serde_json::json;
use std::path::{Path, PathBuf};

/// The sample that becomes a crown: dense, and of a shape that everybody knows.
const SAMPLE: &str = "oak_02";

/// Pixels along a side of the picture.
const PICTURE: u32 = 768;

/// From where the picture is taken, degrees around and above: neither the sample's own view nor its
/// side.
const VIEW_DEG: (f64, f64) = (40.0, 8.0);

/// Makes the crown's folder, and a picture of it beside the folder.
///
/// # Errors
/// [`Failure::Cancelled`], and when files cannot be written.
pub(super) fn demo_crown(session: &Session<'_>, folder: &Path) -> Result<(), Failure> {
    let sample = sample_named(SAMPLE)
        .ok_or_else(|| Failure::Environment("a built-in sample is missing".into()))?;
    let stage = session.progress.stage("crown", 2);
    let picture_path = folder.with_extension("png");
    let files: Vec<PathBuf> = crown_file_names().iter().map(|n| folder.join(n)).collect();
    let digest = digest_of(sample, session.options.seed);
    if session.output.is_ready(&picture_path, digest) && files.iter().all(|file| file.is_file()) {
        return Ok(());
    }
    session.output.check(files.iter().chain([&picture_path]))?;
    let crown = crown_of(sample, session)?;
    stage.advance();
    let picture = picture_of(&crown, session)?;
    stage.advance();
    drop(stage);
    let origin = json!({"sample": SAMPLE, "seed": session.options.seed, "settings": settings()});
    let made = crown_files(&crown, origin, session.cancel)
        .map_err(|error| Failure::of_crown_files(SAMPLE, &error))?;
    session.cancel.check()?;
    for (name, bytes) in made {
        session
            .output
            .write_item(&folder.join(name), bytes, digest)?;
    }
    session.output.write_item(&picture_path, picture, digest)
}

fn settings() -> CrownSettings {
    CrownSettings {
        photo_front: true,
        ..CrownSettings::default()
    }
}

/// The digest of all that goes into the crown and its picture.
fn digest_of(sample: &Sample, seed: u64) -> Digest {
    recipe("demo crown")
        .with(sample.bundled())
        .with(standard().key().as_bytes())
        .with(&seed.to_le_bytes())
        .finish()
}

fn crown_of(sample: &Sample, session: &Session<'_>) -> Result<Crown, Failure> {
    let picture = sample.trimmed()?;
    let labels = standard().segment(&picture, session.cancel)?;
    let mask: Mask = labels.map(|&label| label == Label::Crown);
    let seed = Seed(session.options.seed);
    crown(
        &picture,
        &mask,
        &settings(),
        seed,
        session.progress,
        session.cancel,
    )
    .map_err(failure)
}

fn failure(error: CrownError) -> Failure {
    if error.is_cancelled() {
        Failure::Cancelled
    } else {
        Failure::of(SAMPLE, error)
    }
}

/// A picture of the crown with leaves, drawn by the processor, as a PNG file.
fn picture_of(crown: &Crown, session: &Session<'_>) -> Result<Vec<u8>, Failure> {
    let (center, radius) = crown.tree_bounds();
    let view = SceneView {
        crowns: &[PreparedCrown::new(crown, session.cancel)?],
        instances: &[CrownInstance::plain(0)],
        meshes: &[PreparedMesh::of_trunk(&Trunk::under(crown), crown)],
        leaves: &LeafSet::new(LeafName::Lobed, Seed(session.options.seed)),
        camera: &Camera::framing(center, radius, VIEW_DEG, 1.0),
        light: &Light::default(),
        backdrop: Backdrop::Studio,
    };
    let settings = RenderSettings {
        size: (PICTURE, PICTURE),
        mode: Mode::Leaves,
        ..RenderSettings::default()
    };
    let picture = Renderer::new(Backend::Cpu)?.picture(&view, &settings, session.cancel)?;
    Ok(encode_png(&picture, Compression::Fast))
}
