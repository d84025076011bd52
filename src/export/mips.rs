//! Mip chains: halved again and again, without fringes and without trees that dissolve.
//!
//! Colours are averaged premultiplied, so clear texels add nothing. An average of thin leaves has
//! an alpha below the cutoff of an alpha test, and distant trees lose them; so each level's alpha
//! is scaled until as large a share of it passes the test as of level 0 (Castaño, *Computing alpha
//! mipmaps*, 2010). We do so for every region (sprite of an atlas) by itself: with one scale for
//! all, dense trees would swell to make up for sparse ones.
//!
//! Limits: averages are of sRGB values, like all filtering here, not of linear light: the mean of
//! the stored values stays what it was, and a distant tree looks slightly darker than the sum of
//! its light. Coverage is a whole number of texels, so levels of a few texels can only come near.
//! Departure: the mean colour of the texels that pass the test is kept too, by a constant added to
//! each level (see [`with_mean_kept`]); scaled alpha gives edges more weight than they had.

use super::bleed::bled;
use crate::base::{Cancel, Cancelled};
use crate::raster::{Image, Rect, Straight};

/// The least 8-bit alpha that passes an alpha test of 0.5.
pub const ALPHA_CUTOFF: u8 = 128;

/// Steps of the bisection for a scale of alpha: enough to tell 8-bit alphas apart.
const BISECTIONS: u32 = 20;

/// The largest scale of alpha. Beyond it a level holds no leaf worth keeping, only haze.
const LARGEST_SCALE: f32 = 64.0;

/// Share of texels of `region` whose alpha passes the test.
pub fn coverage(image: &Image<Straight>, region: Rect) -> f64 {
    let passing = texels(image, region).filter(|pixel| pixel.alpha() >= ALPHA_CUTOFF);
    passing.count() as f64 / (f64::from(region.width) * f64::from(region.height))
}

fn texels(image: &Image<Straight>, region: Rect) -> impl Iterator<Item = Straight> + '_ {
    let columns = region.x as usize..(region.x + region.width) as usize;
    (region.y..region.y + region.height)
        .flat_map(move |y| &image.row(y)[columns.clone()])
        .copied()
}

/// All levels of the colour picture `image`, itself the first and 1×1 the last, with the coverage of
/// each of `regions` kept as long as the region is larger than a texel. Colour is bled under clear
/// texels. No regions: the whole picture is one.
///
/// # Errors
/// [`Cancelled`].
pub fn mips(
    image: &Image<Straight>,
    regions: &[Rect],
    cancel: &Cancel,
) -> Result<Vec<Image<Straight>>, Cancelled> {
    let whole = image.rect();
    let regions = if regions.is_empty() {
        std::slice::from_ref(&whole)
    } else {
        regions
    };
    let targets: Vec<Target> = regions.iter().map(|r| Target::of(image, *r)).collect();
    let mut level = Sums::of(image, |pixel| {
        let [r, g, b, a] = pixel.0.map(f32::from);
        [r * a / 255.0, g * a / 255.0, b * a / 255.0, a]
    });
    let mut chain = vec![bled(image)];
    for depth in 1.. {
        cancel.check()?;
        let Some(next) = level.halved() else { break };
        level = next;
        let mut out = level.image(|[r, g, b, a]| {
            if a <= 0.0 {
                return Straight([0; 4]);
            }
            Straight([r, g, b].map(|c| rounded(c * 255.0 / a)).with_alpha(a))
        });
        for target in &targets {
            target.kept(&mut out, &level, depth);
        }
        chain.push(bled(&out));
    }
    Ok(chain)
}

/// All levels of a map without alpha (depth, occlusion): plain averages of all four channels.
///
/// # Errors
/// [`Cancelled`].
pub fn data_mips(
    map: &Image<Straight>,
    cancel: &Cancel,
) -> Result<Vec<Image<Straight>>, Cancelled> {
    chain_of(map, cancel, |sums| Straight(sums.map(rounded)))
}

/// All levels of a normal map: averages of the vectors, made of unit length again.
///
/// # Errors
/// [`Cancelled`].
pub fn normal_mips(
    map: &Image<Straight>,
    cancel: &Cancel,
) -> Result<Vec<Image<Straight>>, Cancelled> {
    chain_of(map, cancel, |[x, y, z, a]| {
        let vector = [x, y, z].map(|value| value / 127.5 - 1.0);
        let length = vector.iter().map(|v| v * v).sum::<f32>().sqrt().max(1e-6);
        let [x, y, z] = vector.map(|v| rounded((v / length + 1.0) * 127.5));
        Straight([x, y, z, rounded(a)])
    })
}

fn chain_of(
    map: &Image<Straight>,
    cancel: &Cancel,
    texel: impl Fn([f32; 4]) -> Straight,
) -> Result<Vec<Image<Straight>>, Cancelled> {
    let mut level = Sums::of(map, |pixel| pixel.0.map(f32::from));
    let mut chain = vec![map.clone()];
    while let Some(next) = level.halved() {
        cancel.check()?;
        chain.push(next.image(&texel));
        level = next;
    }
    Ok(chain)
}

fn rounded(value: f32) -> u8 {
    (value + 0.5).clamp(0.0, 255.0) as u8
}

trait WithAlpha {
    fn with_alpha(self, alpha: f32) -> [u8; 4];
}

impl WithAlpha for [u8; 3] {
    fn with_alpha(self, alpha: f32) -> [u8; 4] {
        [self[0], self[1], self[2], rounded(alpha)]
    }
}

/// What is kept of a region through the levels.
struct Target {
    /// The region at level 0.
    region: Rect,
    coverage: f64,
    /// Mean colour of the texels that pass the test, if any does.
    mean: Option<[f64; 3]>,
}

impl Target {
    fn of(image: &Image<Straight>, region: Rect) -> Self {
        Self {
            region,
            coverage: coverage(image, region),
            mean: mean_of_visible(image, region),
        }
    }

    /// Scales alpha and shifts colour in this region of level `depth`, if it is worth a texel there.
    fn kept(&self, level: &mut Image<Straight>, sums: &Sums, depth: u32) {
        let Some(region) = self.at(level, depth) else {
            return;
        };
        let scale = self.scale(sums, region);
        for y in region.y..region.y + region.height {
            for x in region.x..region.x + region.width {
                let alpha = rounded(sums.at(x, y)[3] * scale);
                level.row_mut(y)[x as usize].0[3] = alpha;
            }
        }
        with_mean_kept(level, region, self.mean);
    }

    /// The region at level `depth`: the texels that lie in it for the most part.
    fn at(&self, level: &Image<Straight>, depth: u32) -> Option<Rect> {
        let half = if depth == 0 { 0 } else { 1u32 << (depth - 1) };
        let down = |at: u32, most: u32| ((at + half) >> depth).min(most);
        let Rect { x, y, .. } = self.region;
        let (left, top) = (down(x, level.width()), down(y, level.height()));
        let right = down(x + self.region.width, level.width());
        let bottom = down(y + self.region.height, level.height());
        // A picture that is one region stays one to the last texel.
        let whole = x == 0 && y == 0 && depth > 0 && level.width().max(level.height()) == 1;
        let (right, bottom) = if whole { (1, 1) } else { (right, bottom) };
        (right > left && bottom > top).then(|| Rect {
            x: left,
            y: top,
            width: right - left,
            height: bottom - top,
        })
    }

    /// The scale of alpha with which the coverage comes nearest to the one of level 0.
    fn scale(&self, sums: &Sums, region: Rect) -> f32 {
        let mut alphas: Vec<f32> = Vec::new();
        for y in region.y..region.y + region.height {
            alphas.extend((region.x..region.x + region.width).map(|x| sums.at(x, y)[3]));
        }
        let count = alphas.len() as f64;
        let passing = |scale: f32| {
            let passing = |alpha: &&f32| rounded(**alpha * scale) >= ALPHA_CUTOFF;
            alphas.iter().filter(passing).count() as f64 / count
        };
        let (mut low, mut high) = (0.0f32, LARGEST_SCALE);
        for _ in 0..BISECTIONS {
            // Geometric above 1/64: scales matter by ratio.
            let middle = if low > 0.0 {
                (low * high).sqrt()
            } else {
                high / 64.0
            };
            if passing(middle) < self.coverage {
                low = middle;
            } else {
                high = middle;
            }
            if low == 0.0 && high < 1.0 / 64.0 {
                break;
            }
        }
        let miss = |scale: f32| (passing(scale) - self.coverage).abs();
        // As it is, if that is as good.
        let candidates = [1.0, high, low];
        let better = |a: &f32, b: &f32| miss(*a).total_cmp(&miss(*b));
        candidates.into_iter().min_by(better).unwrap_or(1.0)
    }
}

/// Mean colour of the texels of `region` that pass the test.
fn mean_of_visible(image: &Image<Straight>, region: Rect) -> Option<[f64; 3]> {
    let (mut sums, mut count) = ([0.0; 3], 0.0);
    for pixel in texels(image, region).filter(|pixel| pixel.alpha() >= ALPHA_CUTOFF) {
        count += 1.0;
        for (sum, &value) in sums.iter_mut().zip(&pixel.0) {
            *sum += f64::from(value);
        }
    }
    (count > 0.0).then(|| sums.map(|sum| sum / count))
}

/// Shifts the colours of `region` so that the texels that pass the test have the mean colour `mean`:
/// a tree neither pales nor darkens with distance. Two rounds, for values that are cut off at 0 and
/// 255.
fn with_mean_kept(level: &mut Image<Straight>, region: Rect, mean: Option<[f64; 3]>) {
    for _ in 0..2 {
        let (Some(wanted), Some(found)) = (mean, mean_of_visible(level, region)) else {
            return;
        };
        let shift: [f64; 3] = std::array::from_fn(|c| wanted[c] - found[c]);
        if shift.iter().all(|s| s.abs() < 0.5) {
            return;
        }
        for y in region.y..region.y + region.height {
            let row = &mut level.row_mut(y)[region.x as usize..(region.x + region.width) as usize];
            for pixel in row.iter_mut().filter(|pixel| pixel.alpha() > 0) {
                for (value, shift) in pixel.0.iter_mut().zip(shift) {
                    *value = (f64::from(*value) + shift + 0.5).clamp(0.0, 255.0) as u8;
                }
            }
        }
    }
}

/// A level before it is rounded.
struct Sums {
    width: u32,
    height: u32,
    texels: Vec<[f32; 4]>,
}

impl Sums {
    fn of(image: &Image<Straight>, value: impl Fn(&Straight) -> [f32; 4]) -> Self {
        Self {
            width: image.width(),
            height: image.height(),
            texels: image.pixels().iter().map(value).collect(),
        }
    }

    fn at(&self, x: u32, y: u32) -> [f32; 4] {
        self.texels[y as usize * self.width as usize + x as usize]
    }

    /// The next level, or `None` after 1×1. Sides are halved and rounded down, as in all graphics
    /// interfaces; each texel is the average of the area under it.
    fn halved(&self) -> Option<Self> {
        if self.width.max(self.height) == 1 {
            return None;
        }
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let across = areas(self.width, width);
        let down = areas(self.height, height);
        let mut texels = Vec::with_capacity(width as usize * height as usize);
        for rows in &down {
            for columns in &across {
                let mut sum = [0.0f32; 4];
                for &(y, by) in rows {
                    for &(x, bx) in columns {
                        for (sum, value) in sum.iter_mut().zip(self.at(x, y)) {
                            *sum += value * bx * by;
                        }
                    }
                }
                texels.push(sum);
            }
        }
        Some(Self {
            width,
            height,
            texels,
        })
    }

    fn image(&self, texel: impl Fn([f32; 4]) -> Straight) -> Image<Straight> {
        let pixels = self.texels.iter().map(|&sums| texel(sums)).collect();
        Image::from_pixels(self.width, self.height, pixels)
    }
}

/// For each of `target` texels along an axis of `source` ones: those under it, with their shares.
fn areas(source: u32, target: u32) -> Vec<Vec<(u32, f32)>> {
    let scale = f64::from(source) / f64::from(target);
    (0..target)
        .map(|i| {
            let (from, to) = (f64::from(i) * scale, f64::from(i + 1) * scale);
            (from as u32..(to.ceil() as u32).min(source))
                .map(|at| {
                    let overlap = to.min(f64::from(at) + 1.0) - from.max(f64::from(at));
                    (at, (overlap / scale) as f32)
                })
                .filter(|(_, share)| *share > 1e-6)
                .collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Seed;

    /// Thin bright leaves of random places on clear black ground: the worst for fringes.
    fn leaves(width: u32, height: u32, share: f64, seed: u64) -> Image<Straight> {
        let mut random = Seed(seed).random();
        let mut image = Image::filled(width, height, Straight([0; 4]));
        for pixel in image.pixels_mut() {
            if random.unit() < share {
                let shade = (random.unit() * 60.0) as u8;
                let alpha = if random.unit() < 0.3 { 70 } else { 255 };
                *pixel = Straight([120 + shade, 180 - shade, 40 + shade, alpha]);
            }
        }
        image
    }

    #[test]
    fn coverage_and_mean_colour_stay_through_the_chain() {
        for (width, height, share) in [(128, 128, 0.2), (100, 67, 0.5), (64, 256, 0.07)] {
            let image = leaves(width, height, share, 5);
            let chain = mips(&image, &[], &Cancel::new()).unwrap();
            let (wanted, mean) = (
                coverage(&image, image.rect()),
                mean_of_visible(&image, image.rect()).unwrap(),
            );
            assert_eq!(chain.last().unwrap().pixels().len(), 1);
            for level in &chain {
                let texels = level.pixels().len() as f64;
                let allowed = 0.05f64.max(0.5 / texels + 1e-9);
                let found = coverage(level, level.rect());
                assert!(
                    (found - wanted).abs() <= allowed,
                    "{texels}: {found} {wanted}"
                );
                if let Some(found) = mean_of_visible(level, level.rect()) {
                    for (found, mean) in found.iter().zip(mean) {
                        assert!((found - mean).abs() <= 3.0, "{texels}: {found} {mean}");
                    }
                }
            }
        }
    }

    #[test]
    fn regions_keep_their_own_coverage() {
        let mut image = Image::filled(128, 64, Straight([0; 4]));
        let (sparse, dense) = (leaves(48, 48, 0.1, 1), leaves(48, 48, 0.9, 2));
        for y in 0..48 {
            image.row_mut(y + 8)[8..56].copy_from_slice(sparse.row(y));
            image.row_mut(y + 8)[72..120].copy_from_slice(dense.row(y));
        }
        let regions = [8, 72].map(|x| Rect {
            x,
            y: 8,
            width: 48,
            height: 48,
        });
        let chain = mips(&image, &regions, &Cancel::new()).unwrap();
        for region in regions {
            let small = Rect {
                x: region.x / 8,
                y: 1,
                width: 6,
                height: 6,
            };
            let (found, wanted) = (coverage(&chain[3], small), coverage(&image, region));
            assert!((found - wanted).abs() <= 0.05, "{found} {wanted}");
        }
    }

    #[test]
    fn an_opaque_picture_is_only_averaged() {
        let image = Image::filled(8, 4, Straight([10, 20, 30, 255]));
        for level in mips(&image, &[], &Cancel::new()).unwrap() {
            assert!(
                level
                    .pixels()
                    .iter()
                    .all(|&p| p == Straight([10, 20, 30, 255]))
            );
        }
    }

    #[test]
    fn normals_stay_of_unit_length() {
        let pixels = (0..64u8).map(|i| Straight([90 + i, 200 - i, 220, 255]));
        let map = Image::from_pixels(8, 8, pixels.collect());
        for level in normal_mips(&map, &Cancel::new()).unwrap().iter().skip(1) {
            for pixel in level.pixels() {
                let length: f64 = pixel.0[..3]
                    .iter()
                    .map(|&v| (f64::from(v) / 127.5 - 1.0).powi(2))
                    .sum();
                assert!((length.sqrt() - 1.0).abs() < 0.01);
            }
        }
    }

    #[test]
    fn shares_of_an_odd_side_sum_to_one() {
        for (source, target) in [(7, 3), (5, 2), (3, 1), (8, 4)] {
            for taps in areas(source, target) {
                assert!((taps.iter().map(|(_, s)| s).sum::<f32>() - 1.0).abs() < 1e-5);
            }
        }
    }
}
