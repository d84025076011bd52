//! Selections that are being drawn: the line of lasso, polygon and livewire, the strokes of smart
//! select. They are no part of the project until they are closed.

use crate::base::Cancel;
use crate::document::PhotoId;
use crate::geometry::Point;
use crate::paint::{BrushSettings, INSIDE, Livewire, OUTSIDE, Paint, Sample, Stroke, TiledMask};
use crate::raster::{Image, Straight};
use std::sync::Arc;

/// A selection in progress.
pub(super) enum Sketch {
    /// A line that goes round what is to be labelled.
    Line(Line),
    /// A line that clings to edges.
    Wire(Box<Wire>),
    /// Strokes inside and outside.
    Smart(Smart),
}

/// Which line it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LineKind {
    /// Follows the hand.
    Free,
    /// Straight from click to click.
    Straight,
}

/// The line of a lasso or a polygon, in pixels of the photograph.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Line {
    pub(super) kind: LineKind,
    pub(super) photo: PhotoId,
    pub(super) points: Vec<Point>,
    /// Where the hand is; not yet a vertex.
    pub(super) hand: Option<Point>,
    /// Whether it clears what it goes round.
    pub(super) erases: bool,
}

impl Line {
    pub(super) fn new(kind: LineKind, photo: PhotoId, start: Point, erases: bool) -> Self {
        Self {
            kind,
            photo,
            points: vec![start],
            hand: None,
            erases,
        }
    }

    /// Adds a vertex; of a free line only if it is a visible step away from the last.
    pub(super) fn add(&mut self, point: Point) {
        let is_step = |last: &Point| last.distance_squared(point) >= 0.25;
        if self.points.last().is_none_or(is_step) {
            self.points.push(point);
        }
        self.hand = None;
    }
}

/// The line of a livewire: what was clicked, and the way from the last click to the hand.
pub(super) struct Wire {
    pub(super) photo: PhotoId,
    picture: Arc<Image<Straight>>,
    /// Each from one click to the next, both included.
    legs: Vec<Vec<(u32, u32)>>,
    start: (u32, u32),
    from_last: Livewire,
    tail: Vec<(u32, u32)>,
    pub(super) erases: bool,
}

impl Wire {
    pub(super) fn new(
        photo: PhotoId,
        picture: Arc<Image<Straight>>,
        start: Point,
        erases: bool,
    ) -> Self {
        let start = pixel(&picture, start);
        Self {
            photo,
            from_last: Livewire::new(&picture, start),
            picture,
            legs: Vec::new(),
            start,
            tail: Vec::new(),
            erases,
        }
    }

    /// Leads the line to the hand.
    pub(super) fn lead(&mut self, to: Point) {
        let to = pixel(&self.picture, to);
        if self.tail.last() != Some(&to) {
            // Nobody raises this flag: the way is within a window and found in a moment.
            self.tail = self
                .from_last
                .path_to(to, &Cancel::new())
                .unwrap_or_default();
        }
    }

    /// Fixes the line up to here.
    pub(super) fn fix(&mut self, at: Point) {
        self.lead(at);
        let leg = std::mem::take(&mut self.tail);
        if let Some(&last) = leg.last()
            && leg.len() > 1
        {
            self.legs.push(leg);
            self.from_last = Livewire::new(&self.picture, last);
        }
    }

    /// Takes back the last click; whether any is left.
    pub(super) fn unfix(&mut self) -> bool {
        if self.legs.pop().is_none() {
            return false;
        }
        self.from_last = Livewire::new(
            &self.picture,
            self.anchors().last().map_or(self.start, |&a| a),
        );
        self.tail.clear();
        true
    }

    /// The pixels that were clicked.
    pub(super) fn anchors(&self) -> Vec<(u32, u32)> {
        let ends = self.legs.iter().filter_map(|leg| leg.last().copied());
        std::iter::once(self.start).chain(ends).collect()
    }

    /// All of the line, up to the hand.
    pub(super) fn line(&self) -> impl Iterator<Item = Point> + '_ {
        let pixels = self.legs.iter().flatten().chain(&self.tail);
        pixels.map(|&(x, y)| Point::new(f64::from(x), f64::from(y)))
    }

    /// The closed line: what was fixed, and the way back to the start along edges.
    pub(super) fn closed(mut self) -> Vec<Point> {
        let (x, y) = self.start;
        self.fix(Point::new(f64::from(x), f64::from(y)));
        self.tail.clear();
        self.line().collect()
    }
}

/// The pixel of the picture nearest to a point.
fn pixel(picture: &Image<Straight>, point: Point) -> (u32, u32) {
    let side = |at: f64, length: u32| at.round().clamp(0.0, f64::from(length - 1)) as u32;
    (
        side(point.x, picture.width()),
        side(point.y, picture.height()),
    )
}

/// Strokes inside and outside, and what they select.
pub(super) struct Smart {
    pub(super) photo: PhotoId,
    /// The strokes.
    pub(super) hints: TiledMask,
    /// The one that is being drawn.
    stroke: Option<Stroke>,
    /// How many were drawn: a result for fewer of them is stale, but better than none.
    pub(super) strokes: u32,
    /// What the last strokes that were thought about select.
    pub(super) selection: Option<Arc<TiledMask>>,
    /// The strokes that the selection is for.
    pub(super) selected_for: u32,
    /// Whether it becomes labels as soon as it is there.
    pub(super) is_wanted: bool,
}

impl Smart {
    pub(super) fn new(photo: PhotoId, width: u32, height: u32) -> Self {
        Self {
            photo,
            hints: TiledMask::filled(width, height, 0),
            stroke: None,
            strokes: 0,
            selection: None,
            selected_for: 0,
            is_wanted: false,
        }
    }

    /// Begins a stroke.
    pub(super) fn press(&mut self, settings: BrushSettings, is_outside: bool) {
        let hint = if is_outside { OUTSIDE } else { INSIDE };
        self.stroke = Some(Stroke::new(settings, Paint::of(hint)));
        self.is_wanted = false;
    }

    pub(super) fn extend(&mut self, sample: Sample) {
        if let Some(stroke) = &mut self.stroke {
            stroke.extend(&mut self.hints, sample);
        }
    }

    /// Ends the stroke; whether there was one.
    pub(super) fn lift(&mut self) -> bool {
        let Some(stroke) = self.stroke.take() else {
            return false;
        };
        stroke.finish(&mut self.hints);
        self.strokes += 1;
        true
    }

    /// Whether the selection is for all strokes there are.
    pub(super) fn is_up_to_date(&self) -> bool {
        self.selection.is_some() && self.selected_for == self.strokes
    }
}
