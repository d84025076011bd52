//! `boscage vary --parents library.json#tree_0003 …`: trees bred from trees that were made.

use super::failure::Failure;
use super::input::PictureFile;
use super::library::{picture_files, pictures};
use super::records::{LibraryRecord, TreeRecord};
use super::vary::Flags;
use super::vary_again::{folders, found, named_tree};
use crate::batch::parents::{Parent, Parents};
use crate::batch::vary::{Trees, Vary};
use crate::contour::HandPins;
use crate::variation::{Aspect, ChoiceSettings, LibraryPicture};
use clap::ValueEnum;
use std::path::{Path, PathBuf};

/// An aspect of trees, as it is typed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum AspectName {
    /// The outline
    Contour,
    /// Which exemplars: none that no parent has
    Exemplars,
    /// Whose colours
    Colors,
    /// How far colours are moved
    Hue,
    /// Foliage, limbs and the mirror
    Foliage,
    /// The season and its extent
    Season,
}

impl AspectName {
    fn aspect(self) -> Aspect {
        match self {
            Self::Contour => Aspect::Contour,
            Self::Exemplars => Aspect::Exemplars,
            Self::Colors => Aspect::Colors,
            Self::Hue => Aspect::Hue,
            Self::Foliage => Aspect::Foliage,
            Self::Season => Aspect::Season,
        }
    }
}

/// The job that the flags mean, which name parents.
pub(super) fn checked(flags: &Flags) -> Result<Vary, Failure> {
    let mut inputs = Inputs::default();
    let mut parents = Vec::new();
    let mut first: Option<LibraryRecord> = None;
    for name in &flags.parents {
        let (file, record, tree) = named_tree(name)?;
        let known = first.get_or_insert_with(|| record.clone());
        if known.settings != record.settings {
            let reason = "was made with other settings than the first of the parents";
            return Err(Failure::of(name, reason));
        }
        let folders = folders(flags, &record, &file);
        let like = inputs.take(&tree, &folders)?;
        parents.push(Parent {
            name: name.clone(),
            record: tree,
            like,
        });
    }
    let Some(record) = first else {
        return Err(Failure::of("--parents", "names no tree"));
    };
    let folder = flags
        .library
        .clone()
        .unwrap_or_else(|| PathBuf::from(&record.library));
    if let Some(library) = &flags.library {
        for path in picture_files(library)? {
            inputs.take_picture(path, None);
        }
    }
    Ok(Vary {
        folder,
        pictures: inputs.pictures,
        has_target: false,
        trees: Trees::Bred(
            Box::new(Parents {
                all: parents,
                locks: flags.lock.iter().map(|name| name.aspect()).collect(),
                generation: flags.generation,
            }),
            flags.count,
        ),
        likes: inputs.likes,
        maps: flags.maps.iter().copied().collect(),
        sheet: flags.sheet.clone(),
        settings: record.settings,
        choice: ChoiceSettings::default(),
        season: None,
        crowns: flags.crowns(),
        cache: flags.cache.folder(),
    })
}

/// The files that parents are made of, each once.
#[derive(Default)]
struct Inputs {
    pictures: Vec<LibraryPicture>,
    likes: Vec<LibraryPicture>,
}

impl Inputs {
    /// Finds the files of `tree` in `folders`; which of the likes gives its colours.
    fn take(&mut self, tree: &TreeRecord, folders: &[PathBuf]) -> Result<Option<usize>, Failure> {
        for exemplar in &tree.exemplars {
            let path = found(&exemplar.file, folders)?;
            self.take_picture(path, exemplar.pins.filter(HandPins::is_sound));
        }
        let Some(like) = &tree.like else {
            return Ok(None);
        };
        let path = found(&like.file, folders)?;
        if PictureFile::read(&path)?.digest().to_string() != like.digest {
            let reason = "is not the file the tree's colours were taken from";
            return Err(Failure::of(path.display(), reason));
        }
        if let Some(known) = self.likes.iter().position(|known| known.path == path) {
            return Ok(Some(known));
        }
        self.likes.extend(pictures(&[path]));
        Ok(Some(self.likes.len() - 1))
    }

    /// Takes a picture into the library, unless it is there. Where nobody set pins it is as it was found.
    fn take_picture(&mut self, path: PathBuf, pins: Option<HandPins>) {
        let whole = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let is_same = |known: &LibraryPicture| {
            whole(&known.path) == whole(&path) && (pins.is_none() || known.pins == pins)
        };
        if !self.pictures.iter().any(is_same) {
            self.pictures.push(LibraryPicture {
                path,
                bytes: None,
                pins,
            });
        }
    }
}
