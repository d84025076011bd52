//! `boscage score`: how much the trees of a folder repeat each other.

use super::failure::Failure;
use super::library::picture_files;
use super::records::LibraryRecord;
use super::session::Session;
use super::{Job, Stages};
use crate::base::Seed;
use crate::batch::score::{Scores, Trees};
use crate::raster::{Compression, encode_opaque_png};
use crate::variation::{Pair, Repetition};
use clap::Args;
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Measure how much trees repeat each other, and name the most alike
///
/// Compares every tree with every other as an eye would that looks along a row of them and into a
/// forest: by the strongest correlation over shifts, small scales and mirrored, and by clumps and
/// gaps that are found again. Colour and size do not count. 0: no tree has a double; 1: copies.
#[derive(Debug, Args)]
#[command(after_help = "Example: boscage score new --against oak.png --sheet score.png")]
pub(super) struct Flags {
    /// Pictures of trees: a folder (with library.json: the trees that it lists) or files
    #[arg(required = true, value_name = "FOLDER|IMAGE")]
    trees: Vec<PathBuf>,
    /// For comparison, also score as many plain copies of this picture (or of those in this folder,
    /// in turn), and copies of other scale, hue, saturation and lightness
    #[arg(long, value_name = "IMAGE|FOLDER")]
    against: Option<PathBuf>,
    /// Also draw the row and the forest, the most alike pair of each framed
    #[arg(long, value_name = "FILE.png")]
    sheet: Option<PathBuf>,
}

/// Pairs that are told at most.
const MOST_TOLD: usize = 20;

impl Job for Flags {
    fn stages(&self) -> Stages {
        &[("read", 1.0), ("compare", 4.0)]
    }

    fn run(&self, session: &Session<'_>) -> Result<(), Failure> {
        if !session.options.shard.contains(0) {
            return session.print_json(|| json!({"output": null, "seconds": session.seconds()}));
        }
        session.output.check(&self.sheet)?;
        let mut files = Vec::new();
        for path in &self.trees {
            files.extend(tree_files(path)?);
        }
        let seed = Seed(session.options.seed);
        let trees = Trees::read(&files, session)?;
        let scores = trees.scores(seed, session)?;
        let mut others: Vec<(&str, Scores)> = Vec::new();
        if let Some(path) = &self.against {
            let copies = Trees::read(&tree_files(path)?, session)?.copied(files.len());
            others.push(("copies", copies.scores(seed, session)?));
            let jittered = copies.jittered(seed);
            others.push(("jittered", jittered.scores(seed, session)?));
        }
        if let Some(path) = &self.sheet {
            let sheet = trees.sheet(&scores, seed);
            session
                .output
                .write(path, &encode_opaque_png(&sheet, Compression::Fast))?;
        }
        if session.options.json {
            return session.print_json(|| answer(&trees, &scores, &others, session));
        }
        let told = told(&trees, &scores, &others);
        write!(std::io::stdout(), "{told}")
            .map_err(|error| Failure::Environment(format!("stdout: cannot be written: {error}")))
    }
}

/// The pictures that `path` means.
fn tree_files(path: &Path) -> Result<Vec<PathBuf>, Failure> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let record = path.join("library.json");
    if !record.is_file() {
        return picture_files(path);
    }
    let trees = LibraryRecord::read(&record)?.trees;
    Ok(trees.iter().map(|tree| path.join(&tree.file)).collect())
}

fn answer(
    trees: &Trees,
    scores: &Scores,
    others: &[(&str, Scores)],
    session: &Session<'_>,
) -> Value {
    let pairs = |found: &Repetition| -> Vec<Value> {
        let told = found.pairs.iter().take(MOST_TOLD);
        told.map(|pair| pair_json(trees, pair)).collect()
    };
    let both = |scores: &Scores| json!({"row": scores.row.score, "forest": scores.forest.score});
    let mut answer = json!({
        "trees": trees.names.len(),
        "row": {"score": scores.row.score, "pairs": pairs(&scores.row)},
        "forest": {"score": scores.forest.score, "pairs": pairs(&scores.forest)},
        "seconds": session.seconds(),
    });
    for (name, scores) in others {
        answer[*name] = both(scores);
    }
    answer
}

fn pair_json(trees: &Trees, pair: &Pair) -> Value {
    let likeness = &pair.likeness;
    json!({
        "a": trees.names[pair.first],
        "b": trees.names[pair.second],
        "score": likeness.score(),
        "correlation": likeness.correlation,
        "matched": likeness.matched,
        "mirrored": likeness.is_mirrored,
        "scale": likeness.scale,
    })
}

/// The answer in words.
fn told(trees: &Trees, scores: &Scores, others: &[(&str, Scores)]) -> String {
    let mut text = format!("{:<28} {:>6} {:>7}\n", "", "row", "forest");
    let mut line = |name: &str, scores: &Scores| {
        let _ = writeln!(
            text,
            "{name:<28} {:>6.3} {:>7.3}",
            scores.row.score, scores.forest.score
        );
    };
    line(&format!("{} trees", trees.names.len()), scores);
    for (name, scores) in others {
        line(name, scores);
    }
    for (place, found) in [("row", &scores.row), ("forest", &scores.forest)] {
        if let Some(pair) = found.pairs.first() {
            let (a, b) = (&trees.names[pair.first], &trees.names[pair.second]);
            let likeness = &pair.likeness;
            let mirrored = if likeness.is_mirrored {
                ", mirrored"
            } else {
                ""
            };
            let _ = writeln!(
                text,
                "most alike in the {place}: {a} and {b}: {:.3} (correlation {:.2}, features {:.2}{mirrored})",
                likeness.score(),
                likeness.correlation,
                likeness.matched,
            );
        }
    }
    text
}
