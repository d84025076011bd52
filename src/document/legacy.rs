//! Contents in the histories of older projects.
//!
//! Histories are postcard, which knows no names: a content can only be read with the fields it was
//! written with. So what a type looked like stays here when it grows. Projects themselves are JSON and
//! need none of this (see [`super::migrate`]).

use super::content::{Content, Photo, PhotoId};
use super::settings::{Coloring, CrownSettings, ExemplarWeight, Favourite, VariationSettings};
use crate::contour::HandPins;
use crate::variation::Finish;
use serde::Deserialize;
use std::collections::BTreeMap;

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
