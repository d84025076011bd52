//! `boscage cubemap`: the foliage of a photograph all around a crown.

use super::failure::Failure;
use super::input::{PhotoWithMask, PictureFile};
use super::session::Session;
use super::synthesize::FoliageFlags;
use super::{Job, Stages};
use crate::base::{Digest, Seed};
use crate::pipeline::{CrownError, CrownSettings, colored_surface};
use crate::raster::{Compression, CubeFace, Cubemap, Image, Mask, Straight, encode_png};
use crate::synth::{CubemapSettings, edge_statistic};
use clap::Args;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Make a cubemap of the foliage of a photograph
///
/// Writes px.png, nx.png, py.png, ny.png, pz.png and nz.png into a folder: faces as in glTF, KTX and
/// Vulkan, +Y up, the photographer at +Z. Leaves are as large as in the photograph, also around tall
/// crowns; no edge or corner of the cube shows.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: boscage cubemap oak.jpg --mask oak.mask.png --photo-front --out oak-foliage"
)]
pub(super) struct Flags {
    /// The photograph
    photo: PathBuf,
    /// The crown: white, or opaque where the file has alpha; of the photograph's size
    #[arg(long, value_name = "MASK")]
    mask: PathBuf,
    /// Texels along a side of a face, a multiple of 16
    #[arg(long, default_value_t = CubemapSettings::default().size, value_name = "N", value_parser = clap::value_parser!(u32).range(32..=1024))]
    size: u32,
    /// Keep the photograph on the front; the rest joins it
    #[arg(long)]
    photo_front: bool,
    /// Lay the texture as around a ball, whatever the crown's shape
    #[arg(long)]
    ball: bool,
    #[command(flatten)]
    foliage: FoliageFlags,
}

impl Job for Flags {
    fn stages(&self) -> Stages {
        &[
            ("read", 1.0),
            ("shape", 4.0),
            ("foliage", 20.0),
            ("write", 1.0),
        ]
    }

    fn run(&self, session: &Session<'_>) -> Result<(), Failure> {
        let folder = session.options.out()?;
        if !session.options.shard.contains(0) {
            return session.print_json(|| json!({"output": null, "seconds": session.seconds()}));
        }
        let crown = self.crown();
        crown
            .check()
            .map_err(|error| Failure::BadInput(error.to_string()))?;
        let paths = CubeFace::ALL.map(|face| folder.join(format!("{}.png", face.name())));
        session.output.check(&paths)?;
        let pictures = PhotoWithMask::read(&self.photo, &self.mask, session)?;
        let recipe = pictures.recipe("cubemap", &crown, session)?;
        let is_kept = paths
            .iter()
            .all(|path| session.output.is_ready(path, recipe));
        let map = if is_kept {
            kept(&paths, self.size)?
        } else {
            let (photo, mask) = pictures.decoded()?;
            let map = self.made(session, &photo, &mask)?;
            self.write(session, &paths, &map, recipe)?;
            map
        };
        session.print_json(|| self.answer(session, folder, is_kept, &map))
    }
}

impl Flags {
    fn crown(&self) -> CrownSettings {
        CrownSettings {
            size: self.size,
            photo_front: self.photo_front,
            foliage: self.settings(),
            ..CrownSettings::default()
        }
    }

    fn settings(&self) -> CubemapSettings {
        CubemapSettings {
            size: self.size,
            as_ball: self.ball,
            exemplar: self.foliage.exemplar(),
            synthesis: self.foliage.synthesis(),
        }
    }

    fn made(
        &self,
        session: &Session<'_>,
        photo: &Image<Straight>,
        mask: &Mask,
    ) -> Result<Cubemap<Straight>, Failure> {
        let seed = Seed(session.options.seed);
        let (progress, cancel) = (session.progress, session.cancel);
        colored_surface(photo, mask, &self.crown(), seed, progress, cancel)
            .map(|surface| surface.color)
            .map_err(|error| self.failure(&error))
    }

    /// Writes all faces: nothing before all of them are encoded.
    fn write(
        &self,
        session: &Session<'_>,
        paths: &[PathBuf; 6],
        map: &Cubemap<Straight>,
        recipe: Digest,
    ) -> Result<(), Failure> {
        let stage = session.progress.stage("write", 2);
        let faces = paths.iter().cloned().zip(map.faces());
        let files = faces.map(|(path, face)| (path, encode_png(face, Compression::Fast)));
        let files = files.collect();
        stage.advance();
        session.output.write_items(files, recipe)?;
        stage.advance();
        Ok(())
    }

    fn answer(
        &self,
        session: &Session<'_>,
        folder: &Path,
        is_kept: bool,
        map: &Cubemap<Straight>,
    ) -> Value {
        let files = CubeFace::ALL.map(|face| format!("{}.png", face.name()));
        json!({
            "file": self.photo.display().to_string(),
            "mask": self.mask.display().to_string(),
            "output": folder.display().to_string(),
            "files": files,
            "kept": is_kept,
            "size": self.size,
            "photo_front": self.photo_front,
            "settings": self.settings(),
            "seams": edge_statistic(map),
            "seconds": session.seconds(),
        })
    }

    fn failure(&self, error: &CrownError) -> Failure {
        match error {
            error if error.is_cancelled() => Failure::Cancelled,
            CrownError::Setting(_) => Failure::BadInput(error.to_string()),
            _ => Failure::of(self.mask.display(), error),
        }
    }
}

/// The faces that are there already.
fn kept(paths: &[PathBuf; 6], size: u32) -> Result<Cubemap<Straight>, Failure> {
    let mut faces = Vec::new();
    for path in paths {
        let face = PictureFile::read(path)?.decoded()?;
        if (face.width(), face.height()) != (size, size) {
            return Err(Failure::of(path.display(), "is not a face of this size"));
        }
        faces.push(face);
    }
    Ok(Cubemap::from_faces(std::array::from_fn(|i| {
        faces[i].clone()
    })))
}
