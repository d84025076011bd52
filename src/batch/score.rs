//! Pictures of trees → how much they repeat each other, in a row and in a forest.

use super::failure::Failure;
use super::run::Run;
use crate::base::Seed;
use crate::raster::{Image, Premultiplied, ReadLimits, Straight, read_image, scaled};
use crate::sheet::{Cell, Forest, rows_of_trees};
use crate::variation::{HslShift, Look, MOST_COMPARED, Repetition};
use rayon::prelude::*;
use std::path::PathBuf;

/// Longest side of a picture that is compared; looks are smaller still.
const COMPARED_PX: u32 = 400;

/// Height of the forest.
const FOREST_PX: u32 = 700;

/// Side of a cell in the rows of a sheet.
const CELL_PX: u32 = 180;

/// Most trees in a row of a sheet.
const COLUMNS: usize = 12;

/// How much larger or smaller jittered copies are.
const SCALES: (f64, f64) = (0.8, 1.2);

/// Trees that are looked at together.
pub(crate) struct Trees {
    pub(crate) names: Vec<String>,
    images: Vec<Image<Premultiplied>>,
}

/// How they repeat.
pub(crate) struct Scores {
    /// Seen whole.
    pub(crate) row: Repetition,
    /// Seen in a forest; the indices are those of the trees.
    pub(crate) forest: Repetition,
}

impl Trees {
    /// Reads the pictures in `files`.
    ///
    /// # Errors
    /// [`Failure`] naming the file that is no picture, or when there are too many.
    pub(crate) fn read(files: &[PathBuf], session: &Run<'_>) -> Result<Self, Failure> {
        if files.len() > MOST_COMPARED {
            let reason = format!("{} pictures are more than {MOST_COMPARED}", files.len());
            return Err(Failure::BadInput(reason));
        }
        let stage = session.progress.stage("read", files.len() as u64);
        let images = files
            .par_iter()
            .with_max_len(1)
            .map(|file| {
                session.cancel.check()?;
                let image = read_image(file, ReadLimits::default())?.premultiplied();
                stage.advance();
                Ok(at_most(&image, COMPARED_PX))
            })
            .collect::<Result<Vec<_>, Failure>>()?;
        let name = |file: &PathBuf| {
            let name = file.file_name().unwrap_or_default();
            name.to_string_lossy().into_owned()
        };
        Ok(Self {
            names: files.iter().map(name).collect(),
            images,
        })
    }

    /// As many copies of these trees in turn.
    pub(crate) fn copied(&self, count: usize) -> Self {
        let of = |i: usize| i % self.images.len();
        Self {
            names: (0..count).map(|i| self.names[of(i)].clone()).collect(),
            images: (0..count).map(|i| self.images[of(i)].clone()).collect(),
        }
    }

    /// The same trees, each at another scale, in another hue, saturation and lightness.
    pub(crate) fn jittered(&self, seed: Seed) -> Self {
        let jittered = |(index, image): (usize, &Image<Premultiplied>)| {
            let mut random = seed.derive("jitter", index as u64).random();
            let shift = HslShift::drawn(1.0, &mut random);
            let mut straight = image.straight();
            shift.apply(&mut straight);
            scaled(
                &straight.premultiplied(),
                random.between(SCALES.0, SCALES.1),
            )
        };
        Self {
            names: self.names.clone(),
            images: self.images.par_iter().enumerate().map(jittered).collect(),
        }
    }

    /// How the trees repeat in a row and in the forest of `seed`.
    ///
    /// # Errors
    /// [`Failure::BadInput`] naming a picture that is clear; [`Failure::Cancelled`].
    pub(crate) fn scores(&self, seed: Seed, session: &Run<'_>) -> Result<Scores, Failure> {
        let looks = self
            .images
            .par_iter()
            .map(|image| Look::of(image, session.cancel))
            .collect::<Result<Vec<Option<Look>>, _>>()?;
        let looks = looks.into_iter().zip(&self.names).map(|(look, name)| {
            look.ok_or_else(|| Failure::of(name, "the picture is fully transparent"))
        });
        let looks = looks.collect::<Result<Vec<Look>, Failure>>()?;
        let row = Repetition::among(&looks, session.progress, session.cancel)?;
        let seen = self.forest(seed).seen;
        let seen: Vec<(usize, Look)> = seen
            .par_iter()
            .enumerate()
            .filter_map(|(index, seen)| Some((index, seen.as_ref()?)))
            .map(|(index, seen)| Ok((index, Look::of(seen, session.cancel)?)))
            .collect::<Result<Vec<_>, Failure>>()?
            .into_iter()
            .filter_map(|(index, look)| Some((index, look?)))
            .collect();
        let (places, looks): (Vec<usize>, Vec<Look>) = seen.into_iter().unzip();
        let mut forest = Repetition::among(&looks, session.progress, session.cancel)?;
        for pair in &mut forest.pairs {
            (pair.first, pair.second) = (places[pair.first], places[pair.second]);
        }
        Ok(Scores { row, forest })
    }

    fn forest(&self, seed: Seed) -> Forest {
        let trees: Vec<&Image<Premultiplied>> = self.images.iter().collect();
        Forest::new(&trees, FOREST_PX, seed)
    }

    /// A picture of the trees in rows above the forest of `seed`, the most alike pair of each framed.
    pub(crate) fn sheet(&self, scores: &Scores, seed: Seed) -> Image<Straight> {
        let worst = |found: &Repetition| -> Vec<usize> {
            let first = found
                .pairs
                .first()
                .filter(|pair| pair.likeness.score() > 0.0);
            first.map_or(Vec::new(), |pair| vec![pair.first, pair.second])
        };
        let cells: Vec<Cell<'_>> = self.images.iter().map(Cell::new).collect();
        let columns = COLUMNS.min(cells.len());
        let rows = rows_of_trees(&cells, columns, CELL_PX, &worst(&scores.row));
        let forest = self.forest(seed).picture(&worst(&scores.forest));
        let width = rows.width().max(forest.width());
        let mut sheet = Image::filled(
            width,
            rows.height() + forest.height(),
            Straight([222, 219, 213, 255]),
        );
        for (picture, top) in [(&rows, 0), (&forest, rows.height())] {
            let left = ((width - picture.width()) / 2) as usize;
            for y in 0..picture.height() {
                let row = &mut sheet.row_mut(top + y)[left..left + picture.width() as usize];
                row.copy_from_slice(picture.row(y));
            }
        }
        sheet
    }
}

/// `image` with no side longer than `side` pixels.
fn at_most(image: &Image<Premultiplied>, side: u32) -> Image<Premultiplied> {
    let longer = image.width().max(image.height());
    if longer <= side {
        image.clone()
    } else {
        scaled(image, f64::from(side) / f64::from(longer))
    }
}
