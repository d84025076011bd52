//! `boscage samples`: trees of our own making as files.

use super::failure::Failure;
use super::input::PictureFile;
use super::items::made;
use super::output::recipe;
use super::photos::write_photos;
use super::session::Session;
use super::{Job, Stages};
use crate::base::Digest;
use crate::branches::samples::{INDIVIDUALS, USUAL_HEIGHT_PX, picture_size};
use crate::branches::species::{LIBRARY, Species, all_species, species_named};
use crate::branches::tree::Layers;
use crate::branches::{Individual, Sample, samples};
use crate::raster::{
    Compression, ReadLimits, encode_grey_png, encode_grey16_png, encode_png, read_image_from_memory,
};
use clap::Args;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Grow trees, or write the built-in ones
///
/// Individual K of a species is the same tree wherever it is grown: K changes age, height, width,
/// lean, density, the bare part of the stem, the colour of the leaves and the light. Writes
/// NAME_KK.png and labels/NAME_KK.labels.png (0 background, 128 trunk, 255 crown); with --layers
/// also layers/NAME_KK.depth.png (16-bit), NAME_KK.normals.png and NAME_KK.json, which says how to
/// read them. --bundled writes the pictures that come with the program at once.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  boscage samples --out trees --bundled
  boscage samples --out oaks --species oak,apple --individuals 50 --first 4 --layers")]
pub(super) struct Flags {
    /// Which species, or `all` [default: those of the built-in library]
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    species: Vec<String>,
    /// How many individuals of each species
    #[arg(long, default_value_t = INDIVIDUALS, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    individuals: u32,
    /// Number of the first individual
    #[arg(long, default_value_t = 1, value_name = "K", value_parser = clap::value_parser!(u32).range(1..=1_000_000_000))]
    first: u32,
    /// Height of the pictures, in pixels; they are two thirds as wide
    #[arg(long, default_value_t = USUAL_HEIGHT_PX, value_name = "PX", value_parser = clap::value_parser!(u32).range(16..=8192))]
    height: u32,
    /// Write depth and normals too
    #[arg(long)]
    layers: bool,
    /// Write the pictures that come with the program, without labels
    #[arg(long, conflicts_with_all = ["species", "individuals", "first", "height", "layers"])]
    bundled: bool,
    /// Write photographs of grown trees, NAME.jpg, with the masks of their crowns, NAME.mask.png
    #[arg(long, conflicts_with_all = ["species", "individuals", "first", "height", "layers", "bundled"])]
    photos: bool,
}

/// Where depth is measured, for those who read the layers.
const FRAME: &str = "metres from the foot of the stem, which is in the middle of the lower edge; \
    x right, y up, z to the viewer; parallel projection along z";

impl Job for Flags {
    fn stages(&self) -> Stages {
        &[("grow", 1.0)]
    }

    fn run(&self, session: &Session<'_>) -> Result<(), Failure> {
        let folder = session.options.out()?;
        if self.bundled {
            return write_bundled(folder, session);
        }
        if self.photos {
            return print_samples(write_photos(folder, session)?, session);
        }
        let tasks = self.tasks(folder)?;
        let shard = session.options.shard;
        let ours = (0u64..).zip(&tasks).filter(|(i, _)| shard.contains(*i));
        session
            .output
            .check(ours.flat_map(|(_, task)| task.files()))?;
        let made = made(session, "grow", &tasks, |_, task| {
            task.run(self.height, session)
        })?;
        print_samples(made.ready, session)
    }
}

impl Flags {
    fn tasks(&self, folder: &Path) -> Result<Vec<Task>, Failure> {
        let mut tasks = Vec::new();
        for species in self.species()? {
            for index in self.first..self.first + self.individuals {
                tasks.push(Task::new(
                    Individual::new(species, index),
                    folder,
                    self.layers,
                ));
            }
        }
        Ok(tasks)
    }

    fn species(&self) -> Result<Vec<&'static Species>, Failure> {
        match self.species.as_slice() {
            [] => Ok(all_species().iter().take(LIBRARY).collect()),
            [all] if all == "all" => Ok(all_species().iter().collect()),
            names => names.iter().map(|name| species_of(name)).collect(),
        }
    }
}

fn species_of(name: &str) -> Result<&'static Species, Failure> {
    species_named(name).ok_or_else(|| {
        let known: Vec<&str> = all_species().iter().map(|species| species.name).collect();
        let reason = format!("no such species; there are {}", known.join(", "));
        Failure::of(format!("--species {name}"), reason)
    })
}

fn print_samples(ready: Vec<(usize, Value)>, session: &Session<'_>) -> Result<(), Failure> {
    session.print_json(|| {
        let samples: Vec<Value> = ready.into_iter().map(|(_, sample)| sample).collect();
        json!({"samples": samples, "seconds": session.seconds()})
    })
}

/// One tree and where it goes.
struct Task {
    individual: Individual,
    image: PathBuf,
    labels: PathBuf,
    /// Depth, normals, and what is to be known of them.
    layers: Option<[PathBuf; 3]>,
}

impl Task {
    fn new(individual: Individual, folder: &Path, with_layers: bool) -> Self {
        let name = individual.name();
        let layer = |end: &str| folder.join("layers").join(format!("{name}.{end}"));
        Self {
            image: folder.join(format!("{name}.png")),
            labels: folder.join("labels").join(format!("{name}.labels.png")),
            layers: with_layers.then(|| ["depth.png", "normals.png", "json"].map(layer)),
            individual,
        }
    }

    fn files(&self) -> impl Iterator<Item = &PathBuf> {
        let layers = self.layers.iter().flatten();
        [&self.image, &self.labels].into_iter().chain(layers)
    }

    /// Makes and writes the files, or keeps those that are there; says what they are.
    fn run(&self, height: u32, session: &Session<'_>) -> Result<Value, Failure> {
        let recipe = recipe("samples")
            .with(self.individual.name().as_bytes())
            .with(&height.to_le_bytes())
            .with(&[u8::from(self.layers.is_some())])
            .finish();
        // Of a tree's files the picture is written last: it stands for all of them.
        let others = self.files().skip(1).all(|file| file.is_file());
        if !(others && session.output.is_ready(&self.image, recipe)) {
            self.make(height, recipe, session)?;
        }
        let (width, height) = picture_size(height);
        let shown = |path: &PathBuf| path.display().to_string();
        Ok(json!({
            "name": self.individual.name(),
            "species": self.individual.species_name(),
            "traits": self.individual.traits(),
            "file": shown(&self.image),
            "labels": shown(&self.labels),
            "layers": self.layers.as_ref().map(|layers| layers.each_ref().map(shown)),
            "width": width,
            "height": height,
        }))
    }

    fn make(&self, height: u32, recipe: Digest, session: &Session<'_>) -> Result<(), Failure> {
        let tree = self.individual.grow(session.cancel)?;
        let size = picture_size(height);
        let made = tree.picture(size, self.layers.is_some(), session.cancel)?;
        let output = &session.output;
        let write = |path: &Path, bytes| output.write_item(path, bytes, recipe);
        if let (Some(paths), Some(layers)) = (&self.layers, &made.layers) {
            let depth = encode_grey16_png(&layers.depth.steps, Compression::Fast);
            write(&paths[0], depth)?;
            write(&paths[1], encode_png(&layers.normals, Compression::Fast))?;
            let legend = self.legend(tree.height_m(), made.pixels_of_metre, layers);
            write(&paths[2], format!("{legend:#}\n").into_bytes())?;
        }
        session.cancel.check()?;
        write(
            &self.labels,
            encode_grey_png(&made.labels, Compression::Fast),
        )?;
        write(&self.image, encode_png(&made.image, Compression::Fast))
    }

    /// How to read depth and normals.
    fn legend(&self, height_m: f32, pixels_of_metre: f32, layers: &Layers) -> Value {
        let depth = &layers.depth;
        json!({
            "name": self.individual.name(),
            "species": self.individual.species_name(),
            "traits": self.individual.traits(),
            "height_m": height_m,
            "pixels_of_metre": pixels_of_metre,
            "frame": FRAME,
            "depth": {
                "background": 0,
                "z_m": "offset_m + step_m * value",
                "offset_m": depth.offset_m,
                "step_m": depth.step_m,
            },
            "normals": "(red, green, blue) = 128 + 127 * (x, y, z); alpha is coverage",
        })
    }
}

/// Writes the pictures that come with the program.
fn write_bundled(folder: &Path, session: &Session<'_>) -> Result<(), Failure> {
    let path = |sample: &Sample| folder.join(format!("{}.png", sample.name()));
    let shard = session.options.shard;
    let ours = (0u64..).zip(samples()).filter(|(i, _)| shard.contains(*i));
    session.output.check(ours.map(|(_, sample)| path(sample)))?;
    let made = made(session, "grow", samples(), |_, sample| {
        let (path, bytes) = (path(sample), sample.bundled());
        let recipe = recipe("bundled sample").with(bytes).finish();
        let image = if session.output.is_ready(&path, recipe) {
            PictureFile::read(&path)?.decoded()?
        } else {
            let name = format!("{}.webp", sample.name());
            let image = read_image_from_memory(bytes, Path::new(&name), ReadLimits::default())?;
            let png = encode_png(&image, Compression::Fast);
            session.output.write_item(&path, png, recipe)?;
            image
        };
        Ok(json!({
            "name": sample.name(),
            "file": path.display().to_string(),
            "width": image.width(),
            "height": image.height(),
        }))
    })?;
    print_samples(made.ready, session)
}
