//! `boscage crown`: a photograph and the mask of its crown → a crown to be drawn.

use super::failure::Failure;
use super::input::{PictureFile, grey, mask_from};
use super::regions::{Region, region_masks, regions_from};
use super::segmenter::{SegmenterFlags, failed, provenance_json};
use super::session::Session;
use super::{Job, Stages};
use crate::base::{Digest, Seed};
use crate::batch::crown::{CrownRecipe, crown_record};
use crate::batch::records::SegmenterRecord;
use crate::branches::leaf_name::LeafName;
use crate::crown::{SubCrown, Tangent, relief};
use crate::export::{CrownRecord, crown_file_names};
use crate::pipeline::{CrownError, CrownSettings, crown, crown_of_regions, leaf_of_picture};
use crate::raster::{Compression, Image, Mask, Straight, encode_grey16_png, opaque_bounds};
use crate::scene::Crown;
use crate::segment::{
    Label, Provenance, Segmented, Segmenter, Source, crown_count, grey_from_labels,
};
use clap::Args;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Make a crown in three dimensions from one photograph
///
/// Writes a folder: crown.json, the colour, height and radius of the crown as cubemaps
/// (color_px.png … radius_nz.png), its base mesh, and crown.glb, a textured mesh for other programs.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  boscage crown oak.jpg --mask oak.mask.png --out oak-crown
  boscage crown oak.jpg --out oak-crown")]
pub(super) struct Flags {
    /// The photograph
    #[arg(required_unless_present = "recipe", value_name = "PHOTO")]
    photo: Option<PathBuf>,
    /// Its crown: white (or opaque) where it is [default: what the learned segmenter finds]
    #[arg(long, value_name = "MASK")]
    mask: Option<PathBuf>,
    #[command(flatten)]
    segmenter: SegmenterFlags,
    /// Make the crown of a crown.json again, from the same files
    #[arg(long, value_name = "crown.json", conflicts_with_all = ["photo", "mask", "k", "regions", "photo_front", "relief", "size", "copies", "height", "trunk_height", "segmenter"])]
    recipe: Option<PathBuf>,
    /// How steeply the crown leaves its silhouette: a number or a formula in i and j, 0 … 1 from left
    /// and top of the crown [default: so that it is as deep as it is wide]
    #[arg(long, value_name = "EXPR", allow_hyphen_values = true)]
    k: Option<String>,
    /// Regions of the mask, by their grey values, each with its own k and depth, merged:
    /// {"regions":[{"label":100,"k":2},{"label":200,"k":"1+j","depth_px":20}]}; depth_px is towards
    /// the viewer, in pixels of a crown whose longer side has --size of them
    #[arg(
        long,
        value_name = "FILE.json",
        conflicts_with = "k",
        requires = "mask"
    )]
    regions: Option<PathBuf>,
    /// Keep the photograph on the front and let the rest grow out of it
    #[arg(long)]
    photo_front: bool,
    /// How far the relief moves the surface, as a share of the radius [default: 0.25]
    #[arg(long, value_name = "RHO")]
    relief: Option<f64>,
    /// Texels along a face of the cubemaps [default: 256]
    #[arg(long, value_name = "N")]
    size: Option<u32>,
    /// Copies turned about the trunk, for crowns that would be flat from the side [default: 1]
    #[arg(long, value_name = "N")]
    copies: Option<u32>,
    /// Height of the crown [default: 10]
    #[arg(long, value_name = "METRES")]
    height: Option<f64>,
    /// Height of the bare trunk below it [default: a fifth of the crown's]
    #[arg(long, value_name = "METRES")]
    trunk_height: Option<f64>,
    /// Shape of its leaves, for `render` and `export` [default: by the photograph's name, or ovate]
    #[arg(long, value_enum, value_name = "SHAPE")]
    leaf: Option<LeafName>,
    /// Also write the relief of the front as the photograph shows it: relief.png, 16-bit grey of the
    /// photograph's size, 0.5 on the silhouette and outside, a quarter for the step from the crown's
    /// darkest to its lightest
    #[arg(long, value_name = "DIR")]
    dump: Option<PathBuf>,
}

/// What `--dump` writes.
const RELIEF_FILE: &str = "relief.png";

impl Job for Flags {
    fn stages(&self) -> Stages {
        &[
            ("read", 1.0),
            ("shape", 4.0),
            ("foliage", 20.0),
            ("relief", 1.0),
            ("write", 2.0),
        ]
    }

    fn run(&self, session: &Session<'_>) -> Result<(), Failure> {
        let folder = session.options.out()?;
        if !session.options.shard.contains(0) {
            return session.print_json(|| json!({"output": null, "seconds": session.seconds()}));
        }
        let paths: Vec<PathBuf> = crown_file_names().iter().map(|n| folder.join(n)).collect();
        let relief_file = self.dump.as_deref().map(|dump| dump.join(RELIEF_FILE));
        session.output.check(paths.iter().chain(&relief_file))?;
        let inputs = self.inputs(session)?;
        let digest = inputs.recipe.digest();
        let record = inputs.recipe.kept(folder, &session.output);
        let is_kept = record.is_some();
        let record = match record {
            Some(record) => record,
            None => inputs.made(session, folder)?,
        };
        if let Some(file) = &relief_file {
            inputs.dump(session, file, digest)?;
        }
        session.print_json(|| {
            json!({
                "output": folder.display().to_string(),
                "relief": relief_file.as_ref().map(|file| file.display().to_string()),
                "mask": inputs.mask.json(),
                "kept": is_kept,
                "size": record.size,
                "center_m": record.center_m,
                "radius_min_m": record.radius_min_m,
                "radius_max_m": record.radius_max_m,
                "seconds": session.seconds(),
            })
        })
    }
}

/// The files of a crown, read, and all that is to be done with them.
struct Inputs {
    photo: PictureFile,
    mask: CrownMask,
    recipe: CrownRecipe,
    /// Where the regions stand, if they were typed.
    regions_file: Option<PathBuf>,
}

impl Flags {
    /// Reads the inputs, as typed or as a record tells.
    fn inputs(&self, session: &Session<'_>) -> Result<Inputs, Failure> {
        if let Some(path) = &self.recipe {
            return self.inputs_again(path, session);
        }
        let missing = |name| Failure::of(name, "is needed by this command");
        let photo_path = self.photo.as_ref().ok_or_else(|| missing("PHOTO"))?;
        let settings = self.settings()?;
        let bad = |error| Failure::BadInput(format!("{error}"));
        settings.check().map_err(bad)?;
        let regions = self.regions.as_deref().map(regions_from).transpose()?;
        let stage = session.progress.stage("read", 1);
        let photo = PictureFile::read(photo_path)?;
        let (mask, segmenter) = match &self.mask {
            Some(path) => (CrownMask::File(PictureFile::read(path)?), None),
            None => {
                let segmenter = self.segmenter.checked(session.cancel)?;
                let mask = CrownMask::found(&photo, segmenter.as_ref(), session)?;
                (mask, Some(SegmenterRecord::of(segmenter.as_ref())))
            }
        };
        let name = photo_path.file_name();
        let named = name.and_then(|name| leaf_of_picture(&name.to_string_lossy()));
        let leaf = self.leaf.or(named);
        let settings = mask.pictured(settings, &photo, leaf.unwrap_or_default())?;
        drop(stage);
        let recipe = CrownRecipe {
            photo: photo_path.display().to_string(),
            photo_digest: photo.digest().to_string(),
            mask: self.mask.as_ref().map(|path| path.display().to_string()),
            mask_digest: mask.digest().to_string(),
            segmenter,
            seed: session.options.seed,
            settings,
            leaf,
            regions: regions.unwrap_or_default(),
        };
        Ok(Inputs {
            photo,
            mask,
            recipe,
            regions_file: self.regions.clone(),
        })
    }

    /// The inputs that the `crown.json` at `path` names, which must not have changed.
    fn inputs_again(&self, path: &Path, session: &Session<'_>) -> Result<Inputs, Failure> {
        let refused = |reason: String| Failure::of(path.display(), reason);
        let record = crown_record(path)?;
        if record.recipe.get("tree").is_some() {
            let reason = "is the crown of a tree: make it again with boscage vary --recipe";
            return Err(refused(reason.to_owned()));
        }
        let recipe: CrownRecipe = serde_json::from_value(record.recipe)
            .map_err(|error| refused(format!("its recipe is not known: {error}")))?;
        recipe
            .settings
            .check()
            .map_err(|error| refused(error.to_string()))?;
        let photo = PictureFile::read(recipe.photo.as_ref())?;
        let changed = |file: &PictureFile| {
            let reason = "is not the file that the crown was made from";
            Err(Failure::of(file.path().display(), reason))
        };
        if photo.digest().to_string() != recipe.photo_digest {
            return changed(&photo);
        }
        let mask = match (&recipe.mask, &recipe.segmenter) {
            (Some(mask), _) => CrownMask::File(PictureFile::read(mask.as_ref())?),
            (None, Some(record)) => {
                let segmenter = self.segmenter.recorded(record, path, session.cancel)?;
                CrownMask::found(&photo, segmenter.as_ref(), session)?
            }
            (None, None) => return Err(refused("its recipe names no mask".to_owned())),
        };
        if mask.digest().to_string() != recipe.mask_digest {
            return match &mask {
                CrownMask::File(file) => changed(file),
                CrownMask::Found { .. } => {
                    let reason = "its crown is found otherwise on this machine";
                    Err(refused(reason.to_owned()))
                }
            };
        }
        Ok(Inputs {
            photo,
            mask,
            recipe,
            regions_file: None,
        })
    }

    fn settings(&self) -> Result<CrownSettings, Failure> {
        let default = CrownSettings::default();
        let k = self.k.as_deref().map(Tangent::parse).transpose();
        Ok(CrownSettings {
            size: self.size.unwrap_or(default.size),
            k: k.map_err(|error| Failure::of("--k", error))?,
            photo_front: self.photo_front,
            copies: self.copies.unwrap_or(default.copies),
            rho: self.relief.unwrap_or(default.rho),
            height_m: self.height.unwrap_or(default.height_m),
            trunk_height_m: self.trunk_height,
            ..default
        })
    }
}

/// Where the crown is.
enum CrownMask {
    /// A file says so.
    File(PictureFile),
    /// A segmenter says so.
    Found {
        picture: Image<Straight>,
        /// The stem's pixels.
        trunk: Mask,
        provenance: Provenance,
    },
}

impl CrownMask {
    /// The crown that `segmenter` sees in `photo`.
    fn found(
        photo: &PictureFile,
        segmenter: &dyn Segmenter,
        session: &Session<'_>,
    ) -> Result<Self, Failure> {
        let picture = photo.decoded()?;
        let path = photo.path();
        let Segmented { labels, provenance } = segmenter
            .segmented(&picture, session.cancel)
            .map_err(|error| failed(path, error))?;
        let is_cut_out = picture.pixels().iter().any(|pixel| pixel.alpha() < 128);
        let is_guess = provenance.source == Source::Classical && !is_cut_out;
        if is_guess || crown_count(&labels) == 0 {
            let sure = provenance
                .confidence
                .map_or_else(String::new, |confidence| {
                    format!(" (confidence {confidence:.2})")
                });
            let reason =
                format!("no crown was found in it with enough confidence{sure}; give a --mask");
            return Err(Failure::of(path.display(), reason));
        }
        if let (Source::Learned, Some(confidence)) = (provenance.source, provenance.confidence) {
            session.progress.warn(&format!(
                "{}: its crown was found by the learned segmenter, confidence {confidence:.2}; \
                 boscage segment shows it",
                path.display()
            ));
        }
        let crown = labels.map(|&label| match label {
            Label::Crown => Label::Crown,
            _ => Label::Background,
        });
        let picture = grey_from_labels(&crown).map(|&grey| Straight([grey, grey, grey, 255]));
        Ok(Self::Found {
            picture,
            trunk: labels.map(|&label| label == Label::Trunk),
            provenance,
        })
    }

    /// Its picture.
    fn picture(&self) -> Result<Image<Straight>, Failure> {
        match self {
            Self::File(file) => file.decoded(),
            Self::Found { picture, .. } => Ok(picture.clone()),
        }
    }

    /// `settings` with what the picture shows beside the crown's outline, where that was found: see
    /// [`CrownSettings::pictured`].
    fn pictured(
        &self,
        settings: CrownSettings,
        photo: &PictureFile,
        leaf: LeafName,
    ) -> Result<CrownSettings, Failure> {
        let Self::Found { picture, trunk, .. } = self else {
            return Ok(settings);
        };
        let crown = mask_from(picture);
        Ok(settings.masked(&photo.decoded()?, [&crown, trunk], leaf))
    }

    /// The digest of the file, or of the pixels.
    fn digest(&self) -> Digest {
        match self {
            Self::File(file) => file.digest(),
            Self::Found { picture, .. } => Digest::of(bytemuck::cast_slice(picture.pixels())),
        }
    }

    fn json(&self) -> Value {
        match self {
            Self::File(file) => json!({"file": file.path().display().to_string()}),
            Self::Found { provenance, .. } => provenance_json(provenance),
        }
    }
}

impl Inputs {
    /// Makes the crown and writes it.
    fn made(&self, session: &Session<'_>, folder: &Path) -> Result<CrownRecord, Failure> {
        let crown = self.crown(session)?;
        let stage = session.progress.stage("write", 1);
        let what = self.photo.path().display().to_string();
        let (output, cancel) = (&session.output, session.cancel);
        let record = self.recipe.write(&crown, folder, output, &what, cancel)?;
        stage.advance();
        Ok(record)
    }

    /// Writes the relief of the front to `file`.
    fn dump(&self, session: &Session<'_>, file: &Path, digest: Digest) -> Result<(), Failure> {
        if session.output.is_ready(file, digest) {
            return Ok(());
        }
        let (photo, image) = (self.photo.decoded()?, self.mask.picture()?);
        let regions = &self.recipe.regions;
        let mask = match regions.is_empty() {
            true => mask_from(&image),
            false => grey(&image).map(|grey| regions.iter().any(|region| region.label == *grey)),
        };
        let heights = relief(&photo, &mask, &self.recipe.settings.relief, session.cancel)?;
        let grey = |&height: &f32| (65_535.0 * (0.5 + 0.25 * height.clamp(-2.0, 2.0)) + 0.5) as u16;
        let png = encode_grey16_png(&heights.map(grey), Compression::Fast);
        session.output.write_item(file, png, digest)
    }

    fn crown(&self, session: &Session<'_>) -> Result<Crown, Failure> {
        let (photo, image) = (self.photo.decoded()?, self.mask.picture()?);
        let CrownRecipe { seed, settings, .. } = &self.recipe;
        let (seed, progress, cancel) = (Seed(*seed), session.progress, session.cancel);
        let made = if self.recipe.regions.is_empty() {
            crown(&photo, &mask_from(&image), settings, seed, progress, cancel)
        } else {
            let regions = self.sub_crowns(&image, session)?;
            crown_of_regions(&photo, &regions, settings, seed, progress, cancel)
        };
        made.map_err(|error| self.failure(&error))
    }

    /// The regions of the mask's picture `image`.
    fn sub_crowns(
        &self,
        image: &Image<Straight>,
        session: &Session<'_>,
    ) -> Result<Vec<SubCrown>, Failure> {
        let (regions, mask) = (&self.recipe.regions, self.mask_path());
        let file = self.regions_file.as_deref().unwrap_or(mask);
        let masks = region_masks(regions, file, image, mask, session)?;
        let is_named = |grey: &u8| regions.iter().any(|region| region.label == *grey);
        let bounds = opaque_bounds(&grey(image).map(is_named));
        let longest = bounds.map_or(1, |bounds| bounds.width.max(bounds.height));
        let photo_px = f64::from(longest) / f64::from(self.recipe.settings.size);
        let sub_crown = |(region, mask): (&Region, Mask)| SubCrown {
            mask,
            tangent: region.k.clone(),
            depth_px: region.depth_px * photo_px,
        };
        Ok(regions.iter().zip(masks).map(sub_crown).collect())
    }

    /// The file to name when something is wrong with the mask.
    fn mask_path(&self) -> &Path {
        match &self.mask {
            CrownMask::File(file) => file.path(),
            CrownMask::Found { .. } => self.photo.path(),
        }
    }

    fn failure(&self, error: &CrownError) -> Failure {
        match error {
            error if error.is_cancelled() => Failure::Cancelled,
            CrownError::Synthesis(_) => Failure::of(self.photo.path().display(), error),
            CrownError::Setting(_) => Failure::BadInput(error.to_string()),
            CrownError::Tangent(_) => match &self.regions_file {
                Some(file) => Failure::of(file.display(), error),
                None => Failure::of("--k", error),
            },
            _ => Failure::of(self.mask_path().display(), error),
        }
    }
}
