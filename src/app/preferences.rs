//! What the user chose for good: kept between sessions, in no project.

use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Most files that are remembered.
const MOST_RECENT: usize = 10;

/// The user's choices.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Preferences {
    /// Dark or light.
    pub is_dark: bool,
    /// Projects, the one opened last first.
    pub recent: Vec<PathBuf>,
    /// Which buttons move the camera.
    pub navigation: Navigation,
    /// Whether the crown is made anew while the user paints.
    pub live_crown: bool,
    /// Whether the first steps were shown.
    pub tour_was_seen: bool,
    /// The library that runs networks, if not the one built in.
    pub onnx_runtime: Option<PathBuf>,
    /// The model that tells crown from trunk, if not the one built in.
    pub segmentation_model: Option<PathBuf>,
}

/// Whose mouse buttons the 3D view uses. Left drag, wheel and Shift work everywhere.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Navigation {
    /// Left orbits, wheel zooms, Shift pans.
    #[default]
    Trackpad,
    /// Middle orbits, Shift+middle pans, Ctrl+middle zooms.
    Blender,
    /// Alt with left, middle, right.
    Maya,
}

impl Default for Preferences {
    fn default() -> Self {
        Self {
            is_dark: true,
            recent: Vec::new(),
            navigation: Navigation::default(),
            live_crown: true,
            tour_was_seen: false,
            onnx_runtime: None,
            segmentation_model: None,
        }
    }
}

impl Preferences {
    /// Puts `path` in front of the files that are remembered.
    pub(super) fn remember(&mut self, path: &Path) {
        self.forget(path);
        self.recent.insert(0, path.to_owned());
        self.recent.truncate(MOST_RECENT);
    }

    /// Takes a file that is gone off the list.
    pub(super) fn forget(&mut self, path: &Path) {
        self.recent.retain(|known| known != path);
    }
}
