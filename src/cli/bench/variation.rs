//! Measurements of new trees from tree pictures.

use super::super::failure::Failure;
use super::row::{Baseline, Row, measured};
use crate::base::{Cancel, Progress, Seed};
use crate::branches::samples::sample_named;
use crate::geometry::Point;
use crate::raster::{Compression, Image, Straight, encode_png};
use crate::segment::{Classical, SegmentError};
use crate::variation::{
    Exemplar, ExemplarError, ExemplarSettings, Histogram, IndividualSettings, Layout, Season,
    SeasonSettings, Source, Transfer, Tree, Variation, WarpPrecision, make_individual,
    put_in_season, synthesized,
};
use std::hint::black_box;

/// The samples that are mixed.
const PAIR: [&str; 2] = ["oak_02", "maple_01"];

/// Holes of the picture that is hardest to prepare.
const HOLES: usize = 5_000;

/// Points that are mapped in double precision, and pixels of a tree for which they stand.
const EXACT_POINTS: usize = 2_000;
const TREE_PIXELS: f64 = 530_000.0;

const PAPER_TREE: Baseline = Baseline {
    what: "Tree Variations (2017): 8 to 12 s a tree",
    ms: 8_000.0,
};
const PAPER_SEGMENTATION: Baseline = Baseline {
    what: "Tree Variations (2017): 15.5 s for segmentation alone",
    ms: 15_500.0,
};
const CGAL: Baseline = Baseline {
    what: "CGAL 5.5: 0.5 s for the coordinates of a tree's pixels",
    ms: 500.0,
};
const PLAIN_KERNEL: Baseline = Baseline {
    what: "a plain AVX kernel, every pixel mapped: 25 to 45 ms",
    ms: 25.0,
};

/// All measurements.
pub(super) fn rows(cancel: &Cancel) -> Result<Vec<Row>, Failure> {
    let pictures = PAIR.map(picture);
    let [Some(first), Some(second)] = pictures else {
        return Err(Failure::Environment("a built-in sample is missing".into()));
    };
    let mut rows = Vec::new();
    for size in [1024, 512] {
        let pair = [
            prepared(&first, size, cancel)?,
            prepared(&second, size, cancel)?,
        ];
        rows.extend(synthesis_rows(&pair, size, cancel)?);
    }
    let hard = punched_disc();
    let preparation = [
        ("preparation, oak", &first),
        ("preparation, 5,000 contours", &hard),
    ];
    for (name, picture) in preparation {
        let row = measured(name, cancel, || prepared(picture, 1024, cancel).map(drop))?;
        rows.push(row.target(150.0).against(PAPER_SEGMENTATION));
    }
    Ok(rows)
}

/// The measurements on two exemplars of `size` pixels.
fn synthesis_rows(pair: &[Exemplar; 2], size: u32, cancel: &Cancel) -> Result<Vec<Row>, Failure> {
    let layout_of = |colors: [f64; 2]| {
        let shapes = [0, 1].map(|i| (&pair[i].shape, 0.5, colors[i]));
        Layout::new(&shapes).map_err(|error| Failure::Environment(error.to_string()))
    };
    let synthesis = |layout: &Layout, colors: [f64; 2]| {
        let sources = [0, 1].map(|i| Source {
            exemplar: &pair[i],
            contour_weight: 0.5,
            color_weight: colors[i],
        });
        synthesized(layout, &sources, WarpPrecision::Interpolated, cancel)
    };
    let layout = layout_of([0.5, 0.5])?;
    if size != 1024 {
        let small = measured("synthesis 512, two exemplars", cancel, || {
            synthesis(&layout, [0.5, 0.5]).map(drop)
        })?;
        let mut rows = vec![small.target(12.0)];
        rows.extend(season_rows(synthesis(&layout, [0.5, 0.5])?, cancel)?);
        return Ok(rows);
    }
    let mut rows = Vec::new();
    let large = measured("synthesis 1024, two exemplars", cancel, || {
        synthesis(&layout, [0.5, 0.5]).map(drop)
    })?;
    rows.push(large.target(40.0).against(PAPER_TREE));
    let one = measured("synthesis 1024, colours of one", cancel, || {
        synthesis(&layout, [1.0, 0.0]).map(drop)
    })?;
    rows.push(one.against(PLAIN_KERNEL));
    rows.push(exact_row(&layout, cancel)?);
    let planning = measured("layout and distortion of a pair", cancel, || {
        layout_of([0.5, 0.5]).map(drop)
    })?;
    rows.push(planning.target(1.0));
    let tree = synthesis(&layout, [0.5, 0.5])?.image.straight();
    let other = pair[1].image.straight();
    rows.push(measured("histogram transfer", cancel, || {
        let transfer = Transfer::between(&Histogram::of(&tree), &Histogram::of(&other));
        black_box(tree.map(|&pixel| transfer.applied(pixel)));
        Ok::<(), Failure>(())
    })?);
    rows.push(measured("PNG encoding, fast", cancel, || {
        black_box(encode_png(&tree, Compression::Fast));
        Ok::<(), Failure>(())
    })?);
    Ok(rows)
}

/// What comes on top of a preview of the mix in each season, and of another individual of it.
fn season_rows(variation: Variation, cancel: &Cancel) -> Result<Vec<Row>, Failure> {
    let tree = Tree {
        image: variation.image.straight(),
        labels: variation.labels,
    };
    let put = |name: &'static str, season: Season| {
        measured(name, cancel, || {
            let settings = SeasonSettings::of(season);
            let evergreen = Some(false);
            put_in_season(
                &mut tree.clone(),
                &settings,
                evergreen,
                None,
                Seed(0),
                cancel,
            )
        })
    };
    let mut rows = vec![
        put("spring 512", Season::Spring)?,
        put("autumn 512", Season::Autumn)?,
        put("winter 512", Season::Winter)?,
    ];
    let settings = IndividualSettings {
        strength: 0.7,
        mirrored: false,
    };
    rows.push(measured("another individual, 512", cancel, || {
        make_individual(&mut tree.clone(), &settings, false, Seed(0), cancel)
    })?);
    Ok(rows)
}

/// One plain map of all pixels of a tree in double precision, reckoned from some of them.
fn exact_row(layout: &Layout, cancel: &Cancel) -> Result<Row, Failure> {
    let warp = &layout.warps[0];
    let side = f64::from(layout.size);
    let mut random = Seed(1).random();
    let points: Vec<Point> = (0..EXACT_POINTS)
        .map(|_| Point::new(random.between(0.0, side), random.between(0.0, side)))
        .collect();
    let mut row = measured("exact coordinates of 530,000 pixels", cancel, || {
        let sum: Point = points.iter().map(|&point| warp.position(point)).sum();
        black_box(sum);
        Ok::<(), Failure>(())
    })?;
    let scale = TREE_PIXELS / EXACT_POINTS as f64 / warp.steps() as f64;
    row.median_ms *= scale;
    row.min_ms *= scale;
    Ok(row.against(CGAL))
}

/// The picture of the built-in sample of this name.
fn picture(name: &str) -> Option<Image<Straight>> {
    sample_named(name)?.trimmed().ok()
}

fn prepared(picture: &Image<Straight>, size: u32, cancel: &Cancel) -> Result<Exemplar, Failure> {
    let settings = ExemplarSettings {
        size,
        ..ExemplarSettings::default()
    };
    Exemplar::prepare(picture, &settings, &Classical, Progress::silent(), cancel).map_err(failure)
}

fn failure(error: ExemplarError) -> Failure {
    match error {
        ExemplarError::Segment(SegmentError::Cancelled(cancelled)) => cancelled.into(),
        other => Failure::Environment(other.to_string()),
    }
}

/// A disc of leaves with [`HOLES`] holes that do not touch.
fn punched_disc() -> Image<Straight> {
    const SIDE: u32 = 1024;
    const CELL: u32 = 12;
    let mut random = Seed(5).random();
    let mut image = Image::filled(SIDE, SIDE, Straight::default());
    let inside = |x: u32, y: u32, radius: f64| {
        Point::new(f64::from(x), f64::from(y)).distance(Point::splat(512.0)) < radius
    };
    for y in 0..SIDE {
        for x in (0..SIDE).filter(|&x| inside(x, y, 511.0)) {
            image.set(x, y, Straight([40, 90 + random.below(60) as u8, 30, 255]));
        }
    }
    let cells = SIDE / CELL;
    let mut left = HOLES;
    for (row, column) in (0..cells).flat_map(|row| (0..cells).map(move |c| (row, c))) {
        let mut jitter = || 2 + random.below(6) as u32;
        let (x, y) = (column * CELL + jitter(), row * CELL + jitter());
        if left > 0 && inside(x, y, 500.0) {
            left -= 1;
            for (dx, dy) in (0..9).map(|i| (i % 3, i / 3)) {
                image.set(x + dx, y + dy, Straight::default());
            }
        }
    }
    image
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contour::outlines;

    #[test]
    fn the_punched_disc_has_as_many_contours_as_promised() {
        let mask = punched_disc().map(|pixel| pixel.alpha() > 127);
        assert_eq!(outlines(&mask).all.len(), HOLES + 1);
    }
}
