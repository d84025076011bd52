//! The crowns of a project: what `boscage crown` makes, from the photographs and masks that the
//! project holds. The studio's export and `boscage export PROJECT` begin with them.

use super::crown::{CrownRecipe, Region};
use super::failure::Failure;
use super::run::Run;
use crate::base::{Digest, Seed};
use crate::branches::leaf_name::LeafName;
use crate::crown::{SubCrown, Tangent};
use crate::document::{CrownSettings, Document, PhotoId, State};
use crate::paint::{TiledMask, grey_of};
use crate::pipeline::{CrownRequest, crown, crown_of_regions, is_crown, leaf_of_picture};
use crate::raster::{
    Compression, Image, ReadLimits, Straight, encode_grey_png, opaque_bounds,
    read_image_from_memory,
};
use crate::scene::Crown;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Where an export's own crowns lie, below its folder.
const SOURCES: &str = "crowns";

/// Where the photographs and masks of those lie, below that.
const PICTURES: &str = "photographs";

/// The photographs of a project that have a crown.
pub(crate) fn crowned(state: &State) -> Vec<PhotoId> {
    let ids = state.content().photos.keys().copied();
    let has_crown = |id: &PhotoId| {
        let mask = state.mask(*id);
        mask.is_some_and(|mask| mask.bounds(is_crown).is_some())
    };
    ids.filter(has_crown).collect()
}

/// Crowns of a project, to be made; they share its data.
pub(crate) struct ProjectCrowns {
    crowns: Vec<Planned>,
    leaf: Option<LeafName>,
}

/// A crown to be made.
struct Planned {
    /// Its name in files.
    name: String,
    photo_name: String,
    bytes: Arc<[u8]>,
    mask: Arc<TiledMask>,
    settings: CrownSettings,
}

impl ProjectCrowns {
    /// The crowns of the photographs `wanted`, all for `leaf` if one is chosen.
    pub(crate) fn of(document: &Document, wanted: &[PhotoId], leaf: Option<LeafName>) -> Self {
        let state = document.state();
        let mut names = BTreeSet::new();
        let planned = |id: &PhotoId| {
            let photo = state.content().photos.get(id)?;
            Some(Planned {
                name: file_name(&photo.name, &mut names),
                photo_name: photo.name.clone(),
                bytes: Arc::clone(document.photo_bytes(*id)?),
                mask: Arc::clone(state.mask(*id)?),
                settings: state.content().crowns.get(id)?.clone(),
            })
        };
        Self {
            crowns: wanted.iter().filter_map(planned).collect(),
            leaf,
        }
    }

    /// Whether there is none.
    pub(crate) fn is_empty(&self) -> bool {
        self.crowns.is_empty()
    }

    /// Makes those of the run's shard below `out`, unless they are there; the names and folders of
    /// all.
    ///
    /// # Errors
    /// [`Failure`], which names the photograph.
    pub(crate) fn make(
        &self,
        out: &Path,
        run: &Run<'_>,
    ) -> Result<Vec<(String, PathBuf)>, Failure> {
        let sources = out.join(SOURCES);
        let pictures = sources.join(PICTURES);
        let stage = run.progress.stage("make crowns", self.crowns.len() as u64);
        let mut folders = Vec::new();
        for (index, planned) in (0..).zip(&self.crowns) {
            let folder = sources.join(&planned.name);
            if run.shard.contains(index) {
                run.check()?;
                planned.make(self.leaf, &pictures, &folder, run)?;
            }
            folders.push((planned.name.clone(), folder));
            stage.advance();
        }
        Ok(folders)
    }
}

/// A name for files, told apart from those in `names`: letters, digits, `-` and `_` of `name`.
fn file_name(name: &str, names: &mut BTreeSet<String>) -> String {
    let stem = Path::new(name).file_stem().unwrap_or_default();
    let plain = |letter: char| match letter {
        '-' | '_' => letter,
        _ if letter.is_alphanumeric() => letter,
        _ => '_',
    };
    let kept: String = stem.to_string_lossy().chars().take(64).map(plain).collect();
    let kept = if kept.is_empty() {
        "crown".to_owned()
    } else {
        kept
    };
    let numbered = (2..).map(|number| format!("{kept}_{number}"));
    let mut all = std::iter::once(kept.clone()).chain(numbered);
    let free = all.find(|name| !names.contains(name)).unwrap_or(kept);
    names.insert(free.clone());
    free
}

impl Planned {
    /// Makes the crown and writes it to `folder`, its photograph and mask to `pictures`, unless it is
    /// there.
    fn make(
        &self,
        leaf: Option<LeafName>,
        pictures: &Path,
        folder: &Path,
        run: &Run<'_>,
    ) -> Result<(), Failure> {
        let failed = |error: &dyn std::fmt::Display| Failure::of(&self.photo_name, error);
        let photo: Image<Straight> = read_image_from_memory(
            &self.bytes,
            Path::new(&self.photo_name),
            ReadLimits::default(),
        )
        .map_err(|error| failed(&error))?;
        let request = CrownRequest::of(&self.settings).map_err(|error| failed(&error))?;
        let named = leaf_of_picture(&self.photo_name);
        let leaf = leaf.or(self.settings.leaf).or(named);
        let request = request.pictured(&photo, &self.mask, leaf.unwrap_or_default());
        let regions = self.regions(&request);
        let mask = encode_grey_png(&self.mask_picture(), Compression::Fast);
        let ending = Path::new(&self.photo_name).extension();
        let photo_file = pictures.join(&self.name);
        let photo_file = photo_file.with_extension(ending.unwrap_or_default());
        let mask_file = pictures.join(format!("{}.mask.png", self.name));
        run.output.write_same(&photo_file, &self.bytes)?;
        run.output.write_same(&mask_file, &mask)?;
        let recipe = CrownRecipe {
            photo: photo_file.display().to_string(),
            photo_digest: Digest::of(&self.bytes).to_string(),
            mask: Some(mask_file.display().to_string()),
            mask_digest: Digest::of(&mask).to_string(),
            segmenter: None,
            seed: request.seed.0,
            settings: request.settings,
            leaf,
            regions,
        };
        if recipe.kept(folder, &run.output).is_none() {
            let crown = self.crown(&photo, &recipe, run)?;
            let what = &self.photo_name;
            recipe.write(&crown, folder, &run.output, what, run.cancel)?;
        }
        Ok(())
    }

    /// The labels of foliage, ascending.
    fn labels(&self) -> Vec<u8> {
        let has = |label: &u8| self.mask.bounds(|own| own == *label).is_some();
        (0..=u8::MAX)
            .filter(|label| is_crown(*label))
            .filter(has)
            .collect()
    }

    /// The regions that are inflated by themselves, if there are several.
    fn regions(&self, request: &CrownRequest) -> Vec<Region> {
        let labels = self.labels();
        let Some(bounds) = self.mask.bounds(is_crown).filter(|_| labels.len() > 1) else {
            return Vec::new();
        };
        let usual = Tangent::Constant(CrownRequest::ROUND);
        let longest = f64::from(bounds.width.max(bounds.height));
        let shrunk = f64::from(request.settings.size) / longest;
        let region = |label: u8| {
            let depth = request.sub_crown_depths.get(&label).unwrap_or(&0.0);
            Region {
                label: grey_of(label),
                k: request.settings.k.clone().unwrap_or(usual.clone()),
                depth_px: depth * f64::from(bounds.width) * shrunk,
            }
        };
        labels.into_iter().map(region).collect()
    }

    /// The mask as a picture for `boscage crown`: white, or each region in its grey.
    fn mask_picture(&self) -> Image<u8> {
        let is_parted = self.labels().len() > 1;
        self.mask.image().map(|&label| match is_crown(label) {
            true if is_parted => grey_of(label),
            true => u8::MAX,
            false => 0,
        })
    }

    fn crown(
        &self,
        photo: &Image<Straight>,
        recipe: &CrownRecipe,
        run: &Run<'_>,
    ) -> Result<Crown, Failure> {
        let (settings, seed) = (&recipe.settings, Seed(recipe.seed));
        let (progress, cancel) = (crate::base::Progress::silent(), run.cancel);
        let all = self.mask.mask(is_crown);
        let made = if recipe.regions.is_empty() {
            crown(photo, &all, settings, seed, progress, cancel)
        } else {
            let bounds = opaque_bounds(&all).map_or(1, |b| b.width.max(b.height));
            let photo_px = f64::from(bounds) / f64::from(settings.size);
            let sub_crown = |(region, label): (&Region, u8)| SubCrown {
                mask: self.mask.mask(|own| own == label),
                tangent: region.k.clone(),
                depth_px: region.depth_px * photo_px,
            };
            let regions: Vec<SubCrown> = recipe
                .regions
                .iter()
                .zip(self.labels())
                .map(sub_crown)
                .collect();
            crown_of_regions(photo, &regions, settings, seed, progress, cancel)
        };
        made.map_err(|error| match error.is_cancelled() {
            true => Failure::Cancelled,
            false => Failure::of(&self.photo_name, error),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_are_plain_and_told_apart() {
        let mut names = BTreeSet::new();
        assert_eq!(file_name("old oak.jpg", &mut names), "old_oak");
        assert_eq!(file_name("old/oak?.png", &mut names), "oak_");
        assert_eq!(file_name("old oak.png", &mut names), "old_oak_2");
        assert_eq!(file_name("", &mut names), "crown");
        assert_eq!(file_name("..", &mut names), "crown_2");
    }
}
