//! The jobs behind mask tools and mask commands, and what becomes of their results.
//!
//! What a job selects depends on the photograph alone and is painted on whatever the mask is by then. A
//! changed mask is taken only if the mask is still the one that it was made from. Results that come
//! while the hand is down wait until it is up, so that none gets into somebody's stroke.

use super::action::Gesture;
use super::outcome::Outcome;
use super::selecting::Sketch;
use super::studio::{Severity, Studio};
use super::tools::Tool;
use crate::base::{Cancel, Cancelled, Digest, read_limited, write_atomic};
use crate::document::{Edit, PhotoId};
use crate::geometry::Point;
use crate::jobs::{Context, JobError, Priority, Request, Topic};
use crate::paint::{
    BACKGROUND, FillRule, Paint, Reach, TiledMask, color_selection, grey_from_mask,
    mask_from_picture, polygon_selection, smart_selection,
};
use crate::pipeline::{PictureShape, picture_shape};
use crate::raster::{
    Compression, Image, ReadLimits, Rect, Straight, encode_grey_png, read_image_from_memory,
};
use crate::segment::{Provenance, Segmenter as _, Source};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What a job found out about a mask.
pub(super) enum MaskResult {
    /// These pixels are to be painted.
    Selected {
        photo: PhotoId,
        selection: TiledMask,
        paint: Paint,
        label: &'static str,
    },
    /// What this many strokes of smart select mean.
    Smart {
        photo: PhotoId,
        strokes: u32,
        selection: TiledMask,
    },
    /// A new mask, made from `before` unless that is `None`.
    Mask {
        photo: PhotoId,
        before: Option<Arc<TiledMask>>,
        after: TiledMask,
        label: &'static str,
    },
    /// What the segmenter sees in a photograph, with its background or cut out.
    Proposal(Proposal),
    /// A mask was written to this file.
    Exported(PathBuf),
    /// The shape of the shown tree.
    Shape(Shaped),
}

/// Labels that nobody painted.
pub(super) struct Proposal {
    photo: PhotoId,
    mask: TiledMask,
    provenance: Provenance,
    is_cut_out: bool,
}

/// The shape of the tree in a photograph.
pub(super) struct Shaped {
    pub(super) photo: Digest,
    /// Or why there is none.
    pub(super) shape: Result<Arc<PictureShape>, String>,
}

impl Studio {
    fn start(
        &mut self,
        name: &'static str,
        kind: &'static str,
        photo: PhotoId,
        work: impl FnOnce(&Context<Outcome>) -> Result<MaskResult, JobError> + Send + 'static,
    ) {
        let topic = Topic {
            kind,
            item: u64::from(photo.0),
        };
        let work = move |context: &Context<Outcome>| work(context).map(Outcome::Mask);
        let request = Request::new(name, topic, Priority::Interactive, work);
        self.jobs.submit(request);
    }

    /// Takes up a result, or keeps it until the hand is up.
    pub(super) fn accept_mask(&mut self, result: MaskResult) {
        let changes = matches!(
            result,
            MaskResult::Selected { .. }
                | MaskResult::Mask { .. }
                | MaskResult::Smart { .. }
                | MaskResult::Proposal(_)
        );
        if changes && (self.painting.is_some() || self.document.is_in_gesture()) {
            self.mask_work.held.push(result);
            return;
        }
        match result {
            MaskResult::Selected {
                photo,
                selection,
                paint,
                label,
            } => self.paint_selection(photo, &selection, paint, label),
            MaskResult::Smart {
                photo,
                strokes,
                selection,
            } => self.accept_smart(photo, strokes, selection),
            MaskResult::Mask {
                photo,
                before,
                after,
                label,
            } => self.accept_changed(photo, before.as_ref(), after, label),
            MaskResult::Proposal(proposal) => self.accept_proposal(proposal),
            MaskResult::Exported(path) => {
                self.notify(Severity::Info, format!("Wrote {}", path.display()));
            }
            MaskResult::Shape(shaped) => self.mask_work.shape = Some(shaped),
        }
    }

    /// Takes up what waited for the hand.
    pub(super) fn take_up_held(&mut self) {
        for result in std::mem::take(&mut self.mask_work.held) {
            self.accept_mask(result);
        }
    }

    fn accept_changed(
        &mut self,
        photo: PhotoId,
        before: Option<&Arc<TiledMask>>,
        after: TiledMask,
        label: &'static str,
    ) {
        let Some(now) = self.document.state().mask(photo) else {
            return;
        };
        if before.is_some_and(|before| before != now) {
            let why = format!("{label}: the mask was changed meanwhile. Please ask again.");
            self.notify(Severity::Warning, why);
        } else if **now == after {
            self.notify(Severity::Info, format!("{label}: nothing is different."));
        } else {
            self.edit(label, Edit::SetMask(photo, Arc::new(after)), Gesture::Whole);
        }
    }

    fn accept_smart(&mut self, photo: PhotoId, strokes: u32, selection: TiledMask) {
        let Some(Sketch::Smart(smart)) = &mut self.mask_work.sketch else {
            return;
        };
        if smart.photo != photo || strokes < smart.selected_for {
            return;
        }
        smart.selection = Some(Arc::new(selection));
        smart.selected_for = strokes;
        if smart.is_wanted && smart.is_up_to_date() {
            self.close_sketch();
        }
    }

    pub(super) fn select_by_color(
        &mut self,
        photo: PhotoId,
        picture: Arc<Image<Straight>>,
        seed: (u32, u32),
        paint: Paint,
    ) {
        let tolerance = self.tools.tolerance;
        let reach = if self.tools.is_contiguous {
            Reach::Contiguous
        } else {
            Reach::Everywhere
        };
        self.start("Selecting by colour", "flood", photo, move |context| {
            let selection = color_selection(&picture, seed, tolerance, reach, context.cancel())?;
            Ok(MaskResult::Selected {
                photo,
                selection,
                paint,
                label: "Flood",
            })
        });
    }

    /// Labels what a closed line goes round.
    pub(super) fn select_inside(
        &mut self,
        photo: PhotoId,
        line: Vec<Point>,
        rule: FillRule,
        paint: Paint,
        label: &'static str,
    ) {
        let Some(mask) = self.document.state().mask(photo) else {
            return;
        };
        if line.len() < 3 {
            return;
        }
        let (width, height) = (mask.width(), mask.height());
        self.start("Filling the line", "line", photo, move |context| {
            context.check()?;
            Ok(MaskResult::Selected {
                photo,
                selection: polygon_selection(width, height, &line, rule),
                paint,
                label,
            })
        });
    }

    /// Finds what the strokes of smart select mean.
    pub(super) fn think_about_strokes(&mut self) {
        let Some(picture) = self.picture_at_hand() else {
            return;
        };
        let Some(Sketch::Smart(smart)) = &self.mask_work.sketch else {
            return;
        };
        let (photo, strokes, hints) = (smart.photo, smart.strokes, smart.hints.clone());
        self.start(
            "Finding the outline",
            "smart select",
            photo,
            move |context| {
                let selection = smart_selection(&picture, &hints, context.cancel())?;
                Ok(MaskResult::Smart {
                    photo,
                    strokes,
                    selection,
                })
            },
        );
    }

    /// Changes the shown mask in a job.
    pub(super) fn change_mask(
        &mut self,
        label: &'static str,
        change: impl FnOnce(&mut TiledMask, &Cancel) -> Result<Option<Rect>, Cancelled> + Send + 'static,
    ) {
        self.end_gesture();
        let Some(photo) = self.shown() else { return };
        let Some(before) = self.document.state().mask(photo).cloned() else {
            return;
        };
        self.start(label, "change mask", photo, move |context| {
            let mut after = TiledMask::clone(&before);
            change(&mut after, context.cancel())?;
            Ok(MaskResult::Mask {
                photo,
                before: Some(before),
                after,
                label,
            })
        });
    }

    /// Labels crown and trunk as the segmenter sees them, in one step.
    pub(super) fn propose_mask(&mut self) {
        self.end_gesture();
        let (Some(photo), Some(picture)) = (self.shown(), self.picture_at_hand()) else {
            return;
        };
        let segmenter = self.segmenter();
        self.start("Proposing a mask", "change mask", photo, move |context| {
            let found = segmenter.segmented(&picture, context.cancel());
            let found = found.map_err(JobError::failed)?;
            Ok(MaskResult::Proposal(Proposal {
                photo,
                mask: TiledMask::from_labels(&found.labels),
                provenance: found.provenance,
                is_cut_out: picture.pixels().iter().any(|pixel| pixel.alpha() < 128),
            }))
        });
    }

    /// The proposal becomes the mask. The rules see nothing in a photograph with its background: there
    /// the user has to say more.
    fn accept_proposal(&mut self, proposal: Proposal) {
        let Provenance {
            source, confidence, ..
        } = proposal.provenance;
        let is_empty = proposal.mask.count(|label| label != BACKGROUND) == 0;
        if is_empty || (source == Source::Classical && !proposal.is_cut_out) {
            self.take_tool(Tool::Smart);
            let how = "No tree was found in this photograph with enough confidence. Smart Select: \
                       draw a stroke inside the crown, then with the right button outside, and \
                       press Enter.";
            self.notify(Severity::Info, how);
            return;
        }
        self.accept_changed(proposal.photo, None, proposal.mask, "Propose Mask");
        let told = match (source, confidence) {
            (Source::Learned, Some(confidence)) => {
                let percent = 100.0 * confidence;
                let who = self.learned_title();
                format!("Proposed by {who}, {percent:.0} % sure. Correct it by hand.")
            }
            _ => "Proposed by the classical segmenter. Correct it by hand.".to_owned(),
        };
        self.notify(Severity::Info, told);
    }

    pub(super) fn import_mask(&mut self, path: PathBuf) {
        self.end_gesture();
        let Some(photo) = self.shown() else { return };
        let Some(mask) = self.document.state().mask(photo) else {
            return;
        };
        let size = (mask.width(), mask.height());
        self.start("Importing a mask", "change mask", photo, move |_| {
            let after = mask_of(&path, size).map_err(JobError::failed)?;
            Ok(MaskResult::Mask {
                photo,
                before: None,
                after,
                label: "Import Mask",
            })
        });
    }

    pub(super) fn export_mask(&mut self, path: PathBuf) {
        let Some(photo) = self.shown() else { return };
        let Some(mask) = self.document.state().mask(photo).cloned() else {
            return;
        };
        self.start("Exporting the mask", "export mask", photo, move |context| {
            let grey = grey_from_mask(&mask);
            context.check()?;
            let bytes = encode_grey_png(&grey, Compression::Fast);
            context.check()?;
            write_atomic(&path, &bytes).map_err(JobError::failed)?;
            Ok(MaskResult::Exported(path))
        });
    }

    /// Asks for the shape of the shown tree, if an overlay needs it and it is not known.
    pub(super) fn ask_for_shape(&mut self) {
        if !self.mask_work.overlays.need_shape() {
            return;
        }
        let Some(photo) = self.shown() else { return };
        let state = self.document.state();
        let digest = state.content().photos.get(&photo).map(|photo| photo.digest);
        let (Some(digest), Some(mask)) = (digest, state.mask(photo).cloned()) else {
            return;
        };
        let Some(picture) = self.photos.whole(digest).cloned() else {
            return;
        };
        let asked = &self.mask_work.shape_asked;
        if asked
            .as_ref()
            .is_some_and(|(of, with)| *of == digest && *with == mask)
        {
            return;
        }
        self.mask_work.shape_asked = Some((digest, Arc::clone(&mask)));
        let segmenter = self.segmenter();
        // A failure is a result: the canvas shows why there is no outline.
        self.start(
            "Finding the outline of the tree",
            "shape",
            photo,
            move |context| {
                let shape = picture_shape(&picture, &mask, segmenter, context.cancel());
                context.check()?;
                Ok(MaskResult::Shape(Shaped {
                    photo: digest,
                    shape: shape.map(Arc::new).map_err(|error| error.to_string()),
                }))
            },
        );
    }
}

/// The mask in a picture file.
fn mask_of(path: &Path, size: (u32, u32)) -> Result<TiledMask, String> {
    let limits = ReadLimits::default();
    let bytes = read_limited(path, limits.file_bytes).map_err(|error| error.to_string())?;
    let picture =
        read_image_from_memory(&bytes, path, limits).map_err(|error| error.to_string())?;
    let found = (picture.width(), picture.height());
    if found != size {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let ((width, height), (needed_width, needed_height)) = (found, size);
        return Err(format!(
            "{name} has {width} × {height} pixels, the photograph {needed_width} × {needed_height}"
        ));
    }
    Ok(mask_from_picture(&picture))
}
