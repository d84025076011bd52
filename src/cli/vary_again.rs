//! `boscage vary --recipe library.json#tree_0003`: one tree again, from its record.

use super::failure::Failure;
use super::library::pictures;
use super::records::{LibraryRecord, TreeRecord};
use super::session::Session;
use super::vary::Flags;
use crate::batch::vary::{Like, Outputs, make_tree};
use crate::contour::HandPins;
use crate::segment::Segmenter;
use crate::variation::{Chosen, Library, Part, Shape, TreeMaker};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Makes the tree that `recipe` names and writes it into the folder `out`.
pub(super) fn run(
    recipe: &str,
    flags: &Flags,
    out: &Path,
    session: &Session<'_>,
) -> Result<(), Failure> {
    let (file, record, tree) = named_tree(recipe)?;
    let (file, tree) = (file.as_path(), &tree);
    let outputs = Outputs {
        folder: out,
        maps: std::collections::BTreeSet::new(),
    };
    session
        .output
        .check(outputs.of(tree.name(), tree.crown.is_some()))?;
    let folders = folders(flags, &record, file);
    let paths = tree
        .exemplars
        .iter()
        .map(|exemplar| found(&exemplar.file, &folders))
        .collect::<Result<Vec<PathBuf>, Failure>>()?;
    let segmenter = flags
        .segmenter
        .recorded(&record.segmenter, file, session.cancel)?;
    let segmenter = segmenter.as_ref();
    let cache = flags.cache.folder();
    let mut exemplars = pictures(&paths);
    for (picture, recorded) in exemplars.iter_mut().zip(&tree.exemplars) {
        picture.pins = recorded.pins.filter(HandPins::is_sound);
    }
    let library = crate::batch::library::opened(
        &exemplars,
        record.settings,
        segmenter,
        cache.as_deref(),
        session,
    )?;
    let chosen = chosen_again(tree, &library, file)?;
    let like = like_again(flags, tree, &record, segmenter, session)?;
    let palette = like.map(|like| like.palette);
    // In a season the picture gives the colours of its leaves.
    let of_maker = palette.clone().filter(|_| tree.season.is_none());
    let maker = TreeMaker::new(&library, of_maker);
    let leaves = palette.as_ref().map(|palette| palette.crown());
    let stage = session.progress.stage("vary", 1);
    make_tree(&maker, &chosen, tree, leaves, &outputs, session)?;
    drop(stage);
    session.print_json(|| json!({"trees": [tree], "seconds": session.seconds()}))
}

/// The tree that `recipe`, FILE.json#NAME, names: the file, all of the record, its own.
///
/// # Errors
/// [`Failure::BadInput`] naming the file.
pub(super) fn named_tree(recipe: &str) -> Result<(PathBuf, LibraryRecord, TreeRecord), Failure> {
    let Some((file, name)) = recipe.rsplit_once('#') else {
        return Err(Failure::of(recipe, "name a tree: FILE.json#tree_0003"));
    };
    let file = PathBuf::from(file);
    let record = LibraryRecord::read(&file)?;
    let mut trees = record.trees.iter();
    let tree = trees.find(|tree| tree.name() == name || tree.file == name);
    let failed = |reason: String| Failure::of(file.display(), reason);
    let tree = tree.ok_or_else(|| failed(format!("has no tree named {name}")))?;
    if !tree.is_in_folder() {
        return Err(failed("the tree's file lies outside the folder".to_owned()));
    }
    let tree = tree.clone();
    Ok((file, record, tree))
}

/// The picture that gives the colours: that of the flags, else the recorded one, which must be what
/// it was.
fn like_again(
    flags: &Flags,
    tree: &TreeRecord,
    record: &LibraryRecord,
    segmenter: &dyn Segmenter,
    session: &Session<'_>,
) -> Result<Option<Like>, Failure> {
    let of = |path: &Path| {
        let picture = &pictures(&[path.to_owned()])[0];
        Like::of(picture, record.settings, segmenter, session)
    };
    match (&flags.like, &tree.like) {
        (Some(path), _) => of(path).map(Some),
        (None, None) => Ok(None),
        (None, Some(recorded)) => {
            let like = of(Path::new(&recorded.file))?;
            if like.digest() != recorded.digest {
                let reason = "is not the file the tree's colours were taken from";
                return Err(Failure::of(&recorded.file, reason));
            }
            Ok(Some(like))
        }
    }
}

/// Where exemplars are looked for: the folder given now, the one recorded, that folder seen from
/// the record.
pub(super) fn folders(flags: &Flags, record: &LibraryRecord, file: &Path) -> Vec<PathBuf> {
    let beside = file.parent().unwrap_or(Path::new("."));
    let recorded = PathBuf::from(&record.library);
    let mut folders: Vec<PathBuf> = flags.library.iter().cloned().collect();
    folders.extend([recorded.clone(), beside.join(recorded), PathBuf::from(".")]);
    folders
}

pub(super) fn found(name: &str, folders: &[PathBuf]) -> Result<PathBuf, Failure> {
    let mut candidates = folders.iter().map(|folder| folder.join(name));
    candidates.find(|path| path.is_file()).ok_or_else(|| {
        Failure::of(
            name,
            "this exemplar is not there; say with --library where it is",
        )
    })
}

/// The recorded decision, with exemplars that are what they were.
fn chosen_again(tree: &TreeRecord, library: &Library<'_>, file: &Path) -> Result<Chosen, Failure> {
    let broken = |reason: &str| Failure::of(file.display(), format!("{}: {reason}", tree.file));
    let entries = library.entries();
    if entries.len() != tree.exemplars.len() {
        return Err(broken("an exemplar cannot be used any more"));
    }
    for (entry, exemplar) in entries.iter().zip(&tree.exemplars) {
        if entry.digest.to_string() != exemplar.digest {
            return Err(Failure::of(
                entry.path.display(),
                "is not the file the tree was made of",
            ));
        }
    }
    if !tree.weights_are_convex() {
        return Err(broken("the weights are not convex"));
    }
    let parts = (0..entries.len()).map(|exemplar| Part {
        exemplar,
        contour_weight: tree.contour_weights[exemplar],
        color_weight: tree.color_weights[exemplar],
    });
    let shapes: Vec<&Shape> = entries.iter().map(|entry| entry.shape.as_ref()).collect();
    Chosen::of(parts.collect(), &shapes).map_err(|error| broken(&error.to_string()))
}
