//! A project's variations: its settings as those of `variation`, and the trees of its gallery.
//!
//! Tree *i* of a gallery has the seed that `boscage vary` gives tree *i* of a batch with the gallery's
//! seed, so that what is seen is what a batch makes. Locked seeds of an earlier gallery stand first;
//! those of this one stay where they are.

use crate::base::Seed;
use crate::document::{self, ExemplarWeight, Favourite, Generation, PhotoId, VariationSettings};
use crate::variation::{
    Brood, ChoiceError, ChoiceSettings, Chosen, Coloring, Decided, Finish, Genome,
    IndividualSettings, Library, Part, Reshaping, SeasonChoice, Shape, chosen, parts_near,
};
use std::sync::Arc;

/// The settings of random choice that `settings` mean.
pub fn choice_settings(settings: &VariationSettings) -> ChoiceSettings {
    ChoiceSettings {
        mix: settings.mix as usize,
        weights: settings.weights,
        coloring: match settings.coloring {
            document::Coloring::One => Coloring::One,
            document::Coloring::Blend => Coloring::Blend,
        },
        strength: settings.strength,
        selective: settings.walks,
    }
}

/// A place of the gallery.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Slot {
    /// The seed of the tree's decisions.
    pub seed: u64,
    /// Whether it stays when the gallery is drawn again.
    pub is_locked: bool,
}

/// The places of the gallery, in order: as many as `settings` count, or as are locked.
pub fn gallery_slots(settings: &VariationSettings) -> Vec<Slot> {
    let count = settings.count as usize;
    let drawn = |index: usize| Seed(settings.seed).derive("tree", index as u64).0;
    let all: Vec<u64> = (0..count).map(drawn).collect();
    let is_locked = |seed: &u64| settings.locked.contains(seed);
    let earlier = settings.locked.iter().filter(|seed| !all.contains(seed));
    let mut slots: Vec<Slot> = earlier
        .map(|&seed| Slot {
            seed,
            is_locked: true,
        })
        .collect();
    // Trees of this gallery give way to earlier ones from its end on, unlocked ones only.
    let locked = all.iter().filter(|seed| is_locked(seed)).count();
    let mut free = count.saturating_sub(slots.len() + locked);
    for seed in all {
        let is_locked = is_locked(&seed);
        if is_locked || free > 0 {
            slots.push(Slot { seed, is_locked });
            free -= usize::from(!is_locked);
        }
    }
    slots
}

/// How a tree of the gallery is decided on.
#[derive(Debug, Clone, PartialEq)]
pub enum GalleryTree {
    /// Drawn with this seed from all exemplars.
    Drawn(u64),
    /// Drawn with this seed near another tree.
    Near(Arc<Genome>, u64),
    /// This tree itself.
    Kept(Arc<Genome>),
    /// The child of this seed.
    Bred(Arc<Brood>, u64),
}

impl GalleryTree {
    /// The pictures whose colours the trees may take that it comes from, as its genomes count them.
    pub fn likes(&self) -> Vec<usize> {
        let genomes = match self {
            Self::Drawn(_) => &[],
            Self::Near(genome, _) | Self::Kept(genome) => std::slice::from_ref(genome.as_ref()),
            Self::Bred(brood, _) => brood.parents.as_slice(),
        };
        genomes.iter().filter_map(|genome| genome.like).collect()
    }
}

/// What all trees are to be that do not come with a will of their own.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Wishes {
    /// What random choice may do.
    pub choice: ChoiceSettings,
    /// The picture whose colours they take, as whoever keeps such pictures counts them.
    pub like: Option<usize>,
    /// The season that they are put into.
    pub season: Option<SeasonChoice>,
}

/// The exemplars of a library that trees are drawn from.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Pool {
    /// Their indices in the library; a target stands last.
    pub members: Vec<usize>,
    /// Whether there is a target.
    pub has_target: bool,
}

impl Pool {
    /// Decides on `tree` of `library`; the parts' indices are those of the library. Variations of a
    /// target are individuals of its kind.
    ///
    /// # Errors
    /// [`ChoiceError`] when the combined cage has no area or no two members match.
    ///
    /// # Panics
    /// When a tree is drawn and there are no members.
    pub fn decided(
        &self,
        library: &Library<'_>,
        tree: &GalleryTree,
        wishes: &Wishes,
    ) -> Result<Decided, ChoiceError> {
        let entries = library.entries();
        let shapes: Vec<&Shape> = entries.iter().map(|entry| entry.shape.as_ref()).collect();
        let mut decided = match tree {
            GalleryTree::Kept(genome) => Decided {
                chosen: Chosen::of(genome.parts.clone(), &shapes)?,
                genome: Genome::clone(genome),
            },
            GalleryTree::Near(genome, seed) => near(genome, Seed(*seed), &shapes, wishes)?,
            GalleryTree::Bred(brood, seed) => brood.child(&shapes, &self.members, Seed(*seed))?,
            GalleryTree::Drawn(seed) => self.drawn(Seed(*seed), &shapes, wishes)?,
        };
        let finish = &mut decided.genome.finish;
        *finish = finish.of_tree(&decided.chosen, library);
        Ok(decided)
    }

    fn drawn(
        &self,
        seed: Seed,
        shapes: &[&Shape],
        wishes: &Wishes,
    ) -> Result<Decided, ChoiceError> {
        let members: Vec<&Shape> = self.members.iter().map(|&index| shapes[index]).collect();
        let target = self.has_target.then(|| self.members.len() - 1);
        let mut chosen = chosen(&members, target, &wishes.choice, seed)?;
        for part in &mut chosen.parts {
            part.exemplar = self.members[part.exemplar];
        }
        let strength = wishes.choice.strength;
        let individual = IndividualSettings::drawn(strength, seed);
        // What is mixed has foliage of its own already.
        let (individual, reshaping) = match target {
            Some(_) => (individual, None),
            None => (
                individual.and_then(IndividualSettings::mirror_alone),
                Reshaping::drawn(strength, seed),
            ),
        };
        let genome = Genome {
            parts: chosen.parts.clone(),
            like: wishes.like,
            finish: Finish {
                individual,
                reshaping,
                season: wishes.season,
                ..Finish::default()
            },
            seed,
        };
        Ok(Decided { genome, chosen })
    }
}

/// A sibling of `genome`: shares nearby, foliage of its own.
fn near(
    genome: &Genome,
    seed: Seed,
    shapes: &[&Shape],
    wishes: &Wishes,
) -> Result<Decided, ChoiceError> {
    let parts = parts_near(&genome.parts, seed);
    let chosen = Chosen::of(parts.clone(), shapes)?;
    let genome = Genome {
        parts,
        like: wishes.like.or(genome.like),
        finish: Finish {
            season: wishes.season.or(genome.finish.season),
            ..genome.finish
        },
        seed,
    };
    Ok(Decided { genome, chosen })
}

/// The mix of `exemplars` with normalised shares, those of 0 left out; `index` finds a photograph in
/// the library. `None` when nothing is left or a photograph is not there.
///
/// The colours have the given shares; with none they come from the largest part or, when `coloring`
/// blends, from all with the shares of the outline.
pub fn parts_of_mix(
    exemplars: &[ExemplarWeight],
    color_weights: &[f64],
    coloring: document::Coloring,
    index: impl Fn(PhotoId) -> Option<usize>,
) -> Option<Vec<Part>> {
    let color = |at: usize| color_weights.get(at).copied().unwrap_or(0.0);
    let used = exemplars.iter().enumerate();
    let used = used.filter(|(at, part)| part.weight > 0.0 || color(*at) > 0.0);
    let used: Vec<(usize, &ExemplarWeight)> = used.collect();
    let sum: f64 = used.iter().map(|(_, part)| part.weight).sum();
    let color_sum: f64 = used.iter().map(|(at, _)| color(*at)).sum();
    if sum <= 0.0 {
        return None;
    }
    // Of equals the first: what `max_by` takes is the last.
    let heavier = |a: &&(usize, &ExemplarWeight), b: &&(usize, &ExemplarWeight)| {
        a.1.weight.total_cmp(&b.1.weight)
    };
    let giver = used.iter().rev().max_by(heavier).map(|(at, _)| *at);
    let part = |(at, exemplar): &(usize, &ExemplarWeight)| {
        let contour_weight = exemplar.weight / sum;
        let color_weight = match coloring {
            _ if color_sum > 0.0 => color(*at) / color_sum,
            document::Coloring::Blend => contour_weight,
            document::Coloring::One => f64::from(u8::from(giver == Some(*at))),
        };
        Some(Part {
            exemplar: index(exemplar.photo)?,
            contour_weight,
            color_weight,
        })
    };
    used.iter().map(part).collect()
}

/// What a tree that was kept is decided by; `index` finds a photograph in the library. `None` when one
/// is not there.
pub fn genome_of(
    kept: &Favourite,
    coloring: document::Coloring,
    index: impl Fn(PhotoId) -> Option<usize>,
) -> Option<Genome> {
    Some(Genome {
        parts: parts_of_mix(&kept.exemplars, &kept.color_weights, coloring, &index)?,
        like: kept.like.and_then(index),
        finish: kept.finish,
        seed: Seed(kept.seed),
    })
}

/// What children of a generation come from; `None` when no parent is there any more.
pub fn brood_of(
    generation: &Generation,
    coloring: document::Coloring,
    index: impl Fn(PhotoId) -> Option<usize>,
) -> Option<Brood> {
    let parents = generation.parents.iter();
    let parents: Vec<Genome> = parents
        .filter_map(|kept| genome_of(kept, coloring, &index))
        .collect();
    (!parents.is_empty()).then(|| Brood {
        parents,
        locks: generation.locks.clone(),
    })
}

/// What is kept of the tree of `genome`; `photo` tells the photograph of a library's exemplar.
pub fn favourite_of(name: String, genome: &Genome, photo: impl Fn(usize) -> PhotoId) -> Favourite {
    let exemplar = |part: &Part| ExemplarWeight {
        photo: photo(part.exemplar),
        weight: part.contour_weight,
    };
    Favourite {
        name,
        seed: genome.seed.0,
        exemplars: genome.parts.iter().map(exemplar).collect(),
        color_weights: genome.parts.iter().map(|part| part.color_weight).collect(),
        like: genome.like.map(&photo),
        finish: genome.finish,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_project_starts_with_the_settings_of_the_command_line() {
        let settings = choice_settings(&VariationSettings::default());
        assert_eq!(settings, ChoiceSettings::default());
    }

    #[test]
    fn locked_trees_stay_when_the_gallery_is_drawn_again() {
        let mut settings = VariationSettings {
            count: 4,
            ..VariationSettings::default()
        };
        let seeds = |settings: &VariationSettings| -> Vec<u64> {
            gallery_slots(settings)
                .iter()
                .map(|slot| slot.seed)
                .collect()
        };
        let before = seeds(&settings);
        settings.locked = vec![before[2]];
        // Locking moves nothing.
        assert_eq!(seeds(&settings), before);
        settings.seed = 1;
        let after = seeds(&settings);
        assert_eq!(after.len(), 4);
        assert_eq!(after[0], before[2]);
        assert!(after[1..].iter().all(|seed| !before.contains(seed)));
        // Two locks of the new gallery and one of the old fill it but for one place.
        settings.locked.extend(&after[2..]);
        let slots = gallery_slots(&settings);
        assert_eq!(slots.len(), 4);
        assert_eq!(slots.iter().filter(|slot| slot.is_locked).count(), 3);
        // More locks than places: all are there.
        settings.count = 1;
        assert_eq!(gallery_slots(&settings).len(), 3);
    }

    #[test]
    fn mixes_are_normalised_and_name_a_giver_of_colours() {
        let part = |photo, weight| ExemplarWeight {
            photo: PhotoId(photo),
            weight,
        };
        let mix = [part(4, 1.0), part(7, 0.0), part(9, 3.0)];
        let index = |photo: PhotoId| Some(photo.0 as usize);
        let parts = parts_of_mix(&mix, &[], document::Coloring::One, index).unwrap();
        let shares = |parts: &[Part]| -> Vec<(usize, f64, f64)> {
            let share = |p: &Part| (p.exemplar, p.contour_weight, p.color_weight);
            parts.iter().map(share).collect()
        };
        assert_eq!(shares(&parts), [(4, 0.25, 0.0), (9, 0.75, 1.0)]);
        let parts = parts_of_mix(&mix, &[], document::Coloring::Blend, index).unwrap();
        assert_eq!(shares(&parts), [(4, 0.25, 0.25), (9, 0.75, 0.75)]);
        assert!(parts_of_mix(&mix, &[], document::Coloring::One, |_| None).is_none());
        assert!(parts_of_mix(&mix[1..2], &[], document::Coloring::One, index).is_none());
        // A favourite gives the same mix again.
        let genome = Genome {
            parts,
            like: Some(3),
            finish: Finish {
                individual: IndividualSettings::drawn(0.4, Seed(1)),
                ..Finish::default()
            },
            seed: Seed(1),
        };
        let kept = favourite_of("a".into(), &genome, |index| PhotoId(index as u32));
        let again = genome_of(&kept, document::Coloring::One, index);
        assert_eq!(again, Some(genome));
    }
}
