//! The text of the shaders: one file a pass in `shaders/`, and what passes share in
//! `shaders/shared/`, put before it.

use crate::base::{FileError, read_limited};
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::path::Path;

/// A pass of the renderer for graphics cards.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pass {
    /// What is behind everything.
    Backdrop,
    /// Shadows of crowns on the ground.
    Ground,
    /// Triangles.
    Mesh,
    /// Leaf crowns.
    Leaves,
    /// Relief crowns.
    Relief,
    /// From light to a picture.
    Tone,
}

/// Largest shader file that is read.
const LARGEST_BYTES: u64 = 1 << 20;

macro_rules! built_in {
    ($($name:literal),*) => {
        &[$(($name, include_str!(concat!("../../shaders/", $name)))),*]
    };
}

impl Pass {
    /// All passes.
    pub const ALL: [Self; 6] = [
        Self::Backdrop,
        Self::Ground,
        Self::Mesh,
        Self::Relief,
        Self::Leaves,
        Self::Tone,
    ];

    /// The files that make up the pass, in order, and what stands in them.
    fn parts(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::Backdrop => {
                built_in!("shared/frame.wgsl", "shared/screen.wgsl", "backdrop.wgsl")
            }
            Self::Ground => {
                built_in!("shared/frame.wgsl", "shared/crown.wgsl", "ground.wgsl")
            }
            Self::Mesh => built_in!("shared/frame.wgsl", "shared/shade.wgsl", "mesh.wgsl"),
            Self::Leaves => built_in!(
                "shared/frame.wgsl",
                "shared/crown.wgsl",
                "shared/shade.wgsl",
                "leaves.wgsl"
            ),
            Self::Relief => built_in!(
                "shared/frame.wgsl",
                "shared/crown.wgsl",
                "shared/shade.wgsl",
                "relief.wgsl"
            ),
            Self::Tone => built_in!("shared/frame.wgsl", "shared/screen.wgsl", "tone.wgsl"),
        }
    }

    /// The files of all passes, below the folder of shaders.
    pub fn files() -> BTreeSet<&'static str> {
        let parts = Self::ALL.iter().flat_map(|pass| pass.parts());
        parts.map(|(name, _)| *name).collect()
    }

    /// The name of the pass, for messages.
    pub fn name(self) -> &'static str {
        let (file, _) = self.parts()[self.parts().len() - 1];
        file.trim_end_matches(".wgsl")
    }

    /// The shader as it was when the program was built.
    pub fn built_in(self) -> Cow<'static, str> {
        Cow::Owned(self.parts().iter().map(|(_, text)| *text).collect())
    }

    /// The shader as it stands in `folder` now, to be changed while the program runs.
    ///
    /// # Errors
    /// [`FileError`] when a file cannot be read.
    pub fn from_folder(self, folder: &Path) -> Result<Cow<'static, str>, FileError> {
        let mut text = String::new();
        for (name, _) in self.parts() {
            let bytes = read_limited(&folder.join(name), LARGEST_BYTES)?;
            text.push_str(&String::from_utf8_lossy(&bytes));
        }
        Ok(Cow::Owned(text))
    }
}
