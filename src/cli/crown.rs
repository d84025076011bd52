//! `boscage crown`: a photograph and the mask of its crown → a crown to be drawn.

use super::failure::Failure;
use super::input::{PhotoWithMask, grey, mask_from};
use super::regions::{Region, region_masks, regions_from};
use super::session::Session;
use super::{Job, Stages};
use crate::base::{Digest, Seed};
use crate::batch::crown::{CrownRecipe, crown_record};
use crate::crown::{SubCrown, Tangent, relief};
use crate::export::{CrownRecord, crown_file_names};
use crate::pipeline::{CrownError, CrownSettings, crown, crown_of_regions};
use crate::raster::{Compression, Image, Mask, Straight, encode_grey16_png, opaque_bounds};
use crate::scene::Crown;
use clap::Args;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Make a crown in three dimensions from one photograph
///
/// Writes a folder: crown.json, the colour, height and radius of the crown as cubemaps
/// (color_px.png … radius_nz.png), its base mesh, and crown.glb, a textured mesh for other programs.
#[derive(Debug, Args)]
#[command(after_help = "Example: boscage crown oak.jpg --mask oak.mask.png --out oak-crown")]
pub(super) struct Flags {
    /// The photograph
    #[arg(required_unless_present = "recipe", value_name = "PHOTO")]
    photo: Option<PathBuf>,
    /// Its crown: white (or opaque) where it is
    #[arg(long, required_unless_present = "recipe", value_name = "MASK")]
    mask: Option<PathBuf>,
    /// Make the crown of a crown.json again, from the same files
    #[arg(long, value_name = "crown.json", conflicts_with_all = ["photo", "mask", "k", "regions", "photo_front", "relief", "size", "copies", "height", "trunk_height"])]
    recipe: Option<PathBuf>,
    /// How steeply the crown leaves its silhouette: a number or a formula in i and j, 0 … 1 from left
    /// and top of the crown [default: so that it is as deep as it is wide]
    #[arg(long, value_name = "EXPR", allow_hyphen_values = true)]
    k: Option<String>,
    /// Regions of the mask, by their grey values, each with its own k and depth, merged:
    /// {"regions":[{"label":100,"k":2},{"label":200,"k":"1+j","depth_px":20}]}; depth_px is towards
    /// the viewer, in pixels of a crown whose longer side has --size of them
    #[arg(long, value_name = "FILE.json", conflicts_with = "k")]
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
    pictures: PhotoWithMask,
    recipe: CrownRecipe,
    /// Where the regions stand, if they were typed.
    regions_file: Option<PathBuf>,
}

impl Flags {
    /// Reads the inputs, as typed or as a record tells.
    fn inputs(&self, session: &Session<'_>) -> Result<Inputs, Failure> {
        if let Some(path) = &self.recipe {
            return inputs_again(path, session);
        }
        let missing = |name| Failure::of(name, "is needed by this command");
        let photo_path = self.photo.as_ref().ok_or_else(|| missing("PHOTO"))?;
        let mask_path = self.mask.as_ref().ok_or_else(|| missing("--mask MASK"))?;
        let settings = self.settings()?;
        let bad = |error| Failure::BadInput(format!("{error}"));
        settings.check().map_err(bad)?;
        let regions = self.regions.as_deref().map(regions_from).transpose()?;
        let pictures = PhotoWithMask::read(photo_path, mask_path, session)?;
        let recipe = CrownRecipe {
            photo: photo_path.display().to_string(),
            photo_digest: pictures.photo.digest().to_string(),
            mask: mask_path.display().to_string(),
            mask_digest: pictures.mask.digest().to_string(),
            seed: session.options.seed,
            settings,
            regions: regions.unwrap_or_default(),
        };
        Ok(Inputs {
            pictures,
            recipe,
            regions_file: self.regions.clone(),
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

/// The inputs that the `crown.json` at `path` names, which must not have changed.
fn inputs_again(path: &Path, session: &Session<'_>) -> Result<Inputs, Failure> {
    let failed = |reason: String| Failure::of(path.display(), reason);
    let record = crown_record(path)?;
    let recipe: CrownRecipe = serde_json::from_value(record.recipe)
        .map_err(|error| failed(format!("its recipe is not known: {error}")))?;
    recipe
        .settings
        .check()
        .map_err(|error| failed(error.to_string()))?;
    let pictures = PhotoWithMask::read(recipe.photo.as_ref(), recipe.mask.as_ref(), session)?;
    let digests = [&recipe.photo_digest, &recipe.mask_digest];
    for (file, digest) in [&pictures.photo, &pictures.mask].into_iter().zip(digests) {
        if file.digest().to_string() != *digest {
            let reason = "is not the file that the crown was made from";
            return Err(Failure::of(file.path().display(), reason));
        }
    }
    Ok(Inputs {
        pictures,
        recipe,
        regions_file: None,
    })
}

impl Inputs {
    /// Makes the crown and writes it.
    fn made(&self, session: &Session<'_>, folder: &Path) -> Result<CrownRecord, Failure> {
        let crown = self.crown(session)?;
        let stage = session.progress.stage("write", 1);
        let what = self.pictures.photo.path().display().to_string();
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
        let (photo, image) = (
            self.pictures.photo.decoded()?,
            self.pictures.mask.decoded()?,
        );
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
        let (photo, image) = (
            self.pictures.photo.decoded()?,
            self.pictures.mask.decoded()?,
        );
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
        let (regions, mask) = (&self.recipe.regions, self.pictures.mask.path());
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

    fn failure(&self, error: &CrownError) -> Failure {
        match error {
            error if error.is_cancelled() => Failure::Cancelled,
            CrownError::Synthesis(_) => Failure::of(self.pictures.photo.path().display(), error),
            CrownError::Setting(_) => Failure::BadInput(error.to_string()),
            CrownError::Tangent(_) => match &self.regions_file {
                Some(file) => Failure::of(file.display(), error),
                None => Failure::of("--k", error),
            },
            _ => Failure::of(self.pictures.mask.path().display(), error),
        }
    }
}
