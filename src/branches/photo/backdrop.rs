//! What grows behind the tree: hills, the edge of a wood, a hedge.

use super::Scene;
use super::frame::Frame;
use crate::base::{Cancel, Cancelled, Random};
use crate::branches::individual::Individual;
use crate::branches::noise::{noise3, ramp};
use crate::branches::species::species_named;
use crate::raster::{Image, Straight, resized};
use glam::Vec3;

/// Paints `count` trees about `away_m` off, from side to side of the picture.
pub(super) fn wood(
    frame: &mut Frame,
    scene: &Scene,
    (away_m, count): (f32, u32),
    cancel: &Cancel,
) -> Result<(), Cancelled> {
    /// What grows there, and how high in metres.
    const KINDS: [(&str, u32, f32); 5] = [
        ("oak", 11, 13.0),
        ("maple", 11, 12.0),
        ("spruce", 12, 17.0),
        ("birch", 12, 14.0),
        ("oak", 12, 12.0),
    ];
    let camera = &scene.camera;
    let mut random = scene.seed.derive("wood", away_m as u64).random();
    let tallest = 1.1 * 17.0 * camera.focal_px / away_m;
    let pictures: Vec<Image<Straight>> = KINDS
        .iter()
        .map(|&(name, index, _)| far_tree(name, index, tallest as u32, cancel))
        .collect::<Result<_, _>>()?;
    let half_m = 0.62 * frame.width as f32 * away_m / camera.focal_px;
    let middle_m = (0.5 * frame.width as f32 - camera.middle_px) * away_m / camera.focal_px;
    for tree in 0..count {
        cancel.check()?;
        // From back to front, everywhere from side to side.
        let slot = (tree as f32 * 0.618_034 + 0.4 * random.unit() as f32).fract();
        let off = away_m * (1.25 - 0.35 * tree as f32 / count as f32);
        let x = middle_m + half_m * (2.0 * slot - 1.0) * off / away_m;
        let kind = random.below(KINDS.len());
        let height_m = KINDS[kind].2 * random.between(0.7, 1.1) as f32;
        let tall = (height_m * camera.focal_px / off) as u32;
        let place = camera.pixel(x, 0.0, off);
        let dim = 0.86 + 0.1 * random.unit() as f32;
        stand(
            frame,
            &pictures[kind],
            (place, tall),
            random.unit() < 0.5,
            |colour| scene.sky.through_air(colour * dim, 1.6 * off),
        );
    }
    undergrowth(frame, scene, away_m);
    Ok(())
}

/// A tree of the distance, cut out, at most `height` pixels high.
fn far_tree(
    name: &str,
    index: u32,
    height: u32,
    cancel: &Cancel,
) -> Result<Image<Straight>, Cancelled> {
    let Some(species) = species_named(name) else {
        return Ok(Image::filled(1, 1, Straight([0; 4])));
    };
    let height = height.clamp(24, 700);
    let tree = Individual::new(species, index).grow(cancel)?;
    let picture = tree.picture((2 * height, height), false, cancel)?;
    Ok(picture.image)
}

/// Stands a picture of a tree on its foot, `tall` pixels high, perhaps mirrored.
fn stand(
    frame: &mut Frame,
    image: &Image<Straight>,
    ((x, y), tall): ((f32, f32), u32),
    mirrored: bool,
    tint: impl Fn(Vec3) -> Vec3,
) {
    let tall = tall.clamp(2, image.height());
    let wide = (image.width() * tall / image.height()).max(1);
    let mut small = resized(&image.premultiplied(), image.rect(), wide, tall).straight();
    if mirrored {
        for row in 0..tall {
            small.row_mut(row).reverse();
        }
    }
    let corner = (x as i64 - i64::from(wide) / 2, y as i64 - i64::from(tall));
    frame.draw(&small, corner, tint);
}

/// A dark ragged band at the foot of a wood: bushes, and the shade below the trees.
fn undergrowth(frame: &mut Frame, scene: &Scene, away_m: f32) {
    let salt = scene.seed.derive("undergrowth", away_m as u64).0 as u32;
    let scale = scene.camera.focal_px / away_m;
    let (_, foot) = scene.camera.pixel(0.0, 0.0, away_m);
    for x in 0..frame.width {
        let at = x as f32 / scale;
        let high = 1.5 + 1.1 * noise3(at * 0.25, 0.0, 0.0, salt) + 0.5 * noise3(at, 1.0, 0.0, salt);
        let top = foot - high.max(0.3) * scale;
        for y in top as i64..=foot as i64 {
            let share = ((y as f32 - top) / (high * scale)).clamp(0.0, 1.0);
            let leaf = noise3(at * 2.2, y as f32 / scale * 2.2, 2.0, salt);
            let light = (0.62 + 0.45 * leaf) * (1.0 - 0.55 * share);
            let colour = Vec3::new(74.0, 92.0, 48.0) * light.max(0.2);
            frame.blend(
                x as i64,
                y,
                scene.sky.through_air(colour, 1.6 * away_m),
                0.96,
            );
        }
    }
}

/// Ranges of hills, each paler than the one before it.
pub(super) fn hills(frame: &mut Frame, scene: &Scene) {
    let salt = scene.seed.derive("hills", 0).0 as u32;
    let unit = frame.height as f32;
    for range in 0..3u32 {
        let away_m = [9000.0, 4200.0, 1900.0][range as usize];
        let high = [0.085, 0.055, 0.030][range as usize] * unit;
        for x in 0..frame.width {
            let at = x as f32 / unit + range as f32 * 9.0;
            let swell = noise3(at * 2.2, range as f32, 0.0, salt)
                + 0.35 * noise3(at * 7.0, range as f32, 1.0, salt)
                + 0.06 * noise3(at * 60.0, range as f32, 2.0, salt);
            let top = scene.camera.horizon_px - high * (0.75 + 0.6 * swell).max(0.05);
            let wooded = noise3(at * 9.0, range as f32, 5.0, salt);
            let colour = Vec3::new(86.0, 104.0, 62.0)
                .lerp(Vec3::new(58.0, 78.0, 52.0), ramp(-0.2, 0.3, wooded));
            let colour = scene.sky.through_air(colour, 0.16 * away_m);
            for y in top as i64..=scene.camera.horizon_px as i64 + 1 {
                frame.blend(x as i64, y, colour, (y as f32 + 1.0 - top).min(1.0));
            }
        }
    }
}

/// A hedge across the picture, trimmed not long ago.
pub(super) fn hedge(
    frame: &mut Frame,
    scene: &Scene,
    away_m: f32,
    cancel: &Cancel,
) -> Result<(), Cancelled> {
    /// Height of the hedge in metres.
    const HEIGHT_M: f32 = 1.9;
    let camera = &scene.camera;
    let scale = camera.focal_px / away_m;
    let bush = far_tree("shrub", 11, (HEIGHT_M * 1.5 * scale) as u32, cancel)?;
    let mut random = scene.seed.derive("hedge", 0).random();
    let salt = random.bits() as u32;
    let mut layer = Frame::new(frame.width as u32, frame.height as u32);
    layer.pixels.copy_from_slice(&frame.pixels);
    darken_below(&mut layer, scene, away_m, HEIGHT_M);
    let count = (frame.width as f32 / (0.16 * scale)) as u32;
    for row in 0..2u32 {
        for _ in 0..count {
            let x = random.unit() as f32 * frame.width as f32;
            let low = HEIGHT_M * if row == 0 { 0.45 } else { 0.0 } * random.unit() as f32;
            let y = camera.pixel(0.0, low, away_m).1;
            let tall = (HEIGHT_M * random.between(0.75, 1.15) as f32 * scale) as u32;
            let dim = shade(&mut random);
            stand(
                &mut layer,
                &bush,
                ((x, y), tall),
                random.unit() < 0.5,
                |colour| scene.sky.through_air(colour * dim, away_m),
            );
        }
        cancel.check()?;
    }
    // The shears.
    for x in 0..frame.width {
        let at = x as f32 / scale;
        let high = HEIGHT_M
            + 0.05 * noise3(at * 1.1, 0.0, 0.0, salt)
            + 0.07 * noise3(at * 9.0, 1.0, 0.0, salt);
        let top = camera.pixel(0.0, high, away_m).1;
        let foot = camera.pixel(0.0, 0.0, away_m).1 as usize;
        for y in (top.max(0.0) as usize)..foot.min(frame.height) {
            let index = y * frame.width + x;
            frame.pixels[index] = layer.pixels[index];
        }
    }
    Ok(())
}

fn shade(random: &mut Random) -> f32 {
    0.72 + 0.3 * random.unit() as f32
}

/// The inside of a hedge is dark.
fn darken_below(layer: &mut Frame, scene: &Scene, away_m: f32, height_m: f32) {
    let top = scene.camera.pixel(0.0, 1.1 * height_m, away_m).1.max(0.0) as usize;
    for pixel in layer.pixels.iter_mut().skip(top * layer.width) {
        *pixel = Vec3::new(30.0, 40.0, 24.0);
    }
}
