//! Doing what the variations' panels ask.

use super::action::Gesture;
use super::batch_jobs::BatchSettings;
use super::commands::Command;
use super::studio::{Effect, Severity, Studio, Workspace};
use super::vary::{Cell, Tile};
use crate::base::Digest;
use crate::document::{Edit, ExemplarWeight, Favourite, Generation, PhotoId, VariationSettings};
use crate::pipeline::{GalleryTree, favourite_of};
use crate::raster::{Image, Straight};
use crate::variation::Aspect;
use std::collections::BTreeSet;
use std::path::PathBuf;

/// Most favourites' numbers that are tried for a name.
const MOST_NAMES: usize = 100_000;

/// What the variations' panels ask for; trees of the gallery are named by their keys.
#[derive(Debug, Clone, PartialEq)]
pub enum VaryAction {
    /// Takes a picture into the exemplars, or out.
    Toggle(PhotoId),
    /// Gives the exemplars their shares in the mix; those not named keep theirs.
    Weigh(Vec<ExemplarWeight>, Gesture),
    /// Locks the tree with this seed, or lets it go.
    Lock(u64),
    /// Makes a tree a favourite, or no longer.
    Keep(Digest),
    /// Gives a favourite another name.
    Rename(usize, String),
    /// Shows siblings of a tree; `None` shows all again.
    MoreLike(Option<Digest>),
    /// Takes a tree's shares into the mix.
    TakeMix(Digest),
    /// Fills the gallery with children of these trees, which have the locked aspects from one of them.
    Breed(Vec<Digest>, BTreeSet<Aspect>),
    /// Shows again what the parents of the gallery's trees were chosen from.
    BackToParents,
    /// Finds how much these trees repeat each other.
    Score(Vec<Digest>),
    /// Shows a tree large; `None` closes it.
    Enlarge(Option<Digest>),
    /// Goes on with exemplars or a gallery that were cancelled.
    GoOn,
    /// Asks for a folder to write to.
    AskForFolder,
    /// This folder was chosen.
    ChoseFolder(PathBuf),
    /// Writes trees to a folder.
    Make(Box<BatchSettings>),
}

impl Studio {
    /// Does what the variations' panels ask.
    pub(super) fn vary(&mut self, action: VaryAction) {
        match action {
            VaryAction::Toggle(photo) => self.toggle_exemplar(photo),
            VaryAction::Weigh(weights, gesture) => self.weigh(&weights, gesture),
            VaryAction::Lock(seed) => self.lock(seed),
            VaryAction::Keep(key) => self.keep(key),
            VaryAction::Rename(index, name) => {
                self.vary_settings("Rename Favourite", Gesture::Whole, |settings| {
                    if let Some(kept) = settings.favourites.get_mut(index) {
                        kept.name = name;
                    }
                });
            }
            VaryAction::MoreLike(key) => self.more_like(key),
            VaryAction::TakeMix(key) => self.take_mix(key),
            VaryAction::Breed(keys, locks) => self.breed(&keys, locks),
            VaryAction::BackToParents => self.back_to_parents(),
            VaryAction::Score(keys) => self.score(keys),
            VaryAction::Enlarge(None) => self.vary.large = None,
            VaryAction::Enlarge(Some(key)) => {
                if let Some(cell) = self.vary.cell(key).cloned() {
                    self.open_large(cell);
                }
            }
            VaryAction::AskForFolder => self.effects.push(Effect::AskForFolder),
            VaryAction::ChoseFolder(folder) => self.vary.folder = Some(folder),
            VaryAction::Make(settings) => self.make_batch(*settings),
            VaryAction::GoOn => {
                self.vary.asked_for = None;
                self.vary.asked_trees = None;
                self.refresh_variations();
            }
        }
    }

    /// The seeds of the gallery's trees, in order.
    pub fn gallery_seeds(&self) -> Vec<u64> {
        self.vary.gallery.iter().map(|cell| cell.seed).collect()
    }

    /// How many trees of the gallery and favourites are still to be made; `None` before exemplars
    /// are prepared.
    pub fn missing_trees(&self) -> Option<usize> {
        self.vary.prepared.as_ref()?;
        Some(self.vary.missing_count())
    }

    /// What is known of how much the selected trees repeat each other: the score, and the two of the
    /// gallery that are most alike.
    pub fn selection_score(&self) -> Option<(f64, Option<[usize; 2]>)> {
        let scored = self.vary.score.as_ref()?;
        let index = |at: usize| {
            let mut all = self.vary.gallery.iter();
            all.position(|cell| cell.key == scored.keys[at])
        };
        let worst = scored.repetition.pairs.first();
        let worst = worst.and_then(|pair| Some([index(pair.first)?, index(pair.second)?]));
        Some((scored.repetition.score, worst))
    }

    /// The picture of the gallery's tree `index` as it is shown, once it was made.
    pub fn gallery_picture(&self, index: usize) -> Option<&Image<Straight>> {
        let tile = self.vary.tile(self.vary.gallery.get(index)?)?;
        Some(&tile.as_ref().ok()?.image)
    }

    /// Draws all trees again that are not locked.
    pub(super) fn roll(&mut self) {
        self.vary_settings("Roll Again", Gesture::Whole, |settings| {
            settings.seed = settings.seed.wrapping_add(1);
        });
    }

    /// Opens the dialog of a command that writes trees.
    pub(super) fn ask_where_to_make(&mut self, command: Command) {
        let of_crowns = command == Command::ExportTrees && self.workspace == Workspace::Crown;
        if !of_crowns {
            // Trees are drawn from exemplars that only this workspace prepares.
            self.go_to(Workspace::Variations);
        }
        self.effects.push(Effect::AskWhatToMake(command));
    }

    fn vary_settings(
        &mut self,
        label: &'static str,
        gesture: Gesture,
        change: impl FnOnce(&mut VariationSettings),
    ) {
        let mut settings = self.document.state().content().variation.clone();
        change(&mut settings);
        let edit = Edit::SetVariation(Box::new(settings));
        self.edit(label, edit, gesture);
    }

    fn toggle_exemplar(&mut self, photo: PhotoId) {
        let mut mix = self.vary.mix(&self.document.state().content().variation);
        let label = match mix.iter().position(|part| part.photo == photo) {
            Some(_) if mix.len() == 1 => {
                let why = "A gallery needs at least one exemplar.";
                self.notify(Severity::Info, why);
                return;
            }
            Some(at) => {
                mix.remove(at);
                "Leave Exemplar Out"
            }
            None => {
                // In the order of the strip.
                let at = mix.partition_point(|part| part.photo < photo);
                let weight = 0.0;
                mix.insert(at, ExemplarWeight { photo, weight });
                "Take Exemplar"
            }
        };
        self.vary_settings(label, Gesture::Whole, |settings| settings.exemplars = mix);
    }

    fn weigh(&mut self, weights: &[ExemplarWeight], gesture: Gesture) {
        let mut mix = self.vary.mix(&self.document.state().content().variation);
        for part in &mut mix {
            let named = weights.iter().find(|named| named.photo == part.photo);
            part.weight = named.map_or(part.weight, |named| named.weight);
        }
        self.vary_settings("Mix", gesture, |settings| settings.exemplars = mix);
    }

    fn lock(&mut self, seed: u64) {
        let is_locked = self
            .document
            .state()
            .content()
            .variation
            .locked
            .contains(&seed);
        let label = if is_locked {
            "Unlock Tree"
        } else {
            "Lock Tree"
        };
        self.vary_settings(label, Gesture::Whole, |settings| {
            if is_locked {
                settings.locked.retain(|locked| *locked != seed);
            } else {
                settings.locked.push(seed);
            }
        });
    }

    /// The tree of `key` with what it is made of, once it was made.
    fn made_tree(&self, key: Digest) -> Option<(&Cell, &Tile)> {
        let cell = self.vary.cell(key)?;
        let tile = self.vary.tile(cell)?.as_ref().ok()?;
        Some((cell, tile))
    }

    /// The tree of `key` as a favourite of the name `name`.
    fn favourite(&self, key: Digest, name: String) -> Option<Favourite> {
        let (cell, tile) = self.made_tree(key)?;
        let photos = &self.vary.prepared.as_ref()?.photos;
        let photo = |index: usize| photos[index];
        // A favourite is what it was kept as, whatever its genome has become.
        match &cell.tree {
            GalleryTree::Kept(genome) => Some(favourite_of(name, genome, photo)),
            _ => Some(favourite_of(name, &tile.genome, photo)),
        }
    }

    fn breed(&mut self, keys: &[Digest], locks: BTreeSet<Aspect>) {
        let parents = keys
            .iter()
            .filter_map(|key| self.favourite(*key, String::new()));
        let parents: Vec<Favourite> = parents.collect();
        if parents.is_empty() {
            self.notify(Severity::Info, "Choose one or several trees to breed from.");
            return;
        }
        self.vary_settings("Breed Next Generation", Gesture::Whole, |settings| {
            settings.lineage.push(Generation {
                parents,
                locks,
                seed: settings.seed,
                locked: std::mem::take(&mut settings.locked),
            });
            settings.around = None;
            settings.seed = settings.seed.wrapping_add(1);
        });
    }

    fn back_to_parents(&mut self) {
        self.vary_settings("Back to Parents", Gesture::Whole, |settings| {
            if let Some(last) = settings.lineage.pop() {
                (settings.seed, settings.locked) = (last.seed, last.locked);
                settings.around = None;
            }
        });
    }

    fn keep(&mut self, key: Digest) {
        let settings = &self.document.state().content().variation;
        let taken = |name: &String| settings.favourites.iter().any(|kept| kept.name == *name);
        let names = (1..MOST_NAMES).map(|number| format!("Tree {number}"));
        let name = names.into_iter().find(|name| !taken(name));
        let Some(kept) = self.favourite(key, name.unwrap_or_default()) else {
            return;
        };
        let at = settings
            .favourites
            .iter()
            .position(|known| known.is_tree_of(&kept));
        let label = at.map_or("Keep Tree", |_| "Drop Favourite");
        self.vary_settings(label, Gesture::Whole, |settings| match at {
            Some(at) => drop(settings.favourites.remove(at)),
            None => settings.favourites.push(kept),
        });
    }

    fn more_like(&mut self, key: Option<Digest>) {
        let around = match key {
            None => None,
            Some(key) => match self.favourite(key, String::new()) {
                Some(around) => Some(around),
                None => return,
            },
        };
        let label = around
            .as_ref()
            .map_or("All Kinds Again", |_| "More Like This");
        self.vary_settings(label, Gesture::Whole, |settings| settings.around = around);
    }

    fn take_mix(&mut self, key: Digest) {
        let Some(kept) = self.favourite(key, String::new()) else {
            return;
        };
        let mut mix = self.vary.mix(&self.document.state().content().variation);
        for part in &mut mix {
            let of = kept.exemplars.iter().find(|own| own.photo == part.photo);
            part.weight = of.map_or(0.0, |own| own.weight);
        }
        let is_there = |own: &ExemplarWeight| mix.iter().any(|part| part.photo == own.photo);
        let others: Vec<_> = kept
            .exemplars
            .iter()
            .filter(|own| !is_there(own))
            .copied()
            .collect();
        mix.extend(others);
        self.vary_settings("Take Mix", Gesture::Whole, |settings| {
            settings.exemplars = mix
        });
    }

    /// The favourite that the tree of `cell` is, if it is one.
    pub(super) fn favourite_index(&self, cell: &Cell) -> Option<usize> {
        let kept = self.favourite(cell.key, String::new())?;
        let favourites = &self.document.state().content().variation.favourites;
        favourites.iter().position(|known| known.is_tree_of(&kept))
    }
}
