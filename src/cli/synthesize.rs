//! `boscage synthesize`: the foliage of a photograph as a texture of any size.

use super::failure::Failure;
use super::input::PhotoWithMask;
use super::session::Session;
use super::{Job, Stages};
use crate::base::{Digest, Seed};
use crate::raster::{Compression, Image, Mask, Straight, encode_png};
use crate::synth::{
    Exemplar, ExemplarSettings, MOST_LEVELS, SynthesisError, SynthesisSettings, Texture,
    patch_distance, repeated_share, texture_around,
};
use clap::Args;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Make a texture of the foliage of a photograph
///
/// The texture has the size asked for and looks like the part of the photograph inside the mask; its
/// leaves are as large as those of the photograph. Sky that shows through the crown is left out.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: boscage synthesize oak.jpg --mask oak.mask.png --width 1056 --height 320 \
                  --out foliage.png"
)]
pub(super) struct Flags {
    /// The photograph
    photo: PathBuf,
    /// The crown: white, or opaque where the file has alpha; of the photograph's size
    #[arg(long, value_name = "MASK")]
    mask: PathBuf,
    /// Width of the texture in pixels
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(1..=MOST_PIXELS))]
    width: u32,
    /// Height of the texture in pixels
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(1..=MOST_PIXELS))]
    height: u32,
    #[command(flatten)]
    foliage: FoliageFlags,
    /// Make the right edge continue at the left one
    #[arg(long)]
    tile: bool,
    /// Also write what the texture was made of: the foliage, its light evened out
    #[arg(long, value_name = "FILE.png")]
    exemplar: Option<PathBuf>,
}

/// Most pixels of a side.
const MOST_PIXELS: i64 = 8192;

/// Side of the squares that are looked for twice in the texture.
const REPEATED_SIDE: u32 = 32;

/// How foliage is taken from the photograph; shared by all commands that make it.
#[derive(Debug, Args)]
pub(super) struct FoliageFlags {
    /// Side of the pieces that the texture is made of, pixels of the photograph
    #[arg(long, default_value_t = SynthesisSettings::default().patch, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(8..=512))]
    patch: u32,
    /// Levels of detail
    #[arg(long, default_value_t = ExemplarSettings::default().levels, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_LEVELS)))]
    levels: u32,
    /// How much of the photograph's large-scale light is taken out, 0 to 1
    #[arg(long, default_value_t = ExemplarSettings::default().flatten, value_name = "SHARE", value_parser = share)]
    flatten: f32,
    /// Pixels taken off the edge of the mask
    #[arg(long, default_value_t = ExemplarSettings::default().erosion, value_name = "PIXELS")]
    erode: u8,
    /// Take colours of the sky for foliage as well
    #[arg(long)]
    keep_sky: bool,
    /// Take what occurs only once (a flower, a sign) for foliage as well
    #[arg(long)]
    keep_unique: bool,
}

/// A number from 0 to 1.
fn share(text: &str) -> Result<f32, String> {
    let number: Option<f32> = text.parse().ok();
    let inside = number.filter(|number| (0.0..=1.0).contains(number));
    inside.ok_or_else(|| "expected a number from 0 to 1".to_owned())
}

impl FoliageFlags {
    /// How the exemplar is to be prepared.
    pub(super) fn exemplar(&self) -> ExemplarSettings {
        ExemplarSettings {
            erosion: self.erode,
            without_sky: !self.keep_sky,
            without_unique: !self.keep_unique,
            flatten: self.flatten,
            levels: self.levels,
        }
    }

    /// How textures are to be made.
    pub(super) fn synthesis(&self) -> SynthesisSettings {
        SynthesisSettings {
            patch: self.patch,
            ..SynthesisSettings::default()
        }
    }
}

impl Job for Flags {
    fn stages(&self) -> Stages {
        &[
            ("read", 1.0),
            ("exemplar", 4.0),
            ("patches", 2.0),
            ("refine", 5.0),
            ("write", 1.0),
        ]
    }

    fn run(&self, session: &Session<'_>) -> Result<(), Failure> {
        let out = session.options.out()?;
        if !session.options.shard.contains(0) {
            return session.print_json(|| json!({"output": null, "seconds": session.seconds()}));
        }
        session.output.check([out])?;
        session.output.check(&self.exemplar)?;
        let pictures = PhotoWithMask::read(&self.photo, &self.mask, session)?;
        let settings = (
            self.foliage.exemplar(),
            self.synthesis(),
            [self.width, self.height],
        );
        let recipe = pictures.recipe("synthesize", &settings, session)?;
        let kept = self.exemplar.iter().map(PathBuf::as_path).chain([out]);
        let mut statistics = Value::Null;
        if !kept
            .into_iter()
            .all(|path| session.output.is_ready(path, recipe))
        {
            let (photo, mask) = pictures.decoded()?;
            statistics = self.make(session, &photo, &mask, (out, recipe))?;
        }
        session.print_json(|| {
            json!({
                "file": self.photo.display().to_string(),
                "mask": self.mask.display().to_string(),
                "output": out.display().to_string(),
                "size": [self.width, self.height],
                "settings": {"exemplar": self.foliage.exemplar(), "synthesis": self.synthesis()},
                "statistics": statistics,
                "seconds": session.seconds(),
            })
        })
    }
}

impl Flags {
    fn synthesis(&self) -> SynthesisSettings {
        SynthesisSettings {
            tiles_x: self.tile,
            ..self.foliage.synthesis()
        }
    }

    /// Makes and writes the texture; its statistics when they are asked for.
    fn make(
        &self,
        session: &Session<'_>,
        photo: &Image<Straight>,
        mask: &Mask,
        (out, recipe): (&Path, Digest),
    ) -> Result<Value, Failure> {
        let stage = session.progress.stage("exemplar", 1);
        let settings = self.foliage.exemplar();
        let exemplar = Exemplar::new(photo, mask, &settings, session.cancel)
            .map_err(|error| self.failure(error))?;
        stage.advance();
        drop(stage);
        let texture = texture_around(
            &exemplar,
            &Image::filled(self.width, self.height, None),
            &self.synthesis(),
            Seed(session.options.seed),
            |_| {},
            &session.progress,
            session.cancel,
        )
        .map_err(|error| self.failure(error))?;
        let stage = session.progress.stage("write", 1);
        let write = |path: &Path, image: &Image<Straight>| {
            let png = encode_png(image, Compression::Fast);
            session.cancel.check()?;
            session.output.write_item(path, png, recipe)
        };
        if let Some(path) = &self.exemplar {
            write(path, &exemplar.picture())?;
        }
        write(out, &texture.image)?;
        stage.advance();
        drop(stage);
        Ok(match session.options.json {
            true => statistics(&exemplar, &texture),
            false => Value::Null,
        })
    }

    fn failure(&self, error: SynthesisError) -> Failure {
        match error {
            SynthesisError::Cancelled(cancelled) => cancelled.into(),
            SynthesisError::SizesDiffer { .. } | SynthesisError::TooLittleFoliage { .. } => {
                Failure::of(self.mask.display(), error)
            }
        }
    }
}

/// How like the exemplar the texture is and how much it repeats itself.
fn statistics(exemplar: &Exemplar, texture: &Texture) -> Value {
    let picture = exemplar.picture();
    let foliage = picture.map(|pixel| pixel.alpha() > 0);
    let distance = patch_distance((&texture.image, None), (&picture, Some(&foliage)));
    json!({
        "foliage_pixels": foliage.count(),
        "patch_distance": distance.is_finite().then_some(distance),
        "repeated_share": repeated_share(texture, REPEATED_SIDE),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_numbers_from_0_to_1() {
        assert_eq!(share("0.25"), Ok(0.25));
        for text in ["-0.1", "1.5", "NaN", "half", ""] {
            assert!(share(text).is_err(), "{text}");
        }
    }
}
