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

/// A small height in pixels that `digests.txt` lists too, for quick tests.
pub const SMALL_HEIGHT_PX: u32 = 128;

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
            bundled: include_bytes!(concat!("../../assets/samples/", $name, ".webp")),
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
            crown_base_m: crown_base(species, &leafage),
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

/// Height in metres of the lowest foliage near the stem, but for a few stray leaves; 0 for
/// shrubs, whose stems are no trunk.
fn crown_base(species: &Species, leafage: &Leafage) -> f32 {
    if matches!(species.habit, Habit::Crown(crown) if crown.stems > 1) {
        return 0.0;
    }
    let mut heights: Vec<f32> = leafage
        .leaves
        .iter()
        .filter(|leaf| leaf.base.x.abs() < 4.0 * species.stem_m + 0.4)
        .map(|leaf| leaf.base.y)
        .collect();
    heights.sort_by(f32::total_cmp);
    heights.get(heights.len() / 50).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Digest;

    /// Lines of `NAME HEIGHT_PX DIGEST`, written by `examples/regenerate_samples.rs`.
    const DIGESTS: &str = include_str!("../../assets/samples/digests.txt");

    fn sample(name: &str) -> &'static Sample {
        samples()
            .iter()
            .find(|sample| sample.name() == name)
            .unwrap()
    }

    fn line(name: &str, image: &Image<Straight>) -> String {
        let digest = Digest::of(bytemuck::cast_slice(image.pixels()));
        format!("{name} {} {digest}", image.height())
    }

    fn assert_listed(line: &str) {
        assert!(
            DIGESTS.lines().any(|listed| listed == line),
            "{line} is not listed"
        );
    }

    fn bundled(sample: &Sample) -> Image<Straight> {
        let file = image::load_from_memory(sample.bundled())
            .unwrap()
            .into_rgba8();
        let pixels = bytemuck::cast_slice(file.as_raw()).to_vec();
        Image::from_pixels(file.width(), file.height(), pixels)
    }

    #[test]
    fn every_bundled_picture_has_the_listed_pixels() {
        for sample in samples() {
            assert_listed(&line(sample.name(), &bundled(sample)));
        }
    }

    #[test]
    fn a_tree_grown_anew_is_the_bundled_one() {
        let sapling = sample("sapling");
        let grown = sapling.grow(BUNDLED_HEIGHT_PX, &Cancel::new()).unwrap();
        assert_eq!(
            line("sapling", &grown.image),
            line("sapling", &bundled(sapling))
        );
    }

    #[test]
    fn small_pictures_have_the_listed_pixels() {
        for name in ["fir", "robinia", "pine"] {
            let grown = sample(name).grow(SMALL_HEIGHT_PX, &Cancel::new()).unwrap();
            assert_listed(&line(name, &grown.image));
        }
    }

    #[test]
    fn labels_tell_a_trunk_below_a_crown() {
        for (name, has_trunk) in [("pine", true), ("birch", true), ("shrub", false)] {
            let tree = sample(name).grow(SMALL_HEIGHT_PX, &Cancel::new()).unwrap();
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
            assert!(labels.row(labels.height() / 4).contains(&255), "{name}");
            assert!(!labels.row(labels.height() / 8).contains(&128), "{name}");
        }
    }

    #[test]
    fn a_raised_flag_stops_the_growth() {
        let cancel = Cancel::new();
        cancel.cancel();
        assert_eq!(sample("oak").grow(64, &cancel), Err(Cancelled));
    }
}
