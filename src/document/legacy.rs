//! Contents in the histories of older projects.
//!
//! Histories are postcard, which knows no names: a content can only be read with the fields it was
//! written with. So what a type looked like stays here when it grows. Projects themselves are JSON and
//! need none of this (see [`super::migrate`]).

use super::content::{Content, Photo, PhotoId};
use super::settings::{
    Coloring, CrownSettings, ExemplarWeight, Favourite, Generation, VariationSettings,
};
use crate::contour::HandPins;
use crate::variation::{Aspect, Finish, HslShift, IndividualSettings, SeasonChoice};
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};

/// A content as it was before trees were bred.
#[derive(Deserialize)]
struct OldContent {
    title: String,
    photos: BTreeMap<PhotoId, Photo>,
    crowns: BTreeMap<PhotoId, CrownSettings>,
    variation: OldVariation,
    next_photo: u32,
    pins: BTreeMap<PhotoId, HandPins>,
}

#[derive(Deserialize)]
struct OldVariation {
    exemplars: Vec<ExemplarWeight>,
    target: Option<PhotoId>,
    strength: f64,
    mix: u32,
    weights: (f64, f64),
    coloring: Coloring,
    like: Option<PhotoId>,
    around: Option<OldFavourite>,
    seed: u64,
    count: u32,
    locked: Vec<u64>,
    favourites: Vec<OldFavourite>,
}

#[derive(Deserialize)]
struct OldFavourite {
    name: String,
    seed: u64,
    exemplars: Vec<ExemplarWeight>,
    color_weights: Vec<f64>,
    like: Option<PhotoId>,
}

/// The content in `bytes`, packed before there was a mark.
pub(super) fn content(bytes: &[u8]) -> Option<Content> {
    // Before there were pins, a content ended where they begin: then there are none.
    let read: Result<OldContent, _> = postcard::from_bytes(bytes).or_else(|_| {
        let without_pins = [bytes, &[0]].concat();
        postcard::from_bytes(&without_pins)
    });
    let old = read.ok()?;
    Some(Content {
        title: old.title,
        photos: old.photos,
        crowns: old.crowns,
        variation: old.variation.today(),
        next_photo: old.next_photo,
        pins: old.pins,
    })
}

impl OldVariation {
    fn today(self) -> VariationSettings {
        VariationSettings {
            exemplars: self.exemplars,
            target: self.target,
            strength: self.strength,
            mix: self.mix,
            weights: self.weights,
            coloring: self.coloring,
            like: self.like,
            around: self.around.map(OldFavourite::today),
            seed: self.seed,
            count: self.count,
            locked: self.locked,
            favourites: self
                .favourites
                .into_iter()
                .map(OldFavourite::today)
                .collect(),
            ..VariationSettings::default()
        }
    }
}

impl OldFavourite {
    fn today(self) -> Favourite {
        Favourite {
            name: self.name,
            seed: self.seed,
            exemplars: self.exemplars,
            color_weights: self.color_weights,
            like: self.like,
            finish: Finish::default(),
        }
    }
}

/// A content as it was before outlines were moved (mark 1).
#[derive(Deserialize)]
struct UnshapedContent {
    title: String,
    photos: BTreeMap<PhotoId, Photo>,
    crowns: BTreeMap<PhotoId, CrownSettings>,
    variation: UnshapedVariation,
    next_photo: u32,
    pins: BTreeMap<PhotoId, HandPins>,
}

#[derive(Deserialize)]
struct UnshapedVariation {
    exemplars: Vec<ExemplarWeight>,
    target: Option<PhotoId>,
    strength: f64,
    mix: u32,
    weights: (f64, f64),
    coloring: Coloring,
    like: Option<PhotoId>,
    around: Option<UnshapedFavourite>,
    seed: u64,
    count: u32,
    locked: Vec<u64>,
    favourites: Vec<UnshapedFavourite>,
    walks: bool,
    season: Option<SeasonChoice>,
    lineage: Vec<UnshapedGeneration>,
}

#[derive(Deserialize)]
struct UnshapedGeneration {
    parents: Vec<UnshapedFavourite>,
    locks: BTreeSet<Aspect>,
    seed: u64,
    locked: Vec<u64>,
}

#[derive(Deserialize)]
struct UnshapedFavourite {
    name: String,
    seed: u64,
    exemplars: Vec<ExemplarWeight>,
    color_weights: Vec<f64>,
    like: Option<PhotoId>,
    finish: UnshapedFinish,
}

#[derive(Deserialize)]
struct UnshapedFinish {
    individual: Option<IndividualSettings>,
    shift: Option<HslShift>,
    season: Option<SeasonChoice>,
}

/// The content in `bytes`, packed with mark 1.
pub(super) fn unshaped_content(bytes: &[u8]) -> Option<Content> {
    let old: UnshapedContent = postcard::from_bytes(bytes).ok()?;
    Some(Content {
        title: old.title,
        photos: old.photos,
        crowns: old.crowns,
        variation: old.variation.today(),
        next_photo: old.next_photo,
        pins: old.pins,
    })
}

impl UnshapedVariation {
    fn today(self) -> VariationSettings {
        VariationSettings {
            exemplars: self.exemplars,
            target: self.target,
            strength: self.strength,
            mix: self.mix,
            weights: self.weights,
            coloring: self.coloring,
            like: self.like,
            around: self.around.map(UnshapedFavourite::today),
            seed: self.seed,
            count: self.count,
            locked: self.locked,
            favourites: today(self.favourites),
            walks: self.walks,
            season: self.season,
            lineage: self
                .lineage
                .into_iter()
                .map(UnshapedGeneration::today)
                .collect(),
        }
    }
}

impl UnshapedGeneration {
    fn today(self) -> Generation {
        Generation {
            parents: today(self.parents),
            locks: self.locks,
            seed: self.seed,
            locked: self.locked,
        }
    }
}

fn today(favourites: Vec<UnshapedFavourite>) -> Vec<Favourite> {
    favourites
        .into_iter()
        .map(UnshapedFavourite::today)
        .collect()
}

impl UnshapedFavourite {
    fn today(self) -> Favourite {
        Favourite {
            name: self.name,
            seed: self.seed,
            exemplars: self.exemplars,
            color_weights: self.color_weights,
            like: self.like,
            finish: Finish {
                individual: self.finish.individual,
                shift: self.finish.shift,
                season: self.finish.season,
                ..Finish::default()
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contents_with_mark_1_are_read() {
        let shift = HslShift {
            hue: 0.01,
            saturation: 1.1,
            lightness: 0.9,
        };
        let part = ExemplarWeight {
            photo: PhotoId(2),
            weight: 0.5,
        };
        let individual = Some(IndividualSettings {
            strength: 0.4,
            mirrored: true,
        });
        let finish = (individual, Some(shift), None::<SeasonChoice>);
        let none = None::<PhotoId>;
        let favourite = ("kept", 7u64, vec![part], vec![1.0], none, finish);
        let generation = (vec![favourite.clone()], vec![Aspect::Hue], 3u64, vec![9u64]);
        let before = (vec![part], none, 0.7, 2u32, (0.3, 0.7), Coloring::One, none);
        let after = (5u64, 12u32, vec![4u64], vec![favourite.clone()]);
        let last = (true, None::<SeasonChoice>, vec![generation]);
        // Postcard writes a struct as its fields one after the other, and tuples do not show.
        let variation = (before, Some(favourite), after, last);
        let photos = BTreeMap::<PhotoId, Photo>::new();
        let crowns = BTreeMap::<PhotoId, CrownSettings>::new();
        let pins = BTreeMap::<PhotoId, HandPins>::new();
        let content = ("old", photos, crowns, variation, 3u32, pins);
        let read = unshaped_content(&postcard::to_stdvec(&content).unwrap_or_default());
        let Some(Content {
            title, variation, ..
        }) = read
        else {
            panic!("it is not read")
        };
        assert_eq!((title.as_str(), variation.count), ("old", 12));
        let kept = &variation.favourites[0];
        assert_eq!(
            (kept.finish.individual, kept.finish.shift),
            (individual, Some(shift))
        );
        assert_eq!(kept.finish.reshaping, None);
        assert_eq!(variation.lineage[0].locked, [9]);
        assert_eq!(variation.around.as_ref(), Some(kept));
    }
}
