//! Trees as a viewer meets them: in rows at one scale, and in a forest where they stand before and
//! behind each other; with a frame around those that are pointed at.

use super::contact::{Cell, Grid, contact_sheet};
use super::paint::{Canvas, Rgba, closed};
use super::scene::{Standing, backdrop, draw_shadows, tree_bounds};
use crate::base::{Random, Seed};
use crate::geometry::Point;
use crate::raster::{Image, Premultiplied, Straight};

/// Colour of a frame: nothing in a tree has it.
const MARK: Rgba = [196, 30, 92, 255];

/// Height of the nearest and of the farthest trees, pixels.
const NEAR_PX: f64 = 340.0;
const FAR_PX: f64 = 110.0;

/// How much of the width of a tree its neighbour to the side leaves free, at least.
const SPACING: f64 = 0.62;

/// Colour that distance fades to, and how much of it the farthest trees have.
const HAZE: [f64; 3] = [206.0, 208.0, 206.0];
const MOST_HAZE: f64 = 0.45;

/// Least share of a tree that must show for it to count as seen.
const LEAST_SEEN: f64 = 0.4;

/// A picture of trees in rows; the trees `marked` are framed.
///
/// # Panics
/// When there are no trees.
pub fn rows_of_trees(
    cells: &[Cell<'_>],
    columns: usize,
    cell_px: u32,
    marked: &[usize],
) -> Image<Straight> {
    let sheet = contact_sheet(cells, columns, cell_px);
    let grid = Grid::new(cells, columns, cell_px);
    let mut canvas = Canvas::new(sheet.width(), sheet.height(), [0, 0, 0, 255]);
    canvas.lay(&sheet.premultiplied(), 0, 0, 1.0);
    let half = f64::from(cell_px) / 2.0;
    for &index in marked {
        let (middle, ground) = grid.place(index);
        let ground = f64::from(ground) + 4.0;
        let low = Point::new(middle - half, ground - f64::from(cell_px));
        frame(&mut canvas, low, Point::new(middle + half, ground));
    }
    canvas.into_image()
}

fn frame(canvas: &mut Canvas, low: Point, high: Point) {
    let corners = [
        low,
        Point::new(high.x, low.y),
        high,
        Point::new(low.x, high.y),
    ];
    let path = closed([corners.as_slice()], 1.0, Point::ZERO);
    canvas.stroke(path.as_ref(), 3.0, MARK);
}

/// A forest.
pub struct Forest {
    canvas: Canvas,
    /// Of each tree what is seen of it, on a frame of the whole tree; `None` where others hide it.
    pub seen: Vec<Option<Image<Premultiplied>>>,
    /// Left, top, right and lower edge of each tree.
    places: Vec<[f64; 4]>,
}

/// A tree in the forest.
struct Stem {
    /// Index of the tree.
    tree: usize,
    /// 0 at the front, 1 at the back.
    distance: f64,
    middle: f64,
    ground: u32,
    image: Image<Premultiplied>,
}

impl Forest {
    /// The forest of all `trees`, each once, `height_px` high and as wide as they need. Where each
    /// stands is drawn from `seed`.
    ///
    /// # Panics
    /// When there are no trees or `height_px` is below 400.
    pub fn new(trees: &[&Image<Premultiplied>], height_px: u32, seed: Seed) -> Self {
        assert!(
            !trees.is_empty() && height_px >= 400,
            "a forest has trees and room"
        );
        let (stems, width) = stems(trees, height_px, &mut seed.derive("forest", 0).random());
        let mut canvas = backdrop(width, height_px);
        let mut front: Vec<u32> = vec![0; width as usize * height_px as usize];
        let mut places = vec![[0.0; 4]; trees.len()];
        for (number, stem) in (1u32..).zip(&stems) {
            let standing = Standing::whole(hazy(&stem.image, stem.distance));
            draw_shadows(&mut canvas, &standing.shadows(stem.middle, stem.ground));
            standing.draw(&mut canvas, stem.middle, stem.ground);
            let (left, top) = stem.corner();
            cover(&mut front, width, height_px, stem, number);
            let (right, low) = (left + i64::from(stem.image.width()), i64::from(stem.ground));
            places[stem.tree] = [left, top, right, low].map(|side| side as f64);
        }
        let mut seen = vec![None; trees.len()];
        for (number, stem) in (1u32..).zip(&stems) {
            seen[stem.tree] = visible(&front, width, height_px, stem, number);
        }
        Self {
            canvas,
            seen,
            places,
        }
    }

    /// The picture, with frames around the trees `marked`.
    pub fn picture(mut self, marked: &[usize]) -> Image<Straight> {
        for &tree in marked {
            let [left, top, right, low] = self.places[tree];
            let room = Point::splat(4.0);
            frame(
                &mut self.canvas,
                Point::new(left, top) - room,
                Point::new(right, low) + room,
            );
        }
        self.canvas.into_image()
    }
}

impl Stem {
    /// Upper left corner in the picture.
    fn corner(&self) -> (i64, i64) {
        let left = (self.middle - f64::from(self.image.width()) / 2.0).round() as i64;
        (
            left,
            i64::from(self.ground) - i64::from(self.image.height()),
        )
    }
}

/// All trees where they stand, the farthest first, and the width of the picture.
fn stems(trees: &[&Image<Premultiplied>], height_px: u32, random: &mut Random) -> (Vec<Stem>, u32) {
    let order = random.choose(trees.len(), trees.len());
    let rows = ((trees.len() as f64 / 3.0).sqrt().round() as usize).clamp(1, 6);
    let mut stems = Vec::with_capacity(trees.len());
    let mut width = 0.0f64;
    for row in 0..rows {
        let distance = (rows - 1 - row) as f64 / (rows.max(2) - 1) as f64;
        let low = f64::from(height_px) - 16.0;
        let ground = low - distance * (low - (FAR_PX + 40.0)).min(0.5 * f64::from(height_px));
        let height = NEAR_PX + (FAR_PX - NEAR_PX) * distance;
        // Farther rows hold more: each takes a share of what is left.
        let from = order.len() * row / rows;
        let mut x = 12.0;
        for &tree in &order[from..order.len() * (row + 1) / rows] {
            let Some(bounds) = tree_bounds(trees[tree]) else {
                continue;
            };
            let scale =
                height * random.between(0.9, 1.0) / f64::from(bounds.width.max(bounds.height));
            let image = Standing::new(trees[tree], bounds, scale).into_image();
            let own = f64::from(image.width());
            let jitter = random.between(0.0, 10.0);
            stems.push(Stem {
                tree,
                distance,
                middle: x + own / 2.0 + jitter,
                ground: (ground - random.between(0.0, 8.0)) as u32,
                image,
            });
            x += own * random.between(SPACING, 1.15) + jitter;
            width = width.max(x + 0.4 * own);
        }
    }
    // Rows of small trees are spread over the whole width.
    spread(&mut stems, width);
    (stems, (width.ceil() as u32).max(64) + 12)
}

/// Moves the trees of each row apart until it is `width` wide.
fn spread(stems: &mut [Stem], width: f64) {
    for row in stems.chunk_by_mut(|a, b| a.distance == b.distance) {
        let right = row
            .iter()
            .map(|stem| stem.middle + 0.5 * f64::from(stem.image.width()));
        let factor = (width / right.fold(1.0, f64::max)).max(1.0);
        for stem in row {
            stem.middle *= factor;
        }
    }
}

/// The tree as it looks through the air of its distance.
fn hazy(tree: &Image<Premultiplied>, distance: f64) -> Image<Premultiplied> {
    let share = MOST_HAZE * distance;
    tree.map(|pixel| {
        let [r, g, b, a] = pixel.0;
        let alpha = f64::from(a) / 255.0;
        let mixed = |value: u8, haze: f64| {
            let value = f64::from(value);
            ((value + (haze * alpha - value) * share + 0.5) as u8).min(a)
        };
        Premultiplied([mixed(r, HAZE[0]), mixed(g, HAZE[1]), mixed(b, HAZE[2]), a])
    })
}

/// The places of the picture, row by row, that the pixels of `stem` fall on.
fn pixels_of(stem: &Stem, width: u32, height: u32) -> impl Iterator<Item = (u32, u32, usize)> + '_ {
    let (left, top) = stem.corner();
    (0..stem.image.height()).flat_map(move |y| {
        (0..stem.image.width()).filter_map(move |x| {
            let (u, v) = (left + i64::from(x), top + i64::from(y));
            let inside = (0..i64::from(width)).contains(&u) && (0..i64::from(height)).contains(&v);
            inside.then(|| (x, y, v as usize * width as usize + u as usize))
        })
    })
}

fn cover(front: &mut [u32], width: u32, height: u32, stem: &Stem, number: u32) {
    for (x, y, place) in pixels_of(stem, width, height) {
        if stem.image.at(x, y).alpha() >= 128 {
            front[place] = number;
        }
    }
}

/// What is seen of a tree: its pixels that no nearer tree covers.
fn visible(
    front: &[u32],
    width: u32,
    height: u32,
    stem: &Stem,
    number: u32,
) -> Option<Image<Premultiplied>> {
    let image = &stem.image;
    let mut seen = Image::filled(image.width(), image.height(), Premultiplied::default());
    let (mut shown, mut all) = (0u32, 0u32);
    for (x, y, place) in pixels_of(stem, width, height) {
        let pixel = image.at(x, y);
        if pixel.alpha() > 0 && front[place] <= number {
            seen.set(x, y, pixel);
        }
        if pixel.alpha() >= 128 {
            all += 1;
            shown += u32::from(front[place] == number);
        }
    }
    (f64::from(shown) >= LEAST_SEEN * f64::from(all.max(1))).then_some(seen)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tree(green: u8) -> Image<Premultiplied> {
        let mut image = Image::filled(60, 90, Premultiplied::default());
        for y in 5..90 {
            for x in 5..55 {
                image.set(x, y, Premultiplied([10, green, 10, 255]));
            }
        }
        image
    }

    #[test]
    fn the_front_row_is_seen_whole_and_the_same_seed_plants_the_same_forest() {
        let trees: Vec<Image<Premultiplied>> = (0..12).map(|i| tree(100 + 10 * i)).collect();
        let trees: Vec<&Image<Premultiplied>> = trees.iter().collect();
        let forest = Forest::new(&trees, 600, Seed(3));
        let whole = |seen: &Image<Premultiplied>| seen.pixels().iter().all(|p| p.alpha() > 0);
        let seen: Vec<bool> = forest.seen.iter().flatten().map(whole).collect();
        assert!(seen.iter().any(|whole| *whole));
        let plain = Forest::new(&trees, 600, Seed(3)).picture(&[]);
        assert_eq!(plain, Forest::new(&trees, 600, Seed(3)).picture(&[]));
        let marked = forest.picture(&[0]);
        assert_ne!(plain, marked);
        assert!(marked.pixels().contains(&Straight(MARK)));
    }

    #[test]
    fn rows_frame_what_is_marked() {
        let one = tree(120);
        let cells = [Cell::new(&one), Cell::new(&one)];
        let sheet = rows_of_trees(&cells, 2, 96, &[1]);
        let half = sheet.width() / 2;
        let marks = |from: u32| {
            let part = sheet.cropped(from, 0, half, sheet.height());
            part.pixels().iter().filter(|p| p.0 == MARK).count()
        };
        // The frame's left side stands on the border of the two.
        assert!(marks(half) > 2 * marks(0), "{} {}", marks(0), marks(half));
    }
}
