//! How much a set of trees repeats itself, as an eye would say that looks along a row of them.
//!
//! Two trees are alike when their pictures correlate ([`correlation`], what one sees from afar) or
//! when the same clumps, gaps and limbs are found in both ([`features`], what one sees on second
//! sight, and what survives a warp). Neither sees colour or size: an eye is not fooled by those
//! (Argudo, Andújar & Chica 2017, *Tree Variations*, §1).
//!
//! The score of a set is the mean, over its trees, of the likeness to the tree most like it: in a
//! forest every tree that has a double is one too many. 1 is a row of copies; a row of different
//! photographs has some hundredths.
//!
//! Limits: a tree mirrored *and* warped, or turned, may be missed; trees of few features (a bare
//! pole, an icon of 30 pixels) are compared by correlation alone.

mod correlation;
mod features;
mod view;

use crate::base::{Cancel, Cancelled, Progress};
use crate::raster::{Image, Premultiplied, opaque_bounds};
use correlation::Views;
use features::Features;
use rayon::prelude::*;

/// Most trees that are compared with each other: half a million pairs take minutes.
pub const MOST_COMPARED: usize = 512;

/// Alpha from which a pixel belongs to the tree.
const SEEN_ALPHA: u8 = 24;

/// Correlation of trees that nobody takes for copies, and of copies under another light. Of the 741
/// pairs of 39 real trees 95 % stay below 0.35; recoloured copies have 0.86 to 1.
const CORRELATION: [f64; 2] = [0.4, 0.85];

/// The same for the share of matched features: 95 % of those pairs stay below 0.14; copies squeezed to
/// 0.7 of their width, whose correlation is 0.43, have 0.56 to 0.9.
const MATCHED: [f64; 2] = [0.15, 0.6];

/// A tree as it is compared.
#[derive(Debug, Clone)]
pub struct Look {
    views: Views,
    features: Features,
}

impl Look {
    /// The look of the tree in `image`, of any size and anywhere in it; `None` when it is clear.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn of(image: &Image<Premultiplied>, cancel: &Cancel) -> Result<Option<Self>, Cancelled> {
        let seen = image.map(|pixel| pixel.alpha() >= SEEN_ALPHA);
        let Some(bounds) = opaque_bounds(&seen) else {
            return Ok(None);
        };
        let tree = image.cropped(bounds.x, bounds.y, bounds.width, bounds.height);
        Ok(Some(Self {
            views: Views::of(&tree, cancel)?,
            features: Features::of(&tree, cancel)?,
        }))
    }

    /// How alike the trees are.
    pub fn likeness(&self, other: &Self) -> Likeness {
        let peak = correlation::peak(&self.views, &other.views);
        let (matched, in_mirror) = features::matched(&self.features, &other.features);
        let by_features = ramp(matched, MATCHED) > ramp(peak.height, CORRELATION);
        Likeness {
            correlation: peak.height.clamp(0.0, 1.0),
            matched,
            is_mirrored: if by_features {
                in_mirror
            } else {
                peak.is_mirrored
            },
            scale: peak.scale,
        }
    }
}

/// How alike two trees are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Likeness {
    /// The highest correlation, 0 to 1.
    pub correlation: f64,
    /// Share of local features that are found again, 0 to 1.
    pub matched: f64,
    /// Whether they are most alike when one is mirrored.
    pub is_mirrored: bool,
    /// How much larger the second is drawn where they correlate most.
    pub scale: f64,
}

impl Likeness {
    /// 0: nobody takes one for the other; 1: a copy.
    pub fn score(&self) -> f64 {
        let by_pixels = ramp(self.correlation, CORRELATION);
        let by_features = ramp(self.matched, MATCHED);
        1.0 - (1.0 - by_pixels) * (1.0 - by_features)
    }
}

/// 0 up to the first of `ends`, 1 from the second on, straight between.
fn ramp(value: f64, [low, high]: [f64; 2]) -> f64 {
    ((value - low) / (high - low)).clamp(0.0, 1.0)
}

/// Two trees of a set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// Index of the first.
    pub first: usize,
    /// Index of the second, which is larger.
    pub second: usize,
    /// How alike they are.
    pub likeness: Likeness,
}

/// How much a set of trees repeats itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Repetition {
    /// Mean likeness to the nearest other tree, 0 to 1.
    pub score: f64,
    /// For each tree the pair with the tree most like it, the most alike pair first; none twice.
    pub pairs: Vec<Pair>,
}

impl Repetition {
    /// The repetition among `looks`; of fewer than two nothing repeats.
    ///
    /// # Errors
    /// [`Cancelled`].
    ///
    /// # Panics
    /// With more than [`MOST_COMPARED`] looks.
    pub fn among(
        looks: &[Look],
        progress: Progress<'_>,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        assert!(looks.len() <= MOST_COMPARED, "every tree meets every other");
        let stage = progress.stage("compare", looks.len() as u64);
        let rows: Vec<Vec<Pair>> = (0..looks.len())
            .into_par_iter()
            .with_max_len(1)
            .map(|first| {
                let others = first + 1..looks.len();
                let pairs = others.map(|second| {
                    cancel.check()?;
                    Ok(Pair {
                        first,
                        second,
                        likeness: looks[first].likeness(&looks[second]),
                    })
                });
                let pairs = pairs.collect();
                stage.advance();
                pairs
            })
            .collect::<Result<_, Cancelled>>()?;
        Ok(Self::of_pairs(looks.len(), &rows.concat()))
    }

    fn of_pairs(count: usize, pairs: &[Pair]) -> Self {
        let mut nearest: Vec<Option<Pair>> = vec![None; count];
        for pair in pairs {
            for tree in [pair.first, pair.second] {
                let is_nearer = |known: Pair| order(&known).1 < order(pair).1;
                if nearest[tree].is_none_or(is_nearer) {
                    nearest[tree] = Some(*pair);
                }
            }
        }
        let scores = nearest.iter().flatten().map(|pair| pair.likeness.score());
        let score = scores.sum::<f64>() / count.max(1) as f64;
        let mut pairs: Vec<Pair> = nearest.into_iter().flatten().collect();
        pairs.sort_by(|a, b| {
            let (one, other) = (order(a), order(b));
            let alike = other.0.total_cmp(&one.0).then(other.1.total_cmp(&one.1));
            alike.then((a.first, a.second).cmp(&(b.first, b.second)))
        });
        pairs.dedup_by_key(|pair| (pair.first, pair.second));
        Self { score, pairs }
    }
}

/// What pairs are ordered by: the score, and where that is at its end the measures.
fn order(pair: &Pair) -> (f64, f64) {
    let likeness = &pair.likeness;
    let score = likeness.score();
    (score, score + likeness.correlation + likeness.matched)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Seed;
    use crate::raster::{ReadLimits, read_image, resized};
    use crate::variation::HslShift;

    /// A real tree by name; `None` where the folder of real pictures is not there.
    fn tree(name: &str) -> Option<Image<Premultiplied>> {
        let data = std::env::var("BOSCAGE_DATA").unwrap_or("../shared/data".to_owned());
        let path = std::path::PathBuf::from(format!("{data}/billboards/{name}.png"));
        if !path.is_file() {
            println!("{} is not there: nothing is compared", path.display());
            return None;
        }
        Some(
            read_image(&path, ReadLimits::default())
                .unwrap()
                .premultiplied(),
        )
    }

    fn look(image: &Image<Premultiplied>) -> Look {
        Look::of(image, &Cancel::new()).unwrap().unwrap()
    }

    fn stretched(image: &Image<Premultiplied>, across: f64, down: f64) -> Image<Premultiplied> {
        let (width, height) = (image.width(), image.height());
        let side = |pixels: u32, scale: f64| (f64::from(pixels) * scale) as u32;
        resized(image, image.rect(), side(width, across), side(height, down))
    }

    fn mirrored(image: &Image<Premultiplied>) -> Image<Premultiplied> {
        let mut image = image.clone();
        for y in 0..image.height() {
            image.row_mut(y).reverse();
        }
        image
    }

    #[test]
    fn copies_are_known_again_however_they_are_disguised() {
        for name in [
            "apple_airy_medium_01",
            "fir_dense_01",
            "willow_green_medium_01",
        ] {
            let Some(tree) = tree(name) else { return };
            let own = look(&tree);
            let mut other = tree.straight();
            HslShift::drawn(1.0, &mut Seed(7).random()).apply(&mut other);
            let other = other.premultiplied();
            assert!(own.likeness(&own).score() > 0.99);
            let smaller = own.likeness(&look(&stretched(&other, 0.8, 0.8)));
            assert!(
                smaller.score() > 0.95 && !smaller.is_mirrored,
                "{name}: {smaller:?}"
            );
            let flipped = own.likeness(&look(&mirrored(&other)));
            assert!(
                flipped.score() > 0.95 && flipped.is_mirrored,
                "{name}: {flipped:?}"
            );
            let squeezed = own.likeness(&look(&stretched(&other, 0.75, 1.0)));
            assert!(squeezed.score() > 0.6, "{name}: {squeezed:?}");
        }
    }

    /// What people see in these pictures: the first pair is one picture in two colours, the second one
    /// tree under less and more snow, the third two spruces, the last a broad-leaved tree and a palm.
    #[test]
    fn real_pairs_stand_in_the_order_an_eye_gives_them() {
        let pairs = [
            ["broadleaf_dense_02", "broadleaf_yellow_dense_05"],
            [
                "bare_broadleaf_snow_sparse_02",
                "bare_broadleaf_snow_sparse_03",
            ],
            ["spruce_dense_11", "spruce_medium_06"],
            ["broadleaf_airy_medium_01", "palm_short_dense_02"],
        ];
        let mut scores = Vec::new();
        for names in pairs {
            let [Some(a), Some(b)] = names.map(tree) else {
                return;
            };
            scores.push(look(&a).likeness(&look(&b)).score());
        }
        println!("{scores:?}");
        assert!(scores[0] > 0.95 && scores[1] > 0.7);
        assert!(scores[2] < 0.5 && scores[3] < 0.1);
        assert!(scores[0] >= scores[1] && scores[1] > scores[2] && scores[2] >= scores[3]);
    }

    #[test]
    fn the_offending_pair_is_named_and_nothing_repeats_alone() {
        let names = ["fir_dense_01", "palm_medium_01", "willow_green_medium_01"];
        let mut looks = Vec::new();
        for name in names {
            let Some(tree) = tree(name) else { return };
            looks.push(look(&tree));
        }
        looks.push(looks[1].clone());
        let silent = Progress::silent();
        let found = Repetition::among(&looks, silent, &Cancel::new()).unwrap();
        assert_eq!((found.pairs[0].first, found.pairs[0].second), (1, 3));
        assert!((0.5..0.7).contains(&found.score), "{}", found.score);
        let alone = Repetition::among(&looks[..1], silent, &Cancel::new()).unwrap();
        assert_eq!((alone.score, alone.pairs.len()), (0.0, 0));
    }

    #[test]
    fn a_clear_picture_has_no_look() {
        let clear = Image::filled(9, 9, Premultiplied::default());
        assert!(Look::of(&clear, &Cancel::new()).unwrap().is_none());
    }
}
