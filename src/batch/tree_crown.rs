//! The crown of a tree that was made: its picture's own mask, inflated and grown over with its own
//! foliage.
//!
//! The folder is what `boscage crown` writes, so that `render` and `export` take it as any other. Its
//! recipe is the tree's: `boscage vary --recipe` makes both again.

use super::crown::{is_whole, write_crown};
use super::failure::Failure;
use super::output::recipe;
use super::records::{TreeCrownRecord, TreeRecord};
use super::run::Run;
use crate::base::{Digest, Progress, Seed};
use crate::branches::leaf_name::LeafName;
use crate::crown::Tangent;
use crate::export::{bled, crown_file_names};
use crate::pipeline::{CrownError, CrownSettings, crown, leaf_of_picture};
use crate::raster::{Image, Mask, Straight, dilated, eroded, opaque_bounds};
use crate::segment::Label;
use crate::variation::{Tree, is_evergreen, stands_straight};
use serde_json::json;
use std::path::{Path, PathBuf};

/// The folder of all crowns of a library, below it.
const FOLDER: &str = "crowns";

/// Height of a tree with its trunk, metres.
const HEIGHT_M: f64 = 12.0;

impl TreeCrownRecord {
    /// The crown of the tree `name` with `size` texels along a face.
    pub(crate) fn of(name: &str, size: u32) -> Self {
        Self {
            folder: format!("{FOLDER}/{name}"),
            size,
        }
    }
}

/// All files of the crown of the tree `name` below `out`.
pub(super) fn crown_files_of(out: &Path, name: &str) -> Vec<PathBuf> {
    let folder = out.join(FOLDER).join(name);
    let names = crown_file_names();
    names.iter().map(|file| folder.join(file)).collect()
}

/// A crown that is to lie in a folder.
pub(super) struct TreeCrown<'a> {
    /// The tree, which has a crown.
    record: &'a TreeRecord,
    size: u32,
    folder: PathBuf,
    digest: Digest,
}

impl<'a> TreeCrown<'a> {
    /// The crown of `record`, whose picture has the digest `of_tree`, below `out`; none if it has none.
    pub(super) fn of(record: &'a TreeRecord, of_tree: Digest, out: &Path) -> Option<Self> {
        let own = record.crown.as_ref()?;
        let digest = recipe("tree crown 3")
            .with(of_tree.bytes())
            .with(&own.size.to_le_bytes())
            .finish();
        Some(Self {
            record,
            size: own.size,
            // Not what the record says: others may have written that.
            folder: out.join(FOLDER).join(record.name()),
            digest,
        })
    }

    /// Whether it is there and may stay.
    pub(super) fn is_ready(&self, session: &Run<'_>) -> bool {
        is_whole(&self.folder, self.digest, &session.output)
    }

    /// Inflates `tree` and writes the crown.
    ///
    /// # Errors
    /// [`Failure`]; a tree that has no crown is bad input.
    pub(super) fn make(&self, tree: &Tree, session: &Run<'_>) -> Result<(), Failure> {
        let name = self.record.name();
        let of_crown = |reason: &dyn std::fmt::Display| {
            Failure::of(
                name,
                format!("its picture has no crown to inflate: {reason}"),
            )
        };
        let mask = crown_mask(tree);
        let photo = without_sky(&tree.image);
        let leaf = leaf_of(self.record, tree, session)?;
        let shown = leaf.unwrap_or_default();
        let Some(mut settings) = settings_of(tree, &mask, self.size, shown) else {
            return Err(of_crown(&"no pixel of it is foliage"));
        };
        if self.record.has_fronds {
            settings = tuft(settings);
        }
        let seed = Seed(self.record.seed).derive("crown", 0);
        let made = crown(
            &photo,
            &mask,
            &settings,
            seed,
            Progress::silent(),
            session.cancel,
        );
        let crown = made.map_err(|error: CrownError| match error.is_cancelled() {
            true => Failure::Cancelled,
            false => of_crown(&error),
        })?;
        let record = TreeRecord {
            crown: None,
            ..self.record.clone()
        };
        let mut recipe = json!({"tree": record, "seed": seed.0, "settings": settings});
        if let Some(leaf) = leaf {
            recipe["leaf"] = json!(leaf);
        }
        write_crown(
            &crown,
            (recipe, self.digest),
            &self.folder,
            &session.output,
            name,
            session.cancel,
        )
    }
}

/// How wide gaps between leaves may be that belong to the crown, as a share of the picture's side: what one
/// sees through them is the crown's inside.
const GAP: f64 = 0.012;

/// How light the inside of a crown is that one sees between its leaves.
const INSIDE: f32 = 0.45;

/// The leaves of a tree: fronds where it was made as a palm, or what the name of the picture tells that gave
/// most of its outline, or boughs where it looks like a conifer.
fn leaf_of(
    record: &TreeRecord,
    tree: &Tree,
    session: &Run<'_>,
) -> Result<Option<LeafName>, Failure> {
    if record.has_fronds {
        return Ok(Some(LeafName::Frond));
    }
    let weighed = record.exemplars.iter().zip(&record.contour_weights);
    let most = weighed.max_by(|a, b| a.1.total_cmp(b.1));
    let name = most.and_then(|(exemplar, _)| Path::new(&exemplar.file).file_name());
    let named = name.and_then(|name| leaf_of_picture(&name.to_string_lossy()));
    if named.is_some() {
        return Ok(named);
    }
    Ok(is_evergreen(tree, session.cancel)?.then_some(LeafName::Bough))
}

/// A palm's crown: its fronds go out to all sides, so its outline stands there in several directions, each
/// thin.
fn tuft(settings: CrownSettings) -> CrownSettings {
    const DIRECTIONS: u32 = 4;
    const THIN: f64 = 0.8;
    CrownSettings {
        copies: DIRECTIONS,
        k: Some(Tangent::Constant(THIN)),
        ..settings
    }
}

/// The pixels of a tree that are its crown, narrow gaps between leaves included.
fn crown_mask(tree: &Tree) -> Mask {
    let pixels = tree.image.pixels().iter().zip(tree.labels.pixels());
    let is_crown = pixels.map(|(pixel, label)| *label == Label::Crown && pixel.alpha() >= 128);
    let (width, height) = (tree.image.width(), tree.image.height());
    let seen: Mask = Image::from_pixels(width, height, is_crown.collect());
    let reach = (GAP * f64::from(width)).round().clamp(1.0, 60.0) as u8;
    eroded(&dilated(&seen, reach), reach)
}

/// The picture with the crown's dark inside in its gaps: foliage there is none, but depth.
fn without_sky(image: &Image<Straight>) -> Image<Straight> {
    let mut filled = bled(image);
    for pixel in filled.pixels_mut() {
        let cover = f32::from(pixel.alpha()) / 255.0;
        let light = cover + (1.0 - cover) * INSIDE;
        let [r, g, b, _] = pixel.0.map(|value| (f32::from(value) * light + 0.5) as u8);
        *pixel = Straight([r, g, b, 255]);
    }
    filled
}

/// How the crown `mask` of `tree` is made: as high above the ground and as high as it is in the picture.
/// `None` when it is empty.
fn settings_of(tree: &Tree, mask: &Mask, size: u32, leaf: LeafName) -> Option<CrownSettings> {
    let crown = opaque_bounds(mask)?;
    let whole = opaque_bounds(&tree.image.map(|pixel| pixel.alpha() >= 128))?;
    let metres = |pixels: u32| HEIGHT_M * f64::from(pixels) / f64::from(whole.height.max(1));
    let below = (whole.y + whole.height).saturating_sub(crown.y + crown.height);
    let settings = CrownSettings {
        size,
        photo_front: true,
        height_m: metres(crown.height),
        trunk_height_m: Some(metres(below)),
        round: stands_straight(tree),
        ..CrownSettings::default()
    };
    let [leaves, trunk] =
        [Label::Crown, Label::Trunk].map(|own| tree.labels.map(|label| *label == own));
    Some(settings.masked(&tree.image, [&leaves, &trunk], leaf))
}
