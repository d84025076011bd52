//! What a user sets: the crown of each photograph, the variations, and the view.
//!
//! The fields are the parameters of the command line under the same names and with the same defaults.
//! They are plain data that says what is wanted; the pipeline turns them into the settings of `crown`
//! and `variation`, and that is the one place to change when those grow.

use super::content::PhotoId;
use crate::branches::leaf_name::LeafName;
use crate::crown::ReliefSettings;
use crate::variation::{Aspect, Finish, SeasonChoice};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Longest expression of a tangent, characters.
const LONGEST_EXPRESSION: usize = 1000;

/// The tangent k at the silhouette.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Tangent {
    /// Whatever makes the crown as deep as it is wide.
    #[default]
    Automatic,
    /// An expression in i and j, both 0…1 over the crown's bounds from the upper left; `3` is one.
    /// Whether it can be evaluated shows when it is: half-typed ones are saved as they stand.
    Expression(String),
    /// Values along the silhouette: its share from the lowest point, counter-clockwise, 0…1
    /// ascending, and k there.
    Profile(Vec<(f64, f64)>),
}

/// How a photograph becomes a crown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct CrownSettings {
    /// k(i, j).
    pub k: Tangent,
    /// Texels along a face of the crown's cubemaps, and pixels along the longer side of the mask that
    /// is inflated; a multiple of 16 from 32 to 1024.
    pub size: u32,
    /// ρ, how far the relief moves the surface, as a share of the radius, 0…1.5.
    pub rho: f64,
    /// How light becomes relief.
    pub relief: ReliefSettings,
    /// Rotated copies that are merged.
    pub copies: u32,
    /// Whether the front shows the photograph itself.
    pub photo_front: bool,
    /// How far sub-crowns are pushed towards the viewer, by label, in shares of the crown's width.
    pub sub_crown_depths: BTreeMap<u8, f64>,
    /// Seed of the synthesised foliage.
    pub seed: u64,
    /// The leaves it is drawn and exported with; none: those that the photograph's name tells.
    pub leaf: Option<LeafName>,
}

impl Default for CrownSettings {
    fn default() -> Self {
        Self {
            k: Tangent::default(),
            size: 256,
            rho: 0.25,
            relief: ReliefSettings::default(),
            copies: 1,
            photo_front: false,
            sub_crown_depths: BTreeMap::new(),
            seed: 0,
            leaf: None,
        }
    }
}

impl CrownSettings {
    /// What is wrong with the values, if anything.
    pub(super) fn complaint(&self) -> Option<&'static str> {
        let is_share = |value: &f64| (0.0..=1.0).contains(value);
        let k_is_good = match &self.k {
            Tangent::Automatic => true,
            Tangent::Expression(text) => text.chars().count() <= LONGEST_EXPRESSION,
            Tangent::Profile(points) => {
                let ascending = points.windows(2).all(|pair| pair[0].0 < pair[1].0);
                let finite = points.iter().all(|(at, k)| is_share(at) && k.is_finite());
                !points.is_empty() && points.len() <= 10_000 && ascending && finite
            }
        };
        let rules = [
            (k_is_good, "k is too long or its profile is not ascending"),
            (
                (32..=1024).contains(&self.size) && self.size.is_multiple_of(16),
                "size is not a multiple of 16 in 32…1024",
            ),
            ((0.0..=1.5).contains(&self.rho), "rho is not in 0…1.5"),
            (self.relief.check().is_ok(), "the relief is out of range"),
            ((1..=16).contains(&self.copies), "copies are not in 1…16"),
            (
                self.sub_crown_depths
                    .values()
                    .all(|depth| depth.is_finite()),
                "a sub-crown's depth is no number",
            ),
        ];
        broken(&rules)
    }
}

/// Where the colours of a variation come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Coloring {
    /// All from one exemplar.
    #[default]
    One,
    /// Averaged over the exemplars.
    Blend,
}

/// An exemplar's part.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ExemplarWeight {
    /// The photograph.
    pub photo: PhotoId,
    /// Its share in what is previewed, ≥ 0; shares are normalised where they are used.
    pub weight: f64,
}

/// A variation that the user kept.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Favourite {
    /// What the user calls it.
    pub name: String,
    /// The seed that makes it again.
    pub seed: u64,
    /// The exemplars it was made of, with their shares of the outline.
    pub exemplars: Vec<ExemplarWeight>,
    /// Their shares of the colours, in the same order; empty: those of the outline.
    #[serde(default)]
    pub color_weights: Vec<f64>,
    /// The picture whose histogram it took.
    #[serde(default)]
    pub like: Option<PhotoId>,
    /// What became of it once it was mixed.
    #[serde(default)]
    pub finish: Finish,
}

/// Trees that others are bred from.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Generation {
    /// The parents; their names do not count.
    pub parents: Vec<Favourite>,
    /// What children have from one parent as it is there.
    pub locks: BTreeSet<Aspect>,
    /// The seed of the gallery that the parents were chosen from.
    pub seed: u64,
    /// The seeds that were locked in it.
    pub locked: Vec<u64>,
}

impl Favourite {
    /// Whether both are one tree, whatever they are called.
    pub fn is_tree_of(&self, other: &Self) -> bool {
        let name = self.name.clone();
        *self
            == Self {
                name,
                ..other.clone()
            }
    }

    /// The photographs that it names.
    fn photos(&self) -> impl Iterator<Item = PhotoId> + '_ {
        self.exemplars
            .iter()
            .map(|part| part.photo)
            .chain(self.like)
    }

    /// Whether its shares can be mixed: finite, not negative, not all 0, one of each for each part.
    fn is_sound(&self) -> bool {
        let sum = |weights: &[f64]| {
            let sound = weights.iter().all(|w| w.is_finite() && *w >= 0.0);
            if sound { weights.iter().sum() } else { 0.0 }
        };
        let contour: Vec<f64> = self.exemplars.iter().map(|part| part.weight).collect();
        let has_colors = self.color_weights.is_empty()
            || (self.color_weights.len() == self.exemplars.len() && sum(&self.color_weights) > 0.0);
        sum(&contour) > 0.0 && has_colors && self.finish.is_sound()
    }
}

/// How variations are made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct VariationSettings {
    /// The exemplars, in the order of the strip.
    pub exemplars: Vec<ExemplarWeight>,
    /// The tree that others are made like.
    pub target: Option<PhotoId>,
    /// How far from the target, or from what is mixed, 0…1.
    pub strength: f64,
    /// Exemplars in a tree.
    pub mix: u32,
    /// Range of the first weight, 0 ≤ low ≤ high ≤ 1.
    pub weights: (f64, f64),
    /// Where colours come from.
    pub coloring: Coloring,
    /// The picture whose histogram is taken.
    pub like: Option<PhotoId>,
    /// The tree that the gallery's trees are siblings of, if they are.
    pub around: Option<Favourite>,
    /// Seed of the gallery.
    pub seed: u64,
    /// Trees in the gallery.
    pub count: u32,
    /// Seeds that stay when the gallery is drawn again.
    pub locked: Vec<u64>,
    /// What was kept.
    pub favourites: Vec<Favourite>,
    /// Whether random choice walks from tree to matching tree, or mixes any.
    pub walks: bool,
    /// The season that new trees are put into.
    pub season: Option<SeasonChoice>,
    /// The generations that the gallery's trees come from, the oldest first; none: trees are drawn.
    pub lineage: Vec<Generation>,
}

impl Default for VariationSettings {
    fn default() -> Self {
        Self {
            exemplars: Vec::new(),
            target: None,
            strength: 0.7,
            mix: 2,
            weights: (0.3, 0.7),
            coloring: Coloring::default(),
            like: None,
            around: None,
            seed: 0,
            count: 12,
            locked: Vec::new(),
            favourites: Vec::new(),
            walks: true,
            season: None,
            lineage: Vec::new(),
        }
    }
}

impl VariationSettings {
    /// What is wrong with the values, if anything.
    pub(super) fn complaint(&self) -> Option<&'static str> {
        let (low, high) = self.weights;
        let weights = self.exemplars.iter().map(|part| part.weight);
        let rules = [
            (
                (0.0..=1.0).contains(&self.strength),
                "strength is not in 0…1",
            ),
            (
                0.0 <= low && low <= high && high <= 1.0,
                "weights are not 0 ≤ low ≤ high ≤ 1",
            ),
            ((1..=16).contains(&self.mix), "mix is not in 1…16"),
            (self.count <= 100_000, "count is above 100,000"),
            (
                weights.into_iter().all(|w| w.is_finite() && w >= 0.0),
                "an exemplar's weight is negative or no number",
            ),
            (
                self.kept().all(Favourite::is_sound),
                "a favourite's weights are none",
            ),
            (
                self.season.is_none_or(|season| season.is_sound()),
                "a season's extent is not in 0…1",
            ),
            (
                self.lineage.iter().all(|one| !one.parents.is_empty()),
                "a generation has no parents",
            ),
        ];
        broken(&rules)
    }

    /// All trees that were kept.
    fn kept(&self) -> impl Iterator<Item = &Favourite> {
        let parents = self.lineage.iter().flat_map(|one| &one.parents);
        self.favourites.iter().chain(&self.around).chain(parents)
    }

    /// All photographs that are named.
    pub(super) fn photos(&self) -> impl Iterator<Item = PhotoId> + '_ {
        let parts = self.exemplars.iter().map(|part| part.photo);
        let kept = self.kept().flat_map(Favourite::photos);
        parts.chain(kept).chain(self.target).chain(self.like)
    }

    /// Forgets a photograph that is no longer there.
    pub(super) fn forget(&mut self, photo: PhotoId) {
        let is_other = |part: &ExemplarWeight| part.photo != photo;
        let is_whole = |kept: &Favourite| kept.exemplars.iter().all(is_other);
        self.exemplars.retain(is_other);
        self.favourites.retain(is_whole);
        self.around = self.around.take().filter(is_whole);
        // What comes after a generation without parents has none either.
        for one in &mut self.lineage {
            one.parents.retain(is_whole);
        }
        let whole = self
            .lineage
            .iter()
            .take_while(|one| !one.parents.is_empty());
        self.lineage.truncate(whole.count());
        self.target = self.target.filter(|&target| target != photo);
        self.like = self.like.filter(|&like| like != photo);
        let parents = self.lineage.iter_mut().flat_map(|one| &mut one.parents);
        let kept = self.favourites.iter_mut().chain(&mut self.around);
        for kept in kept.chain(parents) {
            kept.like = kept.like.filter(|&like| like != photo);
        }
    }
}

/// How the project is looked at: saved, but neither undone nor a change.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ViewState {
    /// The photograph on the canvas.
    pub photo: Option<PhotoId>,
    /// Direction to the sun, degrees around and above the horizon.
    pub sun_deg: (f64, f64),
    /// Camera: yaw and pitch, degrees.
    pub camera_deg: (f64, f64),
    /// Camera: its distance as a share of the one at which the whole tree just fits the view.
    pub distance: f64,
    /// Where the canvas looks; all of the photograph when nobody has looked yet.
    pub canvas: Option<CanvasView>,
}

/// Where the canvas looks.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CanvasView {
    /// Its middle in the photograph, pixels from the upper left corner.
    pub center: (f64, f64),
    /// Points of the screen for a pixel of the photograph.
    pub zoom: f64,
}

impl Default for ViewState {
    fn default() -> Self {
        Self {
            photo: None,
            sun_deg: (-42.0, 48.0),
            camera_deg: (0.0, 6.0),
            distance: 1.0,
            canvas: None,
        }
    }
}

/// The message of the first rule that does not hold.
fn broken(rules: &[(bool, &'static str)]) -> Option<&'static str> {
    rules
        .iter()
        .find(|(holds, _)| !holds)
        .map(|(_, message)| *message)
}
