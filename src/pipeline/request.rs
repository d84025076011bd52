//! A crown as a project asks for it, in the terms of the pipeline.
//!
//! What is in no project (the envelope, how foliage is synthesised, how tall the tree is) has the
//! defaults of the command line, so that a photograph and its mask give the same crown in both.

use super::crown::{CrownError, CrownSettings};
use super::pictured::Pixels;
use crate::base::Seed;
use crate::branches::leaf_name::LeafName;
use crate::crown::{Profile, SubCrown, Tangent};
use crate::document;
use crate::geometry::Point;
use crate::paint::{CROWN, TRUNK, TiledMask};
use crate::raster::{Image, Mask, Rect, Straight, opaque_bounds};
use std::collections::BTreeMap;

/// All that a crown is made by, beside the photograph and its labels.
#[derive(Debug, Clone, PartialEq)]
pub struct CrownRequest {
    /// How it is made.
    pub settings: CrownSettings,
    /// How far sub-crowns are pushed towards the viewer, by label, in shares of the crown's width.
    pub sub_crown_depths: BTreeMap<u8, f64>,
    /// Seed of the foliage.
    pub seed: Seed,
}

impl CrownRequest {
    /// k of a region for which nobody has chosen one: a disc becomes as deep as wide.
    pub const ROUND: f64 = 2.08;

    /// What a project asks for.
    ///
    /// ```
    /// use boscage::{document, pipeline::{CrownRequest, CrownSettings}};
    /// let request = CrownRequest::of(&document::CrownSettings::default()).unwrap();
    /// assert_eq!(request.settings, CrownSettings::default());
    /// ```
    ///
    /// # Errors
    /// [`CrownError::Tangent`] with the column of a formula that cannot be read;
    /// [`CrownError::Profile`].
    pub fn of(asked: &document::CrownSettings) -> Result<Self, CrownError> {
        let k = match &asked.k {
            document::Tangent::Automatic => None,
            document::Tangent::Expression(text) => Some(Tangent::parse(text)?),
            document::Tangent::Profile(points) => {
                let points = points.iter().map(|&(t, k)| [t, k]).collect();
                Some(Tangent::Profile(Profile::new(vec![points])?))
            }
        };
        Ok(Self {
            settings: CrownSettings {
                size: asked.size,
                k,
                copies: asked.copies,
                rho: asked.rho,
                relief: asked.relief,
                photo_front: asked.photo_front,
                ..CrownSettings::default()
            },
            sub_crown_depths: asked.sub_crown_depths.clone(),
            seed: Seed(asked.seed),
        })
    }

    /// The same with what `photo` shows of the tree that is labelled: [`CrownSettings::pictured`].
    #[must_use]
    pub fn pictured(mut self, photo: &Image<Straight>, labels: &TiledMask, leaf: LeafName) -> Self {
        let is_trunk = |label: u8| label == TRUNK;
        let Some(bounds) = labels.bounds(is_crown) else {
            return self;
        };
        let has = &|x, y| is_crown(labels.at(x, y));
        let crown = Pixels { bounds, has };
        let has = &|x, y| is_trunk(labels.at(x, y));
        let trunk = labels.bounds(is_trunk);
        let trunk = trunk.map(|bounds| Pixels { bounds, has });
        self.settings = self.settings.pictured(photo, &crown, trunk.as_ref(), leaf);
        self
    }

    /// The sub-crowns of a picture whose masks are `regions`: all with one k, each at its depth.
    pub(super) fn sub_crowns(&self, regions: &Regions) -> Vec<SubCrown> {
        let tangent = self.settings.k.clone();
        let tangent = tangent.unwrap_or(Tangent::Constant(Self::ROUND));
        let sub_crown = |(label, mask): &(u8, Mask)| SubCrown {
            mask: mask.clone(),
            tangent: tangent.clone(),
            depth_px: self.sub_crown_depths.get(label).unwrap_or(&0.0) * regions.width_px,
        };
        regions.masks.iter().map(sub_crown).collect()
    }
}

/// The labels of a picture as masks.
#[derive(Debug, Clone)]
pub(super) struct Regions {
    /// The crown and its sub-crowns, by label.
    pub(super) masks: Vec<(u8, Mask)>,
    /// All of them.
    pub(super) union: Mask,
    /// Width of all, pixels.
    width_px: f64,
}

/// Whether pixels with this label are foliage: of the crown or of a sub-crown.
pub fn is_crown(label: u8) -> bool {
    label == CROWN || label > TRUNK
}

/// Which pixels of a picture are looked at: every `step`th of a part of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Thinning {
    part: Rect,
    step: u32,
}

impl Thinning {
    /// All pixels of `labels`.
    pub(super) fn none(labels: &TiledMask) -> Self {
        Self {
            part: labels.rect(),
            step: 1,
        }
    }

    /// The pixels around the crown in `labels`, so many that its longer side has `longest` or a few
    /// more, if it has as many.
    pub(super) fn to(labels: &TiledMask, longest: u32) -> Self {
        let Some(bounds) = labels.bounds(is_crown) else {
            return Self::none(labels);
        };
        let step = (bounds.width.max(bounds.height) / longest).max(1);
        let (left, top) = (
            bounds.x.saturating_sub(2 * step),
            bounds.y.saturating_sub(2 * step),
        );
        let right = (bounds.x + bounds.width + 2 * step).min(labels.width());
        let bottom = (bounds.y + bounds.height + 2 * step).min(labels.height());
        let part = Rect {
            x: left,
            y: top,
            width: right - left,
            height: bottom - top,
        };
        Self { part, step }
    }

    /// Width and height of what is looked at, pixels.
    fn size(&self) -> (u32, u32) {
        let side = |length: u32| (length / self.step).max(1);
        (side(self.part.width), side(self.part.height))
    }

    /// The column or row of the `i`th that is looked at.
    fn at(&self, i: u32, first: u32, length: u32) -> u32 {
        first + (i * self.step + self.step / 2).min(length - 1)
    }

    fn labels(&self, labels: &TiledMask) -> Image<u8> {
        let part = self.part;
        if *self == Self::none(labels) {
            return labels.image();
        }
        let (width, height) = self.size();
        let mut image = Image::filled(width, height, 0);
        for y in 0..height {
            let from = i64::from(self.at(y, part.y, part.height));
            let row = labels.window(i64::from(part.x), from, part.width, 1, 0);
            for (x, pixel) in (0..width).zip(image.row_mut(y)) {
                *pixel = row.pixels()[self.at(x, 0, part.width) as usize];
            }
        }
        image
    }

    /// Whether all pixels are looked at.
    pub(super) fn is_none(&self) -> bool {
        self.step == 1 && (self.part.x, self.part.y) == (0, 0)
    }

    /// The place in the photograph of a place in the thinned one.
    pub(super) fn in_photo(&self, place: Point) -> Point {
        let first = Point::new(f64::from(self.part.x), f64::from(self.part.y));
        first + place * f64::from(self.step) + f64::from(self.step / 2)
    }

    /// The same pixels of the photograph.
    pub(super) fn photo(&self, photo: &Image<Straight>) -> Image<Straight> {
        let (part, (width, height)) = (self.part, self.size());
        let pixel = |i: u32| {
            let x = self.at(i % width, part.x, part.width);
            photo.at(x, self.at(i / width, part.y, part.height))
        };
        Image::from_pixels(width, height, (0..width * height).map(pixel).collect())
    }
}

impl Regions {
    /// Of those pixels of `labels`; `None` when no foliage is labelled.
    pub(super) fn new(labels: &TiledMask, thinning: Thinning) -> Option<Self> {
        let image = thinning.labels(labels);
        let mut is_used = [false; 256];
        for &label in image.pixels() {
            is_used[usize::from(label)] = true;
        }
        let used = (0..=255u8).filter(|&label| is_used[usize::from(label)] && is_crown(label));
        let masks: Vec<(u8, Mask)> = used
            .map(|used| (used, image.map(|&label| label == used)))
            .collect();
        let union = match &masks[..] {
            [(_, only)] => only.clone(),
            _ => image.map(|&label| is_crown(label)),
        };
        let bounds = opaque_bounds(&union)?;
        Some(Self {
            masks,
            union,
            width_px: f64::from(bounds.width),
        })
    }

    /// The labels above those of crown and trunk.
    pub(super) fn sub_crowns(&self) -> Vec<u8> {
        let labels = self.masks.iter().map(|(label, _)| *label);
        labels.filter(|&label| label > TRUNK).collect()
    }

    /// Whether there are sub-crowns.
    pub(super) fn is_parted(&self) -> bool {
        self.masks.len() > 1
    }
}
