//! Brush strokes.
//!
//! The pointer's samples are calmed (each point goes only part of the way to the next sample), then
//! joined by quadratic curves between the middles of neighbouring points, so that a quick stroke has
//! no corners. Along the curve a **hard** brush sweeps its disc without gaps: pieces of the curve
//! are the hulls of two discs, exact for any pressure. A **soft** brush cannot leave half a label, so
//! it builds up: dabs of falling strength add to a coverage that the stroke remembers, and a pixel
//! takes the label when half covered. One pass of a soft brush is thinner than the brush and going
//! over it widens and rounds it, as painters expect.
//!
//! A stroke gives the same pixels however its samples are grouped into calls.
//!
//! Limits: a brush is at least 1.5 pixels wide, or thin strokes would have gaps.

use super::tiled::{Paint, TiledMask, joined};
use crate::geometry::Point;
use crate::raster::Rect;

/// Smallest radius: half a pixel's diagonal and a little, so that every place has a pixel.
const LEAST_RADIUS_PX: f64 = 0.75;

/// Largest radius; a larger brush than most pictures.
const MOST_RADIUS_PX: f64 = 4096.0;

/// How far the pieces of a flattened curve may be from it.
const FLATNESS_PX: f64 = 0.1;

/// Most pieces of the curve between two samples.
const MOST_PIECES: f64 = 64.0;

/// Distance of soft dabs as a share of the radius. From 0.3 on single dabs show in the outline.
const DAB_SPACING: f64 = 0.15;

/// Coverage that the middle of one dab adds; some 13 dabs go over a pixel of a straight stroke.
const DAB_FLOW: f64 = 0.25;

/// Coverage from which on a pixel takes the label.
const COVERED: u8 = 128;

/// How a brush paints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BrushSettings {
    /// Radius at full pressure, pixels.
    pub radius_px: f64,
    /// 1: a disc; below, the share of the radius that is fully covered.
    pub hardness: f64,
    /// 0: the pointer's own path; towards 1 it is followed more slowly and smoothly.
    pub smoothing: f64,
    /// Share of the radius that is left at no pressure; 1: pressure does nothing.
    pub least_pressure_size: f64,
}

impl Default for BrushSettings {
    fn default() -> Self {
        Self {
            radius_px: 20.0,
            hardness: 1.0,
            smoothing: 0.3,
            least_pressure_size: 1.0,
        }
    }
}

/// Where the pointer was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Place in the picture, pixels.
    pub position: Point,
    /// 0 to 1; 1 for a mouse.
    pub pressure: f64,
}

impl Sample {
    /// A sample of a device without pressure.
    pub fn at(x: f64, y: f64) -> Self {
        Self {
            position: Point::new(x, y),
            pressure: 1.0,
        }
    }

    fn toward(self, other: Self, share: f64) -> Self {
        Self {
            position: self.position + (other.position - self.position) * share,
            pressure: self.pressure + (other.pressure - self.pressure) * share,
        }
    }
}

/// A disc of the sweep.
#[derive(Debug, Clone, Copy)]
struct Disc {
    center: Point,
    radius: f64,
}

/// A stroke in progress, from the pointer's press to its release.
#[derive(Debug, Clone)]
pub struct Stroke {
    settings: BrushSettings,
    paint: Paint,
    /// The last sample as it came.
    last: Option<Sample>,
    /// The last calmed point: control point of the next curve.
    calm: Option<Sample>,
    /// Where the painted curve ends.
    end: Option<Sample>,
    /// Way from the last soft dab to the end of the curve.
    since_dab_px: f64,
    /// What soft dabs have covered.
    coverage: Option<TiledMask>,
}

impl Stroke {
    /// A stroke that has painted nothing yet. Settings outside of their ranges go to the nearer end.
    pub fn new(settings: BrushSettings, paint: Paint) -> Self {
        let unit = |value: f64| {
            if value.is_finite() {
                value.clamp(0.0, 1.0)
            } else {
                1.0
            }
        };
        let radius = settings.radius_px.clamp(LEAST_RADIUS_PX, MOST_RADIUS_PX);
        Self {
            settings: BrushSettings {
                radius_px: if radius.is_nan() {
                    LEAST_RADIUS_PX
                } else {
                    radius
                },
                hardness: unit(settings.hardness),
                // At 1 the stroke would never move.
                smoothing: unit(settings.smoothing).min(0.95),
                least_pressure_size: unit(settings.least_pressure_size),
            },
            paint,
            last: None,
            calm: None,
            end: None,
            since_dab_px: 0.0,
            coverage: None,
        }
    }

    /// Paints up to `sample`; the rectangle that changed. Samples that are not finite are ignored.
    pub fn extend(&mut self, mask: &mut TiledMask, sample: Sample) -> Option<Rect> {
        if !(sample.position.is_finite() && sample.pressure.is_finite()) {
            return None;
        }
        let sample = Sample {
            // Far outside nothing shows, and numbers stay exact.
            position: sample.position.clamp(Point::splat(-1e5), Point::splat(1e5)),
            pressure: sample.pressure.clamp(0.0, 1.0),
        };
        self.last = Some(sample);
        let Some(calm) = self.calm else {
            self.calm = Some(sample);
            self.end = Some(sample);
            return self.press(mask, sample);
        };
        let next = calm.toward(sample, 1.0 - self.settings.smoothing);
        self.calm = Some(next);
        self.curve(mask, calm, calm.toward(next, 0.5))
    }

    /// Paints what calming and curves still owe: up to the last sample.
    pub fn finish(mut self, mask: &mut TiledMask) -> Option<Rect> {
        let (calm, last) = (self.calm?, self.last?);
        self.curve(mask, calm, last)
    }

    /// The first dab: at full strength, so that a click paints.
    fn press(&mut self, mask: &mut TiledMask, sample: Sample) -> Option<Rect> {
        let disc = self.disc(sample);
        if self.is_hard() {
            sweep(mask, disc, disc, self.paint)
        } else {
            let covered = self.dab(mask, disc, 1.0);
            self.cover(mask, covered)
        }
    }

    /// The quadratic curve from the end of the stroke over `control` to `to`.
    fn curve(&mut self, mask: &mut TiledMask, control: Sample, to: Sample) -> Option<Rect> {
        let from = self.end.replace(to)?;
        let bend = (from.position - control.position * 2.0 + to.position).length();
        let pieces = (bend / (4.0 * FLATNESS_PX))
            .sqrt()
            .ceil()
            .clamp(1.0, MOST_PIECES);
        let mut changed = None;
        let mut before = from;
        for piece in 1..=pieces as u32 {
            let t = f64::from(piece) / pieces;
            let point = from.toward(control, t).toward(control.toward(to, t), t);
            let part = if self.is_hard() {
                sweep(mask, self.disc(before), self.disc(point), self.paint)
            } else {
                self.dabs(mask, before, point)
            };
            changed = joined(changed, part);
            before = point;
        }
        if self.is_hard() {
            changed
        } else {
            self.cover(mask, changed)
        }
    }

    fn is_hard(&self) -> bool {
        self.settings.hardness >= 1.0
    }

    fn disc(&self, sample: Sample) -> Disc {
        let least = self.settings.least_pressure_size;
        let share = least + (1.0 - least) * sample.pressure;
        Disc {
            center: sample.position,
            radius: (self.settings.radius_px * share).max(LEAST_RADIUS_PX),
        }
    }

    /// Soft dabs at equal distances on a straight piece; the rectangle of changed coverage.
    fn dabs(&mut self, mask: &TiledMask, from: Sample, to: Sample) -> Option<Rect> {
        let length = from.position.distance(to.position);
        let mut at = 0.0;
        let mut covered = None;
        loop {
            let disc = self.disc(from.toward(to, if length > 0.0 { at / length } else { 0.0 }));
            let wait = (disc.radius * DAB_SPACING).max(0.5) - self.since_dab_px;
            if at + wait > length {
                self.since_dab_px += length - at;
                return covered;
            }
            at += wait.max(0.0);
            self.since_dab_px = 0.0;
            let disc = self.disc(from.toward(to, at / length));
            covered = joined(covered, self.dab(mask, disc, DAB_FLOW));
        }
    }

    /// Adds one soft dab to the coverage.
    fn dab(&mut self, mask: &TiledMask, disc: Disc, flow: f64) -> Option<Rect> {
        let profile = profile(self.settings.hardness, flow);
        let coverage = self
            .coverage
            .get_or_insert_with(|| TiledMask::filled(mask.width(), mask.height(), 0));
        let (x, y) = (disc.center.x, disc.center.y);
        let reach = disc.radius;
        let left = (x - reach).floor() as i64;
        let top = (y - reach).floor() as i64;
        let side = (2.0 * reach).ceil() as i64 + 2;
        let rect = coverage.clipped(left, top, side, side)?;
        let scale = (PROFILE - 1) as f64 / (reach * reach);
        coverage.edit(rect, |first, row_y, row| {
            let dy = f64::from(row_y) - y;
            for (offset, pixel) in row.iter_mut().enumerate() {
                let dx = f64::from(first) + offset as f64 - x;
                // Beyond the rim the last entry, 0, is meant.
                let entry = ((dx * dx + dy * dy) * scale) as usize;
                let strength = u32::from(profile[entry.min(PROFILE - 1)]);
                let free = u32::from(255 - *pixel);
                *pixel += ((free * strength + 127) / 255) as u8;
            }
        })
    }

    /// Paints where the coverage within `rect` suffices.
    fn cover(&self, mask: &mut TiledMask, rect: Option<Rect>) -> Option<Rect> {
        let (rect, coverage) = (rect?, self.coverage.as_ref()?);
        let (x, y) = (i64::from(rect.x), i64::from(rect.y));
        let covered = coverage.window(x, y, rect.width, rect.height, 0);
        mask.edit(rect, |first, row_y, row| {
            let covered = &covered.row(row_y - rect.y)[(first - rect.x) as usize..];
            for (pixel, &covered) in row.iter_mut().zip(covered) {
                if covered >= COVERED {
                    *pixel = self.paint.on(*pixel);
                }
            }
        })
    }
}

/// Entries of a dab's profile, by the square of the distance.
const PROFILE: usize = 1024;

/// Strength of a dab, 0 to 255, by the square of the distance from its middle to its rim: `flow` up
/// to `hardness`, then falling smoothly to 0.
fn profile(hardness: f64, flow: f64) -> [u8; PROFILE] {
    std::array::from_fn(|entry| {
        let distance = (entry as f64 / (PROFILE - 1) as f64).sqrt();
        let fall = ((distance - hardness) / (1.0 - hardness)).clamp(0.0, 1.0);
        let strength = 1.0 - fall * fall * (3.0 - 2.0 * fall);
        (255.0 * flow * strength + 0.5) as u8
    })
}

/// Paints the hull of two discs.
fn sweep(mask: &mut TiledMask, a: Disc, b: Disc, paint: Paint) -> Option<Rect> {
    let hull = Hull::new(a, b);
    let low = (a.center - a.radius).min(b.center - b.radius).floor();
    let high = (a.center + a.radius).max(b.center + b.radius).ceil();
    let (width, height) = (high.x - low.x + 1.0, high.y - low.y + 1.0);
    let rect = mask.clipped(low.x as i64, low.y as i64, width as i64, height as i64)?;
    // One extent a row, asked for by every tile that the row crosses.
    let rows = rect.y..rect.y + rect.height;
    let extents: Vec<_> = rows.map(|y| hull.extent(f64::from(y))).collect();
    mask.edit(rect, |first, y, row| {
        let Some((left, right)) = extents[(y - rect.y) as usize] else {
            return;
        };
        let column = |x: f64| (x - f64::from(first)).clamp(0.0, row.len() as f64) as usize;
        let (start, end) = (column(left.ceil()), column(right.floor() + 1.0));
        if start < end {
            paint.on_all(&mut row[start..end]);
        }
    })
}

/// Two discs and the quadrilateral between their common tangents.
struct Hull {
    discs: [Disc; 2],
    /// Corners in order, none when one disc holds the other.
    between: Option<[Point; 4]>,
}

impl Hull {
    fn new(a: Disc, b: Disc) -> Self {
        let along = b.center - a.center;
        let (length, narrowing) = (along.length(), a.radius - b.radius);
        let between = (length > narrowing.abs()).then(|| {
            let (along, sine) = (along / length, narrowing / length);
            let across = along.perp() * (1.0 - sine * sine).max(0.0).sqrt();
            let (left, right) = (along * sine + across, along * sine - across);
            [
                a.center + left * a.radius,
                b.center + left * b.radius,
                b.center + right * b.radius,
                a.center + right * a.radius,
            ]
        });
        Self {
            discs: [a, b],
            between,
        }
    }

    /// From where to where the hull reaches in row `y`.
    fn extent(&self, y: f64) -> Option<(f64, f64)> {
        let mut extent: Option<(f64, f64)> = None;
        let mut reach = |low: f64, high: f64| {
            let (l, h) = extent.unwrap_or((low, high));
            extent = Some((l.min(low), h.max(high)));
        };
        for disc in self.discs {
            let dy = y - disc.center.y;
            let square = disc.radius * disc.radius - dy * dy;
            if square >= 0.0 {
                let half = square.sqrt();
                reach(disc.center.x - half, disc.center.x + half);
            }
        }
        for (i, p) in self
            .between
            .iter()
            .flat_map(|corners| corners.iter().enumerate())
        {
            let q = self.between.map_or(*p, |corners| corners[(i + 1) % 4]);
            if (p.y <= y) != (q.y <= y) {
                let x = p.x + (q.x - p.x) * (y - p.y) / (q.y - p.y);
                reach(x, x);
            }
        }
        extent
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paint::{BACKGROUND, CROWN, Over, TRUNK};
    use proptest::prelude::*;

    fn brush(radius_px: f64, hardness: f64) -> BrushSettings {
        BrushSettings {
            radius_px,
            hardness,
            smoothing: 0.0,
            least_pressure_size: 0.2,
        }
    }

    fn stroked(settings: BrushSettings, samples: &[Sample]) -> TiledMask {
        let mut mask = TiledMask::filled(256, 200, BACKGROUND);
        let mut stroke = Stroke::new(settings, Paint::of(CROWN));
        for &sample in samples {
            stroke.extend(&mut mask, sample);
        }
        stroke.finish(&mut mask);
        mask
    }

    #[test]
    fn a_click_paints_a_disc() {
        let mask = stroked(brush(10.0, 1.0), &[Sample::at(128.0, 100.0)]);
        for y in 0..200u32 {
            for x in 0..256u32 {
                let inside = (x as i32 - 128).pow(2) + (y as i32 - 100).pow(2) <= 100;
                assert_eq!(mask.at(x, y) == CROWN, inside, "({x}, {y})");
            }
        }
    }

    #[test]
    fn a_soft_brush_builds_up() {
        let path: Vec<_> = (0..8)
            .map(|i| Sample::at(40.0 + 20.0 * f64::from(i), 100.0))
            .collect();
        let there_and_back: Vec<_> = path.iter().chain(path.iter().rev()).copied().collect();
        let hard = stroked(brush(30.0, 1.0), &path).count(|l| l == CROWN);
        let once = stroked(brush(30.0, 0.2), &path).count(|l| l == CROWN);
        let twice = stroked(brush(30.0, 0.2), &there_and_back).count(|l| l == CROWN);
        assert!(
            once > hard / 3 && once < twice && twice < hard,
            "{once} {twice} {hard}"
        );
        assert!(stroked(brush(30.0, 0.2), &path[..1]).count(|l| l == CROWN) > 500);
    }

    #[test]
    fn erasing_keeps_what_is_protected() {
        let mut mask = TiledMask::filled(50, 50, TRUNK);
        let paint = Paint {
            label: BACKGROUND,
            over: Over::Only(CROWN),
        };
        let changed = Stroke::new(brush(5.0, 1.0), paint).extend(&mut mask, Sample::at(25.0, 25.0));
        assert_eq!((changed, mask), (None, TiledMask::filled(50, 50, TRUNK)));
    }

    #[test]
    fn odd_samples_harm_nothing() {
        let odd = [f64::NAN, f64::INFINITY, -1e300, 1e300, 3.0];
        let samples: Vec<_> = odd.iter().map(|&x| Sample::at(x, 3.0)).collect();
        for hardness in [1.0, 0.5, 0.0, f64::NAN] {
            assert!(stroked(brush(f64::NAN, hardness), &samples).is_canonical());
        }
    }

    /// Distance of a pixel from a segment whose radius goes from one to the other, by brute force.
    fn is_swept(pixel: Point, a: Disc, b: Disc) -> bool {
        (0..=2000).any(|i| {
            let t = f64::from(i) / 2000.0;
            let center = a.center.lerp(b.center, t);
            pixel.distance(center) <= a.radius + (b.radius - a.radius) * t + 1e-9
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        #[test]
        fn a_sweep_is_all_discs_between(
            (ax, ay, ar) in (-10.0..70.0, -10.0..70.0, 1.0..20.0),
            (bx, by, br) in (-10.0..70.0, -10.0..70.0, 1.0..20.0),
        ) {
            let a = Disc { center: Point::new(ax, ay), radius: ar };
            let b = Disc { center: Point::new(bx, by), radius: br };
            let mut mask = TiledMask::filled(64, 64, BACKGROUND);
            sweep(&mut mask, a, b, Paint::of(CROWN));
            for y in 0..64 {
                for x in 0..64 {
                    let pixel = Point::new(f64::from(x), f64::from(y));
                    let painted = mask.at(x, y) == CROWN;
                    if painted != is_swept(pixel, a, b) {
                        // Only where the brute force steps over a rim by a hundredth of a pixel.
                        let wider = |by: f64| {
                            let grown = |d: Disc| Disc { radius: d.radius + by, ..d };
                            is_swept(pixel, grown(a), grown(b))
                        };
                        prop_assert!(wider(0.02) && !wider(-0.02), "({x}, {y}) {painted}");
                    }
                }
            }
        }

        /// The changed rectangles cover all that changed, and the pixels do not depend on whether
        /// the mask was copied between the steps, as undo snapshots do.
        #[test]
        fn steps_tell_what_they_change(
            points in prop::collection::vec((-20.0..276.0, -20.0..220.0, 0.0..1.0), 1..8),
            hardness in prop::sample::select(vec![0.3, 1.0]),
        ) {
            let samples: Vec<_> = points
                .iter()
                .map(|&(x, y, pressure)| Sample { position: Point::new(x, y), pressure })
                .collect();
            let settings = BrushSettings { smoothing: 0.4, ..brush(18.0, hardness) };
            let mut mask = TiledMask::filled(256, 200, BACKGROUND);
            let mut stroke = Stroke::new(settings, Paint::of(CROWN));
            let mut changed = None;
            for &sample in &samples {
                let _snapshot = mask.clone();
                changed = joined(changed, stroke.extend(&mut mask, sample));
            }
            changed = joined(changed, stroke.finish(&mut mask));
            prop_assert_eq!(changed, mask.bounds(|l| l == CROWN));
            prop_assert_eq!(mask, stroked(settings, &samples));
        }
    }
}
