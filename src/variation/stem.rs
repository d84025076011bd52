//! Other bark on bare stems: that of other places of the same stem.
//!
//! A row of trees gives itself away by one stem with the same stains. Bark has no upper and no lower end, so
//! it may be moved along the stem, where it comes to an end turned back, stretched and mirrored. The stem's own
//! silhouette stays and so does what changes slowly along it, as snow at its foot; at both ends all of it. A stem
//! that forks is taken stretch by stretch, from fork to fork.
//!
//! Limits: short stretches, between forks that follow each other, keep their bark.

use super::Tree;
use super::sway::between_pixels;
use crate::base::Random;
use crate::raster::{Image, Straight};
use crate::segment::{Label, Labels, crown_baseline};

/// Shortest stretch that is worth it, and the length at both ends over which bark fades, in cell sizes.
const SHORTEST: f64 = 0.8;
const FADE: f64 = 0.35;

/// How far bark moves, in lengths of its stretch, and how much it is stretched. Moved by 1 it stands upside down, by
/// 2 it would be back where it was.
const MOVED: [f64; 2] = [0.3, 1.7];
const STRETCHED: [f64; 2] = [0.8, 1.25];

/// Share of a stretch at either end that bark never comes from: leaves hang over the one, grass over the other.
const HEM: f64 = 0.12;

/// Share of it next to that in which bark is turned back, at the row that is most even: what lies there is seen
/// twice, head to head.
const TURN: f64 = 0.16;

/// Rows on either side that such a row is judged with, in cell sizes.
const EVEN: f64 = 0.12;

/// Rows over which a stem's middle and width are smoothed, in cell sizes.
const SMOOTHED: f64 = 0.25;

/// Rows on either side over which the colour is told that stays, in cell sizes.
const STAYS: f64 = 0.5;

/// Gives the stems of `tree` other bark; `side` is the size of a cell, pixels. The same draws are made
/// whatever the strength.
pub(super) fn rebarked(tree: &mut Tree, side: f64, strength: f64, random: &mut Random) {
    let before = tree.image.clone();
    let first = crown_baseline(&tree.labels).unwrap_or(tree.labels.height());
    for stretch in stretches(&tree.labels, first, SHORTEST * side) {
        let bark = Bark::drawn(random);
        if bark.turn < 2.0 * strength {
            stretch.rebark(&mut tree.image, &before, &bark, side);
        }
    }
}

/// Where the bark of a stretch comes from.
struct Bark {
    turn: f64,
    moved: f64,
    stretched: f64,
    mirror: f64,
}

impl Bark {
    fn drawn(random: &mut Random) -> Self {
        Self {
            turn: random.unit(),
            moved: random.between(MOVED[0], MOVED[1]),
            stretched: random.between(STRETCHED[0], STRETCHED[1]),
            mirror: if random.unit() < 0.5 { -1.0 } else { 1.0 },
        }
    }

    /// The row of its stretch, between `turns`, that bark comes from which is to stand at `share` of it, 0 to 1.
    fn source(&self, share: f64, [first, last]: [f64; 2]) -> f64 {
        let along = (self.stretched * share + self.moved).rem_euclid(2.0);
        first + (last - first) * (1.0 - (1.0 - along).abs())
    }
}

/// A stem from one fork to the next.
pub(super) struct Stretch {
    /// Its topmost row.
    pub(super) first: u32,
    /// Its first and last pixel, row by row.
    pub(super) ends: Vec<[u32; 2]>,
}

impl Stretch {
    /// Middle and half width, row by row, each smoothed over `reach` rows on either side.
    pub(super) fn rows(&self, reach: usize) -> Vec<[f64; 2]> {
        let smooth = |at: usize| {
            let around =
                &self.ends[at.saturating_sub(reach)..(at + reach + 1).min(self.ends.len())];
            let mean = |of: usize| around.iter().map(|ends| f64::from(ends[of])).sum::<f64>();
            let [left, right] = [0, 1].map(|of| mean(of) / around.len() as f64);
            [0.5 * (left + right), 0.5 * (right - left + 1.0)]
        };
        (0..self.ends.len()).map(smooth).collect()
    }

    /// The mean colour about each row, over `reach` rows on either side.
    fn colors(&self, image: &Image<Straight>, reach: usize) -> Vec<[f32; 3]> {
        let sum = |(y, &[left, right]): (u32, &[u32; 2])| {
            let opaque = (left..=right)
                .map(|x| image.at(x, y))
                .filter(|pixel| pixel.alpha() >= 128);
            opaque.fold([0.0f32; 4], |[r, g, b, count], pixel| {
                let [red, green, blue, _] = pixel.0.map(f32::from);
                [r + red, g + green, b + blue, count + 1.0]
            })
        };
        let sums: Vec<[f32; 4]> = (self.first..).zip(&self.ends).map(sum).collect();
        let mean = |at: usize| {
            let around = &sums[at.saturating_sub(reach)..(at + reach + 1).min(sums.len())];
            let all = |of: usize| around.iter().map(|sum| sum[of]).sum::<f32>();
            [0, 1, 2].map(|of| all(of) / all(3).max(1.0))
        };
        (0..sums.len()).map(mean).collect()
    }

    /// The rows at which bark is turned back: the most even one near either end. `colors` are the mean colours about
    /// the rows, `side` is the size of a cell.
    fn turns(&self, image: &Image<Straight>, colors: &[[f32; 3]], side: f64) -> [f64; 2] {
        let unevenness = |(row, &[left, right]): (usize, &[u32; 2])| {
            let [r, g, b] = colors[row].map(|value| value as u8);
            let mean = Straight([r, g, b, 255]).luma();
            let pixels = (left..=right).map(|x| image.at(x, self.first + row as u32));
            let sum: f32 = pixels.map(|pixel| (pixel.luma() - mean).abs()).sum();
            sum / (right - left + 1) as f32
        };
        let rows: Vec<f32> = self.ends.iter().enumerate().map(unevenness).collect();
        let reach = (EVEN * side) as usize;
        let about = |row: usize| {
            let around = &rows[row.saturating_sub(reach)..(row + reach + 1).min(rows.len())];
            around.iter().sum::<f32>() / around.len() as f32
        };
        let last = rows.len() - 1;
        let [hem, end] = [HEM, HEM + TURN].map(|share| (share * last as f64) as usize);
        let most_even = |rows: std::ops::RangeInclusive<usize>| {
            rows.min_by(|&a, &b| about(a).total_cmp(&about(b)))
                .map_or(0.0, |row| row as f64)
        };
        [hem..=end, last - end..=last - hem].map(most_even)
    }

    /// Lays other bark on the stretch in `image`, which was as in `before`; `side` is the size of a cell.
    fn rebark(
        &self,
        image: &mut Image<Straight>,
        before: &Image<Straight>,
        bark: &Bark,
        side: f64,
    ) {
        let rows = self.rows((SMOOTHED * side) as usize);
        let colors = self.colors(before, (STAYS * side) as usize);
        let turns = self.turns(before, &colors, side);
        let last = (rows.len() - 1) as f64;
        for (row, (&[middle, half], &[left, right])) in rows.iter().zip(&self.ends).enumerate() {
            let y = self.first + row as u32;
            let from = bark.source(row as f64 / last, turns);
            let [from_middle, from_half] = rows[from as usize];
            let end = (row as f64).min(last - row as f64);
            let share = (end / (FADE * side)).clamp(0.0, 1.0) as f32;
            for x in left..=right {
                let across = bark.mirror * (f64::from(x) - middle) / half;
                let from_x = from_middle + across * from_half;
                let other = between_pixels(before, from_x, f64::from(self.first) + from);
                let own = before.at(x, y);
                if other.alpha() >= 128 {
                    let mixed = |c: usize| {
                        let stays = colors[row][c] - colors[from as usize][c];
                        let (a, b) = (f32::from(own.0[c]), f32::from(other.0[c]) + stays);
                        (a + share * (b - a) + 0.5).clamp(0.0, 255.0) as u8
                    };
                    let pixel = Straight([mixed(0), mixed(1), mixed(2), own.alpha()]);
                    image.set(x, y, pixel);
                }
            }
        }
    }
}

/// The stems from row `first` down, from fork to fork, those left out that are of fewer rows than `shortest`.
pub(super) fn stretches(labels: &Labels, first: u32, shortest: f64) -> Vec<Stretch> {
    let mut ended: Vec<Stretch> = Vec::new();
    let mut growing: Vec<Stretch> = Vec::new();
    for y in first..labels.height() {
        let runs = runs(labels, y);
        let touch = |a: &[u32; 2], b: &[u32; 2]| a[0] <= b[1] && b[0] <= a[1];
        let above: Vec<[u32; 2]> = growing
            .iter()
            .map(|stretch| stretch.ends[stretch.ends.len() - 1])
            .collect();
        let mut next = Vec::new();
        let mut kept = vec![false; growing.len()];
        for run in &runs {
            let mut over = (0..above.len()).filter(|&i| touch(&above[i], run));
            let one = over.next().filter(|_| over.next().is_none());
            // One above, and nothing else below that.
            let one =
                one.filter(|&i| runs.iter().filter(|other| touch(&above[i], other)).count() == 1);
            match one {
                Some(i) => {
                    kept[i] = true;
                    growing[i].ends.push(*run);
                }
                None => next.push(Stretch {
                    first: y,
                    ends: vec![*run],
                }),
            }
        }
        for (stretch, is_kept) in std::mem::take(&mut growing).into_iter().zip(kept) {
            match is_kept {
                true => growing.push(stretch),
                false => ended.push(stretch),
            }
        }
        growing.append(&mut next);
    }
    ended.append(&mut growing);
    ended.retain(|stretch| stretch.ends.len() as f64 >= shortest.max(2.0));
    ended
}

/// The first and last pixel of each piece of stem in row `y`.
fn runs(labels: &Labels, y: u32) -> Vec<[u32; 2]> {
    let mut runs: Vec<[u32; 2]> = Vec::new();
    for (x, label) in (0..).zip(labels.row(y)) {
        if *label != Label::Trunk {
            continue;
        }
        match runs.last_mut() {
            Some(run) if run[1] + 1 == x => run[1] = x,
            _ => runs.push([x, x]),
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Seed;

    /// Two stems with stains that join at the foot, under a crown.
    fn forked() -> Tree {
        let mut image = Image::filled(64, 128, Straight([0; 4]));
        let mut labels = image.map(|_| Label::Background);
        for y in 0..128u32 {
            for x in 0..64u32 {
                let is_stem = y >= 20 && (if y < 100 { x % 32 < 8 } else { x < 40 });
                if y < 20 || is_stem {
                    labels.set(x, y, if y < 20 { Label::Crown } else { Label::Trunk });
                    let stain = (x * 7 + y * 13) % 50;
                    image.set(x, y, Straight([60 + stain as u8, (y * 2) as u8, 40, 255]));
                }
            }
        }
        Tree { image, labels }
    }

    #[test]
    fn a_stem_is_taken_from_fork_to_fork() {
        let tree = forked();
        let found = stretches(&tree.labels, 20, 16.0);
        let told: Vec<(u32, usize, [u32; 2])> = found
            .iter()
            .map(|stretch| (stretch.first, stretch.ends.len(), stretch.ends[0]))
            .collect();
        assert_eq!(
            told,
            [(20, 80, [0, 7]), (20, 80, [32, 39]), (100, 28, [0, 39])]
        );
    }

    #[test]
    fn bark_changes_within_the_stem_and_not_at_its_ends() {
        let tree = forked();
        let mut other = tree.clone();
        rebarked(&mut other, 16.0, 1.0, &mut Seed(2).random());
        let alpha = |tree: &Tree| tree.image.map(|pixel| pixel.alpha());
        assert_eq!(alpha(&tree), alpha(&other));
        let changed = |y: u32| other.image.row(y) != tree.image.row(y);
        assert!(!changed(10) && !changed(20) && !changed(99) && !changed(127));
        assert!(changed(40) && changed(80) && changed(114));
        let mut same = tree.clone();
        rebarked(&mut same, 16.0, 0.0, &mut Seed(2).random());
        assert_eq!(same, tree);
    }

    #[test]
    fn bark_is_turned_back_where_it_is_even() {
        let mut image = Image::filled(16, 200, Straight([200, 200, 200, 255]));
        let labels = image.map(|_| Label::Trunk);
        // Stains over all that is turned back at but for eight rows at either end.
        for y in (20..40).chain(48..60).chain(140..152).chain(160..180) {
            for x in 4..9 {
                image.set(x, y, Straight([30, 30, 30, 255]));
            }
        }
        let stretch = &stretches(&labels, 0, 16.0)[0];
        let colors = stretch.colors(&image, 8);
        let [first, last] = stretch.turns(&image, &colors, 16.0);
        assert!((40.0..48.0).contains(&first), "{first}");
        assert!((152.0..160.0).contains(&last), "{last}");
    }
}
