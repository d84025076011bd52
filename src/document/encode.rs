//! Projects as bytes: what stands in which section.
//!
//! | Kind | Content | |
//! |---|---|---|
//! | `DOCU` | titles, photographs, settings: JSON | required |
//! | `MASK` | a photograph's number, then its labels in packed tiles | required, one a photograph |
//! | `BLOB` | the bytes of a photograph's file | required, one a content |
//! | `VIEW` | how it was looked at: JSON | optional |
//! | `HIST` | steps to undo and redo: postcard | optional |
//!
//! The history goes into the file so that yesterday's stroke can be undone today. Steps that need a
//! photograph which was taken out are left out with all that lie beyond them: who removes a picture
//! and saves may trust that it is gone.

use super::content::{Content, PhotoId, State};
use super::format::{FormatError, Section, container, number32, sections};
use super::history::{Step, digests};
use super::migrate::migrated;
use super::project::{Document, Snapshot};
use crate::base::{Cancel, Cancelled, Digest};
use crate::paint::TiledMask;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Most bytes of the history in a file; older steps are left out.
const HISTORY_BYTES: usize = 64 << 20;

/// Most memory that the masks of a project take once they are read, bytes: packed tiles of noise grow
/// 200 times, so a small file could ask for any memory.
const MOST_MASK_BYTES: usize = 4 << 30;

/// A project that was read.
#[derive(Debug)]
pub struct Decoded {
    /// The project.
    pub document: Document,
    /// What the user should be told, one line each.
    pub notes: Vec<String>,
}

/// The history as a file holds it.
#[derive(Serialize, Deserialize)]
struct SavedHistory<S> {
    undo: Vec<S>,
    redo: Vec<S>,
}

/// The file of a project. The same snapshot gives the same bytes.
///
/// # Errors
/// [`Cancelled`], looked at before each section.
pub fn encode(snapshot: &Snapshot, cancel: &Cancel) -> Result<Vec<u8>, Cancelled> {
    let mut all = without_photos(snapshot, cancel)?;
    for bytes in snapshot.blobs.values() {
        cancel.check()?;
        all.push(Section::new(b"BLOB", Arc::clone(bytes)));
    }
    Ok(container(&all))
}

/// The file of a project whose photographs lie elsewhere: for autosaves, which come often.
///
/// # Errors
/// [`Cancelled`], looked at before each section.
pub fn encode_without_photos(snapshot: &Snapshot, cancel: &Cancel) -> Result<Vec<u8>, Cancelled> {
    Ok(container(&without_photos(snapshot, cancel)?))
}

fn without_photos(snapshot: &Snapshot, cancel: &Cancel) -> Result<Vec<Section>, Cancelled> {
    let json = "plain data with text keys is JSON";
    let state = &snapshot.state;
    let content = serde_json::to_vec_pretty(&*state.content).expect(json);
    let view = serde_json::to_vec_pretty(&snapshot.view).expect(json);
    let mut all = vec![Section::new(b"DOCU", content).compressed()];
    for (PhotoId(id), mask) in &state.masks {
        cancel.check()?;
        let mut bytes = id.to_le_bytes().to_vec();
        bytes.extend(mask.to_bytes());
        // Uniform tiles repeat the same four bytes.
        all.push(Section::new(b"MASK", bytes).compressed());
    }
    cancel.check()?;
    all.push(Section::new(b"VIEW", view).compressed().optional());
    if let Some(history) = saved_history(snapshot) {
        all.push(Section::new(b"HIST", history).optional());
    }
    all.extend_from_slice(&snapshot.unknown);
    Ok(all)
}

/// The newest steps that need no other photographs than the project and keep within the limit.
fn saved_history(snapshot: &Snapshot) -> Option<Vec<u8>> {
    let present = digests(&snapshot.state);
    let mut bytes = 0;
    let mut newest = |steps: &[Arc<Step>]| {
        let kept = steps.iter().rev().take_while(|step| {
            bytes += step.memory_bytes();
            bytes <= HISTORY_BYTES && step.blobs().all(|digest| present.contains(digest))
        });
        steps.len() - kept.count()
    };
    let (undo, redo) = (newest(&snapshot.undo), newest(&snapshot.redo));
    let history = SavedHistory::<&Step> {
        undo: snapshot.undo[undo..].iter().map(|step| &**step).collect(),
        redo: snapshot.redo[redo..].iter().map(|step| &**step).collect(),
    };
    if history.undo.is_empty() && history.redo.is_empty() {
        return None;
    }
    Some(postcard::to_stdvec(&history).expect("plain data of known lengths fits into a Vec"))
}

/// The project in the bytes of a file.
///
/// `elsewhere` finds photographs that the file does not hold, by their digest; what it gives is
/// checked.
///
/// # Errors
/// [`FormatError`], one line for the user; never a panic, and never much more memory than the file.
pub fn decode(
    file: &[u8],
    elsewhere: impl Fn(Digest) -> Option<Arc<[u8]>>,
) -> Result<Decoded, FormatError> {
    let (version, all) = sections(file)?;
    let mut parts = Parts::default();
    for section in all {
        parts.take(section)?;
    }
    let content = parts
        .content
        .ok_or(FormatError::damaged("no DOCU section"))?;
    let content = content_of(&content, version)?;
    let mut notes = Vec::new();
    let wanted: BTreeSet<Digest> = content.photos.values().map(|photo| photo.digest).collect();
    let mut blobs = BTreeMap::new();
    for digest in wanted {
        let bytes = parts
            .blobs
            .remove(&digest)
            .or_else(|| elsewhere(digest).filter(|bytes| Digest::of(bytes) == digest));
        let bytes = bytes.ok_or(FormatError::damaged("a photograph is missing"))?;
        blobs.insert(digest, bytes);
    }
    let state = State {
        content: Arc::new(content),
        masks: parts.masks,
    };
    if let Some(complaint) = state.complaint() {
        return Err(FormatError::Damaged(complaint));
    }
    let view = parts
        .view
        .and_then(|json| serde_json::from_slice(&json).ok());
    let had_history = parts.history.is_some();
    let history = parts
        .history
        .and_then(|bytes| postcard::from_bytes(&bytes).ok());
    let history = history.unwrap_or(SavedHistory::<Step> {
        undo: Vec::new(),
        redo: Vec::new(),
    });
    let is_read = !history.undo.is_empty() || !history.redo.is_empty();
    let snapshot = Snapshot::new(state, blobs)
        .with_view(view.unwrap_or_default())
        .with_history(shared(history.undo), shared(history.redo))
        .with_unknown(parts.unknown);
    let (document, fits) = Document::restored(snapshot);
    if had_history && !(fits && is_read) {
        notes.push("its undo history could not be read and was left out".to_owned());
    }
    Ok(Decoded { document, notes })
}

fn shared(steps: Vec<Step>) -> Vec<Arc<Step>> {
    steps.into_iter().map(Arc::new).collect()
}

/// The sections of a file by what they are.
#[derive(Default)]
struct Parts {
    content: Option<Arc<[u8]>>,
    view: Option<Arc<[u8]>>,
    history: Option<Arc<[u8]>>,
    masks: BTreeMap<PhotoId, Arc<TiledMask>>,
    mask_bytes: usize,
    blobs: BTreeMap<Digest, Arc<[u8]>>,
    unknown: Vec<Section>,
}

impl Parts {
    fn take(&mut self, section: Section) -> Result<(), FormatError> {
        let twice = match &section.kind {
            b"DOCU" => self.content.replace(section.bytes).is_some(),
            b"VIEW" => self.view.replace(section.bytes).is_some(),
            b"HIST" => self.history.replace(section.bytes).is_some(),
            b"BLOB" => {
                let digest = Digest::of(&section.bytes);
                self.blobs.insert(digest, section.bytes).is_some()
            }
            b"MASK" => {
                let mut rest = &*section.bytes;
                let id = PhotoId(number32(&mut rest)?);
                let mask = TiledMask::from_bytes(rest);
                let mask = mask.map_err(|error| FormatError::Damaged(error.to_string()))?;
                self.mask_bytes += mask.memory_bytes();
                if self.mask_bytes > MOST_MASK_BYTES {
                    return Err(FormatError::TooLarge);
                }
                self.masks.insert(id, Arc::new(mask)).is_some()
            }
            _ if section.is_required => {
                let kind = section.name();
                return Err(FormatError::Unknown { kind });
            }
            _ => {
                self.unknown.push(section);
                false
            }
        };
        if twice {
            return Err(FormatError::damaged("a section stands twice"));
        }
        Ok(())
    }
}

fn content_of(json: &[u8], version: u32) -> Result<Content, FormatError> {
    let broken = |error: serde_json::Error| FormatError::Damaged(error.to_string());
    let value = serde_json::from_slice(json).map_err(broken)?;
    serde_json::from_value(migrated(value, version)?).map_err(broken)
}

#[cfg(test)]
mod tests;
