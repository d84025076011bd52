//! One tree from seed to picture: skeleton, girth, limbs, leaves, light, paint.

use super::canvas::{Canvas, DepthImage};
use super::crown::crown_skeleton;
use super::foliage::{Leaf, Leafage, leafage};
use super::individual::Individual;
use super::light::{Blocker, LightGrid};
use super::limbs::{Girth, girth};
use super::ornament::ornaments;
use super::palm::palm;
use super::render::{Ornaments, Subject, View, paint};
use super::shadow::ShadowMap;
use super::skeleton::Skeleton;
use super::species::Habit;
use super::spline::{Limb, limbs};
use super::sprite::Sprite;
use super::whorls::whorl_skeleton;
use crate::base::{Cancel, Cancelled};
use crate::raster::{Image, Straight};
use glam::{Vec2, Vec3};

/// A grown tree, ready to be painted at any size.
pub struct Tree {
    individual: Individual,
    limbs: Vec<Limb>,
    leafage: Leafage,
    ornaments: Vec<Leaf>,
    sprite: Sprite,
    light: LightGrid,
    shadows: ShadowMap,
    low: Vec3,
    high: Vec3,
    crown_base_m: f32,
}

/// A grown tree's picture and what its pixels show.
#[derive(Debug, Clone, PartialEq)]
pub struct GrownTree {
    /// The tree on a clear ground, its foot in the middle of the lower edge.
    pub image: Image<Straight>,
    /// Of the same size: 0 background, 128 trunk, 255 crown. Limbs seen inside the crown are
    /// crown, as in the labels that people draw.
    pub labels: Image<u8>,
    /// Pixels of a metre.
    pub pixels_of_metre: f32,
    /// Depth and normals, if they were asked for.
    pub layers: Option<Layers>,
}

/// What a picture holds beside colour.
#[derive(Debug, Clone, PartialEq)]
pub struct Layers {
    /// How near each pixel is.
    pub depth: DepthImage,
    /// Where each pixel faces: x right, y up, z to the viewer, 128 for 0.
    pub normals: Image<Straight>,
}

/// Cells of the shadow map for a leaf's length, at most and at least this fine in metres.
const SHADOW_CELL_M: (f32, f32) = (0.02, 0.06);

impl Individual {
    /// Lets the tree grow.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn grow(&self, cancel: &Cancel) -> Result<Tree, Cancelled> {
        let (skeleton, girth, leafage) = self.body(cancel)?;
        let species = &self.species;
        let sprite = Sprite::new(species.foliage.shape);
        let mut random = self.seed.derive("ornament", 0).random();
        let ornaments = match &self.season.ornament {
            Some(ornament) => ornaments(ornament, &leafage, &mut random),
            None => Vec::new(),
        };
        let (low, high) = bounds(&skeleton, &girth, &leafage);
        let voxel_m = (high.y / 60.0).max(0.03);
        let to_sun = self.daylight.to_sun;
        let light = LightGrid::new(&blockers(&leafage, &sprite), to_sun, voxel_m, cancel)?;
        cancel.check()?;
        Ok(Tree {
            limbs: limbs(&skeleton, &girth),
            shadows: self.shadows(&leafage, &sprite, low, high),
            crown_base_m: self.crown_base(&leafage),
            individual: self.clone(),
            leafage,
            ornaments,
            sprite,
            light,
            low,
            high,
        })
    }

    fn body(&self, cancel: &Cancel) -> Result<(Skeleton, Girth, Leafage), Cancelled> {
        let species = &self.species;
        let mut random = self.seed.derive("skeleton", 0).random();
        let skeleton = match &species.habit {
            Habit::Crown(crown) => crown_skeleton(crown, &self.stance, &mut random, cancel)?,
            Habit::Whorls(whorls) => whorl_skeleton(whorls, &self.stance, &mut random),
            Habit::Palm(habit) => {
                let (stem_m, leaf_m) = (species.stem_m, species.foliage.leaf_m);
                let grown = palm(habit, &self.stance, stem_m, leaf_m, &mut random);
                return Ok((grown.skeleton, grown.girth, grown.leafage));
            }
        };
        let girth = girth(&skeleton, species.stem_m, species.tip_m);
        let mut random = self.seed.derive("foliage", 0).random();
        let tint = &self.season.tint;
        let leafage = leafage(&skeleton, &girth, &species.foliage, tint, &mut random);
        Ok((skeleton, girth, leafage))
    }

    fn shadows(&self, leafage: &Leafage, sprite: &Sprite, low: Vec3, high: Vec3) -> ShadowMap {
        let foliage = &self.species.foliage;
        let cell_m = (0.4 * foliage.leaf_m).clamp(SHADOW_CELL_M.0, SHADOW_CELL_M.1);
        let mut shadows = ShadowMap::new(&self.daylight, low, high, cell_m);
        let covered = sprite.coverage();
        for leaf in &leafage.leaves {
            // The disc that hides as much of the sun as the leaf does on average.
            let area = leaf.along.length() * leaf.across.length() * covered;
            shadows.cover(leaf.base + leaf.along * 0.5, 0.45 * area.sqrt());
        }
        shadows
    }

    /// Height in metres of the lowest foliage near the stem, but for a few stray leaves; 0 for
    /// shrubs, whose stems are no trunk.
    fn crown_base(&self, leafage: &Leafage) -> f32 {
        if matches!(self.species.habit, Habit::Crown(crown) if crown.stems > 1) {
            return 0.0;
        }
        let near_m = 4.0 * self.species.stem_m + 0.4;
        let stem = self.stance.lean.x;
        let mut heights: Vec<f32> = leafage
            .leaves
            .iter()
            .filter(|leaf| (leaf.base.x - stem * leaf.base.y).abs() < near_m)
            .map(|leaf| leaf.base.y)
            .collect();
        heights.sort_by(f32::total_cmp);
        heights.get(heights.len() / 50).copied().unwrap_or(0.0)
    }
}

impl Tree {
    /// The picture of `width` × `height` pixels: as large as it fits, foot in the middle of the
    /// lower edge; with depth and normals if `with_layers`.
    ///
    /// The tree is the same at every size; only its picture gets finer.
    ///
    /// # Errors
    /// [`Cancelled`].
    ///
    /// # Panics
    /// When a side is 0.
    pub fn picture(
        &self,
        (width, height): (u32, u32),
        with_layers: bool,
        cancel: &Cancel,
    ) -> Result<GrownTree, Cancelled> {
        assert!(width > 0 && height > 0, "a picture has at least one pixel");
        let corners = (self.low.truncate(), self.high.truncate());
        let view = View::fitted(corners, (width, height));
        let mut canvas = Canvas::new(width, height, with_layers);
        paint(&mut canvas, &view, &self.subject(), cancel)?;
        cancel.check()?;
        Ok(GrownTree {
            image: canvas.image(),
            labels: canvas.labels(),
            pixels_of_metre: view.pixels_of_metre(),
            layers: with_layers.then(|| Layers {
                depth: canvas.depth(),
                normals: canvas.normals(),
            }),
        })
    }

    /// Height of the tree in metres.
    pub fn height_m(&self) -> f32 {
        self.high.y
    }

    /// Left and right end of the tree, in metres from its foot.
    pub fn extent_m(&self) -> Vec2 {
        Vec2::new(self.low.x, self.high.x)
    }

    fn subject(&self) -> Subject<'_> {
        let Individual {
            species,
            season,
            daylight,
            ..
        } = &self.individual;
        Subject {
            limbs: &self.limbs,
            leafage: &self.leafage,
            ornaments: season.ornament.as_ref().map(|ornament| Ornaments {
                leaves: &self.ornaments,
                sprite: Sprite::ornament(ornament.kind),
                ornament,
            }),
            sprite: &self.sprite,
            tint: &season.tint,
            bark: &species.bark,
            daylight,
            light: &self.light,
            shadows: &self.shadows,
            leaf_m: species.foliage.leaf_m,
            stem_m: species.stem_m,
            height_m: self.high.y,
            crown_base_m: self.crown_base_m,
        }
    }
}

fn blockers(leafage: &Leafage, sprite: &Sprite) -> Vec<Blocker> {
    let covered = sprite.coverage();
    leafage
        .leaves
        .iter()
        .map(|leaf| Blocker {
            position: leaf.base + leaf.along * 0.5,
            area_m2: leaf.along.length() * leaf.across.length() * covered,
        })
        .collect()
}

/// The box around the tree in metres, down to the ground.
fn bounds(skeleton: &Skeleton, girth: &Girth, leafage: &Leafage) -> (Vec3, Vec3) {
    let stem_m = girth.radius_m.first().copied().unwrap_or(0.1);
    let wood = skeleton.nodes.iter().map(|node| node.position);
    let leaves = leafage.leaves.iter();
    let leaves = leaves.flat_map(|leaf| [leaf.base, leaf.base + leaf.along]);
    let foot = Vec3::new(2.0 * stem_m, 0.0, 2.0 * stem_m);
    let start = (-foot, foot + Vec3::Y * 0.5);
    let (mut low, high) = wood.chain(leaves).fold(start, |(low, high), point| {
        (low.min(point), high.max(point))
    });
    low.y = 0.0;
    (low, high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::branches::species::species_named;

    fn grown(name: &str, index: u32, height_px: u32) -> GrownTree {
        let individual = Individual::new(species_named(name).unwrap(), index);
        let tree = individual.grow(&Cancel::new()).unwrap();
        let size = (height_px * 2 / 3, height_px);
        tree.picture(size, true, &Cancel::new()).unwrap()
    }

    #[test]
    fn labels_tell_a_trunk_below_a_crown() {
        for (name, has_trunk) in [("pine", true), ("palm", true), ("shrub", false)] {
            let tree = grown(name, 1, 192);
            let labels = &tree.labels;
            assert_eq!(labels.width(), tree.image.width());
            assert!(
                labels
                    .pixels()
                    .iter()
                    .all(|label| [0, 128, 255].contains(label))
            );
            let foot = labels.row(labels.height() - 2);
            assert_eq!(foot.contains(&128), has_trunk, "{name}");
            let top = labels.pixels().iter().position(|&label| label > 0).unwrap();
            assert_eq!(labels.pixels()[top], 255, "{name}");
        }
    }

    #[test]
    fn layers_cover_what_the_picture_covers() {
        let tree = grown("spruce", 2, 96);
        let layers = tree.layers.unwrap();
        for (index, pixel) in tree.image.pixels().iter().enumerate() {
            let is_seen = pixel.alpha() > 0;
            assert_eq!(layers.depth.steps.pixels()[index] > 0, is_seen);
            assert_eq!(layers.normals.pixels()[index].alpha() > 0, is_seen);
        }
    }

    #[test]
    fn individuals_differ() {
        for name in ["birch", "poplar", "cypress", "fir", "palm"] {
            let [one, two] = [1, 2].map(|index| grown(name, index, 48));
            let covered = one.image.pixels().iter().filter(|p| p.alpha() > 127);
            assert!(covered.count() > 80, "{name}");
            assert_ne!(one.image, two.image, "{name}");
        }
    }

    #[test]
    fn a_raised_flag_stops_the_growth() {
        let cancel = Cancel::new();
        cancel.cancel();
        let individual = Individual::new(species_named("oak").unwrap(), 1);
        assert!(individual.grow(&cancel).is_err());
    }
}
