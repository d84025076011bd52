//! Blocks read back by the `basisu` crate, which follows the reference reader bit by bit.

use super::*;
use crate::base::Cancel;
use crate::branches::samples;
use crate::export::{BlockFormat, CompressedLevels, compressed, encode_ktx2, mips};
use crate::raster::{Image, ReadLimits, read_image_from_memory};
use basisu::etc::uastc_to_etc1::transcode_uastc_to_etc1;
use basisu::uastc::unpack::unpack_uastc;
use basisu::{DecodeFlags, TargetFormat, Transcoder};
use proptest::prelude::*;
use std::path::Path;

fn decoded(block: &[u8; 16]) -> [Straight; 16] {
    unpack_uastc(block, false)
        .unwrap()
        .map(|pixel| Straight([pixel.r(), pixel.g(), pixel.b(), pixel.a()]))
}

fn largest_difference(a: &[Straight; 16], b: &[Straight; 16]) -> u8 {
    let pairs = a.iter().flat_map(|p| p.0).zip(b.iter().flat_map(|p| p.0));
    pairs.map(|(a, b)| a.abs_diff(b)).max().unwrap()
}

#[test]
fn one_colour_comes_back_as_it_was() {
    for color in [[0, 0, 0, 0], [255; 4], [17, 200, 3, 255], [90, 91, 92, 77]] {
        let texels = [Straight(color); 16];
        assert_eq!(decoded(&block(&texels)), texels);
    }
}

#[test]
fn lines_through_colour_space_come_back_closely() {
    let ramp = |alpha: fn(u8) -> u8| {
        std::array::from_fn(|i| {
            let i = i as u8;
            Straight([40 + 9 * i, 200 - 7 * i, 30 + 2 * i, alpha(i)])
        })
    };
    let opaque = ramp(|_| 255);
    assert!(largest_difference(&decoded(&block(&opaque)), &opaque) <= 5);
    let along = ramp(|i| 10 + 14 * i);
    assert!(largest_difference(&decoded(&block(&along)), &along) <= 12);
}

#[test]
fn alpha_that_goes_its_own_way_has_its_own_weights() {
    let texels = std::array::from_fn(|i| {
        let dark = i % 4 < 2;
        let color = if dark { [40, 60, 20] } else { [120, 160, 60] };
        let alpha = if i / 4 < 2 { 255 } else { 40 };
        Straight([color[0], color[1], color[2], alpha])
    });
    assert!(largest_difference(&decoded(&block(&texels)), &texels) <= 3);
}

#[test]
fn blocks_without_a_visible_texel_are_of_one_colour() {
    let texels = std::array::from_fn(|i| Straight([i as u8 * 10, 90, 30, (i % 3) as u8]));
    let found = decoded(&block(&texels));
    assert!(found.iter().all(|texel| texel == &found[0]));
    assert_eq!(found[0].alpha(), 0);
}

/// Mean square of what is amiss with the visible colours and the alpha of `image`, as a
/// signal-to-noise ratio in decibels.
fn psnr(image: &Image<Straight>, back: &[[u8; 4]]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for (wanted, found) in image.pixels().iter().zip(back) {
        let visible = f64::from(wanted.alpha()) / 255.0;
        for (channel, (&wanted, &found)) in wanted.0.iter().zip(found).enumerate() {
            let amiss = f64::from(wanted) - f64::from(found);
            let weight = if channel == 3 { 1.0 } else { visible };
            sum += weight * amiss * amiss;
            count += weight;
        }
    }
    10.0 * libm::log10(255.0 * 255.0 * count / sum)
}

#[test]
fn a_tree_survives_and_a_strange_reader_reads_the_file() {
    let birch = samples().iter().find(|tree| tree.name() == "birch_01");
    let bytes = birch.unwrap().bundled();
    let tree =
        read_image_from_memory(bytes, Path::new("birch.webp"), ReadLimits::default()).unwrap();
    let side = 256;
    let left = tree.width() / 2 - side / 2;
    let rows =
        (500..500 + side).flat_map(|y| tree.row(y)[left as usize..][..side as usize].to_vec());
    let part = Image::from_pixels(side, side, rows.collect());
    let levels = mips(&part, &[], &Cancel::new()).unwrap();
    let blocks = CompressedLevels::of(&levels, BlockFormat::Uastc, &Cancel::new()).unwrap();
    let file = encode_ktx2(&blocks, true, &Cancel::new()).unwrap();
    let reader = Transcoder::new(&file).unwrap();
    assert_eq!(reader.base_dimensions(), (side, side));
    assert_eq!(reader.level_count() as usize, levels.len());
    assert!(reader.has_alpha());
    for (number, least) in [(0, 32.0), (1, 29.0), (2, 28.0)] {
        let target = TargetFormat::Rgba32;
        let bytes = reader.transcode(number, target, DecodeFlags::NONE).unwrap();
        let (back, _) = bytes.as_chunks::<4>();
        let found = psnr(&levels[number as usize], back);
        assert!(found > least, "level {number}: {found} dB");
    }
}

#[test]
fn old_phones_get_a_picture_too() {
    let texels = std::array::from_fn(|i| {
        let light = if i % 4 < 2 { 60 } else { 140 };
        Straight([light, light + 30, light / 2, 255])
    });
    let etc = transcode_uastc_to_etc1(&block(&texels)).unwrap();
    // Side by side, so the flip bit is clear.
    assert_eq!(etc[3] & 1, 0);
    let solid = transcode_uastc_to_etc1(&block(&[Straight([100, 150, 40, 255]); 16])).unwrap();
    // Differential, without a difference: the base colour is within a step of 8.
    assert_eq!(solid[3] & 2, 2);
    for (byte, wanted) in solid.iter().zip([100u8, 150, 40]) {
        let five = byte >> 3;
        assert!((five << 3 | five >> 2).abs_diff(wanted) <= 20);
    }
}

#[test]
fn sides_need_no_multiple_of_four() {
    let image = Image::from_pixels(6, 3, vec![Straight([10, 20, 30, 255]); 18]);
    let blocks = compressed(&image, BlockFormat::Uastc, &Cancel::new()).unwrap();
    assert_eq!(blocks.len(), 2 * BLOCK_BYTES);
}

proptest! {
    /// Whatever a block holds, what is written is a block, and near what it was where the block is
    /// nearly of one colour.
    #[test]
    fn any_block_is_readable(texels: [[u8; 4]; 16], base: [u8; 4], noise: [[u8; 4]; 16]) {
        let texels = texels.map(Straight);
        decoded(&block(&texels));
        let near: [Straight; 16] = std::array::from_fn(|i| {
            Straight(std::array::from_fn(|c| base[c].saturating_add(noise[i][c] % 8)))
        });
        if near.iter().all(|texel| texel.alpha() > 128) {
            prop_assert!(largest_difference(&decoded(&block(&near)), &near) <= 9);
        }
    }
}
