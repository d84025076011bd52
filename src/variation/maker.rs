//! From a decision to a finished tree: what `vary`, `morph` and the studio all call.

use super::{Chosen, Exemplar, Library, LibraryError, Palette, Source, WarpPrecision, synthesized};
use crate::base::Cancel;
use crate::raster::{Image, Straight};
use crate::segment::Labels;
use std::sync::{Arc, OnceLock};

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
    like: Option<Palette>,
}

impl<'a> TreeMaker<'a> {
    /// A maker of trees; with `like` all of them get that palette.
    pub fn new(library: &'a Library<'a>, like: Option<Palette>) -> Self {
        let palettes = library.entries().iter().map(|_| OnceLock::new()).collect();
        Self {
            library,
            palettes,
            like,
        }
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
        let precision = WarpPrecision::Interpolated;
        let variation = synthesized(&chosen.layout, &sources, precision, cancel)?;
        let mut image = variation.image.straight();
        let giving = sources
            .iter()
            .filter(|source| source.color_weight > 0.0)
            .count();
        if let Some(like) = &self.like {
            Palette::apply(&mut image, &variation.labels, &[(like, 1.0)]);
        } else if giving > 1 {
            let references: Vec<(&Palette, f64)> = exemplars
                .iter()
                .zip(&chosen.parts)
                .map(|(exemplar, part)| {
                    let palette =
                        self.palettes[part.exemplar].get_or_init(|| Palette::of_exemplar(exemplar));
                    (palette, part.color_weight)
                })
                .collect();
            Palette::apply(&mut image, &variation.labels, &references);
        }
        Ok(Tree {
            image,
            labels: variation.labels,
        })
    }
}
