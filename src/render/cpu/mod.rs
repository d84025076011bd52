//! The twin on the processor: the same passes with the same arithmetic as the shaders, in the same
//! order. It is the reference in tests and the renderer where there is no graphics card.
//!
//! A picture is made in bands of rows, each by itself, so that threads change nothing.

mod backdrop;
mod relief;
mod shade;
mod target;
mod tone;

use super::frame::{CrownNumbers, Frame, InstanceNumbers, View3d};
use super::settings::RenderSettings;
use crate::base::{Cancel, Cancelled, Progress};
use crate::raster::{Image, Straight};
use target::{Band, Target};

/// Draws a scene.
///
/// # Errors
/// [`Cancelled`].
pub fn picture(
    view: &View3d<'_>,
    settings: &RenderSettings,
    progress: &Progress<'_>,
    cancel: &Cancel,
) -> Result<Image<Straight>, Cancelled> {
    let frame = Frame::new(view, settings);
    let mut target = Target::new(frame.size.map(|side| side as u32));
    let instances: Vec<Drawn<'_>> = view.instances.iter().map(|i| Drawn::new(i, view)).collect();
    let stage = progress.stage("draw", target.band_count());
    target.for_bands(|band| {
        if !cancel.is_cancelled() {
            backdrop::draw(&frame, band);
            for drawn in &instances {
                relief::draw(&frame, drawn, band);
            }
            stage.advance();
        }
    });
    cancel.check()?;
    Ok(tone::picture(&frame, &target, settings.fineness))
}

/// An instance with its crown.
struct Drawn<'a> {
    crown: &'a super::PreparedCrown,
    numbers: CrownNumbers,
    instance: InstanceNumbers,
}

impl<'a> Drawn<'a> {
    fn new(instance: &crate::scene::CrownInstance, view: &View3d<'a>) -> Self {
        let crown = &view.crowns[instance.crown];
        Self {
            crown,
            numbers: CrownNumbers::new(crown),
            instance: InstanceNumbers::new(instance, crown),
        }
    }
}
