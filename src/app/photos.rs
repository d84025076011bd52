//! The pixels of the project's photographs, decoded beside the window.
//!
//! The project holds files as they came. The photograph that is shown is decoded whole; of the others
//! thumbnails are kept, of those that panels showed last as many as fit into a limit.

use super::dock::Pane;
use crate::base::Digest;
use crate::raster::{Image, Pyramid, Straight};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Longer side of a thumbnail, pixels: sharp at twice the usual density.
pub(super) const THUMBNAIL_PX: u32 = 160;

/// Most bytes of thumbnails: some 1,300. Those that were made first go first.
const MOST_THUMBNAIL_BYTES: usize = 128 << 20;

/// The decoded photographs, by the digest of their bytes.
#[derive(Debug, Default)]
pub(super) struct Photos {
    whole: Option<(Digest, Arc<Image<Straight>>)>,
    pyramid: Option<(Digest, Arc<Pyramid>)>,
    /// The one whose pixels were asked for last.
    asked: Option<Digest>,
    thumbnails: BTreeMap<Digest, Thumbnail>,
    /// Those that are there, in the order in which they were made.
    made: VecDeque<Digest>,
    made_bytes: usize,
    pub(super) missing: Missing,
}

/// A small picture, or why there is none.
#[derive(Debug, Clone)]
pub(super) enum Thumbnail {
    /// At most [`THUMBNAIL_PX`] wide and high.
    Ready(Arc<Image<Straight>>),
    /// The file cannot be decoded, and why.
    Failed(String),
}

impl Thumbnail {
    fn bytes(&self) -> usize {
        match self {
            Self::Ready(image) => size_of_val(image.pixels()),
            Self::Failed(reason) => reason.len(),
        }
    }
}

impl Photos {
    /// The pixels of the photograph with this digest, if they are there.
    pub(super) fn whole(&self, digest: Digest) -> Option<&Arc<Image<Straight>>> {
        let (of, image) = self.whole.as_ref()?;
        (*of == digest).then_some(image)
    }

    /// The thumbnail of the photograph with this digest, if it is there.
    pub(super) fn thumbnail(&self, digest: Digest) -> Option<&Thumbnail> {
        self.thumbnails.get(&digest)
    }

    /// Notes that the pixels of the photograph with this digest are needed; whether they must be asked
    /// for: those of one photograph at a time are kept or on their way.
    pub(super) fn ask(&mut self, digest: Digest) -> bool {
        self.asked.replace(digest) != Some(digest)
    }

    /// Whether the thumbnail of the photograph with this digest is there or comes with its pixels.
    pub(super) fn has_thumbnail(&self, digest: Digest) -> bool {
        self.thumbnails.contains_key(&digest) || self.is_on_its_way(digest)
    }

    fn is_on_its_way(&self, digest: Digest) -> bool {
        self.asked == Some(digest) && self.whole(digest).is_none()
    }

    /// The smaller versions of the photograph with this digest, if they are there.
    pub(super) fn pyramid(&self, digest: Digest) -> Option<&Arc<Pyramid>> {
        let (of, pyramid) = self.pyramid.as_ref()?;
        (*of == digest).then_some(pyramid)
    }

    pub(super) fn put_pyramid(&mut self, digest: Digest, pyramid: Arc<Pyramid>) {
        self.pyramid = Some((digest, pyramid));
    }

    pub(super) fn put_whole(&mut self, digest: Digest, image: Arc<Image<Straight>>) {
        self.whole = Some((digest, image));
    }

    pub(super) fn put_thumbnail(&mut self, digest: Digest, thumbnail: Thumbnail) {
        self.missing.lock().making.remove(&digest);
        self.made_bytes += thumbnail.bytes();
        self.made.push_back(digest);
        if let Some(older) = self.thumbnails.insert(digest, thumbnail) {
            self.made_bytes -= older.bytes();
            if let Some(at) = self.made.iter().position(|made| *made == digest) {
                self.made.remove(at);
            }
        }
        while self.made_bytes > MOST_THUMBNAIL_BYTES
            && let Some(oldest) = self.made.pop_front()
        {
            let gone = self.thumbnails.remove(&oldest);
            self.made_bytes -= gone.map_or(0, |gone| gone.bytes());
        }
    }
}

/// A photograph whose thumbnail is missing.
#[derive(Debug, Clone)]
pub(super) struct Wanted {
    pub(super) digest: Digest,
    pub(super) name: String,
    pub(super) bytes: Arc<[u8]>,
}

/// What the panels see and is not there; shared with the job that makes it.
#[derive(Debug, Clone, Default)]
pub(super) struct Missing(Arc<Mutex<MissingList>>);

#[derive(Debug, Default)]
pub(super) struct MissingList {
    /// What each panel sees now, in the order in which it is wanted.
    in_sight: BTreeMap<Pane, VecDeque<Wanted>>,
    /// What the job has taken and the window has not got yet.
    making: BTreeSet<Digest>,
    /// Whether a job is there.
    has_job: bool,
}

impl Missing {
    fn lock(&self) -> MutexGuard<'_, MissingList> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Replaces what a panel sees; the work for a new job if none is there.
    pub(super) fn see(&self, pane: Pane, wanted: Vec<Wanted>) -> Option<MissingWork> {
        let mut list = self.lock();
        let wanted = wanted.into_iter();
        let new = wanted.filter(|wanted| !list.making.contains(&wanted.digest));
        let new: VecDeque<Wanted> = new.collect();
        let needs_job = !new.is_empty() && !list.has_job;
        list.in_sight.insert(pane, new);
        list.has_job |= needs_job;
        drop(list);
        needs_job.then(|| MissingWork {
            missing: self.clone(),
            is_done: false,
        })
    }
}

/// A job's hold on the list: once it is gone another job may come.
pub(super) struct MissingWork {
    missing: Missing,
    is_done: bool,
}

impl MissingWork {
    /// Up to `most` of what is wanted now; nothing when all is done, and then no more will come.
    pub(super) fn next(&mut self, most: usize) -> Vec<Wanted> {
        let mut list = self.missing.lock();
        let list = &mut *list;
        let mut taken = Vec::new();
        for wanted in list.in_sight.values_mut() {
            while taken.len() < most
                && let Some(wanted) = wanted.pop_front()
            {
                // Another panel may see it, too.
                if list.making.insert(wanted.digest) {
                    taken.push(wanted);
                }
            }
        }
        self.is_done = taken.is_empty();
        list.has_job = !self.is_done;
        taken
    }
}

impl Drop for MissingWork {
    fn drop(&mut self) {
        if self.is_done {
            return;
        }
        let mut list = self.missing.lock();
        list.has_job = false;
        // What arrived is there, and what did not is missing again.
        list.making.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn digest(number: u32) -> Digest {
        Digest::of(&number.to_le_bytes())
    }

    fn wanted(numbers: std::ops::Range<u32>) -> Vec<Wanted> {
        let wanted = |number| Wanted {
            digest: digest(number),
            name: String::new(),
            bytes: Vec::new().into(),
        };
        numbers.map(wanted).collect()
    }

    #[test]
    fn only_so_many_thumbnails_are_kept_and_the_latest_of_them() {
        let mut photos = Photos::default();
        let image = Arc::new(Image::filled(160, 160, Straight([1, 2, 3, 4])));
        for number in 0..2000 {
            photos.put_thumbnail(digest(number), Thumbnail::Ready(Arc::clone(&image)));
            photos.put_thumbnail(digest(number), Thumbnail::Ready(Arc::clone(&image)));
        }
        let kept = MOST_THUMBNAIL_BYTES / (160 * 160 * 4);
        assert_eq!(photos.thumbnails.len(), kept);
        assert_eq!(photos.made.len(), kept);
        assert!(photos.thumbnail(digest(1999)).is_some() && photos.thumbnail(digest(0)).is_none());
    }

    #[test]
    fn one_job_makes_what_is_in_sight_last() {
        let missing = Missing::default();
        let mut job = missing.see(Pane::Pictures, wanted(0..9)).unwrap();
        assert_eq!(job.next(2).len(), 2);
        // Scrolled on: what went out of sight is not made, what is being made not asked for again.
        assert!(missing.see(Pane::Pictures, wanted(1..5)).is_none());
        assert!(missing.see(Pane::Exemplars, wanted(3..4)).is_none());
        let rest: Vec<Digest> = job.next(9).iter().map(|wanted| wanted.digest).collect();
        assert_eq!(rest, [digest(2), digest(3), digest(4)]);
        assert!(job.next(9).is_empty());
        // It is about to end: a new one may begin, and its end takes nothing from that.
        let mut next = missing.see(Pane::Pictures, wanted(7..8)).unwrap();
        assert_eq!(next.next(9).len(), 1);
        drop(job);
        assert!(missing.see(Pane::Pictures, wanted(7..8)).is_none());
        // A job that was cancelled leaves nothing behind.
        drop(next);
        assert!(missing.see(Pane::Pictures, wanted(7..8)).is_some());
    }
}
