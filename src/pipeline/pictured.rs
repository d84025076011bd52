//! What a picture shows of a tree beside the outline of its crown.

use super::cover::cover_in;
use super::crown::CrownSettings;
use super::stem::stem_in;
use crate::branches::leaf_name::LeafName;
use crate::raster::{Image, Mask, Rect, Straight, opaque_bounds};

/// Some pixels of a picture: a rectangle around them, and which of it they are.
pub struct Pixels<'a> {
    /// Around them, pixels.
    pub bounds: Rect,
    /// Whether the pixel at a column and a row is one.
    pub has: &'a dyn Fn(u32, u32) -> bool,
}

/// Height of a stem below the crown that tells where the ground is, as a share of the crown's: a dab on the
/// crown's lower edge does not.
const LEAST_STEM: f64 = 0.03;

impl CrownSettings {
    /// The same with what `photo` shows of the tree whose pixels are `crown` and `trunk`: how dense its leaves are,
    /// if the photograph is a cut-out; thickness, taper and bark of its stem; and how high the stem carries the crown,
    /// unless that is set. Between fronds one sees others, so crowns with those for `leaf` are closed.
    #[must_use]
    pub fn pictured(
        mut self,
        photo: &Image<Straight>,
        crown: &Pixels<'_>,
        trunk: Option<&Pixels<'_>>,
        leaf: LeafName,
    ) -> Self {
        let metres_a_pixel = self.height_m / f64::from(crown.bounds.height);
        let stem =
            trunk.and_then(|trunk| stem_in(photo, trunk, crown.bounds, (metres_a_pixel, leaf)));
        if let Some(found) = stem {
            self.stem = Some(found.look);
            let tells = found.height_m > LEAST_STEM * self.height_m;
            let height_m = tells.then_some(found.height_m);
            self.trunk_height_m = self.trunk_height_m.or(height_m);
        }
        if leaf != LeafName::Frond {
            self.cover = cover_in(photo, crown).unwrap_or(self.cover);
        }
        self
    }

    /// [`CrownSettings::pictured`] of masks of the photograph's size.
    #[must_use]
    pub fn masked(
        self,
        photo: &Image<Straight>,
        [crown, trunk]: [&Mask; 2],
        leaf: LeafName,
    ) -> Self {
        let pixels = |mask: &Mask, has| opaque_bounds(mask).map(|bounds| Pixels { bounds, has });
        let (is_crown, is_trunk) = (|x, y| crown.at(x, y), |x, y| trunk.at(x, y));
        match pixels(crown, &is_crown) {
            Some(crown) => self.pictured(photo, &crown, pixels(trunk, &is_trunk).as_ref(), leaf),
            None => self,
        }
    }
}
