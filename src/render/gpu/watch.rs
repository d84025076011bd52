//! Shaders that are changed while the program runs, for those who write them.

use crate::base::changed_at;
use crate::render::Pass;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// A folder of shaders, and when each of its files was last seen to change.
#[derive(Debug)]
pub(super) struct Watch {
    folder: PathBuf,
    seen: Vec<Option<SystemTime>>,
}

impl Watch {
    /// Watches `folder` from now on.
    pub(super) fn new(folder: &Path) -> Self {
        Self {
            folder: folder.to_owned(),
            seen: times(folder),
        }
    }

    pub(super) fn folder(&self) -> &Path {
        &self.folder
    }

    /// Whether a file has changed since the last time this was asked.
    pub(super) fn has_changed(&mut self) -> bool {
        let now = times(&self.folder);
        let changed = now != self.seen;
        self.seen = now;
        changed
    }
}

fn times(folder: &Path) -> Vec<Option<SystemTime>> {
    let files = Pass::files();
    files
        .iter()
        .map(|name| changed_at(&folder.join(name)))
        .collect()
}
