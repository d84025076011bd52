//! New trees of the real library as people see them: small sheets, compared with those that were looked at.
//!
//! Pictures in `tests/golden/variation`; `REGENERATE=1` writes them anew, to be looked at. They need the
//! real trees of `BOSCAGE_DATA` (default `../shared/data`); without the folder the test says so and passes.

use crate::reference;
use boscage::base::{Cancel, Progress, Seed};
use boscage::raster::{
    Compression, Image, Premultiplied, ReadLimits, Rect, Straight, encode_opaque_png, read_image,
    resized,
};
use boscage::segment::Classical;
use boscage::variation::{
    Brood, ChoiceSettings, Chosen, ExemplarSettings, Finish, Genome, IndividualSettings, Library,
    LibraryPicture, Season, SeasonChoice, SeasonSettings, Shape, Tree, TreeMaker, chosen,
};
use std::path::{Path, PathBuf};

/// Side of a tree on a sheet, and trees in a row.
const CELL: u32 = 96;
const COLUMNS: u32 = 6;

/// How far a sheet may be from the one that was looked at: mean difference of a channel, and the share of
/// pixels that differ by more than a tenth.
const MEAN: f64 = 1.5;
const FAR: f64 = 0.02;

fn library(data: &Path) -> Library<'static> {
    let folder = std::fs::read_dir(data.join("billboards")).unwrap();
    let mut files: Vec<PathBuf> = folder.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    let pictures: Vec<LibraryPicture> = files
        .into_iter()
        .map(|path| LibraryPicture {
            path,
            bytes: None,
            pins: None,
        })
        .collect();
    let settings = ExemplarSettings {
        size: 256,
        ..ExemplarSettings::default()
    };
    let (silent, cancel) = (Progress::silent(), Cancel::new());
    let made = Library::of(&pictures, settings, &Classical, None, None, silent, &cancel);
    let (library, refused) = made.unwrap();
    assert!(refused.is_empty());
    library
}

fn cell(tree: &Tree) -> Image<Premultiplied> {
    let image = tree.image.premultiplied();
    let whole = Rect {
        x: 0,
        y: 0,
        width: image.width(),
        height: image.height(),
    };
    resized(&image, whole, CELL, CELL)
}

/// The trees in rows, on paper.
fn sheet(trees: &[Tree]) -> Image<Straight> {
    let rows = (trees.len() as u32).div_ceil(COLUMNS);
    let paper = [222u8, 219, 213];
    let [r, g, b] = paper;
    let mut sheet = Image::filled(COLUMNS * CELL, rows * CELL, Straight([r, g, b, 255]));
    for (index, tree) in (0..).zip(trees) {
        let (left, top) = (index % COLUMNS * CELL, index / COLUMNS * CELL);
        let small = cell(tree);
        for y in 0..CELL {
            for x in 0..CELL {
                let pixel = small.at(x, y).0;
                let over = |c: usize| {
                    let behind = u32::from(paper[c]) * (255 - u32::from(pixel[3]));
                    (u32::from(pixel[c]) + (behind + 127) / 255).min(255) as u8
                };
                let color = Straight([over(0), over(1), over(2), 255]);
                sheet.set(left + x, top + y, color);
            }
        }
    }
    sheet
}

fn compared(name: &str, trees: &[Tree]) {
    let sheet = sheet(trees);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/variation");
    let file = folder.join(format!("{name}.png"));
    if std::env::var_os("REGENERATE").is_some() {
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(&file, encode_opaque_png(&sheet, Compression::Small)).unwrap();
    }
    let golden = read_image(&file, ReadLimits::default()).unwrap();
    let sizes = [&golden, &sheet].map(|image| (image.width(), image.height()));
    assert_eq!(sizes[0], sizes[1], "{name}");
    let (mut sum, mut far) = (0.0, 0.0);
    for (a, b) in golden.pixels().iter().zip(sheet.pixels()) {
        let apart = |c: usize| f64::from(a.0[c].abs_diff(b.0[c]));
        sum += (apart(0) + apart(1) + apart(2)) / 3.0;
        far += f64::from(u8::from((0..3).any(|c| apart(c) > 25.0)));
    }
    let count = sheet.pixels().len() as f64;
    let (mean, far) = (sum / count, far / count);
    if mean > MEAN || far > FAR {
        let actual = std::env::temp_dir().join(format!("{name}.actual.png"));
        std::fs::write(&actual, encode_opaque_png(&sheet, Compression::Fast)).unwrap();
        panic!(
            "{name}: mean {mean:.2}, far {far:.4}; see {}",
            actual.display()
        );
    }
}

/// The library and all that its trees are made with.
struct Studio<'a> {
    maker: TreeMaker<'a>,
    shapes: Vec<&'a Shape>,
    settings: ChoiceSettings,
    cancel: Cancel,
}

impl Studio<'_> {
    fn index(&self, name: &str) -> usize {
        let mut names = self.maker.library().entries().iter();
        let file = format!("{name}.png");
        names.position(|entry| entry.file_name() == file).unwrap()
    }

    /// The exemplar itself.
    fn plain(&self, name: &str) -> Tree {
        let library = self.maker.library();
        let own = library.exemplar(self.index(name), &self.cancel).unwrap();
        Tree {
            image: own.image.straight(),
            labels: own.labels.clone(),
        }
    }

    fn chosen(&self, target: Option<usize>, seed: Seed) -> Chosen {
        chosen(&self.shapes, target, &self.settings, seed).unwrap()
    }

    fn tree(&self, chosen: &Chosen, finish: &Finish, seed: Seed) -> Tree {
        let mut tree = self.maker.make(chosen, &self.cancel).unwrap();
        let finish = finish.of_tree(chosen, self.maker.library());
        finish.put(&mut tree, None, seed, &self.cancel).unwrap();
        tree
    }

    fn individual(&self, name: &str, index: u64) -> Tree {
        let seed = Seed(2).derive("tree", index);
        let chosen = self.chosen(Some(self.index(name)), seed);
        let finish = Finish {
            individual: IndividualSettings::drawn(self.settings.strength, seed),
            ..Finish::default()
        };
        self.tree(&chosen, &finish, seed)
    }

    fn in_season(&self, name: &str, season: Season, snow: f64) -> Tree {
        let settings = SeasonSettings {
            snow,
            ..SeasonSettings::of(season)
        };
        let choice = SeasonChoice {
            settings,
            evergreen: None,
        };
        let finish = Finish {
            season: Some(choice.of_picture(&format!("{name}.png"))),
            ..Finish::default()
        };
        let mut tree = self.plain(name);
        finish.put(&mut tree, None, Seed(3), &self.cancel).unwrap();
        tree
    }

    /// Two trees and ten of their children.
    fn family(&self, names: [&str; 2]) -> Vec<Tree> {
        let parent = |name: &str| {
            let seed = Seed(4).derive("tree", 0);
            let chosen = self.chosen(Some(self.index(name)), seed);
            let genome = Genome {
                parts: chosen.parts.clone(),
                like: None,
                finish: Finish::default(),
                seed,
            };
            (genome, chosen)
        };
        let parents = names.map(parent);
        let mut family: Vec<Tree> = parents
            .iter()
            .map(|(genome, chosen)| self.tree(chosen, &genome.finish, genome.seed))
            .collect();
        let brood = Brood {
            parents: parents.map(|(genome, _)| genome).to_vec(),
            locks: [].into(),
        };
        let all: Vec<usize> = (0..self.shapes.len()).collect();
        for index in 0..10 {
            let seed = Seed(5).derive("tree", index);
            let child = brood.child(&self.shapes, &all, seed).unwrap();
            family.push(self.tree(&child.chosen, &child.genome.finish, child.genome.seed));
        }
        family
    }
}

#[test]
fn trees_look_as_they_did_when_they_were_looked_at() {
    let Some(data) = reference::data("billboards") else {
        return;
    };
    let library = library(&data);
    let entries = library.entries().iter();
    let studio = Studio {
        maker: TreeMaker::new(&library, None),
        shapes: entries.map(|entry| entry.shape.as_ref()).collect(),
        settings: ChoiceSettings::default(),
        cancel: Cancel::new(),
    };

    let drawn = (0..12).map(|index| {
        let seed = Seed(1).derive("tree", index);
        let chosen = studio.chosen(None, seed);
        let folded = chosen.layout.distortion.folded;
        assert!(folded <= 0.0, "tree {index} folds: {folded}");
        studio.tree(&chosen, &Finish::default(), seed)
    });
    compared("drawn", &drawn.collect::<Vec<Tree>>());

    let mut rows = Vec::new();
    for name in ["fir_dense_01", "apple_airy_medium_01", "broadleaf_dense_01"] {
        rows.push(studio.plain(name));
        rows.extend((0..5).map(|index| studio.individual(name, index)));
    }
    compared("individuals", &rows);

    let mut rows = Vec::new();
    for name in ["broadleaf_dense_01", "spruce_dense_01"] {
        rows.push(studio.plain(name));
        let seasons = [
            Season::Spring,
            Season::Summer,
            Season::Autumn,
            Season::Winter,
        ];
        rows.extend(seasons.map(|season| studio.in_season(name, season, 0.0)));
        rows.push(studio.in_season(name, Season::Winter, 0.6));
    }
    compared("seasons", &rows);

    compared(
        "bred",
        &studio.family(["broadleaf_dense_01", "broadleaf_dense_04"]),
    );
}
