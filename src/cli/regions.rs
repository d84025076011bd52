//! The regions of a mask that are inflated by themselves: the file of `--regions`.
//!
//! `{"regions": [{"label": 100, "k": 2}, {"label": 200, "k": "1+j", "depth_px": 20}]}`: `label` is
//! the grey value of the region in the mask.

use super::failure::Failure;
use super::input::grey;
use super::session::Session;
use crate::base::read_limited;
pub(super) use crate::batch::crown::{Region, usual_k};
use crate::crown::labelled_regions;
use crate::raster::{Image, Mask, Straight};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// The largest file of settings that is read.
const LARGEST_BYTES: u64 = 1 << 20;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RegionsFile {
    regions: Vec<Region>,
}

/// The regions that the file at `path` names: one at least, their depths numbers.
///
/// # Errors
/// [`Failure::BadInput`], naming the file.
pub(super) fn regions_from(path: &Path) -> Result<Vec<Region>, Failure> {
    let bytes = read_limited(path, LARGEST_BYTES)?;
    regions_in(&bytes).map_err(|reason| Failure::of(path.display(), reason))
}

/// The regions in the content of such a file.
pub(super) fn regions_in(bytes: &[u8]) -> Result<Vec<Region>, String> {
    let file = serde_json::from_slice(bytes).map_err(|error| error.to_string());
    let RegionsFile { regions } = file?;
    if regions.is_empty() {
        return Err("names no region".to_owned());
    }
    if !regions.iter().all(|region| region.depth_px.is_finite()) {
        return Err("depth_px must be a number".to_owned());
    }
    Ok(regions)
}

/// The pixels of each region in the picture of a mask, in the order of `regions`; `file` is where
/// the regions stand, `mask` where the picture does.
///
/// # Errors
/// [`Failure::BadInput`] when a region has no pixel or is named twice.
pub(super) fn region_masks(
    regions: &[Region],
    file: &Path,
    image: &Image<Straight>,
    mask: &Path,
    session: &Session<'_>,
) -> Result<Vec<Mask>, Failure> {
    let mut masks: BTreeMap<u8, Mask> = labelled_regions(&grey(image)).into_iter().collect();
    let mut found = Vec::new();
    for region in regions {
        let pixels = masks.remove(&region.label).ok_or_else(|| {
            let reason = format!(
                "no pixel of {} has the grey {}, or it is named twice",
                mask.display(),
                region.label
            );
            Failure::of(file.display(), reason)
        })?;
        found.push(pixels);
    }
    if let Some(left) = masks.keys().next() {
        let name = mask.display();
        let warning = format!("{name}: the grey {left} is in no region and left out");
        session.progress.warn(&warning);
    }
    Ok(found)
}

/// What the JSON file at `path` holds.
///
/// # Errors
/// [`Failure::BadInput`], naming the file.
pub(super) fn from_json<T: for<'a> Deserialize<'a>>(path: &Path) -> Result<T, Failure> {
    let bytes = read_limited(path, LARGEST_BYTES)?;
    serde_json::from_slice(&bytes).map_err(|error| Failure::of(path.display(), error))
}
