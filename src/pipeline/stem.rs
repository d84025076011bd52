//! What a picture shows of a tree's stem: how thick it is, how far it tapers, how high it carries the crown,
//! and the colour of its bark.
//!
//! In each row of the picture the longest run of trunk is the stem. Its foot (roots, grass) and its top (what
//! leaves hide) are left out, and medians of the other rows make up for forks and masks painted in haste.

use super::pictured::Pixels;
use crate::branches::bark::BarkKind;
use crate::branches::leaf_name::LeafName;
use crate::raster::{Image, Rect, Straight};
use crate::scene::StemLook;

/// A stem that was found in a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FoundStem {
    /// What it looks like.
    pub(super) look: StemLook,
    /// From its foot to the crown's lowest point, metres; 0 when the crown reaches lower.
    pub(super) height_m: f64,
}

/// Which rows count, as shares of the stem's height from its foot: those of its base and of its top.
const BASE: [f64; 2] = [0.1, 0.45];
const TOP: [f64; 2] = [0.65, 0.92];

/// Fewest rows of a stem that tells anything, and its least width, pixels.
const LEAST_ROWS: u32 = 12;
const LEAST_WIDTH: u32 = 2;

/// Thinnest and thickest stem, as shares of the tree's height: what is beyond was not painted as a stem.
const RADIUS: [f64; 2] = [0.003, 0.12];

/// Least taper: what leaves hide is no more than this thinner.
const LEAST_TAPER: f64 = 0.3;

/// The middle of a row's run whose colours count: its edges are blurred into what is beside it.
const MIDDLE: f64 = 0.6;

/// The stem among the pixels `trunk` of `photo`, below or within a crown that fills `crown`, pixels.
///
/// `metres_a_pixel` > 0; the tree has leaves `leaf`. `None` when too little of a stem is there.
pub(super) fn stem_in(
    photo: &Image<Straight>,
    trunk: &Pixels<'_>,
    crown: Rect,
    (metres_a_pixel, leaf): (f64, LeafName),
) -> Option<FoundStem> {
    let bounds = trunk.bounds;
    if bounds.height < LEAST_ROWS {
        return None;
    }
    let foot = bounds.y + bounds.height;
    let rows = |[from, to]: [f64; 2]| {
        let row = |share: f64| foot - (share * f64::from(bounds.height)) as u32;
        row(to)..row(from)
    };
    let width = |part: [f64; 2]| {
        let mut widths: Vec<u32> = rows(part).map(|y| longest_run(trunk, y).1).collect();
        widths.retain(|&width| width > 0);
        median(&mut widths).filter(|&width| width >= LEAST_WIDTH)
    };
    let tall_px = foot.max(crown.y + crown.height) - crown.y.min(bounds.y);
    let [thin, thick] = RADIUS.map(|share| share * f64::from(tall_px) * metres_a_pixel);
    let base_width = width(BASE)?;
    let base_radius_m = (0.5 * f64::from(base_width) * metres_a_pixel).clamp(thin, thick);
    // It goes on to taper within the crown as it does below.
    let taper = width(TOP).map_or(1.0, |top| f64::from(top) / f64::from(base_width));
    let taper = (taper * taper).clamp(LEAST_TAPER, 1.0);
    let bark = bark(photo, trunk, rows([BASE[0], TOP[1]]))?;
    let below_px = foot.saturating_sub(crown.y + crown.height);
    Some(FoundStem {
        look: StemLook {
            base_radius_m,
            top_radius_m: taper * base_radius_m,
            bark,
            bark_kind: bark_kind(leaf, bark),
        },
        height_m: f64::from(below_px) * metres_a_pixel,
    })
}

/// The first column and the length of the longest run in a row; 0 when there is none.
fn longest_run(trunk: &Pixels<'_>, y: u32) -> (u32, u32) {
    let Rect { x: left, width, .. } = trunk.bounds;
    let (mut longest, mut first) = ((0, 0), left);
    for x in left..left + width {
        if !(trunk.has)(x, y) {
            first = x + 1;
        } else if x + 1 - first > longest.1 {
            longest = (first, x + 1 - first);
        }
    }
    longest
}

/// Least brightness of a birch's bark, 0 … 255, and most difference of its channels.
const WHITE: f32 = 150.0;
const GREY: u8 = 50;

/// The structure of the bark of a tree with such leaves, whose bark has that colour, sRGB.
fn bark_kind(leaf: LeafName, [r, g, b]: [u8; 3]) -> BarkKind {
    let is_grey = r.max(g).max(b) - r.min(g).min(b) < GREY;
    let is_white = Straight([r, g, b, 255]).luma() > WHITE;
    match leaf {
        LeafName::Frond => BarkKind::Rings,
        LeafName::Bough | LeafName::Tuft => BarkKind::Plates,
        LeafName::Brush => BarkKind::Strips,
        _ if is_grey && is_white => BarkKind::Birch,
        _ => BarkKind::Furrowed,
    }
}

/// The median colour of the middle of the stem.
fn bark(
    photo: &Image<Straight>,
    trunk: &Pixels<'_>,
    rows: std::ops::Range<u32>,
) -> Option<[u8; 3]> {
    let mut channels: [Vec<u8>; 3] = Default::default();
    for y in rows {
        let (first, width) = longest_run(trunk, y);
        let margin = (0.5 * (1.0 - MIDDLE) * f64::from(width)) as u32;
        for x in first + margin..(first + width).saturating_sub(margin) {
            let Straight([r, g, b, alpha]) = photo.at(x, y);
            if alpha >= 128 {
                for (channel, value) in channels.iter_mut().zip([r, g, b]) {
                    channel.push(value);
                }
            }
        }
    }
    let [r, g, b] = channels.map(|mut channel| median(&mut channel));
    Some([r?, g?, b?])
}

fn median<T: Ord + Copy>(values: &mut [T]) -> Option<T> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable(middle).1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::CrownSettings;
    use crate::raster::{Mask, opaque_bounds};

    fn found(photo: &Image<Straight>, trunk: &Mask, crown: Rect) -> Option<FoundStem> {
        let trunk = Pixels {
            bounds: opaque_bounds(trunk)?,
            has: &|x, y| trunk.at(x, y),
        };
        stem_in(photo, &trunk, crown, (0.1, LeafName::Ovate))
    }

    /// A stem 100 pixels high that tapers from 20 to 14 pixels, with a wide foot, below a crown.
    fn tree() -> (Image<Straight>, Mask, Rect) {
        let half = |y: u32| match y {
            190.. => 25,
            100.. => 7 + (y - 100) / 30,
            _ => 0,
        };
        let is_trunk = |i: u32| (i % 100).abs_diff(50) < half(i / 100);
        let mask = Mask::from_pixels(100, 200, (0..20_000).map(is_trunk).collect());
        let color = |&trunk: &bool| match trunk {
            true => Straight([200, 190, 180, 255]),
            false => Straight([10, 200, 10, 255]),
        };
        let crown = Rect {
            x: 0,
            y: 0,
            width: 100,
            height: 120,
        };
        (mask.map(color), mask, crown)
    }

    #[test]
    fn thickness_taper_height_and_colour_are_those_of_the_picture() {
        let (photo, trunk, crown) = tree();
        let found = found(&photo, &trunk, crown).unwrap();
        assert!((0.8..1.0).contains(&found.look.base_radius_m), "{found:?}");
        let taper = found.look.top_radius_m / found.look.base_radius_m;
        assert!((0.5..0.85).contains(&taper), "{found:?}");
        assert_eq!(found.look.bark, [200, 190, 180]);
        assert!((found.height_m - 8.0).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn barks_go_by_leaves_and_colour() {
        assert_eq!(bark_kind(LeafName::Ovate, [190, 185, 180]), BarkKind::Birch);
        assert_eq!(bark_kind(LeafName::Ovate, [90, 80, 60]), BarkKind::Furrowed);
        assert_eq!(bark_kind(LeafName::Frond, [190, 185, 180]), BarkKind::Rings);
        assert_eq!(bark_kind(LeafName::Bough, [90, 80, 60]), BarkKind::Plates);
    }

    #[test]
    fn a_crown_stands_on_the_stem_of_its_picture_unless_told_otherwise() {
        let (photo, trunk, crown) = tree();
        let leaves = Mask::from_pixels(
            100,
            200,
            (0..20_000).map(|i| i / 100 < crown.height).collect(),
        );
        let masks = [&leaves, &trunk];
        let settings = CrownSettings::default().masked(&photo, masks, LeafName::Ovate);
        let height_m = settings.trunk_height_m.unwrap();
        // The crown is 120 pixels high and 10 metres, the stem below it has 80.
        assert!((height_m - 80.0 / 12.0).abs() < 1e-9, "{height_m}");
        assert!(settings.stem.is_some() && settings.check().is_ok());
        let told = CrownSettings {
            trunk_height_m: Some(1.0),
            ..CrownSettings::default()
        };
        let told = told.masked(&photo, masks, LeafName::Ovate);
        assert_eq!((told.trunk_height_m, told.stem), (Some(1.0), settings.stem));
    }

    #[test]
    fn a_dab_of_trunk_or_none_tells_nothing() {
        let (photo, trunk, crown) = tree();
        let nothing = trunk.map(|_| false);
        assert_eq!(found(&photo, &nothing, crown), None);
        let mut dab = nothing;
        dab.set(50, 150, true);
        assert_eq!(found(&photo, &dab, crown), None);
    }
}
