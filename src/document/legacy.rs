//! Contents in the histories of older projects.
//!
//! Histories are postcard, which knows no names: a content can only be read with the fields it was
//! written with. So what a type looked like stays here when it grows. Projects themselves are JSON and
//! need none of this (see [`super::migrate`]).

use super::content::{Content, Photo, PhotoId};
use super::settings::{
    Coloring, CrownSettings, ExemplarWeight, Favourite, Generation, Tangent, VariationSettings,
};
use crate::contour::HandPins;
use crate::crown::ReliefSettings;
use crate::variation::{Aspect, Finish, HslShift, IndividualSettings, SeasonChoice};
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};

/// A content whose crowns, and maybe variations, were others.
#[derive(Deserialize)]
struct OldContent<V> {
    title: String,
    photos: BTreeMap<PhotoId, Photo>,
    crowns: BTreeMap<PhotoId, LeaflessCrown>,
    variation: V,
    next_photo: u32,
    pins: BTreeMap<PhotoId, HandPins>,
}

/// A crown's settings as they were before it had leaves of its own (mark 2 and all before).
#[derive(Deserialize)]
struct LeaflessCrown {
    k: Tangent,
    size: u32,
    rho: f64,
    relief: ReliefSettings,
    copies: u32,
    photo_front: bool,
    sub_crown_depths: BTreeMap<u8, f64>,
    seed: u64,
}

/// Variations as they were before trees were bred (no mark).
#[derive(Deserialize)]
struct OldVariation<F> {
    exemplars: Vec<ExemplarWeight>,
    target: Option<PhotoId>,
    strength: f64,
    mix: u32,
    weights: (f64, f64),
    coloring: Coloring,
    like: Option<PhotoId>,
    around: Option<F>,
    seed: u64,
    count: u32,
    locked: Vec<u64>,
    favourites: Vec<F>,
}

/// A favourite as it was then.
#[derive(Deserialize)]
struct OldFavourite {
    name: String,
    seed: u64,
    exemplars: Vec<ExemplarWeight>,
    color_weights: Vec<f64>,
    like: Option<PhotoId>,
}

/// Variations as they were before outlines were moved (mark 1): what came behind the older ones.
#[derive(Deserialize)]
struct UnshapedVariation {
    older: OldVariation<UnshapedFavourite>,
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
    older: OldFavourite,
    finish: UnshapedFinish,
}

#[derive(Deserialize)]
struct UnshapedFinish {
    individual: Option<IndividualSettings>,
    shift: Option<HslShift>,
    season: Option<SeasonChoice>,
}

/// The content in `bytes`, packed before there was a mark.
pub(super) fn content(bytes: &[u8]) -> Option<Content> {
    // Before there were pins, a content ended where they begin: then there are none.
    let read: Result<OldContent<OldVariation<OldFavourite>>, _> = postcard::from_bytes(bytes)
        .or_else(|_| {
            let without_pins = [bytes, &[0]].concat();
            postcard::from_bytes(&without_pins)
        });
    Some(read.ok()?.today())
}

/// The content in `bytes`, packed with mark 2.
pub(super) fn leafless_content(bytes: &[u8]) -> Option<Content> {
    let old: OldContent<VariationSettings> = postcard::from_bytes(bytes).ok()?;
    Some(old.today())
}

/// The content in `bytes`, packed with mark 1.
pub(super) fn unshaped_content(bytes: &[u8]) -> Option<Content> {
    let old: OldContent<UnshapedVariation> = postcard::from_bytes(bytes).ok()?;
    Some(old.today())
}

impl<V: Into<VariationSettings>> OldContent<V> {
    fn today(self) -> Content {
        let crowns = self.crowns.into_iter();
        Content {
            title: self.title,
            photos: self.photos,
            crowns: crowns.map(|(photo, crown)| (photo, crown.into())).collect(),
            variation: self.variation.into(),
            next_photo: self.next_photo,
            pins: self.pins,
        }
    }
}

impl From<LeaflessCrown> for CrownSettings {
    fn from(old: LeaflessCrown) -> Self {
        Self {
            k: old.k,
            size: old.size,
            rho: old.rho,
            relief: old.relief,
            copies: old.copies,
            photo_front: old.photo_front,
            sub_crown_depths: old.sub_crown_depths,
            seed: old.seed,
            leaf: None,
        }
    }
}

impl<F: Into<Favourite>> From<OldVariation<F>> for VariationSettings {
    fn from(old: OldVariation<F>) -> Self {
        Self {
            exemplars: old.exemplars,
            target: old.target,
            strength: old.strength,
            mix: old.mix,
            weights: old.weights,
            coloring: old.coloring,
            like: old.like,
            around: old.around.map(Into::into),
            seed: old.seed,
            count: old.count,
            locked: old.locked,
            favourites: old.favourites.into_iter().map(Into::into).collect(),
            ..Self::default()
        }
    }
}

impl From<UnshapedVariation> for VariationSettings {
    fn from(old: UnshapedVariation) -> Self {
        Self {
            walks: old.walks,
            season: old.season,
            lineage: old.lineage.into_iter().map(Into::into).collect(),
            ..old.older.into()
        }
    }
}

impl From<UnshapedGeneration> for Generation {
    fn from(old: UnshapedGeneration) -> Self {
        Self {
            parents: old.parents.into_iter().map(Into::into).collect(),
            locks: old.locks,
            seed: old.seed,
            locked: old.locked,
        }
    }
}

impl From<OldFavourite> for Favourite {
    fn from(old: OldFavourite) -> Self {
        Self {
            name: old.name,
            seed: old.seed,
            exemplars: old.exemplars,
            color_weights: old.color_weights,
            like: old.like,
            finish: Finish::default(),
        }
    }
}

impl From<UnshapedFavourite> for Favourite {
    fn from(old: UnshapedFavourite) -> Self {
        let finish = Finish {
            individual: old.finish.individual,
            shift: old.finish.shift,
            season: old.finish.season,
            ..Finish::default()
        };
        Self {
            finish,
            ..old.older.into()
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

    #[test]
    fn contents_with_mark_2_are_read() {
        let depths = BTreeMap::from([(3u8, 0.2)]);
        let relief = ReliefSettings::default();
        let crown = (
            Tangent::Expression("3*j".into()),
            512u32,
            0.3,
            relief,
            2u32,
            true,
            depths,
            9u64,
        );
        let crowns = BTreeMap::from([(PhotoId(1), crown)]);
        let photos = BTreeMap::<PhotoId, Photo>::new();
        let pins = BTreeMap::<PhotoId, HandPins>::new();
        let variation = VariationSettings {
            count: 17,
            ..VariationSettings::default()
        };
        let content = ("old", photos, crowns, variation.clone(), 2u32, pins);
        let read = leafless_content(&postcard::to_stdvec(&content).unwrap_or_default());
        let Some(Content {
            crowns,
            variation: read,
            ..
        }) = read
        else {
            panic!("it is not read")
        };
        assert_eq!(read, variation);
        let crown = &crowns[&PhotoId(1)];
        assert_eq!((crown.size, crown.seed, crown.leaf), (512, 9, None));
        assert_eq!(crown.k, Tangent::Expression("3*j".into()));
    }
}
