//! A project's variations: its settings as those of `variation`, and the trees of its gallery.
//!
//! Tree *i* of a gallery has the seed that `boscage vary` gives tree *i* of a batch with the gallery's
//! seed, so that what is seen is what a batch makes. Locked seeds of an earlier gallery stand first;
//! those of this one stay where they are.

use crate::base::Seed;
use crate::document::{self, ExemplarWeight, Favourite, PhotoId, VariationSettings};
use crate::variation::{
    ChoiceError, ChoiceSettings, Chosen, Coloring, Library, Part, Shape, chosen, parts_near,
};

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
        ..ChoiceSettings::default()
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
    /// Drawn with this seed near a mix of exemplars.
    Near(Vec<Part>, u64),
    /// This mix itself.
    Kept(Vec<Part>),
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
    /// Decides on `tree` of `library`; the parts' indices are those of the library.
    ///
    /// # Errors
    /// [`ChoiceError`] when the combined cage has no area or no two members match.
    ///
    /// # Panics
    /// When a tree is drawn and there are no members.
    pub fn chosen(
        &self,
        library: &Library<'_>,
        tree: &GalleryTree,
        settings: &ChoiceSettings,
    ) -> Result<Chosen, ChoiceError> {
        let entries = library.entries();
        let all = || -> Vec<&Shape> { entries.iter().map(|entry| entry.shape.as_ref()).collect() };
        match tree {
            GalleryTree::Kept(parts) => Ok(Chosen::of(parts.clone(), &all())?),
            GalleryTree::Near(parts, seed) => {
                Ok(Chosen::of(parts_near(parts, Seed(*seed)), &all())?)
            }
            GalleryTree::Drawn(seed) => {
                let shape = |index: &usize| entries[*index].shape.as_ref();
                let shapes: Vec<&Shape> = self.members.iter().map(shape).collect();
                let target = self.has_target.then(|| self.members.len() - 1);
                let mut chosen = chosen(&shapes, target, settings, Seed(*seed))?;
                for part in &mut chosen.parts {
                    part.exemplar = self.members[part.exemplar];
                }
                Ok(chosen)
            }
        }
    }
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

/// What is kept of a tree made of `parts`; `photo` tells the photograph of a library's exemplar.
pub fn favourite_of(
    name: String,
    seed: u64,
    parts: &[Part],
    like: Option<PhotoId>,
    photo: impl Fn(usize) -> PhotoId,
) -> Favourite {
    let exemplar = |part: &Part| ExemplarWeight {
        photo: photo(part.exemplar),
        weight: part.contour_weight,
    };
    Favourite {
        name,
        seed,
        exemplars: parts.iter().map(exemplar).collect(),
        color_weights: parts.iter().map(|part| part.color_weight).collect(),
        like,
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
        let kept = favourite_of("a".into(), 1, &parts, None, |index| PhotoId(index as u32));
        let again = parts_of_mix(
            &kept.exemplars,
            &kept.color_weights,
            document::Coloring::One,
            index,
        );
        assert_eq!(again.unwrap(), parts);
    }
}
