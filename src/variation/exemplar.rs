//! A tree picture made ready for synthesis: normalised, labelled, its outline as vectors.
//!
//! After Argudo, Andújar & Chica, *Tree Variations* (2017), §4. The steps are functions of their
//! own, so that `inspect` can show each; [`Exemplar::prepare`] runs them in order.

use super::gaps::gaps;
use super::habit::Habit;
use super::measures::{fullness, texture};
use super::normalize::{Normalized, normalized};
use crate::base::{Cancel, Cancelled, Progress};
use crate::contour::{HandPins, Outlines, PinnedContour, Pins, filled, outlines, pins};
use crate::geometry::{Point, Polygon};
use crate::raster::{
    Image, Mask, Premultiplied, Straight, dilated, eroded, labelled_components, resized,
};
use crate::segment::{
    Label, Labels, Provenance, SegmentError, Segmented, Segmenter, crown_baseline,
};
use serde::{Deserialize, Serialize};

/// How exemplars are prepared. All exemplars of a library share one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ExemplarSettings {
    /// Side of the square that pictures are resized to, in pixels.
    pub size: u32,
    /// Alpha above which a pixel is opaque, 0 to 1.
    pub threshold: f64,
    /// N, points of the resampled contour.
    pub points: usize,
    /// M, vertices of the cage.
    pub simplified: usize,
}

impl Default for ExemplarSettings {
    fn default() -> Self {
        Self {
            size: 1024,
            threshold: 0.5,
            points: 2000,
            simplified: 100,
        }
    }
}

impl ExemplarSettings {
    /// What is wrong with settings that came from a file, if anything: one line. Sizes beyond these
    /// take memory and time that no machine has.
    pub fn complaint(&self) -> Option<&'static str> {
        let is_threshold = self.threshold > 0.0 && self.threshold < 1.0;
        if !(16..=8192).contains(&self.size) {
            Some("\"size\" must lie between 16 and 8192")
        } else if !is_threshold {
            Some("\"threshold\" must lie between 0 and 1")
        } else if !(10..=100_000).contains(&self.points) {
            Some("\"points\" must lie between 10 and 100000")
        } else if !(10..=self.points).contains(&self.simplified) {
            Some("\"simplified\" must lie between 10 and \"points\"")
        } else {
            None
        }
    }
}

/// Why a picture cannot be an exemplar.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ExemplarError {
    /// No pixel is opaque.
    #[error("the picture is fully transparent: there is no tree in it")]
    Transparent,
    /// Every pixel is opaque.
    #[error("the picture has no transparent background; cut the tree out first")]
    NoBackground,
    /// The tree is too small to have a shape.
    #[error("the tree is only {width}×{height} pixels; at least {least}×{least} are needed")]
    TooSmall {
        /// Columns that the tree covers.
        width: u32,
        /// Rows that the tree covers.
        height: u32,
        /// The least of each.
        least: u32,
    },
    /// Segmentation failed or was cancelled.
    #[error(transparent)]
    Segment(#[from] SegmentError),
}

impl From<Cancelled> for ExemplarError {
    fn from(cancelled: Cancelled) -> Self {
        Self::Segment(cancelled.into())
    }
}

/// Fewest rows and columns of a tree that may join a library: below, an outline has no shape and
/// the picture is an icon or an accident.
const LEAST_SIDE_PX: u32 = 16;

/// Iterations of dilation between outline and cage, for pictures of 1,024 pixels (TV §4.6).
const DILATION_AT_1024: f64 = 8.0;

/// The vectors of an exemplar: all that is needed to choose and to plan, without its pixels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Shape {
    /// Side of the normalised picture, in pixels; the coordinates below are pixels of it.
    pub size: u32,
    /// C_r, the outline in N points.
    pub contour: PinnedContour,
    /// C_s, the cage of M vertices some pixels outside of it.
    pub cage: PinnedContour,
    /// Row where the crown begins above the trunk, if a trunk shows.
    pub baseline_y: Option<f64>,
    /// Share of the outline's inside that is opaque, 0 to 1: how dense the tree is.
    pub density: f64,
    /// Share of the crown's convex hull that is opaque, 0 to 1: how much of a crown there is.
    pub fullness: f64,
    /// How much the crown stands about one straight stem, 0 (round) to 1 (a spire or a column).
    pub straight: f64,
    /// How coarse the foliage is: the distance at which it looks like another place, per picture side.
    pub texture: f64,
    /// The largest gaps between branches, the largest first.
    pub gaps: Vec<Polygon>,
}

/// A prepared tree picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Exemplar {
    /// Its vectors.
    pub shape: Shape,
    /// The normalised picture, [`Shape::size`] pixels square.
    pub image: Image<Premultiplied>,
    /// Crown and trunk of the normalised picture.
    pub labels: Labels,
    /// Who told them apart.
    pub provenance: Provenance,
}

impl Exemplar {
    /// Prepares `picture`, with `segmenter` telling crown from trunk.
    ///
    /// # Errors
    /// [`ExemplarError`]: nothing or everything is opaque, the tree is too small, segmentation
    /// failed, or `cancel` was raised.
    pub fn prepare(
        picture: &Image<Straight>,
        settings: &ExemplarSettings,
        segmenter: &dyn Segmenter,
        progress: Progress<'_>,
        cancel: &Cancel,
    ) -> Result<Self, ExemplarError> {
        Self::prepare_pinned(picture, None, settings, segmenter, progress, cancel)
    }

    /// As [`Exemplar::prepare`], with pins that were set by hand in the normalised picture, if they
    /// were.
    ///
    /// # Errors
    /// As [`Exemplar::prepare`].
    pub fn prepare_pinned(
        picture: &Image<Straight>,
        by_hand: Option<HandPins>,
        settings: &ExemplarSettings,
        segmenter: &dyn Segmenter,
        progress: Progress<'_>,
        cancel: &Cancel,
    ) -> Result<Self, ExemplarError> {
        let stage = progress.stage("normalize", 1);
        let normalized = normalized(picture, settings.size, settings.threshold)?;
        check_usable(picture, &normalized)?;
        drop(stage);
        let stage = progress.stage("segment", 1);
        let Segmented { labels, provenance } =
            segmenter.segmented(&normalized.image.straight(), cancel)?;
        drop(stage);
        let outlined = Outlined {
            by_hand,
            ..Outlined::new(&normalized, progress)
        };
        let shape = outlined.shape(&normalized.image, &labels, settings, progress);
        Ok(Self {
            shape,
            image: normalized.image,
            labels,
            provenance,
        })
    }
}

impl Shape {
    /// The same shape in pixels of a picture of another `size`.
    pub fn resized(&self, size: u32) -> Self {
        let scale = f64::from(size) / f64::from(self.size);
        let scaled = |contour: &PinnedContour| PinnedContour {
            points: contour.points.iter().map(|point| *point * scale).collect(),
            pins: contour.pins,
        };
        Self {
            size,
            contour: scaled(&self.contour),
            cage: scaled(&self.cage),
            baseline_y: self.baseline_y.map(|y| y * scale),
            density: self.density,
            fullness: self.fullness,
            straight: self.straight,
            texture: self.texture,
            gaps: self
                .gaps
                .iter()
                .map(|gap| gap.iter().map(|point| *point * scale).collect())
                .collect(),
        }
    }
}

impl Exemplar {
    /// The exemplar at another `size`: for quick looks, which need not be prepared anew and
    /// therefore show what the full size will.
    pub fn resized(&self, size: u32) -> Self {
        let own = self.shape.size;
        let nearest =
            |i: u32| ((2 * u64::from(i) + 1) * u64::from(own) / (2 * u64::from(size))) as u32;
        let places = (0..size).flat_map(|y| (0..size).map(move |x| (x, y)));
        let labels = places.map(|(x, y)| self.labels.at(nearest(x), nearest(y)));
        Self {
            shape: self.shape.resized(size),
            image: resized(&self.image, self.image.rect(), size, size),
            labels: Image::from_pixels(size, size, labels.collect()),
            provenance: self.provenance.clone(),
        }
    }
}

/// Refuses pictures that can be looked at but not used.
fn check_usable(picture: &Image<Straight>, normalized: &Normalized) -> Result<(), ExemplarError> {
    let crop = normalized.placement.crop;
    if crop.width < LEAST_SIDE_PX || crop.height < LEAST_SIDE_PX {
        return Err(ExemplarError::TooSmall {
            width: crop.width,
            height: crop.height,
            least: LEAST_SIDE_PX,
        });
    }
    if picture.pixels().iter().all(|pixel| pixel.alpha() == 255) {
        return Err(ExemplarError::NoBackground);
    }
    Ok(())
}

/// A normalised picture and all borders of its opaque part.
pub struct Outlined {
    /// The opaque pixels, which the borders were followed on.
    pub mask: Mask,
    /// All borders.
    pub outlines: Outlines,
    /// The longest exterior border, counter-clockwise as seen on screen.
    pub longest: Vec<Point>,
    /// The pins that somebody set.
    pub by_hand: Option<HandPins>,
}

impl Outlined {
    /// Follows the borders of `normalized`.
    pub fn new(normalized: &Normalized, progress: Progress<'_>) -> Self {
        let _stage = progress.stage("contours", 1);
        let mask = normalized.mask.clone();
        let outlines = outlines(&mask);
        let longest = outlines
            .longest_exterior()
            .unwrap_or_else(|| unreachable!("a normalised picture has opaque pixels"));
        Self {
            mask,
            outlines,
            longest,
            by_hand: None,
        }
    }

    /// The pins of the longest border.
    pub fn pins(&self, labels: &Labels) -> (Pins, Option<f64>) {
        if let Some(by_hand) = &self.by_hand {
            let pins = by_hand.on(&self.longest, f64::from(self.mask.width()));
            let tops = [pins.left, pins.right].map(|pin| self.longest[pin].y);
            let baseline_y = pins.has_trunk().then(|| tops[0].min(tops[1]));
            return (pins, baseline_y);
        }
        let baseline_y = crown_baseline(labels).map(f64::from);
        let on_trunk = |p: Point| labels.get(p.x as i64, p.y as i64) == Some(Label::Trunk);
        (pins(&self.longest, baseline_y, on_trunk), baseline_y)
    }

    /// The outline of `image` as vectors: resampled contour and cage; and what else is compared.
    pub fn shape(
        &self,
        image: &Image<Premultiplied>,
        labels: &Labels,
        settings: &ExemplarSettings,
        progress: Progress<'_>,
    ) -> Shape {
        let stage = progress.stage("pins", 1);
        let (pins, baseline_y) = self.pins(labels);
        drop(stage);
        let stage = progress.stage("resample", 1);
        let contour = PinnedContour::resampled(&self.longest, pins, settings.points);
        drop(stage);
        let _stage = progress.stage("simplify", 1);
        let inside = filled(&contour.points, Point::ZERO, settings.size, settings.size);
        let cage = cage(&contour, &self.mask, settings);
        let gaps = gaps(&cage.points, &self.mask);
        let opaque = inside
            .pixels()
            .iter()
            .zip(self.mask.pixels())
            .filter(|(i, m)| **i && **m);
        let density = opaque.count() as f64 / inside.count().max(1) as f64;
        Shape {
            size: settings.size,
            contour,
            cage,
            baseline_y,
            density,
            fullness: fullness(&self.mask, labels),
            straight: Habit::seen(&self.mask, labels).map_or(0.0, |habit| habit.straight()),
            texture: texture(image, &self.mask, labels),
            gaps,
        }
    }
}

/// C_s: the outline of the filled and dilated contour, resampled between the same pins (TV §4.6).
///
/// Departure from the paper: leaves that float free but lie within reach of the dilation are
/// filled too, so that the cage goes round them instead of cutting them.
fn cage(contour: &PinnedContour, mask: &Mask, settings: &ExemplarSettings) -> PinnedContour {
    let radius = (DILATION_AT_1024 * f64::from(settings.size) / 1024.0)
        .round()
        .max(2.0);
    let margin = (radius + BRIDGE_AT_1024 * f64::from(settings.size) / 1024.0) as u32 + 3;
    let side = settings.size + 2 * margin;
    let offset = Point::splat(f64::from(margin));
    let mut inside = filled(&contour.points, offset, side, side);
    add_floating_parts(&mut inside, mask, margin, radius as u8);
    let grown = closed_and_grown(&inside, radius, settings.size);
    let outer: Vec<Point> = outlines(&grown)
        .longest_exterior()
        .unwrap_or_else(|| unreachable!("a filled contour has an inside"))
        .into_iter()
        .map(|point| point - offset)
        .collect();
    let pins = moved_pins(contour, &outer, radius);
    PinnedContour::with_feet(&outer, pins, settings.simplified)
}

/// Bays of the outline up to twice this width are bridged by the cage, for pictures of 1,024 pixels.
///
/// Departure from the paper: round every branch the way is so long that hundred vertices, equally far
/// apart, meet the tips of one tree and the forks of the next. Of the 1,482 ordered pairs of 39 real
/// trees mixed by halves 72 % folded nowhere without bridges, 98.1 % with 24 pixels and 99.7 % with 48;
/// the mean stretching was 2.4, 1.7 and 1.6. The branches are in the picture's alpha.
const BRIDGE_AT_1024: f64 = 48.0;

/// `inside` with narrow gaps bridged, grown by `radius`.
fn closed_and_grown(inside: &Mask, radius: f64, size: u32) -> Mask {
    let bridge = (BRIDGE_AT_1024 * f64::from(size) / 1024.0).round();
    let far = dilated(inside, (bridge + radius).min(255.0) as u8);
    eroded(&far, bridge.min(255.0) as u8)
}

/// Adds to `inside` the parts of `mask` that a dilation by `radius` of both would join to it.
fn add_floating_parts(inside: &mut Mask, mask: &Mask, margin: u32, radius: u8) {
    let mut all = inside.clone();
    for y in 0..mask.height() {
        let row = &mut all.row_mut(y + margin)[margin as usize..];
        for (all, &own) in row.iter_mut().zip(mask.row(y)) {
            *all |= own;
        }
    }
    let joined = labelled_components(&dilated(&all, radius));
    let main = inside.pixels().iter().position(|&own| own);
    let Some(main) = main.map(|index| joined.pixels()[index]) else {
        return;
    };
    let parts = joined.pixels().iter().zip(all.pixels());
    for (inside, (&part, &own)) in inside.pixels_mut().iter_mut().zip(parts) {
        *inside |= own && part == main;
    }
}

/// The pins of `contour` on the wider outline `outer`.
fn moved_pins(contour: &PinnedContour, outer: &[Point], radius: f64) -> Pins {
    let count = outer.len();
    let nearest = |to: Point, among: &mut dyn Iterator<Item = usize>| {
        let distance = |i: &usize| outer[*i].distance_squared(to);
        among
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
            .unwrap_or(0)
    };
    let bottom = nearest(contour.bottom() + Point::new(0.0, radius), &mut (0..count));
    if !contour.pins.has_trunk() || count < 4 {
        return Pins::without_trunk(bottom);
    }
    // The sides of a trunk are upright: its dilation moves them sideways. Each is looked for on its
    // own half of the way round, where a bridge may have hidden it.
    let half = |steps: std::ops::Range<usize>| steps.map(|step| (bottom + step) % count);
    let right = contour.right() + Point::new(radius, 0.0);
    let left = contour.left() - Point::new(radius, 0.0);
    Pins {
        bottom,
        right: nearest(right, &mut half(1..count / 2)),
        left: nearest(left, &mut half(count / 2..count)),
    }
}
