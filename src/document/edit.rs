//! What can be done to a project.

use super::content::{Content, LONGEST_NAME, Photo, PhotoId, State};
use super::settings::{CrownSettings, VariationSettings};
use crate::base::Digest;
use crate::contour::HandPins;
use crate::paint::{BACKGROUND, TiledMask};
use std::sync::Arc;

/// One change. Several make a transaction.
#[derive(Debug, Clone, PartialEq)]
pub enum Edit {
    /// Gives the project another title.
    SetTitle(String),
    /// Adds photographs: all, or none when one is refused. The number of the first is the state's
    /// `next_photo` before.
    AddPhotos(Vec<NewPhoto>),
    /// Takes a photograph away, with its mask, its crown and its part in variations.
    RemovePhoto(PhotoId),
    /// Gives a photograph another name.
    RenamePhoto(PhotoId, String),
    /// Replaces the labels of a photograph: the mask that tools changed on a copy. What both share
    /// costs nothing.
    SetMask(PhotoId, Arc<TiledMask>),
    /// Replaces the settings of a crown.
    SetCrown(PhotoId, Box<CrownSettings>),
    /// Replaces the settings of the variations.
    SetVariation(Box<VariationSettings>),
    /// Sets the pins of a photograph, or leaves them to the segmenter again.
    SetPins(PhotoId, Option<HandPins>),
}

/// A photograph that is to be added.
#[derive(Debug, Clone, PartialEq)]
pub struct NewPhoto {
    photo: Photo,
    bytes: Arc<[u8]>,
}

impl NewPhoto {
    /// The file `bytes`, whatever format they are in, called `name` for people; `width` and `height`
    /// are those of the upright picture, pixels.
    pub fn new(name: impl Into<String>, bytes: Arc<[u8]>, (width, height): (u32, u32)) -> Self {
        let photo = Photo {
            name: name.into(),
            digest: Digest::of(&bytes),
            width,
            height,
        };
        Self { photo, bytes }
    }
}

/// An edit was refused; the project is unchanged.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EditError {
    /// The photograph is not there.
    #[error("there is no photo {}", .0.0)]
    NoPhoto(PhotoId),
    /// A mask does not fit its photograph.
    #[error("a mask of {mask_width}×{mask_height} does not fit a photograph of {width}×{height}")]
    MaskSize {
        /// Width of the mask.
        mask_width: u32,
        /// Height of the mask.
        mask_height: u32,
        /// Width of the photograph.
        width: u32,
        /// Height of the photograph.
        height: u32,
    },
    /// A value is out of its range; one line for the user.
    #[error("{0}")]
    Invalid(String),
}

/// The bytes of a photograph's file and their digest.
type Blob = (Digest, Arc<[u8]>);

/// `state` after `edit`, and the bytes of photographs that came with it.
pub(super) fn edited(state: &State, edit: Edit) -> Result<(State, Vec<Blob>), EditError> {
    let mut new = state.clone();
    let mut blobs = Vec::new();
    match edit {
        Edit::SetTitle(title) => content(&mut new).title = named(title)?,
        Edit::AddPhotos(photos) => {
            for NewPhoto { photo, bytes } in photos {
                blobs.push((photo.digest, bytes));
                add(&mut new, photo)?;
            }
        }
        Edit::RemovePhoto(id) => {
            known(state, id)?;
            let content = content(&mut new);
            content.photos.remove(&id);
            content.crowns.remove(&id);
            content.variation.forget(id);
            content.pins.remove(&id);
            new.masks.remove(&id);
        }
        Edit::RenamePhoto(id, name) => {
            known(state, id)?;
            if let Some(photo) = content(&mut new).photos.get_mut(&id) {
                photo.name = named(name)?;
            }
        }
        Edit::SetMask(id, mask) => {
            let Photo { width, height, .. } = *known(state, id)?;
            let (mask_width, mask_height) = (mask.width(), mask.height());
            if (mask_width, mask_height) != (width, height) {
                return Err(EditError::MaskSize {
                    mask_width,
                    mask_height,
                    width,
                    height,
                });
            }
            new.masks.insert(id, mask);
            // The content is as it was: 60 strokes a second need not look at it.
            return Ok((new, blobs));
        }
        Edit::SetCrown(id, settings) => {
            known(state, id)?;
            content(&mut new).crowns.insert(id, *settings);
        }
        Edit::SetVariation(settings) => content(&mut new).variation = *settings,
        Edit::SetPins(id, pins) => {
            known(state, id)?;
            let all = &mut content(&mut new).pins;
            match pins {
                Some(pins) => drop(all.insert(id, pins)),
                None => drop(all.remove(&id)),
            }
        }
    }
    match new.content.complaint() {
        Some(complaint) => Err(EditError::Invalid(complaint)),
        None => Ok((new, blobs)),
    }
}

fn content(state: &mut State) -> &mut Content {
    Arc::make_mut(&mut state.content)
}

fn known(state: &State, id: PhotoId) -> Result<&Photo, EditError> {
    state.content.photos.get(&id).ok_or(EditError::NoPhoto(id))
}

fn named(name: String) -> Result<String, EditError> {
    if name.len() > LONGEST_NAME {
        let reason = format!("a name is longer than {LONGEST_NAME} bytes");
        return Err(EditError::Invalid(reason));
    }
    Ok(name)
}

fn add(state: &mut State, photo: Photo) -> Result<(), EditError> {
    let photo = Photo {
        name: named(photo.name)?,
        ..photo
    };
    if photo.width == 0 || photo.height == 0 {
        return Err(EditError::Invalid("a photograph without pixels".to_owned()));
    }
    let pixels = u64::from(photo.width) * u64::from(photo.height);
    if pixels > 20_000 * 20_000 {
        let reason = "a photograph of more than 400 million pixels".to_owned();
        return Err(EditError::Invalid(reason));
    }
    let mask = TiledMask::filled(photo.width, photo.height, BACKGROUND);
    let content = content(state);
    let id = PhotoId(content.next_photo);
    content.next_photo += 1;
    content.photos.insert(id, photo);
    content.crowns.insert(id, CrownSettings::default());
    state.masks.insert(id, Arc::new(mask));
    Ok(())
}
