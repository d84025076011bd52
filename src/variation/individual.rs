//! Another individual of the same tree: its foliage grown anew from its own, its colours moved a little
//! within what the species has.
//!
//! A warp leaves every clump and gap where an eye finds it again. So the crown is cut into cells that take
//! what other places of it show ([`super::cells`]), on the outline such as end as it does there; limbs sway and the
//! outline swells and shrinks by smooth noise ([`super::sway`], [`super::rim`]). Strength
//! says how many cells change and scales all else: more of it keeps all changes and adds to them. What stands
//! straight gets other boughs first ([`super::tiers`]).
//!
//! What is no foliage is not cut: a palm's fronds are turned about its heart ([`super::fronds`]), the limbs of a bare
//! tree stand in each other's places ([`super::limbs`]).
//!
//! The trunk and the wood that shows in the crown ([`super::wood`]) only sway.
//!
//! Limits: limbs whose colours are those of leaves are cut.

use super::cells::{Both, Grid, cell_side, regrown};
use super::finish::Reshaping;
use super::fronds;
use super::habit::Habit;
use super::limbs::{is_bare, relimbed};
use super::noise::Noise;
use super::rim::{clear_loose_leaves, within_outline};
use super::stem::rebarked;
use super::sway::{Boughs, swayed};
use super::tiers::retiered;
use super::wood;
use super::{HslShift, Tree};
use crate::base::{Cancel, Cancelled, Random, Seed};
use crate::raster::{Image, opaque_bounds};
use crate::segment::Label;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// How much of the usual jitter of hue, saturation and lightness: within one species.
const COLOR: f64 = 0.45;

/// The same for the difference of clumps as wide as this many cells.
const CLUMP_COLOR: f64 = 0.6;
const CLUMP: f64 = 1.6;

/// How a tree is made another individual.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct IndividualSettings {
    /// 0 (the tree itself) to 1 (far from what it was).
    pub strength: f64,
    /// Whether it stands mirrored.
    pub mirrored: bool,
}

impl IndividualSettings {
    /// Least strength at which trees are mirrored.
    const LEAST_MIRRORED: f64 = 0.25;

    /// What becomes of the variation of a target with this seed; nothing without strength.
    pub fn drawn(strength: f64, seed: Seed) -> Option<Self> {
        let side = seed.derive("mirror", 0).random().unit();
        (strength > 0.0).then_some(Self {
            strength,
            mirrored: strength >= Self::LEAST_MIRRORED && side < 0.5,
        })
    }

    /// The mirror of it alone, if it is mirrored.
    #[must_use]
    pub fn mirror_alone(self) -> Option<Self> {
        let strength = 0.0;
        self.mirrored.then_some(Self { strength, ..self })
    }
}

/// Makes `tree` another individual. `has_fronds` tells whether its crown is of fronds about one heart, as
/// that of a palm.
///
/// # Errors
/// [`Cancelled`].
pub fn make_individual(
    tree: &mut Tree,
    settings: &IndividualSettings,
    has_fronds: bool,
    seed: Seed,
    cancel: &Cancel,
) -> Result<(), Cancelled> {
    let strength = settings.strength;
    if settings.mirrored {
        *tree = mirrored(tree);
    }
    let crown = tree.labels.map(|label| *label == Label::Crown);
    let Some(bounds) = opaque_bounds(&crown).filter(|_| strength > 0.0) else {
        return Ok(());
    };
    let mut random = seed.derive("individual", 0).random();
    let shift = HslShift::drawn(COLOR * strength, &mut random);
    let of_clump = HslShift::drawn(CLUMP_COLOR * strength, &mut random);
    let grid = Grid::new(bounds, crown.count(), &mut random);
    let Some(habit) = Habit::of(tree) else {
        return Ok(());
    };
    rebarked(tree, grid.side, strength, &mut random);
    let turn = &mut seed.derive("fronds", 0).random();
    if has_fronds && fronds::turned(tree, strength, turn, cancel)? {
        let stance = (&habit, None);
        *tree = swayed(tree, stance, grid.side, [strength; 2], &mut random, cancel)?;
    } else if is_bare(tree, grid.side) {
        let of_limbs = &mut seed.derive("limbs", 0).random();
        let mut bare = relimbed(tree, &habit, strength, of_limbs, cancel)?;
        let wood = wood::wood(tree, grid.side, cancel)?;
        wood::keep(&wood, tree, &mut bare);
        let boughs = Boughs::new(&mut seed.derive("boughs", 0).random()).bare();
        let stance = (&habit, Some(&boughs));
        *tree = swayed(&bare, stance, grid.side, [strength; 2], &mut random, cancel)?;
    } else {
        *tree = refoliated(tree, (&habit, &grid), strength, seed, &mut random, cancel)?;
    }
    let clumps = Noise::new(&mut random);
    recolored(tree, grid.side, |place| {
        shift.between(&of_clump, clumps.at(place) - 0.5)
    });
    Ok(())
}

/// `tree` with other boughs if it stands straight, another outline and other foliage.
fn refoliated(
    tree: &Tree,
    (habit, grid): (&Habit, &Grid),
    strength: f64,
    seed: Seed,
    random: &mut Random,
    cancel: &Cancel,
) -> Result<Tree, Cancelled> {
    let side = grid.side;
    let shunned = wood::wood(tree, side, cancel)?;
    let of_tiers = &mut seed.derive("tiers", 0).random();
    let tiered = match habit.is_straight() {
        true => Some(retiered(
            tree,
            (habit, &shunned),
            side,
            strength,
            of_tiers,
            cancel,
        )?),
        false => None,
    };
    let boughs = Boughs::new(&mut seed.derive("boughs", 0).random());
    let stance = (habit, Some(&boughs));
    let tiered = tiered.as_ref().unwrap_or(tree);
    let outline = swayed(tiered, stance, side, [strength; 2], random, cancel)?;
    let stays = wood::wood(&outline, side, cancel)?;
    let both = Both {
        swayed: &outline,
        tree,
        habit,
        wood: [&stays, &shunned],
    };
    let grown = regrown(both, grid, strength, seed, cancel)?;
    let (mut made, inside) = within_outline((&outline, habit), &grown, side, cancel)?;
    clear_loose_leaves(&mut made, tree, &inside, side);
    Ok(made)
}

/// Moves the outline of `tree`; its stem and its leaves stay what they are.
///
/// # Errors
/// [`Cancelled`].
pub fn reshape(
    tree: &mut Tree,
    reshaping: &Reshaping,
    has_fronds: bool,
    cancel: &Cancel,
) -> Result<(), Cancelled> {
    let strength = reshaping.strength;
    let mut random = Seed(reshaping.seed).derive("reshaping", 0).random();
    let crown = tree.labels.map(|label| *label == Label::Crown);
    let (Some(habit), true) = (Habit::of(tree), strength > 0.0) else {
        return Ok(());
    };
    if has_fronds && fronds::turned(tree, strength, &mut random, cancel)? {
        return Ok(());
    }
    let boughs = Boughs::new(&mut random);
    let side = cell_side(crown.count());
    let stance = (&habit, Some(&boughs));
    *tree = swayed(tree, stance, side, [strength, 0.0], &mut random, cancel)?;
    Ok(())
}

/// Moves the colours of all but the stem, from clump to clump by what `shift` tells of their places;
/// `side` is the size of a cell, pixels.
fn recolored(tree: &mut Tree, side: f64, shift: impl Fn([f64; 2]) -> HslShift + Sync) {
    let width = tree.image.width() as usize;
    let rows = tree.image.pixels_mut().par_chunks_mut(width);
    let rows = rows.zip(tree.labels.pixels().par_chunks(width)).enumerate();
    rows.for_each(|(y, (pixels, labels))| {
        for (x, (pixel, label)) in pixels.iter_mut().zip(labels).enumerate() {
            if *label != Label::Trunk && pixel.alpha() > 0 {
                let place = [x, y].map(|along| along as f64 / (CLUMP * side));
                *pixel = shift(place).applied(*pixel);
            }
        }
    });
}

/// `tree` seen in a mirror.
pub fn mirrored(tree: &Tree) -> Tree {
    fn flipped<P: Copy>(image: &Image<P>) -> Image<P> {
        let rows = (0..image.height()).flat_map(|y| image.row(y).iter().rev().copied());
        Image::from_pixels(image.width(), image.height(), rows.collect())
    }
    Tree {
        image: flipped(&tree.image),
        labels: flipped(&tree.labels),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::dilated;
    use crate::segment::crown_count;
    use crate::variation::Look;
    use crate::variation::cells::cell_side;
    use crate::variation::maker::grown as sample;

    fn individual(tree: &Tree, strength: f64) -> Tree {
        let mut tree = tree.clone();
        let settings = IndividualSettings {
            strength,
            mirrored: false,
        };
        make_individual(&mut tree, &settings, false, Seed(3), &Cancel::new()).unwrap();
        tree
    }

    /// Mean difference of premultiplied colours.
    fn difference(a: &Tree, b: &Tree) -> f64 {
        let pixels = a.image.pixels().iter().zip(b.image.pixels());
        let sum: f64 = pixels
            .map(|(a, b)| {
                let (a, b) = (a.premultiplied().0, b.premultiplied().0);
                (0..4).map(|c| f64::from(a[c].abs_diff(b[c]))).sum::<f64>()
            })
            .sum();
        sum / a.image.pixels().len() as f64
    }

    #[test]
    fn no_strength_is_the_tree_and_more_goes_farther() {
        for name in ["oak", "spruce"] {
            let tree = sample(name);
            assert_eq!(individual(&tree, 0.0), tree);
            let steps = [0.0, 0.1, 0.35, 1.0].map(|s| difference(&tree, &individual(&tree, s)));
            assert!(steps.is_sorted(), "{name}: {steps:?}");
            assert!(steps[3] > 4.0, "{name}: {steps:?}");
        }
    }

    #[test]
    fn an_eye_knows_it_less_and_less() {
        let tree = sample("maple");
        let look = |tree: &Tree| {
            Look::of(&tree.image.premultiplied(), &Cancel::new())
                .unwrap()
                .unwrap()
        };
        let own = look(&tree);
        let likeness = [0.1, 0.35, 0.7].map(|s| own.likeness(&look(&individual(&tree, s))).score());
        assert!(likeness[0] > likeness[2], "{likeness:?}");
        assert!(likeness[1] >= likeness[2], "{likeness:?}");
        assert!(likeness[2] < 0.5, "{likeness:?}");
    }

    #[test]
    fn the_species_keeps_its_colours_its_mass_and_its_trunk() {
        let tree = sample("linden");
        let other = individual(&tree, 1.0);
        let seen = |tree: &Tree| {
            tree.image
                .pixels()
                .iter()
                .filter(|p| p.alpha() > 127)
                .count() as f64
        };
        let share = seen(&other) / seen(&tree);
        assert!((0.85..1.25).contains(&share), "{share}");
        let mean = |tree: &Tree, c: usize| {
            let pixels = tree.image.pixels().iter().filter(|p| p.alpha() > 127);
            pixels.map(|p| f64::from(p.0[c])).sum::<f64>() / seen(tree)
        };
        for c in 0..3 {
            assert!((mean(&tree, c) - mean(&other, c)).abs() < 22.0);
        }
        // The stem winds a little; it stands where it stood, as thick as it was.
        let row = |tree: &Tree, y: u32| {
            let labels = tree.labels.row(y).iter().enumerate();
            let trunk = labels.filter(|(_, label)| **label == Label::Trunk);
            let columns: Vec<f64> = trunk.map(|(x, _)| x as f64).collect();
            (
                columns.iter().sum::<f64>() / columns.len() as f64,
                columns.len(),
            )
        };
        let foot = tree.image.height() - 4;
        let (own, new) = (row(&tree, foot), row(&other, foot));
        assert!((own.0 - new.0).abs() < 2.5, "{own:?} {new:?}");
        assert!(own.1.abs_diff(new.1) <= 3, "{own:?} {new:?}");
    }

    #[test]
    fn the_stem_in_the_crown_is_not_cut_in_pieces() {
        let tree = sample("birch");
        let side = cell_side(crown_count(&tree.labels));
        let stem = |tree: &Tree| wood::wood(tree, side, &Cancel::new()).unwrap();
        let own = stem(&tree);
        let about = dilated(&own, (1.5 * side) as u8);
        let (mut all, mut elsewhere) = (0, 0);
        for seed in 0..4 {
            let mut other = tree.clone();
            let settings = IndividualSettings {
                strength: 0.7,
                mirrored: false,
            };
            make_individual(&mut other, &settings, false, Seed(seed), &Cancel::new()).unwrap();
            let new = stem(&other);
            let pixels = new.pixels().iter().zip(about.pixels());
            all += new.count();
            elsewhere += pixels.filter(|(is, is_near)| **is && !**is_near).count();
        }
        // Cut in cells like leaves, more than half of it was elsewhere. Twigs are taken for wood at this size.
        assert!(all > 4 * own.count(), "{all}");
        assert!(10 * elsewhere < 4 * all, "{elsewhere} of {all}");
    }

    #[test]
    fn a_mirror_twice_is_the_tree() {
        let tree = sample("birch");
        assert_ne!(mirrored(&tree), tree);
        assert_eq!(mirrored(&mirrored(&tree)), tree);
    }
}
