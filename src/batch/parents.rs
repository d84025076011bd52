//! Trees that others are bred from: their records, and what children come from.

use super::failure::Failure;
use super::records::{OUT_OF_RANGE, TreeRecord};
use crate::base::Seed;
use crate::pipeline::GalleryTree;
use crate::variation::{Aspect, Brood, Genome, Library, Part, Shape};
use std::collections::BTreeSet;
use std::sync::Arc;

/// A tree that others are bred from.
#[derive(Debug, Clone)]
pub(crate) struct Parent {
    /// As it was named: `FILE.json#NAME`.
    pub(crate) name: String,
    pub(crate) record: TreeRecord,
    /// Which of the job's pictures gives its colours.
    pub(crate) like: Option<usize>,
}

/// What is bred from.
#[derive(Debug, Clone)]
pub(crate) struct Parents {
    /// At least one.
    pub(crate) all: Vec<Parent>,
    pub(crate) locks: BTreeSet<Aspect>,
    /// Which generation after the parents is made: 1 their children.
    pub(crate) generation: u32,
}

impl Parents {
    /// Their names.
    pub(super) fn names(&self) -> Vec<String> {
        self.all.iter().map(|parent| parent.name.clone()).collect()
    }

    /// One child for each of `seeds`, of exemplars of `library`, of which `members` may join.
    ///
    /// # Errors
    /// [`Failure::BadInput`] when an exemplar of a parent is not there, or nobody can be bred.
    pub(super) fn children(
        &self,
        library: &Library<'_>,
        members: &[usize],
        seeds: &[Seed],
    ) -> Result<Vec<GalleryTree>, Failure> {
        let genomes = self.all.iter().map(|parent| parent.genome(library));
        let brood = Brood {
            parents: genomes.collect::<Result<_, Failure>>()?,
            locks: self.locks.clone(),
        };
        let entries = library.entries();
        let shapes: Vec<&Shape> = entries.iter().map(|entry| entry.shape.as_ref()).collect();
        let brood = brood.after(self.generation.saturating_sub(1), &shapes, members, seeds);
        let brood = Arc::new(brood.map_err(|error| Failure::of("--parents", error))?);
        let child = |seed: &Seed| GalleryTree::Bred(Arc::clone(&brood), seed.0);
        Ok(seeds.iter().map(child).collect())
    }
}

impl Parent {
    /// What it is decided by, with the exemplars of `library`.
    fn genome(&self, library: &Library<'_>) -> Result<Genome, Failure> {
        let record = &self.record;
        if !record.weights_are_convex() {
            return Err(Failure::of(&self.name, "the weights are not convex"));
        }
        if !record.finish().is_sound() {
            return Err(Failure::of(&self.name, OUT_OF_RANGE));
        }
        let part = |at: usize| {
            let wanted = &record.exemplars[at];
            let mut entries = library.entries().iter();
            let same = entries.position(|entry| {
                entry.digest.to_string() == wanted.digest && entry.pins == wanted.pins
            });
            let exemplar = same.ok_or_else(|| {
                let reason = format!("{} is not the file that it was made of", wanted.file);
                Failure::of(&self.name, reason)
            })?;
            Ok(Part {
                exemplar,
                contour_weight: record.contour_weights[at],
                color_weight: record.color_weights[at],
            })
        };
        let parts = (0..record.exemplars.len()).map(part);
        Ok(Genome {
            parts: parts.collect::<Result<_, Failure>>()?,
            like: self.like,
            finish: record.finish(),
            seed: Seed(record.seed),
        })
    }
}
