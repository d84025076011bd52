//! The project that a user works on and saves: photographs, painted masks, settings, and the history
//! of their changes.
//!
//! A [`Document`] is changed by [`Edit`]s only, within a transaction for each gesture of the user, so
//! that one gesture is one step to undo. Its state is cheap to copy: masks are shared tile by tile and
//! photographs whole. A step is the difference of two states; undo and redo therefore bring back
//! exactly what was, whatever edits lay between. What is merely looked at ([`ViewState`]) is saved but
//! neither undone nor counted as a change.
//!
//! Photographs are **embedded** as the bytes of their files, each content once: a project that is
//! moved or mailed loses nothing, and the pictures cannot change under it.
//!
//! Files are opened in `store` only; the rest is bytes to bytes.
//!
//! Imports `base`, `raster`, `contour`, `paint`, `variation` (what becomes of a tree), `crown` (settings
//! of the relief).

mod content;
mod edit;
mod encode;
mod format;
mod history;
mod legacy;
mod migrate;
mod project;
mod settings;
pub mod store;

pub use content::{Content, Photo, PhotoId, State};
pub use edit::{Edit, EditError, NewPhoto};
pub use encode::{Decoded, decode, encode, encode_without_photos};
pub use format::{FormatError, VERSION};
pub use history::Changed;
pub use project::{Document, Snapshot};
pub use settings::{
    CanvasView, Coloring, CrownSettings, ExemplarWeight, Favourite, Generation, Tangent,
    VariationSettings, ViewState,
};
