//! From a decision to a finished tree: what `vary`, `morph` and the studio all call.

use super::rim::{clear_torn, largest_hanging};
use super::{
    Chosen, Distortion, Exemplar, Histogram, Layout, Library, LibraryError, Palette, Part, Shape,
    Source, WarpPrecision, synthesized,
};
use crate::base::{Cancel, Cancelled};
use crate::contour::outlines;
use crate::geometry::Point;
use crate::raster::{Image, Straight};
use crate::segment::Labels;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// A finished tree.
#[derive(Debug, Clone, PartialEq)]
pub struct Tree {
    /// The picture, [`super::ExemplarSettings::size`] pixels square.
    pub image: Image<Straight>,
    /// Its crown and trunk.
    pub labels: Labels,
}

/// Makes trees of one library; may be used by several threads at once.
pub struct TreeMaker<'a> {
    library: &'a Library<'a>,
    /// The palette of each exemplar, once it was needed.
    palettes: Vec<OnceLock<Palette>>,
    /// The same of how large a piece of it hangs in the air, pixels.
    hanging: Vec<OnceLock<usize>>,
    like: Option<Palette>,
}

impl<'a> TreeMaker<'a> {
    /// A maker of trees; with `like` all of them get that palette.
    pub fn new(library: &'a Library<'a>, like: Option<Palette>) -> Self {
        let count = library.entries().len();
        Self {
            library,
            palettes: (0..count).map(|_| OnceLock::new()).collect(),
            hanging: (0..count).map(|_| OnceLock::new()).collect(),
            like,
        }
    }

    /// The exemplars that trees are made of.
    pub fn library(&self) -> &'a Library<'a> {
        self.library
    }

    /// Makes the tree `chosen`. Where colours of several exemplars are mixed, their contrast is
    /// given back by matching the blend of their palettes.
    ///
    /// # Errors
    /// [`LibraryError`] when an exemplar's pixels cannot be had or `cancel` was raised.
    pub fn make(&self, chosen: &Chosen, cancel: &Cancel) -> Result<Tree, LibraryError> {
        let exemplars: Vec<Arc<Exemplar>> = chosen
            .parts
            .iter()
            .map(|part| self.library.exemplar(part.exemplar, cancel))
            .collect::<Result<_, _>>()?;
        let sources: Vec<Source<'_>> = exemplars
            .iter()
            .zip(&chosen.parts)
            .map(|(exemplar, part)| Source {
                exemplar,
                contour_weight: part.contour_weight,
                color_weight: part.color_weight,
            })
            .collect();
        let palette = |index: usize| {
            let part = chosen.parts[index].exemplar;
            self.palettes[part].get_or_init(|| Palette::of_exemplar(&exemplars[index]))
        };
        let hanging = |index: usize| {
            let part = chosen.parts[index].exemplar;
            *self.hanging[part].get_or_init(|| hanging(&exemplars[index]))
        };
        let like = self.like.as_ref();
        let (tree, _) = finished(&chosen.layout, &sources, like, (palette, hanging), cancel)?;
        Ok(tree)
    }
}

/// How large a piece of `exemplar` hangs in the air, pixels.
fn hanging(exemplar: &Exemplar) -> usize {
    largest_hanging(&exemplar.image, |pixel| pixel.0[3])
}

/// The tree of `layout` from its `sources`, and its picture before colours were matched where they
/// were. `palette` and `hanging` give those of a source.
fn finished<'p>(
    layout: &Layout,
    sources: &[Source<'_>],
    like: Option<&Palette>,
    (palette, hanging): (impl Fn(usize) -> &'p Palette, impl Fn(usize) -> usize),
    cancel: &Cancel,
) -> Result<(Tree, Option<Image<Straight>>), Cancelled> {
    let variation = synthesized(layout, sources, WarpPrecision::Interpolated, cancel)?;
    let mut image = variation.image.straight();
    let gives = |source: &&Source<'_>| source.color_weight > 0.0;
    let mut before = None;
    if let Some(like) = like {
        before = Some(image.clone());
        Palette::apply(&mut image, &variation.labels, &[(like, 1.0)]);
    } else if sources.iter().filter(gives).count() > 1 {
        let weights = sources.iter().map(|source| source.color_weight);
        let references: Vec<(&Palette, f64)> =
            weights.enumerate().map(|(i, w)| (palette(i), w)).collect();
        Palette::apply(&mut image, &variation.labels, &references);
    }
    let labels = variation.labels;
    let mut tree = Tree { image, labels };
    let givers = (0..sources.len()).filter(|&index| gives(&&sources[index]));
    clear_torn(&mut tree, givers.map(hanging).max().unwrap_or(0));
    Ok((tree, before))
}

/// A small tree that is made while a hand moves.
#[derive(Debug, Clone)]
pub struct Draft {
    /// The picture, [`Drafts::SIZE`] pixels square.
    pub image: Image<Straight>,
    /// Its crown and trunk.
    pub labels: Labels,
    /// The outline of what the picture shows, in pixels of it: that of its largest part.
    pub outline: Vec<Point>,
    /// How far its sources are distorted.
    pub distortion: Distortion,
    /// Colours before and after the histogram of another picture was taken, if one was.
    pub histograms: Option<(Histogram, Histogram)>,
}

/// Exemplars and palettes of a library at the size of drafts, made as they are needed; may be used by
/// several threads at once.
#[derive(Default)]
pub struct Drafts {
    small: Mutex<BTreeMap<usize, Arc<SmallExemplar>>>,
}

struct SmallExemplar {
    exemplar: Exemplar,
    palette: Palette,
    hanging: usize,
}

impl Drafts {
    /// Side of a draft, pixels.
    pub const SIZE: u32 = 512;

    /// The draft of the tree that `parts` of `library` make, with the colours of `like` if given.
    ///
    /// # Errors
    /// [`LibraryError`] as [`TreeMaker::make`]; `Ok(None)` when the combined outline has no area.
    pub fn make(
        &self,
        library: &Library<'_>,
        parts: &[Part],
        like: Option<&Palette>,
        cancel: &Cancel,
    ) -> Result<Option<Draft>, LibraryError> {
        let small: Vec<Arc<SmallExemplar>> = parts
            .iter()
            .map(|part| self.small(library, part.exemplar, cancel))
            .collect::<Result<_, _>>()?;
        let of_parts: Vec<(&Shape, f64, f64)> = small
            .iter()
            .zip(parts)
            .map(|(s, p)| (&s.exemplar.shape, p.contour_weight, p.color_weight))
            .collect();
        let Ok(layout) = Layout::new(&of_parts) else {
            return Ok(None);
        };
        let sources: Vec<Source<'_>> = small
            .iter()
            .zip(parts)
            .map(|(small, part)| Source {
                exemplar: &small.exemplar,
                contour_weight: part.contour_weight,
                color_weight: part.color_weight,
            })
            .collect();
        let palette = |index: usize| &small[index].palette;
        let hanging = |index: usize| small[index].hanging;
        let (tree, before) = finished(&layout, &sources, like, (palette, hanging), cancel)?;
        let seen = tree.image.map(|pixel| pixel.alpha() >= 128);
        Ok(Some(Draft {
            histograms: before.map(|before| (Histogram::of(&before), Histogram::of(&tree.image))),
            outline: outlines(&seen).longest_exterior().unwrap_or_default(),
            image: tree.image,
            labels: tree.labels,
            distortion: layout.distortion,
        }))
    }

    fn small(
        &self,
        library: &Library<'_>,
        index: usize,
        cancel: &Cancel,
    ) -> Result<Arc<SmallExemplar>, LibraryError> {
        let known = || self.small.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(small) = known().get(&index) {
            return Ok(Arc::clone(small));
        }
        let exemplar = library.exemplar(index, cancel)?.resized(Self::SIZE);
        let small = Arc::new(SmallExemplar {
            palette: Palette::of_exemplar(&exemplar),
            hanging: hanging(&exemplar),
            exemplar,
        });
        known().insert(index, Arc::clone(&small));
        Ok(small)
    }
}

/// The first individual of a species with its true labels, 256 pixels a side, for tests.
#[cfg(test)]
pub(super) fn grown(species: &str) -> Tree {
    use crate::branches::{Individual, species::species_named};
    use crate::segment::labels_from_grey;

    let species = species_named(species).unwrap_or_else(|| unreachable!("{species} is known"));
    let individual = Individual::new(species, 1);
    let picture = individual
        .grow(&Cancel::new())
        .and_then(|tree| tree.picture((256, 256), false, &Cancel::new()))
        .unwrap_or_else(|_| unreachable!("nobody cancels"));
    Tree {
        labels: labels_from_grey(&picture.labels),
        image: picture.image,
    }
}
