//! Growing, shrinking and smoothing one label.
//!
//! Only tiles near an outline are looked at, each with a margin, in parallel; the others stay
//! shared. Distances are Euclidean and exact. What lies beyond the border of the picture counts as a
//! continuation of it, so a crown that is cut by the border does not shrink away from it.

use super::tiled::{BACKGROUND, Over, Paint, TILE, Tile, TiledMask, joined};
use crate::base::{Cancel, Cancelled};
use crate::raster::{Image, Mask, Rect};
use rayon::prelude::*;

/// Largest radius of these functions; larger ones count as this.
const MOST_RADIUS_PX: f64 = 512.0;

/// Gives `label` to the pixels within `radius_px` of it that `over` allows; what changed.
///
/// # Errors
/// [`Cancelled`]; the mask is then unchanged.
pub fn grown(
    mask: &mut TiledMask,
    label: u8,
    radius_px: f64,
    over: Over,
    cancel: &Cancel,
) -> Result<Option<Rect>, Cancelled> {
    let reach = Reach::of(radius_px);
    let paint = Paint { label, over };
    by_window(mask, label, reach.margin(), cancel, |window, part| {
        let near = within(window, part, &reach);
        Box::new(move |x, y, old| if near.at(x, y) { paint.on(old) } else { old })
    })
}

/// Makes background of the pixels with `label` that lie within `radius_px` of one without; what
/// changed.
///
/// # Errors
/// [`Cancelled`]; the mask is then unchanged.
pub fn shrunk(
    mask: &mut TiledMask,
    label: u8,
    radius_px: f64,
    cancel: &Cancel,
) -> Result<Option<Rect>, Cancelled> {
    let reach = Reach::of(radius_px);
    by_window(mask, label, reach.margin(), cancel, |window, part| {
        let near = within(&window.map(|inside| !inside), part, &reach);
        Box::new(move |x, y, old| {
            if old == label && near.at(x, y) {
                BACKGROUND
            } else {
                old
            }
        })
    })
}

/// Rounds the outline of `label`: details smaller than about `radius_px` go, on both sides of it.
///
/// A pixel gets the label where more than half of its neighbourhood has it, weighed by three
/// successive boxes (nearly a Gaussian of standard deviation `radius_px`), and loses it where less
/// than half has; straight outlines stay. New pixels are taken where `over` allows.
///
/// # Errors
/// [`Cancelled`]; the mask is then unchanged.
pub fn smoothed(
    mask: &mut TiledMask,
    label: u8,
    radius_px: u32,
    over: Over,
    cancel: &Cancel,
) -> Result<Option<Rect>, Cancelled> {
    let radius = radius_px.clamp(1, 128);
    let paint = Paint { label, over };
    by_window(mask, label, 3 * radius, cancel, |window, part| {
        let (sums, whole) = weights(window, radius);
        Box::new(move |x, y, old| {
            let sum = sums.at(x + part.0, y + part.1);
            match (2 * sum).cmp(&whole) {
                std::cmp::Ordering::Greater if old != label => paint.on(old),
                std::cmp::Ordering::Less if old == label => BACKGROUND,
                _ => old,
            }
        })
    })
}

/// What becomes of a pixel of a tile: given its column and row in the tile, and its label.
type Change = Box<dyn Fn(u32, u32, u8) -> u8>;

/// Runs `change` on each tile that has an outline of `label` within `margin`: it gets where the
/// label is, in the tile and its margin, and the tile's place in that.
fn by_window(
    mask: &mut TiledMask,
    label: u8,
    margin: u32,
    cancel: &Cancel,
    change: impl Fn(&Mask, (u32, u32)) -> Change + Sync,
) -> Result<Option<Rect>, Cancelled> {
    let source = &*mask;
    let indices: Vec<usize> = (0..source.tiles().len()).collect();
    let tiles: Result<Vec<_>, Cancelled> = indices
        .into_par_iter()
        .filter(|&index| has_outline(source, label, index, margin))
        .map(|index| {
            cancel.check()?;
            let rect = source.tile_rect(index);
            let window = membership(source, label, rect, margin);
            let change = change(&window, (margin, margin));
            let (x, y) = (i64::from(rect.x), i64::from(rect.y));
            let mut tile = source.window(x, y, rect.width, rect.height, BACKGROUND);
            for y in 0..rect.height {
                for (x, pixel) in (0..).zip(tile.row_mut(y)) {
                    *pixel = change(x, y, *pixel);
                }
            }
            Ok((rect, tile))
        })
        .collect();
    let mut changed = None;
    for (rect, tile) in tiles? {
        let part = mask.edit(rect, |_, y, row| row.copy_from_slice(tile.row(y - rect.y)));
        changed = joined(changed, part);
    }
    Ok(changed)
}

/// Whether some pixels within `margin` of tile `index` have `label` and some have not.
fn has_outline(mask: &TiledMask, label: u8, index: usize, margin: u32) -> bool {
    let rect = mask.tile_rect(index);
    let (x, y) = (i64::from(rect.x), i64::from(rect.y));
    let wide = i64::from(margin);
    let side = i64::from(TILE) + 2 * wide;
    let Some(around) = mask.clipped(x - wide, y - wide, side, side) else {
        return false;
    };
    let (mut some_in, mut some_out) = (false, false);
    for index in mask.tiles_of(around) {
        match mask.tiles()[index] {
            Tile::Uniform(own) if own == label => some_in = true,
            Tile::Uniform(_) => some_out = true,
            // Two labels, though `label` may be none of them: looked at closely later.
            Tile::Varied(_) => return true,
        }
    }
    some_in && some_out
}

/// Where `label` is, in `rect` and `margin` around it, continued beyond the picture's border.
fn membership(mask: &TiledMask, label: u8, rect: Rect, margin: u32) -> Mask {
    let (x, y) = (i64::from(rect.x), i64::from(rect.y));
    let wide = i64::from(margin);
    let (width, height) = (rect.width + 2 * margin, rect.height + 2 * margin);
    let mut window = mask
        .window(x - wide, y - wide, width, height, BACKGROUND)
        .map(|&own| own == label);
    // The part of the window that is inside the picture.
    let left = (wide - x).max(0) as usize;
    let right = (i64::from(mask.width()) - x + wide).min(i64::from(width)) as usize;
    let top = (wide - y).max(0) as u32;
    let bottom = (i64::from(mask.height()) - y + wide).min(i64::from(height)) as u32;
    for y in top..bottom {
        let row = window.row_mut(y);
        let (first, last) = (row[left], row[right - 1]);
        row[..left].fill(first);
        row[right..].fill(last);
    }
    for y in (0..top).chain(bottom..height) {
        let from = window.row(if y < top { top } else { bottom - 1 }).to_vec();
        window.row_mut(y).copy_from_slice(&from);
    }
    window
}

/// A disc as the half-widths of its rows.
struct Reach {
    /// Entry d: how far the disc reaches sideways in rows d from its middle.
    half_widths: Vec<u32>,
}

impl Reach {
    fn of(radius_px: f64) -> Self {
        let radius = if radius_px > 0.0 {
            radius_px.min(MOST_RADIUS_PX)
        } else {
            0.0
        };
        let rows = 0..=radius as u32;
        let half = |d: u32| {
            (radius * radius - f64::from(d) * f64::from(d))
                .max(0.0)
                .sqrt() as u32
        };
        Self {
            half_widths: rows.map(half).collect(),
        }
    }

    /// Pixels that the disc reaches at most.
    fn margin(&self) -> u32 {
        self.half_widths[0]
    }
}

/// The pixels from `part` on, to the same distance from the other end, that have one of `inside`
/// within `reach`.
///
/// First the distance to the nearest one in the same column, then every pixel marks in its row what
/// a disc that far away reaches: linear in the number of pixels, whatever the radius.
fn within(inside: &Mask, part: (u32, u32), reach: &Reach) -> Mask {
    let (width, height) = (inside.width() as usize, inside.height() as usize);
    let far = reach.half_widths.len() as u32;
    let mut above = vec![far; width * height];
    for pass in 0..2 {
        let mut before = vec![far; width];
        for step in 0..height {
            let y = if pass == 0 { step } else { height - 1 - step };
            let row = &mut above[y * width..][..width];
            for ((distance, before), &inside) in
                row.iter_mut().zip(&mut before).zip(inside.row(y as u32))
            {
                *before = if inside { 0 } else { (*before + 1).min(far) };
                *distance = (*distance).min(*before);
            }
        }
    }
    let (out_width, out_height) = (width as u32 - 2 * part.0, height as u32 - 2 * part.1);
    let mut near = Image::filled(out_width, out_height, false);
    let mut starts = vec![0i32; width + 1];
    for y in 0..out_height {
        starts.fill(0);
        let row = &above[(y + part.1) as usize * width..][..width];
        for (x, &distance) in row.iter().enumerate() {
            if let Some(&half) = reach.half_widths.get(distance as usize) {
                starts[x.saturating_sub(half as usize)] += 1;
                starts[(x + half as usize + 1).min(width)] -= 1;
            }
        }
        let mut covering = 0;
        let mut sums = starts.iter().map(|start| {
            covering += start;
            covering > 0
        });
        let out = near.row_mut(y);
        for (pixel, is_near) in out.iter_mut().zip(sums.by_ref().skip(part.0 as usize)) {
            *pixel = is_near;
        }
    }
    near
}

/// Weighed number of `inside` around each pixel, and what it is where all are; right where the
/// neighbourhood of three boxes lies within the window.
fn weights(inside: &Mask, radius: u32) -> (Image<u64>, u64) {
    let (width, height) = (inside.width() as usize, inside.height() as usize);
    let mut sums: Vec<u64> = inside
        .pixels()
        .iter()
        .map(|&inside| u64::from(inside))
        .collect();
    for _ in 0..3 {
        for row in sums.chunks_exact_mut(width) {
            let boxed = box_sums(row, radius as usize);
            row.copy_from_slice(&boxed);
        }
        let mut column = vec![0; height];
        for x in 0..width {
            for (y, value) in column.iter_mut().enumerate() {
                *value = sums[y * width + x];
            }
            for (y, value) in box_sums(&column, radius as usize).into_iter().enumerate() {
                sums[y * width + x] = value;
            }
        }
    }
    let side = u64::from(2 * radius + 1);
    (
        Image::from_pixels(inside.width(), inside.height(), sums),
        side.pow(6),
    )
}

/// Sums over `radius` values on both sides, cut at the ends.
fn box_sums(values: &[u64], radius: usize) -> Vec<u64> {
    let mut before = Vec::with_capacity(values.len() + 1);
    let mut sum = 0;
    before.push(0);
    before.extend(values.iter().map(|value| {
        sum += value;
        sum
    }));
    (0..values.len())
        .map(|i| before[(i + radius + 1).min(values.len())] - before[i.saturating_sub(radius)])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Seed;
    use crate::paint::{CROWN, TRUNK};
    use proptest::prelude::*;

    /// Some blobs of crown and trunk over more than one tile.
    fn blobs(seed: u64) -> TiledMask {
        let mut random = Seed(seed).random();
        let mut mask = TiledMask::filled(150, 140, BACKGROUND);
        for _ in 0..6 {
            let mut side = || 4 + random.below(50) as u32;
            let (width, height) = (side(), side());
            let rect = Rect {
                x: random.below(150) as u32,
                y: random.below(140) as u32,
                width,
                height,
            };
            let label = random.below(3) as u8;
            mask.edit(rect, |_, _, row| row.fill(label));
        }
        mask
    }

    fn has_near(
        mask: &TiledMask,
        x: u32,
        y: u32,
        radius: f64,
        wanted: impl Fn(u8) -> bool,
    ) -> bool {
        let reach = radius as i64;
        let labels = mask.image();
        (-reach..=reach).any(|dy| {
            (-reach..=reach).any(|dx| {
                (dx * dx + dy * dy) as f64 <= radius * radius
                    && labels
                        .get(i64::from(x) + dx, i64::from(y) + dy)
                        .is_some_and(&wanted)
            })
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(6))]

        #[test]
        fn growing_and_shrinking_match_the_definition(seed in 0u64..1000, radius in 0.5..6.0f64) {
            let before = blobs(seed);
            let mut wide = before.clone();
            let changed = grown(&mut wide, CROWN, radius, Over::Background, &Cancel::new()).unwrap();
            let mut thin = before.clone();
            shrunk(&mut thin, CROWN, radius, &Cancel::new()).unwrap();
            for y in (0..140).step_by(3) {
                for x in 0..150 {
                    let old = before.at(x, y);
                    let gains = old == BACKGROUND && has_near(&before, x, y, radius, |l| l == CROWN);
                    prop_assert_eq!(wide.at(x, y), if gains { CROWN } else { old });
                    let loses = old == CROWN && has_near(&before, x, y, radius, |l| l != CROWN);
                    prop_assert_eq!(thin.at(x, y), if loses { BACKGROUND } else { old });
                }
            }
            prop_assert_eq!(changed.is_some(), wide != before);
        }
    }

    #[test]
    fn smoothing_keeps_straight_outlines_and_removes_hairs() {
        let mut mask = TiledMask::filled(200, 200, BACKGROUND);
        let half = Rect {
            x: 0,
            y: 0,
            width: 200,
            height: 100,
        };
        mask.edit(half, |_, _, row| row.fill(CROWN));
        let straight = mask.clone();
        let hair = Rect {
            x: 90,
            y: 100,
            width: 2,
            height: 60,
        };
        mask.edit(hair, |_, _, row| row.fill(CROWN));
        smoothed(&mut mask, CROWN, 4, Over::Everything, &Cancel::new()).unwrap();
        // The root of the hair may leave a bump of one row.
        assert!(mask.bounds(|l| l == CROWN).unwrap().height <= 101);
        mask = straight.clone();
        let changed = smoothed(&mut mask, CROWN, 4, Over::Everything, &Cancel::new());
        assert_eq!((changed, mask), (Ok(None), straight));
    }

    #[test]
    fn smoothing_spares_what_is_protected() {
        let mut mask = TiledMask::filled(60, 60, CROWN);
        let dot = Rect {
            x: 30,
            y: 30,
            width: 3,
            height: 3,
        };
        mask.edit(dot, |_, _, row| row.fill(TRUNK));
        let before = mask.clone();
        smoothed(&mut mask, CROWN, 3, Over::Background, &Cancel::new()).unwrap();
        assert_eq!(mask, before);
        smoothed(&mut mask, CROWN, 3, Over::Everything, &Cancel::new()).unwrap();
        assert_eq!(mask, TiledMask::filled(60, 60, CROWN));
    }

    #[test]
    fn a_full_mask_does_not_shrink_from_the_border() {
        let mut mask = TiledMask::filled(300, 20, CROWN);
        assert_eq!(shrunk(&mut mask, CROWN, 5.0, &Cancel::new()), Ok(None));
    }
}
