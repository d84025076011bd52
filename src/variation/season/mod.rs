//! A tree in another season: spring, summer, autumn, winter, and snow.
//!
//! Leaves take the colours of the season by matching the distribution of their light with that of a
//! palette, built in or a reference picture's (histogram transfer; Argudo, Andújar & Chica 2017, *Tree
//! Variations*, §5.3), on crown pixels only and on those that are leaf, not limb. What the paper
//! does not have: leaves turn in clumps, the top and the outside first ([`colors`]); in winter they
//! fall, and the limbs that the picture shows, or limbs grown in their place, remain ([`winter`]);
//! snow lies on what faces the sky ([`snow`]); evergreens keep their leaves ([`evergreen`]).
//!
//! Limits: a crown too dense to show its limbs gets limbs of our own growing, like trees of its
//! outline have, not those it really has.

mod bark;
mod colors;
mod evergreen;
mod growth;
mod leaves;
mod snow;
mod winter;

use super::{Histogram, Tree};
use crate::base::{Cancel, Cancelled, Seed};
use crate::segment::Label;
use leaves::Leaves;
use serde::{Deserialize, Serialize};

pub use evergreen::{is_evergreen, named_evergreen};

/// A season.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Season {
    /// Young leaves, light and yellowish.
    Spring,
    /// Green.
    Summer,
    /// Turned leaves.
    Autumn,
    /// Bare limbs.
    Winter,
}

/// How a season shows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SeasonSettings {
    /// Which.
    pub season: Season,
    /// How far it has come, 0 (not at all) to 1: the share of leaves that have turned or fallen.
    pub amount: f64,
    /// How much of what faces the sky is under snow, 0 to 1.
    pub snow: f64,
}

impl SeasonSettings {
    /// A season as it usually looks, without snow.
    pub fn of(season: Season) -> Self {
        let amount = match season {
            Season::Autumn => 0.8,
            Season::Spring | Season::Summer => 0.85,
            Season::Winter => 1.0,
        };
        Self {
            season,
            amount,
            snow: 0.0,
        }
    }
}

/// Puts `tree` into a season. `evergreen` trees keep leaves and colours, but for the snow; where it is not told,
/// their looks decide as for [`is_evergreen`]. `like`
/// gives the colours of turned leaves instead of the built-in palette. Where leaves turn first is drawn
/// from `seed`. Labels change where leaves fall.
///
/// # Errors
/// [`Cancelled`].
pub fn put_in_season(
    tree: &mut Tree,
    settings: &SeasonSettings,
    evergreen: Option<bool>,
    like: Option<&Histogram>,
    seed: Seed,
    cancel: &Cancel,
) -> Result<(), Cancelled> {
    let leaves = Leaves::of(tree, cancel)?;
    if let Some(leaves) = &leaves
        && !evergreen.unwrap_or_else(|| evergreen::looks_evergreen(tree, leaves))
    {
        match settings.season {
            Season::Winter => {
                if !leaves.are_fallen() {
                    winter::undress(tree, leaves, settings.amount, seed, cancel)?;
                }
            }
            Season::Summer if leaves.are_green() && like.is_none() => {}
            season => colors::turn(tree, leaves, season, settings.amount, like, seed, cancel)?,
        }
    }
    if settings.snow > 0.0 {
        snow::fall(tree, settings.snow, seed, cancel)?;
    }
    for (pixel, label) in tree.image.pixels().iter().zip(tree.labels.pixels_mut()) {
        if pixel.alpha() < 128 {
            *label = Label::Background;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::{Image, Straight};
    use crate::variation::maker::grown as sample;

    fn put(tree: &Tree, season: Season, amount: f64, snow: f64, evergreen: bool) -> Tree {
        let mut tree = tree.clone();
        let settings = SeasonSettings {
            season,
            amount,
            snow,
        };
        put_in_season(
            &mut tree,
            &settings,
            Some(evergreen),
            None,
            Seed(5),
            &Cancel::new(),
        )
        .unwrap();
        tree
    }

    fn seen(tree: &Tree) -> usize {
        tree.image
            .pixels()
            .iter()
            .filter(|pixel| pixel.alpha() >= 128)
            .count()
    }

    /// Share of the changed pixels among those of `label` in some rows, by eighths of the height.
    fn changed(a: &Tree, b: &Tree, label: Label, rows: std::ops::Range<u32>) -> f64 {
        let height = a.image.height();
        let (mut all, mut other) = (0.0f64, 0.0);
        for y in rows.start * height / 8..rows.end * height / 8 {
            for x in 0..a.image.width() {
                if a.labels.at(x, y) == label && a.image.at(x, y).alpha() > 200 {
                    let (one, two) = (a.image.at(x, y).0, b.image.at(x, y).0);
                    all += 1.0;
                    other += f64::from(u8::from((0..3).any(|c| one[c].abs_diff(two[c]) > 24)));
                }
            }
        }
        other / all.max(1.0)
    }

    #[test]
    fn the_top_turns_first_and_the_trunk_never() {
        let tree = sample("linden");
        let autumn = put(&tree, Season::Autumn, 0.4, 0.0, false);
        let (top, low) = (
            changed(&tree, &autumn, Label::Crown, 0..3),
            changed(&tree, &autumn, Label::Crown, 4..7),
        );
        assert!(top > low + 0.15, "{top} {low}");
        assert_eq!(changed(&tree, &autumn, Label::Trunk, 0..8), 0.0);
        assert_eq!(seen(&tree), seen(&autumn));
        let none = put(&tree, Season::Autumn, 0.0, 0.0, false);
        assert_eq!(none.image, tree.image);
    }

    #[test]
    fn more_leaves_turn_and_fall_as_a_season_goes_on() {
        let tree = sample("maple");
        let turned = |amount| {
            let autumn = put(&tree, Season::Autumn, amount, 0.0, false);
            changed(&tree, &autumn, Label::Crown, 0..8)
        };
        let steps = [0.2, 0.5, 0.8].map(turned);
        assert!(steps[0] < steps[1] && steps[1] < steps[2], "{steps:?}");
        let left =
            [0.0, 0.5, 1.0].map(|amount| seen(&put(&tree, Season::Winter, amount, 0.0, false)));
        assert!(left[0] > left[1] && left[1] > left[2], "{left:?}");
        assert!(left[2] < seen(&tree) * 3 / 4);
    }

    #[test]
    fn limbs_stand_on_the_trunk_and_reach_into_the_crown() {
        let tree = sample("oak");
        let winter = put(&tree, Season::Winter, 1.0, 0.0, false);
        let wood = winter.image.map(|pixel| pixel.alpha() >= 96);
        let parts = crate::raster::labelled_components(&wood);
        let foot = (0..wood.width()).find(|&x| wood.at(x, wood.height() - 4));
        let trunk = parts.at(foot.unwrap(), wood.height() - 4);
        let one = parts.pixels().iter().filter(|part| **part == trunk).count();
        assert!(one * 10 > wood.count() * 8, "{one} of {}", wood.count());
        let high = (0..wood.height() / 4)
            .any(|y| (0..wood.width()).any(|x| parts.at(x, y) == trunk && wood.at(x, y)));
        assert!(high);
    }

    #[test]
    fn the_trunk_goes_on_as_thick_as_it_was() {
        for name in ["oak", "maple", "linden"] {
            let tree = sample(name);
            let winter = put(&tree, Season::Winter, 1.0, 0.0, false);
            // The longest run of wood in a row.
            let run = |y: u32| {
                let row = winter.image.row(y);
                let runs = row.split(|pixel| pixel.alpha() < 128).map(<[_]>::len);
                runs.max().unwrap_or(0) as f64
            };
            let height = tree.image.height();
            let is_trunk = |y: &u32| {
                let row = tree.labels.row(*y).iter();
                run(*y) > 0.0
                    && row.filter(|label| **label == Label::Trunk).count() as f64 > 0.7 * run(*y)
            };
            let top = (height / 2..height).find(is_trunk).unwrap();
            let step = height / 60;
            let (above, below) = (run(top - step), run(top + 2 * step));
            assert!(above > 0.65 * below, "{name}: {above} above {below}");
        }
    }

    #[test]
    fn evergreens_change_only_under_snow() {
        let tree = sample("spruce");
        for season in [
            Season::Spring,
            Season::Summer,
            Season::Autumn,
            Season::Winter,
        ] {
            assert_eq!(put(&tree, season, 1.0, 0.0, true).image, tree.image);
        }
        let white = |tree: &Tree| {
            let is_white = |pixel: &&Straight| pixel.alpha() > 128 && pixel.0[2] > 140;
            tree.image.pixels().iter().filter(is_white).count()
        };
        let some = put(&tree, Season::Winter, 1.0, 0.3, true);
        let much = put(&tree, Season::Winter, 1.0, 0.9, true);
        assert!(white(&tree) < white(&some) && 2 * white(&some) < 3 * white(&much));
    }

    #[test]
    fn looks_tell_conifers() {
        for (name, evergreen) in [("spruce", true), ("linden", false), ("maple", false)] {
            let found = is_evergreen(&sample(name), &Cancel::new()).unwrap();
            assert_eq!(found, evergreen, "{name}");
        }
    }

    #[test]
    fn a_clear_picture_stays_clear_in_all_seasons() {
        let tree = Tree {
            image: Image::filled(20, 20, Straight([0; 4])),
            labels: Image::filled(20, 20, Label::Background),
        };
        for season in [Season::Spring, Season::Autumn, Season::Winter] {
            assert_eq!(put(&tree, season, 1.0, 1.0, false), tree);
        }
    }
}
