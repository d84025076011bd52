//! Leaves that keep their size where a map stretches.
//!
//! A smooth map draws leaves out wherever it has to bridge outlines that differ: the picture turns to
//! streaks (Argudo, Andújar & Chica 2017, *Tree Variations*, Fig. 15). There we take foliage from the
//! same neighbourhood of the exemplar in pieces that are only turned, never stretched.
//!
//! *Idea.* A lattice of triangles lies over the new tree. Each corner knows where the smooth map takes
//! it and how the map turns there, and offers the exemplar's picture round that place at its natural
//! size. A pixel where the map stretches more than [`FINE`] chooses between the offers of its three
//! corners: the nearer corner counts more, and so does light foliage, so that the seams run in the
//! dark gaps between leaves (the lattice is that of E. Heitz and F. Neyret, *High-performance
//! by-example noise using a histogram-preserving blending operator*, 2018; we choose where they blend,
//! since averaged leaves are no leaves). Corners where the smooth map would repeat what a neighbour
//! offers look a little aside.
//!
//! *Limits.* Pieces do not join branches: trunks, and trees too sparse to hide seams, are left to the
//! smooth map. In a moving picture the lattice would stand still before the leaves: `morph` leaves it
//! out.

use super::Exemplar;
use super::mean_value::{LANES, Lanes};
use super::warp::{TILE, Warp, WarpTile};
use crate::base::Seed;
use crate::raster::Mask;
use crate::segment::Label;

/// Distance of the lattice's corners, for pictures of 1,024 pixels: some leaves.
const SPACING_AT_1024: f64 = 40.0;

/// Stretching up to which the smooth map alone is used, see [`super::Distortion::stretch`].
const FINE: f32 = 1.3;

/// Stretching from which pieces alone are used.
const COARSE: f32 = 1.6;

/// How much the lightness of an offer counts beside the nearness of its corner.
const LIGHTNESS: f32 = 0.35;

/// Trees less dense than this are left alone: their branches show.
const LEAST_DENSITY: f64 = 0.7;

/// Trees whose crown covers less of its hull are left alone likewise: palms, whose fronds would break.
const LEAST_FULLNESS: f64 = 0.53;

/// Distance of the points of a central difference from a corner, in pixels.
const DIFFERENCE_PX: f32 = 3.0;

/// How much larger (the first) or smaller leaves may get with the tree as a whole.
const SIZES: (f32, f32) = (0.7, 1.4);

/// How far aside a corner may look, as a share of the lattice's spacing.
const ASIDE: f64 = 0.5;

/// Height of a row of the lattice by its spacing.
const ROW: f64 = 0.866_025_403_784_438_6;

/// What a corner of the lattice offers.
#[derive(Debug, Clone, Copy, Default)]
struct Corner {
    /// Where it is in the new tree.
    at: [f32; 2],
    /// Where it looks in the exemplar.
    source: [f32; 2],
    /// The turn from the new tree to the exemplar and the size of the tree as a whole.
    turn: [f32; 2],
    /// How far the smooth map stretches; 0 outside the tree.
    stretch: f32,
}

/// Pieces of an exemplar at natural size, for one map.
#[derive(Debug)]
pub(super) struct LeafSize<'a> {
    exemplar: &'a Exemplar,
    spacing: f32,
    /// Corners in a row of the skewed lattice, and the index of its first.
    columns: i32,
    first_column: i32,
    corners: Vec<Corner>,
}

impl<'a> LeafSize<'a> {
    /// The pieces of `exemplar` for the tree `inside` as seen through `warp`; `None` where the smooth
    /// map does well everywhere, or pieces would not.
    pub(super) fn new(warp: &Warp, exemplar: &'a Exemplar, inside: &Mask) -> Option<Self> {
        let shape = &exemplar.shape;
        if shape.density < LEAST_DENSITY || shape.fullness < LEAST_FULLNESS {
            return None;
        }
        let spacing = SPACING_AT_1024 * f64::from(inside.width()) / 1024.0;
        let rows = (f64::from(inside.height()) / (ROW * spacing)).ceil() as i32 + 2;
        let first_column = -(rows / 2) - 1;
        let columns = (f64::from(inside.width()) / spacing).ceil() as i32 + 2 - first_column;
        let mut pieces = Self {
            exemplar,
            spacing: spacing as f32,
            columns,
            first_column,
            corners: vec![Corner::default(); (columns * rows) as usize],
        };
        let coarsest = pieces.look(warp, inside);
        (coarsest > FINE).then_some(pieces)
    }

    /// Fills the corners inside the tree; the largest stretching among them.
    fn look(&mut self, warp: &Warp, inside: &Mask) -> f32 {
        let (spacing, columns, first) = (f64::from(self.spacing), self.columns, self.first_column);
        let mut within = Vec::new();
        for (index, corner) in (0i32..).zip(&mut self.corners) {
            let (row, column) = (index / columns, index % columns + first);
            let x = (f64::from(column) + 0.5 * f64::from(row)) * spacing;
            let y = f64::from(row) * ROW * spacing;
            corner.at = [x as f32, y as f32];
            if inside.get(x.round() as i64, y.round() as i64) == Some(true) {
                within.push(index as usize);
            }
        }
        let ats: Vec<[f32; 2]> = within.iter().map(|&i| self.corners[i].at).collect();
        let derivatives = derivatives(warp, &ats);
        let mut areas: Vec<f32> = derivatives
            .iter()
            .map(|(_, [a, b, c, d])| (a * d - b * c).abs())
            .collect();
        areas.sort_by(f32::total_cmp);
        let scale = areas.get(areas.len() / 2).map_or(1.0, |area| area.sqrt());
        let scale = scale.clamp(0.25, 4.0);
        let mut coarsest = 0.0f32;
        for (&index, (source, derivative)) in within.iter().zip(&derivatives) {
            let corner = &mut self.corners[index];
            corner.source = *source;
            corner.turn = turn(derivative).map(|part| part * scale.clamp(SIZES.0, SIZES.1));
            corner.stretch = stretch(derivative, scale);
            coarsest = coarsest.max(corner.stretch);
            if corner.stretch > FINE {
                let aside = aside(self.exemplar, *source, spacing, index);
                self.corners[index].source = aside;
            }
        }
        coarsest
    }

    /// Puts pieces into the tile at (`left`, `top`) where the smooth map stretches.
    pub(super) fn fill_tile(
        &self,
        tile: &mut WarpTile,
        left: usize,
        top: usize,
        needed: &[u32; TILE],
    ) {
        if !self.is_stretched(left, top) {
            return;
        }
        for (row, bits) in needed.iter().enumerate() {
            for column in (0..TILE).filter(|column| bits >> column & 1 == 1) {
                let at = [(left + column) as f32, (top + row) as f32];
                let (x, y) = tile.row(row);
                if let Some(source) = self.chosen(at, [x[column], y[column]]) {
                    tile.set(column, row, source);
                }
            }
        }
    }

    /// Whether a corner that reaches into the tile is stretched.
    fn is_stretched(&self, left: usize, top: usize) -> bool {
        let (low, high) = (self.skewed([left as f32, top as f32]), {
            let end = TILE as f32;
            self.skewed([left as f32 + end, top as f32 + end])
        });
        // Columns lean: the lower left corner of the tile has the smallest of them.
        let least = self.skewed([left as f32, (top + TILE) as f32])[0];
        let most = self.skewed([(left + TILE) as f32, top as f32])[0];
        let rows = low[1].floor() as i32..=high[1].floor() as i32 + 1;
        let mut rows = rows.into_iter();
        rows.any(|row| {
            let mut columns = least.floor() as i32..=most.floor() as i32 + 1;
            columns.any(|column| self.corner(column, row).stretch > FINE)
        })
    }

    /// The column and row of a place in the skewed lattice.
    fn skewed(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        let row = y / (ROW as f32 * self.spacing);
        [x / self.spacing - 0.5 * row, row]
    }

    fn corner(&self, column: i32, row: i32) -> Corner {
        let column = column - self.first_column;
        if row < 0 || !(0..self.columns).contains(&column) {
            return Corner::default();
        }
        let corner = self.corners.get((row * self.columns + column) as usize);
        corner.copied().unwrap_or_default()
    }

    /// The three corners round a place, with their shares.
    fn round(&self, at: [f32; 2]) -> [(Corner, f32); 3] {
        let [u, v] = self.skewed(at);
        let (column, row) = (u.floor(), v.floor());
        let (s, t) = (u - column, v - row);
        let (column, row) = (column as i32, row as i32);
        if s + t < 1.0 {
            [
                (self.corner(column, row), 1.0 - s - t),
                (self.corner(column + 1, row), s),
                (self.corner(column, row + 1), t),
            ]
        } else {
            [
                (self.corner(column + 1, row + 1), s + t - 1.0),
                (self.corner(column, row + 1), 1.0 - s),
                (self.corner(column + 1, row), 1.0 - t),
            ]
        }
    }

    /// Where the pixel `at` comes from instead of `smooth`; `None` when it stays.
    fn chosen(&self, at: [f32; 2], smooth: [f32; 2]) -> Option<[f32; 2]> {
        let corners = self.round(at);
        let inside = || corners.iter().filter(|(corner, _)| corner.stretch > 0.0);
        let share: f32 = inside().map(|(_, share)| share).sum();
        let stretch: f32 = inside().map(|(corner, share)| corner.stretch * share).sum();
        if share < 1e-3 || stretch <= FINE * share || self.label(smooth) == Label::Trunk {
            return None;
        }
        let coarse = ((stretch / share - FINE) / (COARSE - FINE)).min(1.0);
        let mut best = None;
        let mut most = (1.0 - coarse) * (1.0 + LIGHTNESS * self.lightness(smooth));
        for (corner, share_here) in inside() {
            let (dx, dy) = (at[0] - corner.at[0], at[1] - corner.at[1]);
            let [cos, sin] = corner.turn;
            let source = [
                corner.source[0] + cos * dx - sin * dy,
                corner.source[1] + sin * dx + cos * dy,
            ];
            let nearness = coarse * share_here / share;
            let score = nearness + LIGHTNESS * self.lightness(source);
            if score > most && self.label(source) != Label::Trunk {
                (most, best) = (score, Some(source));
            }
        }
        best
    }

    fn label(&self, [x, y]: [f32; 2]) -> Label {
        let place = (x.round() as i64, y.round() as i64);
        let label = self.exemplar.labels.get(place.0, place.1);
        label.unwrap_or_default()
    }

    /// How light the exemplar is at a place, 0 to 1; 0 where it is clear.
    fn lightness(&self, [x, y]: [f32; 2]) -> f32 {
        let place = (x.round() as i64, y.round() as i64);
        let pixel = self.exemplar.image.get(place.0, place.1);
        let [red, green, blue, _] = pixel.unwrap_or_default().0.map(u32::from);
        (2 * red + 7 * green + blue) as f32 / 2550.0
    }
}

/// Where the map takes each of `ats`, and its derivative [∂x/∂x′, ∂x/∂y′, ∂y/∂x′, ∂y/∂y′] there.
fn derivatives(warp: &Warp, ats: &[[f32; 2]]) -> Vec<([f32; 2], [f32; 4])> {
    const OFFSETS: [[f32; 2]; 4] = [
        [-DIFFERENCE_PX, 0.0],
        [DIFFERENCE_PX, 0.0],
        [0.0, -DIFFERENCE_PX],
        [0.0, DIFFERENCE_PX],
    ];
    let groups = ats.chunks(LANES / 4);
    let mut ends: Vec<(Lanes, Lanes)> = groups
        .map(|group| {
            let at = |lane: usize| group[(lane / 4).min(group.len() - 1)];
            (
                std::array::from_fn(|lane| at(lane)[0] + OFFSETS[lane % 4][0]),
                std::array::from_fn(|lane| at(lane)[1] + OFFSETS[lane % 4][1]),
            )
        })
        .collect();
    warp.map(&mut ends);
    let of_point = |index: usize| {
        let (x, y) = &ends[index / (LANES / 4)];
        let lane = index % (LANES / 4) * 4;
        let slope = |v: &Lanes, lane: usize| (v[lane + 1] - v[lane]) / (2.0 * DIFFERENCE_PX);
        let middle = |v: &Lanes| v[lane..lane + 4].iter().sum::<f32>() / 4.0;
        let derivative = [
            slope(x, lane),
            slope(x, lane + 2),
            slope(y, lane),
            slope(y, lane + 2),
        ];
        ([middle(x), middle(y)], derivative)
    };
    (0..ats.len()).map(of_point).collect()
}

/// Cosine and sine of the rotation nearest to a matrix.
fn turn([a, b, c, d]: &[f32; 4]) -> [f32; 2] {
    let (cos, sin) = (a + d, c - b);
    let length = (cos * cos + sin * sin).sqrt();
    // A fold, or squeezed to nothing: as it is.
    if length > 1e-6 {
        [cos / length, sin / length]
    } else {
        [1.0, 0.0]
    }
}

/// How many times longer or shorter than `scale` the matrix makes a leaf in its worst direction.
fn stretch([a, b, c, d]: &[f32; 4], scale: f32) -> f32 {
    let sum = ((a + d) * (a + d) + (b - c) * (b - c)).sqrt();
    let difference = ((a - d) * (a - d) + (b + c) * (b + c)).sqrt();
    let (large, small) = ((sum + difference) / 2.0, (sum - difference).abs() / 2.0);
    (large / scale).max(scale / small.max(1e-6)).min(8.0)
}

/// A place near `source` with foliage all round, drawn by the number of the corner; `source` itself
/// where there is none.
fn aside(exemplar: &Exemplar, source: [f32; 2], spacing: f64, corner: usize) -> [f32; 2] {
    let mut random = Seed(0).derive("leaf size", corner as u64).random();
    let mut offset = || (ASIDE * spacing * random.between(-1.0, 1.0)) as f32;
    let place = [source[0] + offset(), source[1] + offset()];
    let reach = spacing as f32 * 0.75;
    let is_foliage = |dx: f32, dy: f32| {
        let (x, y) = (
            (place[0] + dx * reach) as i64,
            (place[1] + dy * reach) as i64,
        );
        exemplar.labels.get(x, y) == Some(Label::Crown)
    };
    let around = [(-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0), (0.0, 0.0)];
    if around.iter().all(|&(dx, dy)| is_foliage(dx, dy)) {
        place
    } else {
        source
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contour::{PinnedContour, Pins};
    use crate::geometry::Point;
    use crate::raster::{Image, Premultiplied};
    use crate::variation::{Layout, Leaves, Shape, Source, WarpPrecision, synthesized};

    /// A block of foliage, `width` × 200 pixels of 256, of dark and light checks of 8 pixels.
    fn block(width: f64) -> Exemplar {
        let size = 256;
        let (left, right) = (128.0 - width / 2.0, 128.0 + width / 2.0);
        let outline = [
            (128.0, 228.0),
            (right, 228.0),
            (right, 28.0),
            (left, 28.0),
            (left, 228.0),
        ];
        let contour =
            PinnedContour::resampled(&outline.map(Point::from), Pins::without_trunk(0), 100);
        let inside =
            |x: u32, y: u32| (left..right).contains(&f64::from(x)) && (28..228).contains(&y);
        let mut image = Image::filled(size, size, Premultiplied::default());
        let mut labels = Image::filled(size, size, Label::Background);
        for (x, y) in (0..size).flat_map(|y| (0..size).map(move |x| (x, y))) {
            if inside(x, y) {
                let light = [200, 40][((x / 8 + y / 8) % 2) as usize];
                image.set(x, y, Premultiplied([light / 2, light, 20, 255]));
                labels.set(x, y, Label::Crown);
            }
        }
        let shape = Shape {
            size,
            cage: contour.clone(),
            contour,
            baseline_y: None,
            density: 1.0,
            fullness: 1.0,
            straight: 0.0,
            texture: 0.03,
            gaps: Vec::new(),
        };
        Exemplar {
            shape,
            image,
            labels,
            provenance: crate::segment::Provenance {
                source: crate::segment::Source::Classical,
                confidence: None,
                reason: None,
            },
        }
    }

    /// Changes between dark and light in the middle row of the tree.
    fn changes(leaves: Leaves) -> usize {
        let (narrow, wide) = (block(60.0), block(220.0));
        let mut layout =
            Layout::new(&[(&narrow.shape, 0.0, 1.0), (&wide.shape, 1.0, 0.0)]).unwrap();
        layout.leaves = leaves;
        let source = |exemplar, contour_weight, color_weight| Source {
            exemplar,
            contour_weight,
            color_weight,
        };
        let sources = [source(&narrow, 0.0, 1.0), source(&wide, 1.0, 0.0)];
        let cancel = crate::base::Cancel::new();
        let made = synthesized(&layout, &sources, WarpPrecision::Interpolated, &cancel).unwrap();
        let row: Vec<bool> = made.image.row(128)[24..232]
            .iter()
            .map(|p| p.0[1] > 120)
            .collect();
        row.windows(2).filter(|pair| pair[0] != pair[1]).count()
    }

    #[test]
    fn checks_keep_their_size_where_the_map_stretches() {
        // 208 pixels have 26 checks; drawn out from 60 pixels they have 7.
        let (stretched, kept) = (changes(Leaves::Stretch), changes(Leaves::KeepTheirSize));
        assert!(stretched <= 9, "{stretched}");
        assert!(kept >= 14, "{kept}");
    }
}
