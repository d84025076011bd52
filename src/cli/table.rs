//! `boscage table`: a folder of trees → each crossed with every other, on one sheet.

use super::exemplars::prepared;
use super::failure::Failure;
use super::library::picture_files;
use super::session::Session;
use super::{Job, Stages};
use crate::raster::{Compression, Image, Premultiplied, encode_png};
use crate::segment::standard;
use crate::sheet::{map_sheet, silhouette, table_sheet};
use crate::variation::{
    CompatibilityGraph, Exemplar, ExemplarSettings, Layout, Shape, Source, WarpPrecision,
    library_places, synthesized,
};
use clap::{Args, ValueEnum};
use rayon::prelude::*;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Cross every tree of a folder with every other, on one sheet
///
/// The outline in row i and column j is two thirds of tree i and one third of tree j; with --kind
/// images it is filled with the picture of tree i. On the diagonal stand the trees themselves.
/// With --kind compatibility it is a map instead: trees that go together stand side by side, and lines
/// join each with those that random choice mixes it with.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  boscage table --library trees --out table.png
  boscage table --library trees --kind compatibility --out map.png --json")]
pub(super) struct Flags {
    /// A folder of tree pictures
    #[arg(long, value_name = "DIR")]
    library: PathBuf,
    /// What the cells show
    #[arg(long, value_enum, default_value_t, value_name = "KIND")]
    kind: Kind,
    /// Most trees in the table, 40 at most, or on the map; of more, some evenly spread over the folder
    /// [default: 12, on the map all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(2..))]
    limit: Option<u16>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum Kind {
    /// Outlines
    Contours,
    /// The row's picture warped into the outline
    #[default]
    Images,
    /// A map of which trees go together
    Compatibility,
}

/// The row's share of a cell's outline (*Tree Variations*, Fig. 13–14).
const ROW_WEIGHT: f64 = 2.0 / 3.0;

/// Trees in a table where nothing else is asked for.
const USUAL_LIMIT: u16 = 12;

/// Most trees in a table: beyond, its cells are more than a screen can show.
const MOST_CROSSED: u16 = 40;

/// Side of the prepared pictures, in pixels.
const PICTURE_PX: u32 = 256;

/// Side of a cell, in pixels; trees fill five sixths of it and are not magnified.
const CELL_PX: u32 = 240;

impl Job for Flags {
    fn stages(&self) -> Stages {
        &[("prepare", 3.0), ("cells", 2.0), ("sheet", 1.0)]
    }

    fn run(&self, session: &Session<'_>) -> Result<(), Failure> {
        let out = session.options.out()?;
        // One file is one item: the first shard makes it.
        let is_ours = session.options.shard.contains(0);
        if !is_ours {
            return session.print_json(|| json!({"file": null}));
        }
        session.output.check([out])?;
        let files = spread(picture_files(&self.library)?, self.checked_limit()?);
        let trees = self.prepared(&files, session)?;
        if self.kind == Kind::Compatibility {
            return compatibility(&trees, out, session);
        }
        let (images, distortion) = crossings(&trees, self.kind, session)?;
        let stage = session.progress.stage("sheet", 1);
        let originals: Vec<Image<Premultiplied>> =
            trees.iter().map(|tree| tree.shown(self.kind)).collect();
        let heads: Vec<&Image<Premultiplied>> = originals.iter().collect();
        let sheet = table_sheet(&heads, &heads, &images, CELL_PX);
        session.cancel.check()?;
        session
            .output
            .write(out, &encode_png(&sheet, Compression::Small))?;
        drop(stage);
        session.print_json(|| {
            let files: Vec<String> = trees.iter().map(|t| t.file.display().to_string()).collect();
            json!({
                "file": out.display().to_string(),
                "width": sheet.width(),
                "height": sheet.height(),
                "exemplars": files,
                "distortion": distortion.chunks(trees.len()).collect::<Vec<_>>(),
                "seconds": session.seconds(),
            })
        })
    }
}

/// One of the folder's trees.
struct Tree {
    file: PathBuf,
    exemplar: Exemplar,
}

impl Tree {
    /// The tree itself, as the table shows it.
    fn shown(&self, kind: Kind) -> Image<Premultiplied> {
        match kind {
            Kind::Contours => silhouette(&self.exemplar.shape.contour.points, PICTURE_PX),
            Kind::Images | Kind::Compatibility => self.exemplar.image.clone(),
        }
    }
}

impl Flags {
    fn checked_limit(&self) -> Result<usize, Failure> {
        match (self.kind, self.limit) {
            (Kind::Compatibility, limit) => Ok(limit.map_or(usize::MAX, usize::from)),
            (_, Some(limit)) if limit > MOST_CROSSED => {
                let reason =
                    format!("a table has {MOST_CROSSED} trees at most; {limit} are asked for");
                Err(Failure::of("--limit", reason))
            }
            (_, limit) => Ok(limit.unwrap_or(USUAL_LIMIT).into()),
        }
    }

    fn prepared(&self, files: &[PathBuf], session: &Session<'_>) -> Result<Vec<Tree>, Failure> {
        let settings = ExemplarSettings {
            size: PICTURE_PX,
            ..ExemplarSettings::default()
        };
        let stage = session.progress.stage("prepare", files.len() as u64);
        let prepare = |file: &PathBuf| {
            let outcome = match prepared(file, &settings, standard(), session) {
                Ok((exemplar, _)) => Some(Tree {
                    file: file.clone(),
                    exemplar,
                }),
                Err(Failure::BadInput(reason)) => {
                    session.progress.warn(&reason);
                    None
                }
                Err(other) => return Err(other),
            };
            stage.advance();
            Ok(outcome)
        };
        let outcomes: Vec<Option<Tree>> = files
            .par_iter()
            .with_max_len(1)
            .map(prepare)
            .collect::<Result<_, Failure>>()?;
        let trees: Vec<Tree> = outcomes.into_iter().flatten().collect();
        if trees.len() < 2 {
            let reason = format!("{} usable pictures; a table needs 2", trees.len());
            return Err(Failure::of(self.library.display(), reason));
        }
        Ok(trees)
    }
}

/// `limit` of `files`, evenly spread, the first always among them.
fn spread(files: Vec<PathBuf>, limit: usize) -> Vec<PathBuf> {
    if files.len() <= limit {
        return files;
    }
    (0..limit)
        .map(|i| files[i * files.len() / limit].clone())
        .collect()
}

/// Draws the map of `trees` and prints their graph.
fn compatibility(trees: &[Tree], out: &Path, session: &Session<'_>) -> Result<(), Failure> {
    let stage = session.progress.stage("cells", 1);
    let shapes: Vec<&Shape> = trees.iter().map(|tree| &tree.exemplar.shape).collect();
    let graph = CompatibilityGraph::of(&shapes);
    session.cancel.check()?;
    let places = library_places(&shapes);
    drop(stage);
    session.cancel.check()?;
    let stage = session.progress.stage("sheet", 1);
    let images: Vec<&Image<Premultiplied>> =
        trees.iter().map(|tree| &tree.exemplar.image).collect();
    let (side, tree) = map_sides(trees.len());
    let map = map_sheet(&images, &places, &graph.edges(), side, tree);
    session
        .output
        .write(out, &encode_png(&map, Compression::Small))?;
    drop(stage);
    session.print_json(|| {
        let exemplars = trees.iter().zip(&places).zip(&graph.neighbours);
        let exemplars = exemplars.map(|((tree, place), neighbours)| {
            let shape = &tree.exemplar.shape;
            let neighbours = neighbours.iter().map(|neighbour| {
                json!({
                    "exemplar": neighbour.exemplar,
                    "distance": neighbour.distance,
                    "foreseen": [neighbour.foreseen.own, neighbour.foreseen.other],
                })
            });
            json!({
                "file": tree.file.display().to_string(),
                "place": [place.x, place.y],
                "has_trunk": shape.contour.pins.has_trunk(),
                "density": shape.density,
                "fullness": shape.fullness,
                "texture": shape.texture,
                "neighbours": neighbours.collect::<Vec<Value>>(),
            })
        });
        json!({
            "file": out.display().to_string(),
            "width": map.width(),
            "height": map.height(),
            "exemplars": exemplars.collect::<Vec<Value>>(),
            "seconds": session.seconds(),
        })
    })
}

/// Sides of the map of `count` trees and of each of its trees, in pixels.
fn map_sides(count: usize) -> (u32, u32) {
    let tree = 110;
    // Trees lie denser in the middle than on the rim: three times the room that they need.
    let side = (3.0 * count as f64).sqrt() * f64::from(tree);
    ((side as u32).clamp(640, 6_400), tree)
}

/// What a cell shows; `None` where nothing could be made.
type Shown = Option<Image<Premultiplied>>;

/// What a cell shows, and its distortion.
type Crossing = (Shown, Value);

/// Pictures and distortions of all cells, row by row.
fn crossings(
    trees: &[Tree],
    kind: Kind,
    session: &Session<'_>,
) -> Result<(Vec<Shown>, Vec<Value>), Failure> {
    let count = trees.len();
    let stage = session.progress.stage("cells", (count * count) as u64);
    let cells: Vec<Crossing> = (0..count * count)
        .into_par_iter()
        .map(|index| {
            let crossing = crossing(&trees[index / count], &trees[index % count], kind, session);
            stage.advance();
            crossing
        })
        .collect::<Result<_, Failure>>()?;
    Ok(cells.into_iter().unzip())
}

fn crossing(
    row: &Tree,
    column: &Tree,
    kind: Kind,
    session: &Session<'_>,
) -> Result<Crossing, Failure> {
    session.cancel.check()?;
    if std::ptr::eq(row, column) {
        return Ok((Some(row.shown(kind)), Value::Null));
    }
    let shapes = [
        (&row.exemplar.shape, ROW_WEIGHT, 1.0),
        (&column.exemplar.shape, 1.0 - ROW_WEIGHT, 0.0),
    ];
    let layout = match Layout::new(&shapes) {
        Ok(layout) => layout,
        Err(error) => {
            let (row, column) = (row.file.display(), column.file.display());
            let warning = format!("{row} and {column}: {error}");
            session.progress.warn(&warning);
            return Ok((None, Value::Null));
        }
    };
    let image = match kind {
        Kind::Contours => silhouette(&layout.contour.points, PICTURE_PX),
        Kind::Images | Kind::Compatibility => poured(&layout, row, column, session)?,
    };
    Ok((Some(image), json!(layout.distortion)))
}

/// The picture of `row` in the outline of `layout`.
fn poured(
    layout: &Layout,
    row: &Tree,
    column: &Tree,
    session: &Session<'_>,
) -> Result<Image<Premultiplied>, Failure> {
    let sources = [
        Source {
            exemplar: &row.exemplar,
            contour_weight: ROW_WEIGHT,
            color_weight: 1.0,
        },
        Source {
            exemplar: &column.exemplar,
            contour_weight: 1.0 - ROW_WEIGHT,
            color_weight: 0.0,
        },
    ];
    let made = synthesized(
        layout,
        &sources,
        WarpPrecision::Interpolated,
        session.cancel,
    )?;
    Ok(made.image)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_large_folder_is_thinned_evenly() {
        let files = |count: usize| (0..count).map(|i| PathBuf::from(i.to_string())).collect();
        let kept = spread(files(10), 4);
        assert_eq!(kept, ["0", "2", "5", "7"].map(Path::new));
        assert_eq!(spread(files(3), 4).len(), 3);
    }
}
