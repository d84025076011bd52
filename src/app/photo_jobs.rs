//! The jobs that read pictures, decode them and make thumbnails.

use super::dock::Pane;
use super::outcome::Outcome;
use super::photos::{MissingWork, THUMBNAIL_PX, Thumbnail, Wanted};
use super::studio::Studio;
use crate::base::{Cancel, Cancelled, Stage, read_limited};
use crate::document::{NewPhoto, PhotoId};
use crate::jobs::{Context, JobError, Priority, Request, Topic};
use crate::raster::{
    Image, ImageError, Pyramid, ReadLimits, Refusal, Straight, read_image_from_memory, scaled,
};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Most pixels of a picture that is decoded beside others; larger ones come one after the other, for
/// each needs a gigabyte.
const SMALL_PX: u64 = 1 << 24;

fn topic(kind: &'static str, item: u64) -> Topic {
    Topic { kind, item }
}

impl Studio {
    /// Asks for the pixels of the photograph that is shown, where they are not there.
    pub(super) fn decode_what_is_shown(&mut self) {
        let Some(id) = self.shown() else { return };
        let Some(photo) = self.document.state().content().photos.get(&id) else {
            return;
        };
        let Some(bytes) = self.document.photo_bytes(id).map(Arc::clone) else {
            return;
        };
        let (digest, name) = (photo.digest, photo.name.clone());
        if !self.photos.ask(digest) {
            return;
        }
        let title = format!("Decoding {name}");
        let work = move |context: &Context<Outcome>| {
            let image = match decoded(&bytes, &name) {
                Ok(image) => Arc::new(image),
                Err(reason) => {
                    let failed = Thumbnail::Failed(reason.clone());
                    context.publish(Outcome::Thumb(digest, failed));
                    return Err(JobError::failed(reason));
                }
            };
            let small = Thumbnail::Ready(Arc::new(thumbnail(&image)));
            context.publish(Outcome::Thumb(digest, small));
            context.publish(Outcome::Whole(digest, Arc::clone(&image)));
            let pyramid = Pyramid::of(&image, THUMBNAIL_PX, context.cancel())?;
            Ok(Outcome::Reduced(digest, Arc::new(pyramid)))
        };
        let topic = topic("whole photo", 0);
        self.jobs
            .submit(Request::new(title, topic, Priority::Interactive, work));
    }

    /// Has the thumbnails made that a panel sees and that are missing.
    pub(super) fn see_photos(&mut self, pane: Pane, ids: &[PhotoId]) {
        let photos = &self.document.state().content().photos;
        let wanted = ids.iter().filter_map(|id| {
            let photo = photos.get(id)?;
            let bytes = Arc::clone(self.document.photo_bytes(*id)?);
            let wanted = Wanted {
                digest: photo.digest,
                name: photo.name.clone(),
                bytes,
            };
            (!self.photos.has_thumbnail(photo.digest)).then_some(wanted)
        });
        let wanted = wanted.collect();
        if let Some(mut missing) = self.photos.missing.see(pane, wanted) {
            let work = move |context: &Context<Outcome>| made(&mut missing, context);
            let topic = topic("thumbnails", 0);
            self.jobs
                .submit(Request::new("Thumbnails", topic, Priority::Preview, work));
        }
    }

    /// Reads pictures and adds them to the project.
    pub(super) fn read_pictures(&mut self, paths: Vec<PathBuf>) {
        let work = move |context: &Context<Outcome>| {
            let (mut pictures, mut failures) = (Vec::new(), Vec::new());
            let stage = context.progress().stage("read", paths.len() as u64);
            let read = in_turn(&paths, &stage, context.cancel(), |path, limits| {
                picture(path, limits)
            })?;
            for read in read {
                match read {
                    Ok(picture) => pictures.push(picture),
                    Err(error) => failures.push(error.to_string()),
                }
            }
            Ok(Outcome::Pictures(pictures, failures))
        };
        let topic = topic("add pictures", self.next_notice);
        let name = "Adding pictures";
        self.jobs
            .submit(Request::new(name, topic, Priority::Interactive, work));
    }
}

/// Makes thumbnails as long as any are missing in sight, those wanted first first.
fn made(missing: &mut MissingWork, context: &Context<Outcome>) -> Result<Outcome, JobError> {
    let at_once = 2 * rayon::current_num_threads();
    loop {
        context.check()?;
        let batch = missing.next(at_once);
        if batch.is_empty() {
            return Ok(Outcome::Seen);
        }
        let stage = context.progress().stage("thumbnails", batch.len() as u64);
        let made = in_turn(&batch, &stage, context.cancel(), |wanted, limits| {
            let name = Path::new(&wanted.name);
            let image = read_image_from_memory(&wanted.bytes, name, limits)?;
            let small = Thumbnail::Ready(Arc::new(thumbnail(&image)));
            context.publish(Outcome::Thumb(wanted.digest, small));
            Ok(())
        })?;
        for (wanted, made) in batch.iter().zip(made) {
            if let Err(error) = made {
                let failed = Thumbnail::Failed(error.to_string());
                context.publish(Outcome::Thumb(wanted.digest, failed));
            }
        }
    }
}

/// Reads all `items`, small pictures beside one another and large ones alone; what became of each.
fn in_turn<I: Sync, T: Send>(
    items: &[I],
    stage: &Stage<'_>,
    cancel: &Cancel,
    read: impl Fn(&I, ReadLimits) -> Result<T, ImageError> + Sync,
) -> Result<Vec<Result<T, ImageError>>, Cancelled> {
    let limits = ReadLimits::default();
    let small = ReadLimits {
        pixels: SMALL_PX,
        ..limits
    };
    let read_small = |item: &I| {
        cancel.check()?;
        let outcome = read(item, small);
        if !is_large(&outcome) {
            stage.advance();
        }
        Ok(outcome)
    };
    let outcomes: Result<Vec<_>, Cancelled> = items.par_iter().map(read_small).collect();
    let mut outcomes = outcomes?;
    for (item, outcome) in items.iter().zip(&mut outcomes) {
        if is_large(outcome) {
            cancel.check()?;
            *outcome = read(item, limits);
            stage.advance();
        }
    }
    Ok(outcomes)
}

/// Whether a picture was refused for having more pixels than [`SMALL_PX`].
fn is_large<T>(outcome: &Result<T, ImageError>) -> bool {
    matches!(
        outcome,
        Err(ImageError::Refused {
            reason: Refusal::TooManyPixels { .. },
            ..
        })
    )
}

/// The pixels of a file; `name` stands in messages and tells the format where the bytes do not.
pub(super) fn decoded(bytes: &[u8], name: &str) -> Result<Image<Straight>, String> {
    read_image_from_memory(bytes, Path::new(name), ReadLimits::default())
        .map_err(|error| error.to_string())
}

fn picture(path: &Path, limits: ReadLimits) -> Result<NewPhoto, ImageError> {
    let bytes = read_limited(path, limits.file_bytes)?;
    let image = read_image_from_memory(&bytes, path, limits)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let size = (image.width(), image.height());
    Ok(NewPhoto::new(name, bytes.into(), size))
}

fn thumbnail(image: &Image<Straight>) -> Image<Straight> {
    let longer = image.width().max(image.height());
    if longer <= THUMBNAIL_PX {
        return image.clone();
    }
    let scale = f64::from(THUMBNAIL_PX) / f64::from(longer);
    scaled(&image.premultiplied(), scale).straight()
}
