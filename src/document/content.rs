//! The state of a project at one moment.

use super::settings::{CrownSettings, VariationSettings};
use crate::base::{Digest, Hasher};
use crate::contour::HandPins;
use crate::paint::TiledMask;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Most photographs of a project.
pub(super) const MOST_PHOTOS: usize = 10_000;

/// Longest name or title, bytes.
pub(super) const LONGEST_NAME: usize = 1000;

/// The largest side of a photograph, pixels.
const LONGEST_SIDE: u32 = 100_000;

/// A photograph's number within its project, never given twice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct PhotoId(pub u32);

/// A photograph of the project; its bytes lie beside it, once for each content.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Photo {
    /// The name of the file it came from, without folders, or what the user made of it.
    pub name: String,
    /// The digest of the file's bytes.
    pub digest: Digest,
    /// Width when upright, pixels.
    pub width: u32,
    /// Height when upright, pixels.
    pub height: u32,
}

/// All of a project that is small: what `DOCU` holds in a file.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Content {
    /// What the user calls the project.
    pub title: String,
    /// The photographs.
    pub photos: BTreeMap<PhotoId, Photo>,
    /// The crown of each photograph; all have one.
    pub crowns: BTreeMap<PhotoId, CrownSettings>,
    /// The variations.
    pub variation: VariationSettings,
    /// The number of the next photograph.
    pub next_photo: u32,
    /// Pins that were set by hand, in the normalised picture.
    pub pins: BTreeMap<PhotoId, HandPins>,
}

impl Content {
    /// What is wrong, if anything: one line.
    pub(super) fn complaint(&self) -> Option<String> {
        let names = self.photos.values().map(|photo| &photo.name);
        if names
            .chain([&self.title])
            .any(|name| name.len() > LONGEST_NAME)
        {
            return Some(format!("a name is longer than {LONGEST_NAME} bytes"));
        }
        if self.photos.len() > MOST_PHOTOS {
            return Some(format!("more than {MOST_PHOTOS} photographs"));
        }
        for (PhotoId(id), photo) in &self.photos {
            let sides = [photo.width, photo.height];
            if sides.iter().any(|side| !(1..=LONGEST_SIDE).contains(side)) {
                return Some(format!("photo {id} has no possible size"));
            }
            if *id >= self.next_photo {
                return Some(format!("photo {id} has a number that is to be given yet"));
            }
        }
        if !self.crowns.keys().eq(self.photos.keys()) {
            return Some("photographs and crowns do not match".to_owned());
        }
        if let Some((PhotoId(id), _)) = self
            .pins
            .iter()
            .find(|(id, pins)| !self.photos.contains_key(id) || !pins.is_sound())
        {
            return Some(format!("the pins of photo {id} are out of range"));
        }
        if let Some(photo) = self
            .variation
            .photos()
            .find(|id| !self.photos.contains_key(id))
        {
            return Some(format!(
                "variations name photo {}, which is not there",
                photo.0
            ));
        }
        let crowns = self.crowns.values().find_map(CrownSettings::complaint);
        crowns.or(self.variation.complaint()).map(str::to_owned)
    }
}

/// A project at one moment; copies share photographs and masks.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct State {
    pub(super) content: Arc<Content>,
    pub(super) masks: BTreeMap<PhotoId, Arc<TiledMask>>,
}

impl State {
    /// All that is small.
    pub fn content(&self) -> &Content {
        &self.content
    }

    /// The labels of a photograph, `None` when it is not there.
    pub fn mask(&self, photo: PhotoId) -> Option<&Arc<TiledMask>> {
        self.masks.get(&photo)
    }

    /// What is wrong, if anything: one line. Nothing ever should be.
    pub fn complaint(&self) -> Option<String> {
        if !self.masks.keys().eq(self.content.photos.keys()) {
            return Some("photographs and masks do not match".to_owned());
        }
        for (photo, mask) in self.content.photos.values().zip(self.masks.values()) {
            if (photo.width, photo.height) != (mask.width(), mask.height()) {
                return Some(format!("the mask of {} has another size", photo.name));
            }
            if !mask.is_canonical() {
                return Some(format!("the mask of {} is not canonical", photo.name));
            }
        }
        self.content.complaint()
    }

    /// The digest of everything that undo brings back: equal states have equal digests.
    pub fn digest(&self) -> Digest {
        let mut hasher = Hasher::new("boscage project").with(&packed_content(&self.content));
        for mask in self.masks.values() {
            hasher = hasher.with(mask.digest().bytes());
        }
        hasher.finish()
    }
}

/// The content in exact bytes, for digests and history (which must be told when a field comes: see
/// `history::MARK`).
pub(super) fn packed_content(content: &Content) -> Vec<u8> {
    postcard::to_stdvec(content).expect("plain data of known lengths fits into a Vec")
}
