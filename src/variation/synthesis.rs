//! One new tree: outlines combined, pictures warped into the new outline, colours mixed.
//!
//! After Argudo, Andújar & Chica, *Tree Variations* (2017), §5.1–5.2.
//!
//! *Departures.* (1) Pictures are pulled through composite mean value maps ([`Warp`]) instead of
//! plain ones, which fold. (2) Colours are averaged by weight *times alpha*, not over all sources of
//! non-zero alpha: the colour of an almost transparent pixel is noise. (3) The alpha of the new tree
//! is that of its sources inside the new cage; cutting it at the combined outline, as the paper
//! does, would cut through leaves. The combined outline still says where the tree is.
//!
//! *Speed.* Two billboards at 1,024² on the Zen 5 cores described in `mean_value`, composite maps of
//! four steps: 38 ms on one core, 24 ms on two; half of it for the maps, a third for sampling and
//! mixing, 3 % for flooding, which one thread does. `boscage bench` on its two samples: 15 ms, and
//! 4.4 ms at 512². Memory is no limit: 8 MB of sources are read and 5 MB written in that time,
//! under 1 GB/s of the 30 GB/s that a copy moves there. What limits is arithmetic: the maps are at
//! the pace of the vector units, the mix still spends most of its time gathering and spilling lanes.

use super::gaps::common_gaps;
use super::leaf_size::LeafSize;
use super::matched::{combined, combined_outline, matched};
use super::mean_value::{Cage, CageError};
use super::mix::MixTile;
use super::warp::{TILE, Warp, WarpPrecision, WarpTile, needed_pixels};
use super::{Distortion, Exemplar, Shape};
use crate::base::{Cancel, Cancelled, with_level_of_cpu};
use crate::contour::{PinnedContour, filled};
use crate::geometry::{Point, Polygon};
use crate::raster::{Image, Mask, Premultiplied};
use crate::segment::{Label, Labels};
use rayon::prelude::*;
use std::borrow::Cow;

/// What one exemplar gives to a new tree.
#[derive(Debug, Clone, Copy)]
pub struct Source<'a> {
    /// The exemplar.
    pub exemplar: &'a Exemplar,
    /// Its share of the outline; the shares of all sources sum to 1.
    pub contour_weight: f64,
    /// Its share of the colours; likewise. A source of no share gives neither colour nor alpha.
    pub color_weight: f64,
}

/// A new tree.
#[derive(Debug, Clone, PartialEq)]
pub struct Variation {
    /// The picture, as large as the exemplars'.
    pub image: Image<Premultiplied>,
    /// Its crown and trunk.
    pub labels: Labels,
}

/// What becomes of leaves where a map stretches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Leaves {
    /// Foliage comes in pieces of its natural size.
    #[default]
    KeepTheirSize,
    /// They are drawn out: for pictures in motion.
    Stretch,
}

/// The outline of a new tree and the maps back to its sources, before any pixel is made.
#[derive(Debug, Clone)]
pub struct Layout {
    /// Side of the picture, in pixels.
    pub size: u32,
    /// The combined outline C′_r.
    pub contour: PinnedContour,
    /// The combined cage C′_s.
    pub cage: PinnedContour,
    /// For each source the map from the new tree to it.
    pub warps: Vec<Warp>,
    /// Gaps between branches that all sources have, where they are in the new tree.
    pub gaps: Vec<Polygon>,
    /// The worst distortion among the maps whose source gives colour.
    pub distortion: Distortion,
    /// What becomes of leaves where a map stretches.
    pub leaves: Leaves,
}

/// Most steps of a composite map: more than 16 changed nothing on 741 pairs of real trees.
const MOST_STEPS: usize = 16;

/// Mean distance in pixels, at a size of 1,024, that a cage vertex moves in one step. Smaller steps
/// fold less and cost more; see `docs/ARCHITECTURE.md` for the figures behind it.
const STEP_AT_1024_PX: f64 = 24.0;

impl Layout {
    /// The layout of the tree that mixes `shapes` with `(contour weight, color weight)`.
    ///
    /// # Errors
    /// [`CageError`] when a combined cage has no area.
    ///
    /// # Panics
    /// When there are no shapes or they were prepared with different settings.
    pub fn new(shapes: &[(&Shape, f64, f64)]) -> Result<Self, CageError> {
        let size = shapes[0].0.size;
        let contour = combined_outline(shapes);
        let cages = matched(shapes, |shape| &shape.cage);
        let cage = combined(&cages, shapes);
        let maps = Maps::new(&cage, &cages, shapes)?;
        Ok(Self {
            size,
            contour,
            cage,
            warps: maps.warps,
            gaps: maps.gaps,
            distortion: maps.distortion,
            leaves: Leaves::default(),
        })
    }

    /// The pixels that may belong to the tree: inside the cage or inside the outline. The cage has
    /// few vertices and cuts corners, the foot of the trunk first of all; the outline has them.
    fn inside(&self) -> Mask {
        let (contour, cage) = (&self.contour.points, &self.cage.points);
        let mut inside = filled(cage, Point::ZERO, self.size, self.size);
        let outline = filled(contour, Point::ZERO, self.size, self.size);
        for (inside, outlined) in inside.pixels_mut().iter_mut().zip(outline.pixels()) {
            *inside |= outlined;
        }
        inside
    }
}

/// The maps of a mix, and the worst distortion among those whose source gives colour.
struct Maps {
    warps: Vec<Warp>,
    gaps: Vec<Polygon>,
    distortion: Distortion,
}

/// How much worse maps may get, see [`Distortion::penalty`], for gaps that stay where they belong.
const WORSE_FOR_GAPS: f64 = 1.05;

impl Maps {
    /// The maps from `cage`, the combination of `cages`, to each of these; with the gaps that all
    /// `shapes` have, unless the maps get worse by them.
    fn new(
        cage: &PinnedContour,
        cages: &[Cow<'_, PinnedContour>],
        shapes: &[(&Shape, f64, f64)],
    ) -> Result<Self, CageError> {
        let weights: Vec<(f64, f64)> = shapes.iter().map(|(_, c, p)| (*c, *p)).collect();
        let size = shapes[0].0.size;
        let target = Cage::new(std::slice::from_ref(&cage.points))?;
        let sources: Vec<Cage> = cages
            .iter()
            .map(|own| target.moved(own.points.clone()))
            .collect::<Result<_, _>>()?;
        let without = Self::between(&target, &sources, &[&cage.points], &weights, size)?;
        let gaps: Vec<&[Polygon]> = shapes.iter().map(|(s, _, _)| s.gaps.as_slice()).collect();
        let common = common_gaps(&sources, &gaps);
        if shapes.len() < 2 || common[0].is_empty() {
            return Ok(without);
        }
        let mut best = without;
        let limit = WORSE_FOR_GAPS * best.distortion.penalty();
        let mut kept: Vec<usize> = Vec::new();
        // All at once where that is good, else the largest first, each if the maps bear it.
        let all: Vec<usize> = (0..common[0].len()).collect();
        let single = all.iter().map(|&gap| vec![gap]);
        for tried in std::iter::once(all.clone()).chain(single) {
            let tried = [kept.clone(), tried].concat();
            let with = Self::with_gaps(cage, cages, &tried, &common, &weights, size);
            if let Some(with) = with
                && with.distortion.folded <= best.distortion.folded
                && with.distortion.penalty() <= limit
            {
                (best, kept) = (with, tried);
            }
            if kept.len() == all.len() {
                break;
            }
        }
        Ok(best)
    }

    /// The maps with the gaps `chosen` of those in common as further polygons; `None` where they have no
    /// area.
    fn with_gaps(
        cage: &PinnedContour,
        cages: &[Cow<'_, PinnedContour>],
        chosen: &[usize],
        common: &[Vec<Polygon>],
        weights: &[(f64, f64)],
        size: u32,
    ) -> Option<Self> {
        let mut polygons = vec![cage.points.clone()];
        polygons.extend(chosen.iter().map(|&gap| {
            let parts = common.iter().zip(weights);
            weighted_sum(parts.map(|(own, (weight, _))| (&own[gap], *weight)))
        }));
        let target = Cage::new(&polygons).ok()?;
        let with_gaps = cages.iter().zip(common).map(|(own, gaps)| {
            let gaps = chosen.iter().flat_map(|&gap| &gaps[gap]);
            let points = own.points.iter().chain(gaps);
            target.moved(points.copied().collect()).ok()
        });
        let sources: Vec<Cage> = with_gaps.collect::<Option<_>>()?;
        let around: Vec<&[Point]> = polygons.iter().map(Vec::as_slice).collect();
        let maps = Self::between(&target, &sources, &around, weights, size).ok()?;
        Some(Self {
            gaps: polygons.split_off(1),
            ..maps
        })
    }

    /// The maps from `target` to `sources`, whose shares are `weights` of outline and colours, measured
    /// inside the first polygon of `inside` and outside of the others.
    fn between(
        target: &Cage,
        sources: &[Cage],
        inside: &[&[Point]],
        weights: &[(f64, f64)],
        size: u32,
    ) -> Result<Self, CageError> {
        let mut distortion = Distortion::NONE;
        let mut warps = Vec::with_capacity(sources.len());
        for (source, (_, color_weight)) in sources.iter().zip(weights) {
            let steps = steps_between(target.points(), source.points(), size);
            let warp = Warp::new(target, source, steps)?;
            if *color_weight > 0.0 {
                distortion = distortion.worst(Distortion::within(&warp, inside));
            }
            warps.push(warp);
        }
        Ok(Self {
            warps,
            gaps: Vec::new(),
            distortion,
        })
    }
}

/// Σ wᵢ·pᵢ of polygons of the same number of points.
fn weighted_sum<'a>(parts: impl Iterator<Item = (&'a Polygon, f64)>) -> Polygon {
    let mut sum: Polygon = Vec::new();
    for (polygon, weight) in parts {
        sum.resize(polygon.len(), Point::ZERO);
        for (sum, point) in sum.iter_mut().zip(polygon) {
            *sum += *point * weight;
        }
    }
    sum
}

/// Steps of the composite map between two cages of pictures of `size` pixels.
fn steps_between(from: &[Point], to: &[Point], size: u32) -> usize {
    let count = from.len() as f64;
    let moved: f64 = from.iter().zip(to).map(|(a, b)| a.distance(*b)).sum();
    let step = STEP_AT_1024_PX * f64::from(size) / 1024.0;
    ((moved / count / step).ceil() as usize).clamp(1, MOST_STEPS)
}

/// Makes the tree of `layout` from its `sources`, given in the same order.
///
/// # Errors
/// [`Cancelled`].
pub fn synthesized(
    layout: &Layout,
    sources: &[Source<'_>],
    precision: WarpPrecision,
    cancel: &Cancel,
) -> Result<Variation, Cancelled> {
    let size = layout.size as usize;
    let inside = layout.inside();
    let giving: Vec<Giving<'_>> = layout
        .warps
        .iter()
        .zip(sources)
        .filter(|(_, source)| source.color_weight > 0.0)
        .map(|(warp, source)| Giving {
            warp,
            source,
            pieces: match layout.leaves {
                Leaves::KeepTheirSize => LeafSize::new(warp, source.exemplar, &inside),
                Leaves::Stretch => None,
            },
        })
        .collect();
    let mut pixels = vec![Premultiplied::default(); size * size];
    let mut labels = vec![Label::Background; size * size];
    pixels
        .par_chunks_mut(size * TILE)
        .zip(labels.par_chunks_mut(size * TILE))
        .enumerate()
        .try_for_each(|(band, (pixels, labels))| {
            cancel.check()?;
            let rows = Band {
                top: band * TILE,
                size,
                pixels,
                labels,
            };
            rows.fill(&giving, &inside, precision);
            Ok(())
        })?;
    Ok(Variation {
        image: Image::from_pixels(layout.size, layout.size, pixels),
        labels: Image::from_pixels(layout.size, layout.size, labels),
    })
}

/// [`TILE`] rows of the new picture.
struct Band<'a> {
    top: usize,
    size: usize,
    pixels: &'a mut [Premultiplied],
    labels: &'a mut [Label],
}

/// A source that gives colours.
struct Giving<'a> {
    warp: &'a Warp,
    source: &'a Source<'a>,
    pieces: Option<LeafSize<'a>>,
}

impl Band<'_> {
    fn fill(self, giving: &[Giving<'_>], inside: &Mask, precision: WarpPrecision) {
        let mut parts: Vec<(WarpTile, &Source<'_>)> = giving
            .iter()
            .map(|giving| (WarpTile::new(), giving.source))
            .collect();
        for left in (0..self.size).step_by(TILE) {
            let needed = needed_pixels(inside, left, self.top);
            if needed.iter().all(|&bits| bits == 0) {
                continue;
            }
            for ((tile, _), giving) in parts.iter_mut().zip(giving) {
                giving
                    .warp
                    .fill_tile(tile, left, self.top, &needed, precision);
                if let Some(pieces) = &giving.pieces {
                    pieces.fill_tile(tile, left, self.top, &needed);
                }
            }
            with_level_of_cpu(MixTile {
                parts: &parts,
                needed: &needed,
                left,
                size: self.size,
                pixels: self.pixels,
                labels: self.labels,
            });
        }
    }
}
