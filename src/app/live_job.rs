//! The jobs that make the crown that is shown: shape, foliage, and what a renderer needs of them.

use super::live::{LiveOutcome, ShownCrown, leaves};
use super::outcome::Outcome;
use crate::branches::leaf_name::LeafName;
use crate::document::PhotoId;
use crate::jobs::{Context, JobError};
use crate::pipeline::{CrownError, CrownRequest, LiveCrown, LiveInput, LiveResult, Quality};
use crate::render::{PreparedCrown, PreparedMesh};
use crate::scene::Trunk;
use std::sync::{Arc, Mutex, PoisonError};

/// A job's share of the work.
pub(super) struct Making {
    pub(super) photo: PhotoId,
    pub(super) input: LiveInput,
    pub(super) request: CrownRequest,
    pub(super) leaf: LeafName,
    pub(super) serial: u64,
    pub(super) cache: Arc<Mutex<LiveCrown>>,
    /// What is shown now.
    pub(super) last: Option<Arc<ShownCrown>>,
    pub(super) cells: Option<u32>,
}

impl Making {
    /// With what the picture shows of stem and leaves.
    pub(super) fn pictured(mut self) -> Self {
        let LiveInput { photo, labels } = &self.input;
        self.request = self.request.pictured(photo, labels, self.leaf);
        self
    }

    /// A coarse crown first; then, where no mask was painted, the crown at its own size. The second is
    /// given up when a later edit comes.
    pub(super) fn quick(&self, context: &Context<Outcome>) -> Result<Outcome, JobError> {
        let known = self.cached();
        if !known.is_inflated(&self.input) {
            return self.outcome(Quality::Coarse, context);
        }
        if !known.is_shaped(&self.input, &self.request) {
            context.publish(self.outcome(Quality::Coarse, context)?);
        }
        self.outcome(Quality::Fine, context)
    }

    pub(super) fn full(&self, context: &Context<Outcome>) -> Result<Outcome, JobError> {
        if !self.cached().is_inflated(&self.input) {
            context.publish(self.outcome(Quality::Fine, context)?);
        }
        self.outcome(Quality::Full, context)
    }

    /// A copy of what is known so far.
    fn cached(&self) -> LiveCrown {
        let cache = self.cache.lock();
        cache.unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn outcome(&self, quality: Quality, context: &Context<Outcome>) -> Result<Outcome, JobError> {
        let mut live = self.cached();
        let cancel = context.cancel();
        let made = live.update(
            &self.input,
            &self.request,
            quality,
            context.progress(),
            cancel,
        );
        let cache = self.cache.lock();
        cache.unwrap_or_else(PoisonError::into_inner).adopt(live);
        let outcome = match made {
            Ok(made) => LiveOutcome::Crown(Box::new(self.prepared(made, quality, context)?)),
            Err(error) if error.is_cancelled() => return Err(crate::base::Cancelled.into()),
            Err(error) => LiveOutcome::Failed(self.serial, told(&error)),
        };
        Ok(Outcome::Live(outcome))
    }

    /// What a renderer needs; as much as can be of what is shown now.
    fn prepared(
        &self,
        LiveResult {
            crown,
            color_version,
            silhouette,
            k,
            sub_crowns,
        }: LiveResult,
        quality: Quality,
        context: &Context<Outcome>,
    ) -> Result<ShownCrown, JobError> {
        let last = self.last.as_ref().filter(|last| {
            let same = last.color_version == color_version;
            same && quality != Quality::Full
        });
        let trunk = Trunk::under(&crown);
        let surface = self
            .cells
            .map(|cells| (cells, PreparedMesh::of_crown(&crown, cells)));
        let (prepared, mesh, bounds) = match last {
            Some(last) => (
                last.prepared.reshaped(&crown),
                last.trunk.clone(),
                last.bounds,
            ),
            None => (
                PreparedCrown::new(&crown, context.cancel())?.on_stem(&trunk),
                PreparedMesh::of_trunk(&trunk, &crown),
                crown.tree_bounds(),
            ),
        };
        // Made here where nobody waits for a frame.
        leaves(self.leaf);
        Ok(ShownCrown {
            photo: self.photo,
            source: Arc::clone(&self.input.photo),
            serial: self.serial,
            quality,
            crown,
            prepared,
            trunk: mesh,
            surface,
            bounds,
            silhouette,
            k,
            sub_crowns,
            leaf: self.leaf,
            color_version,
        })
    }
}

/// Why there is no crown, in the words of the panel.
fn told(error: &CrownError) -> String {
    error.to_string()
}
