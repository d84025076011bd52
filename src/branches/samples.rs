//! The built-in library: trees of our own making, the same bits wherever they are grown.
//!
//! Nothing but code goes in, so the pictures carry nobody's licence. The bundled files in
//! `assets/samples` hold exactly what [`Sample::grow`] gives at [`BUNDLED_HEIGHT_PX`];
//! `digests.txt` beside them names those pixels, and a test compares.

use super::canvas::Canvas;
use super::crown::crown_skeleton;
use super::foliage::{Leafage, leafage};
use super::light::{Blocker, LightGrid};
use super::limbs::girth;
use super::render::{Subject, fitted, paint};
use super::skeleton::Skeleton;
use super::species::{self, Habit, Species};
use super::sprite::Sprite;
use super::whorls::whorl_skeleton;
use crate::base::{Cancel, Cancelled, Random, Seed};
use crate::raster::{Image, Straight};
use glam::Vec2;

/// Height of the bundled pictures in pixels.
pub const BUNDLED_HEIGHT_PX: u32 = 1024;

/// One tree of the built-in library.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    name: &'static str,
    species: &'static Species,
    seed: Seed,
    bundled: &'static [u8],
}

/// A grown tree's picture and what its pixels show.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GrownTree {
    /// The tree on a clear ground, its foot at the lower edge.
    pub image: Image<Straight>,
    /// Of the same size: 0 background, 128 trunk, 255 crown. Limbs seen inside the crown are
    /// crown, as in the labels that people draw.
    pub labels: Image<u8>,
}

macro_rules! sample {
    ($name:literal, $species:ident, $seed:literal) => {
        Sample {
            name: $name,
            species: &species::$species,
            seed: Seed($seed),
            bundled: include_bytes!(concat!("../../assets/samples/", $name, ".png")),
        }
    };
}

static SAMPLES: [Sample; 13] = [
    sample!("oak", OAK, 2),
    sample!("linden", LINDEN, 1),
    sample!("birch", BIRCH, 1),
    sample!("poplar", POPLAR, 1),
    sample!("maple", MAPLE, 1),
    sample!("maple_autumn", MAPLE_AUTUMN, 2),
    sample!("sapling", SAPLING, 1),
    sample!("shrub", SHRUB, 1),
    sample!("willow", WILLOW, 1),
    sample!("robinia", ROBINIA, 1),
    sample!("spruce", SPRUCE, 1),
    sample!("fir", FIR, 1),
    sample!("pine", PINE, 1),
];

/// The built-in library, in the order it is shown.
pub fn samples() -> &'static [Sample] {
    &SAMPLES
}

impl Sample {
    /// Name of the tree, also of its file: lower-case letters and underscores.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// The bundled picture as the bytes of an image file, [`BUNDLED_HEIGHT_PX`] high.
    pub fn bundled(&self) -> &'static [u8] {
        self.bundled
    }

    /// Grows the tree and paints it `height_px` high, as wide as it needs.
    ///
    /// The tree is the same at every height; only its picture gets finer. At 1024 it takes about
    /// a second of one core.
    ///
    /// # Errors
    /// [`Cancelled`].
    ///
    /// # Panics
    /// When `height_px` is 0.
    pub fn grow(&self, height_px: u32, cancel: &Cancel) -> Result<GrownTree, Cancelled> {
        assert!(height_px > 0, "a picture has at least one row");
        let species = self.species;
        let seed = self.seed.derive("built-in sample", 0);
        let skeleton = skeleton(species, &mut seed.derive("skeleton", 0).random(), cancel)?;
        let girth = girth(&skeleton, species.stem_m, species.tip_m);
        let sprite = Sprite::new(species.foliage.shape);
        let mut random = seed.derive("foliage", 0).random();
        let leafage = leafage(
            &skeleton,
            &girth,
            &species.foliage,
            sprite.aspect,
            &mut random,
        );
        let voxel_m = species.height_m / 60.0;
        let light = LightGrid::new(&blockers(&leafage, &sprite), voxel_m, cancel)?;
        let (low, high) = bounds(&skeleton, &leafage);
        let (view, width_px) = fitted(low, high, height_px);
        let mut canvas = Canvas::new(width_px, height_px);
        let subject = Subject {
            skeleton: &skeleton,
            girth: &girth,
            leafage: &leafage,
            sprite: &sprite,
            tint: &species.foliage.tint,
            bark: &species.bark,
            light: &light,
            height_m: high.y,
            crown_base_m: crown_base(&leafage, species.stem_m),
        };
        paint(&mut canvas, &view, &subject, cancel)?;
        Ok(GrownTree {
            image: canvas.image(),
            labels: canvas.labels(),
        })
    }
}

fn skeleton(
    species: &Species,
    random: &mut Random,
    cancel: &Cancel,
) -> Result<Skeleton, Cancelled> {
    match &species.habit {
        Habit::Crown(crown) => crown_skeleton(crown, species.height_m, random, cancel),
        Habit::Whorls(whorls) => Ok(whorl_skeleton(whorls, species.height_m, random)),
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

/// The picture's extent: lower left and upper right corner in metres, above the ground.
fn bounds(skeleton: &Skeleton, leafage: &Leafage) -> (Vec2, Vec2) {
    let wood = skeleton.nodes.iter().map(|node| node.position);
    let leaves = leafage
        .leaves
        .iter()
        .flat_map(|leaf| [leaf.base, leaf.base + leaf.along]);
    wood.chain(leaves).fold(
        (Vec2::new(-0.5, 0.0), Vec2::new(0.5, 1.0)),
        |(low, high), point| (low.min(point.truncate()), high.max(point.truncate())),
    )
}

/// Height in metres of the lowest foliage near the stem, but for a few stray leaves.
fn crown_base(leafage: &Leafage, stem_m: f32) -> f32 {
    let mut heights: Vec<f32> = leafage
        .leaves
        .iter()
        .filter(|leaf| leaf.base.x.abs() < 4.0 * stem_m + 0.4)
        .map(|leaf| leaf.base.y)
        .collect();
    heights.sort_by(f32::total_cmp);
    heights.get(heights.len() / 50).copied().unwrap_or(0.0)
}
