//! Correction of a texture at one level: seams are worked over until their surroundings look like
//! surroundings in the exemplar.
//!
//! Each pixel of a texture is a place in the exemplar. Where the 5×5 pixels around one continue each
//! other as they do in the exemplar there is nothing to correct. Elsewhere the 7×7 window around the
//! pixel is compared with windows of the exemplar: those that continue a neighbour's piece, and those
//! around places that look like them. The best takes the pixel.
//!
//! This work is based on: S. Lefebvre & H. Hoppe, *Parallel Controllable Texture Synthesis*, 2005
//! (coordinates, sub-passes, coherence); M. Ashikhmin, *Synthesizing Natural Textures*, 2001 (a
//! neighbour's piece continued); X. Tong and others 2002 (k-coherence).
//!
//! Departures: colours, not their principal components, are compared, in whole numbers, so that the
//! result is the same on every processor; all pixels of a sub-pass read what was there before it.

use super::canvas::Canvas;
use super::level::{Level, RADIUS};
use super::similar::{NOWHERE, SIMILAR};
use crate::base::{Cancel, Cancelled, Seed};
use rayon::prelude::*;

/// How far around a pixel pieces must be whole for it to be left alone, and from how far away
/// neighbours' pieces are continued, pixels.
const REACH: i64 = 2;

/// How much worse a jump to a similar place counts than continuing a neighbour's piece, as a shift
/// to the right: a quarter. Less, and pieces crumble into noise; more, and seams stay.
const JUMP_SHIFT: u32 = 2;

/// What a jump costs at least: a difference of 4 in each channel over the window. Without it flat
/// shade crumbles for nothing.
const JUMP: u32 = 49 * 3 * 16;

/// Pixels of a sub-pass lie this far apart.
const SPACING: usize = 2;

const SIDE: usize = 2 * RADIUS + 1;
/// Numbers in a window's row: four for each of its pixels and one more, which makes whole vectors.
const ROW: usize = 4 * (SIDE + 1);

/// Places tried at random for a pixel beside given ones, which offer nothing to continue, and then
/// around the best of them, each time within half the distance.
const SEARCHED: usize = 48;
const SEARCHED_AROUND: [i32; 5] = [16, 8, 4, 2, 1];

/// Corrects all pixels of `canvas` once; `seed` is for what has to be searched for.
pub(super) fn corrected(
    canvas: &mut Canvas,
    level: &Level,
    similar: &[[u32; SIMILAR]],
    seed: Seed,
    cancel: &Cancel,
) -> Result<(), Cancelled> {
    for class in 0..SPACING * SPACING {
        let (first_x, first_y) = (class % SPACING, class / SPACING);
        let reader = &*canvas;
        let changes: Result<Vec<Vec<(usize, u32)>>, Cancelled> = (first_y..canvas.height)
            .into_par_iter()
            .step_by(SPACING)
            .map(|y| {
                cancel.check()?;
                let columns = (first_x..reader.width).step_by(SPACING);
                Ok(columns
                    .filter_map(|x| changed(reader, level, similar, seed, (x, y)))
                    .collect())
            })
            .collect();
        for (at, index) in changes?.into_iter().flatten() {
            canvas.set(at, index, level);
        }
    }
    Ok(())
}

/// The pixel (x, y) and its new place, if a better one was found.
fn changed(
    canvas: &Canvas,
    level: &Level,
    similar: &[[u32; SIMILAR]],
    seed: Seed,
    (x, y): (usize, usize),
) -> Option<(usize, u32)> {
    let at = y * canvas.width + x;
    let own = canvas.places[at];
    if canvas.given[at] || is_whole(canvas, level, x as i64, y as i64, own) {
        return None;
    }
    let window = Window::around(canvas, x as i64, y as i64);
    let mut best = Best {
        index: own,
        cost: window.difference(level, own as usize, u32::MAX),
        tried: [NOWHERE; MOST_TRIED],
        count: 0,
    };
    for (dx, dy) in (-REACH..=REACH).flat_map(|dy| (-REACH..=REACH).map(move |dx| (dx, dy))) {
        let Some(place) = place(canvas, x as i64 + dx, y as i64 + dy) else {
            continue;
        };
        let (back_x, back_y) = (-dx as i32, -dy as i32);
        if let Some(index) = level.moved(place, back_x, back_y) {
            best.try_one(&window, level, index, false);
        }
        if dx.abs() <= 1 && dy.abs() <= 1 {
            for &there in &similar[place as usize] {
                if there != NOWHERE
                    && let Some(index) = level.moved(there, back_x, back_y)
                {
                    best.try_one(&window, level, index, true);
                }
            }
        }
    }
    if is_beside_given(canvas, x as i64, y as i64) {
        best.search(&window, level, Seed(seed.0 ^ at as u64));
    }
    (best.index != own).then_some((at, best.index))
}

/// Whether a pixel within reach of (x, y) is given.
fn is_beside_given(canvas: &Canvas, x: i64, y: i64) -> bool {
    let mut around = (-REACH..=REACH).flat_map(|dy| (-REACH..=REACH).map(move |dx| (dx, dy)));
    around.any(|(dx, dy)| canvas.at(x + dx, y + dy).is_some_and(|at| canvas.given[at]))
}

/// The place of pixel (x, y), if it has one.
#[inline]
fn place(canvas: &Canvas, x: i64, y: i64) -> Option<u32> {
    let place = canvas.places[canvas.at(x, y)?];
    (place != NOWHERE).then_some(place)
}

/// Whether all pixels around (x, y) continue the piece that it belongs to.
fn is_whole(canvas: &Canvas, level: &Level, x: i64, y: i64, own: u32) -> bool {
    for dy in -REACH..=REACH {
        for dx in -REACH..=REACH {
            let Some(at) = canvas.at(x + dx, y + dy) else {
                continue;
            };
            let expected = i64::from(own) + dy * level.stride as i64 + dx;
            if i64::from(canvas.places[at]) != expected {
                return false;
            }
        }
    }
    true
}

/// Most places that are tried for a pixel.
const MOST_TRIED: usize = 25 + 9 * SIMILAR;

/// The best place so far.
struct Best {
    index: u32,
    cost: u32,
    tried: [u32; MOST_TRIED],
    count: usize,
}

impl Best {
    /// Looks for better places anywhere and then around the best.
    fn search(&mut self, window: &Window, level: &Level, seed: Seed) {
        let mut random = seed.random();
        for _ in 0..SEARCHED {
            let index = random.below(level.usable.len());
            if level.usable[index] {
                self.try_one(window, level, index as u32, false);
            }
        }
        for reach in SEARCHED_AROUND {
            let mut away = || random.below(2 * reach as usize + 1) as i32 - reach;
            if let Some(index) = level.moved(self.index, away(), away()) {
                self.try_one(window, level, index, false);
            }
        }
    }

    #[inline]
    fn try_one(&mut self, window: &Window, level: &Level, index: u32, is_jump: bool) {
        if index == self.index || self.tried[..self.count].contains(&index) {
            return;
        }
        if self.count < MOST_TRIED {
            self.tried[self.count] = index;
            self.count += 1;
        }
        let mut cost = window.difference(level, index as usize, self.cost);
        if is_jump {
            cost = cost.saturating_add(cost >> JUMP_SHIFT).saturating_add(JUMP);
        }
        if cost < self.cost {
            self.cost = cost;
            self.index = index;
        }
    }
}

/// The colours around a pixel; what lies outside the canvas does not count.
struct Window {
    colors: [[i16; ROW]; SIDE],
    /// All bits set where a number counts.
    masks: [[i16; ROW]; SIDE],
}

impl Window {
    fn around(canvas: &Canvas, x: i64, y: i64) -> Self {
        let mut window = Self {
            colors: [[0; ROW]; SIDE],
            masks: [[0; ROW]; SIDE],
        };
        let radius = RADIUS as i64;
        for (dy, (colors, masks)) in
            (-radius..).zip(window.colors.iter_mut().zip(&mut window.masks))
        {
            for (dx, i) in (-radius..=radius).zip((0..).step_by(4)) {
                if let Some(at) = canvas.at(x + dx, y + dy).filter(|&at| canvas.is_set(at)) {
                    colors[i..i + 4].copy_from_slice(&canvas.colors[at]);
                    masks[i..i + 4].fill(-1);
                }
            }
        }
        window
    }

    /// Sum of the squared differences from the window around place `index`; stops early, with
    /// something not less than `limit`, when it gets there.
    #[inline]
    fn difference(&self, level: &Level, index: usize, limit: u32) -> u32 {
        let numbers: &[i16] = bytemuck::cast_slice(&level.colors);
        let mut start = 4 * (index - RADIUS * level.stride - RADIUS);
        let mut sum = 0u32;
        for (colors, masks) in self.colors.iter().zip(&self.masks) {
            sum += row_difference(&numbers[start..start + ROW], colors, masks);
            if sum >= limit {
                return sum;
            }
            start += 4 * level.stride;
        }
        sum
    }
}

#[inline]
fn row_difference(there: &[i16], here: &[i16; ROW], masks: &[i16; ROW]) -> u32 {
    let mut sum = 0i32;
    for i in 0..ROW {
        let difference = (there[i] - here[i]) & masks[i];
        sum += i32::from(difference) * i32::from(difference);
    }
    sum as u32
}
