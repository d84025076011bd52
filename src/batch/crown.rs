//! What a crown was made from, and a crown as files: what `boscage crown` writes and the studio
//! keeps beside what it exports.

use super::failure::Failure;
use super::output::{Output, recipe};
use super::records::SegmenterRecord;
use crate::base::{Cancel, Digest, read_limited};
use crate::branches::leaf_name::LeafName;
use crate::crown::Tangent;
use crate::export::{CROWN_RECORD, CrownRecord, crown_file_names, crown_files};
use crate::pipeline::CrownSettings;
use crate::scene::Crown;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::path::Path;

/// What a crown was made from; stands in its `crown.json` as `recipe`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct CrownRecipe {
    pub(crate) photo: String,
    pub(crate) photo_digest: String,
    /// The mask's file; none where the crown was found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) mask: Option<String>,
    /// Digest of that file, or of the mask that was found.
    pub(crate) mask_digest: String,
    /// What found the crown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) segmenter: Option<SegmenterRecord>,
    pub(crate) seed: u64,
    pub(crate) settings: CrownSettings,
    /// The leaves that it is drawn and exported with, unless others are asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) leaf: Option<LeafName>,
    /// Which greys of the mask are inflated by themselves; none: all of it at once.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) regions: Vec<Region>,
}

/// A region of a mask that is inflated by itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Region {
    /// Its grey value in the mask.
    pub(crate) label: u8,
    #[serde(default = "usual_k")]
    pub(crate) k: Tangent,
    /// How far it is shifted towards the viewer, pixels of the mask as it is inflated.
    #[serde(default)]
    pub(crate) depth_px: f64,
}

/// The k of a mask or region of which nobody says more.
pub(crate) fn usual_k() -> Tangent {
    Tangent::Constant(2.0)
}

impl CrownRecipe {
    /// The digest of all that goes into the files; where the inputs lie has no part in it.
    pub(crate) fn digest(&self) -> Digest {
        let settings = serde_json::to_vec(&self.settings)
            .unwrap_or_else(|_| unreachable!("settings hold numbers only"));
        let regions = serde_json::to_vec(&self.regions)
            .unwrap_or_else(|_| unreachable!("regions hold numbers and formulas"));
        let made = recipe("crown").with(&regions);
        let made = match self.leaf {
            Some(leaf) => made.with(format!("{leaf:?}").as_bytes()),
            None => made,
        };
        made.with(self.photo_digest.as_bytes())
            .with(self.mask_digest.as_bytes())
            .with(&self.seed.to_le_bytes())
            .with(&settings)
            .finish()
    }

    /// The record of the crown in `folder`, when what is there may stay and is what would be made.
    pub(crate) fn kept(&self, folder: &Path, output: &Output) -> Option<CrownRecord> {
        let digest = self.digest();
        if !is_whole(folder, digest, output) {
            return None;
        }
        let record = crown_record(&folder.join(CROWN_RECORD)).ok()?;
        let recipe: Self = serde_json::from_value(record.recipe.clone()).ok()?;
        (recipe.digest() == digest).then_some(record)
    }

    /// Writes `crown` to `folder`, see [`write_crown`].
    ///
    /// # Errors
    /// [`Failure`]; one about the crown itself names `what`.
    pub(crate) fn write(
        &self,
        crown: &Crown,
        folder: &Path,
        output: &Output,
        what: &str,
        cancel: &Cancel,
    ) -> Result<CrownRecord, Failure> {
        let recipe = json!(self);
        let record = CrownRecord::new(crown, recipe.clone());
        write_crown(crown, (recipe, self.digest()), folder, output, what, cancel)?;
        Ok(record)
    }
}

/// Whether all files of a crown are in `folder`, may stay, and were written under `digest`.
pub(super) fn is_whole(folder: &Path, digest: Digest, output: &Output) -> bool {
    let names = crown_file_names();
    let mut paths = names.iter().map(|name| folder.join(name));
    paths.all(|path| {
        let is_picture = path.extension().is_some_and(|ending| ending == "png");
        path.is_file() && (!is_picture || output.is_ready(&path, digest))
    })
}

/// Writes `crown` with its `recipe` to `folder`, under a digest: nothing before all of it is there, the
/// record last.
///
/// # Errors
/// [`Failure`]; one about the crown itself names `what`.
pub(super) fn write_crown(
    crown: &Crown,
    (recipe, digest): (Value, Digest),
    folder: &Path,
    output: &Output,
    what: &str,
    cancel: &Cancel,
) -> Result<(), Failure> {
    let files = crown_files(crown, recipe, cancel);
    let files = files.map_err(|error| Failure::of_crown_files(what, &error))?;
    let files = files.into_iter();
    let files = files.map(|(name, bytes)| (folder.join(name), bytes));
    output.write_items(files.collect(), digest)
}

/// The record in a `crown.json`.
///
/// # Errors
/// [`Failure::BadInput`] naming the file.
pub(crate) fn crown_record(path: &Path) -> Result<CrownRecord, Failure> {
    /// Far more than any record.
    const LARGEST_BYTES: u64 = 1 << 24;
    let bytes = read_limited(path, LARGEST_BYTES)?;
    CrownRecord::read(&bytes).map_err(|error| Failure::of(path.display(), error))
}
