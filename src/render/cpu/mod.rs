//! The twin on the processor: the same passes with the same arithmetic as the shaders, in the same
//! order. It is the reference in tests and the renderer where there is no graphics card.
//!
//! A picture is made in bands of rows, each by itself, so that threads change nothing.

mod backdrop;
mod crown;
mod dither;
mod ground;
mod leaves;
mod mesh;
mod relief;
mod shade;
mod target;
mod tone;

use super::PreparedCrown;
use super::frame::{CrownNumbers, Frame, InstanceNumbers, Resolved, SceneView};
use super::settings::RenderSettings;
use crate::base::{Cancel, Cancelled, Progress};
use crate::raster::{Image, Straight};
use leaves::Leaf;
use rayon::prelude::*;
use target::{Band, Target};

/// Draws a scene.
///
/// # Errors
/// [`Cancelled`].
pub fn picture(
    view: &SceneView<'_>,
    settings: &RenderSettings,
    progress: &Progress<'_>,
    cancel: &Cancel,
) -> Result<Image<Straight>, Cancelled> {
    let frame = Frame::new(view, settings);
    let target = drawn(&frame, view, settings, progress, cancel)?;
    Ok(tone::picture(&frame, &target, settings.fineness))
}

/// How far what is seen in each pixel lies from the plane of the eye, metres; infinite where there
/// is nothing. One sample a pixel.
///
/// # Errors
/// [`Cancelled`].
pub fn distances_m(
    view: &SceneView<'_>,
    settings: &RenderSettings,
    cancel: &Cancel,
) -> Result<Image<f32>, Cancelled> {
    let single = RenderSettings {
        fineness: 1,
        ..*settings
    };
    let frame = Frame::new(view, &single);
    let target = drawn(&frame, view, &single, &Progress::silent(), cancel)?;
    Ok(target.depth().map(|depth| frame.near / depth))
}

/// Light and depth of all samples.
fn drawn(
    frame: &Frame,
    view: &SceneView<'_>,
    settings: &RenderSettings,
    progress: &Progress<'_>,
    cancel: &Cancel,
) -> Result<Target, Cancelled> {
    let mut target = Target::new(frame.size.map(|side| side as u32));
    let resolved = Resolved::new(view, settings);
    let with_crowns = |list: &[(usize, InstanceNumbers)]| -> Vec<Drawn<'_>> {
        let made = list
            .iter()
            .map(|(crown, instance)| Drawn::new(&view.crowns[*crown], *instance));
        made.collect()
    };
    let [shadows, relief, leafy] =
        [&resolved.shadows, &resolved.relief, &resolved.leaves].map(|list| with_crowns(list));
    let leaves: Vec<Vec<Leaf>> = leafy
        .par_iter()
        .map(|drawn| leaves::leaves(frame, drawn, view.leaves))
        .collect();
    let stage = progress.stage("draw", target.band_count());
    target.for_bands(|band| {
        if !cancel.is_cancelled() {
            backdrop::draw(frame, band);
            for drawn in &shadows {
                ground::draw(frame, drawn, band);
            }
            for part in view.meshes {
                mesh::draw(frame, part, band);
            }
            for drawn in &relief {
                relief::draw(frame, drawn, band);
            }
            for (drawn, leaves) in leafy.iter().zip(&leaves) {
                leaves::draw(frame, drawn, leaves, &view.leaves.atlas, band);
            }
            stage.advance();
        }
    });
    cancel.check()?;
    Ok(target)
}

/// An instance with its crown.
struct Drawn<'a> {
    crown: &'a PreparedCrown,
    numbers: CrownNumbers,
    instance: InstanceNumbers,
}

impl<'a> Drawn<'a> {
    fn new(crown: &'a PreparedCrown, instance: InstanceNumbers) -> Self {
        Self {
            crown,
            numbers: CrownNumbers::new(crown),
            instance,
        }
    }
}
