//! `library.json` of an exported library: what stands in the folder, how large it is, where its foot
//! is, what it was made of. The format is described by `docs/library.schema.json`.
//!
//! Trees are listed one by one and share nothing but the header, so that a library can grow by
//! further trees without a change to the first ones.

use crate::raster::Rect;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;

/// Version of the format; goes up when a key changes its meaning, not when one is added.
pub(super) const VERSION: u32 = 1;

/// A whole folder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PresetLibrary {
    /// `boscage-export`.
    pub format: String,
    /// 1.
    pub version: u32,
    /// Program and version that wrote it.
    pub generator: String,
    /// Name of the preset.
    pub preset: String,
    /// Whose work it is, and what others may do with it.
    #[serde(flatten)]
    pub rights: LicenseRecord,
    /// The trees that are pictures.
    pub trees: Vec<PresetTree>,
    /// The trees that are crowns.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub crowns: Vec<PresetCrown>,
    /// Further files of the folder, by what they are.
    pub files: BTreeMap<String, Vec<String>>,
}

/// Author and licence.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct LicenseRecord {
    /// Who made it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub author: Option<String>,
    /// An SPDX expression or any text.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub license: Option<String>,
}

impl LicenseRecord {
    /// Both in one line, if there is any.
    pub fn copyright(&self) -> Option<String> {
        match (&self.author, &self.license) {
            (Some(author), Some(license)) => Some(format!("{author}, {license}")),
            (one, other) => one.clone().or_else(|| other.clone()),
        }
    }
}

/// A tree.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PresetTree {
    /// Its name.
    pub name: String,
    /// Its files by what they are (`albedo`, `normal`, `model`, …), relative to this file.
    pub files: BTreeMap<String, String>,
    /// Width and height of its pictures, in pixels.
    pub size_px: [u32; 2],
    /// The part of its pictures that shows.
    pub frame: Rect,
    /// The trunk's foot, in pixels from the pictures' top-left corner.
    pub pivot_px: [f64; 2],
    /// Side of a pixel, in metres.
    pub metres_per_pixel: f64,
    /// Width and height of the part that shows, in metres.
    pub size_m: [f64; 2],
    /// What 255 in the depth map means, in metres towards the viewer, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth_m: Option<f64>,
    /// The cut-out mesh.
    pub cutout: CutoutRecord,
    /// How the tree was made, as recorded by the program that made it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recipe: Option<Value>,
}

/// A tree with a crown in three dimensions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PresetCrown {
    /// Its name.
    pub name: String,
    /// Its files by what they are (`model`, `surface`, `impostor_full`, `colors`, …), relative to
    /// this file.
    pub files: BTreeMap<String, String>,
    /// Width, height and depth, in metres; the foot of its stem is at the origin of its models.
    pub size_m: [f64; 3],
    /// Triangles of each level of detail of the leaf cards, the finest first.
    pub leaf_triangles: Vec<usize>,
    /// Triangles of each level of detail of the surface.
    pub surface_triangles: Vec<usize>,
    /// Its impostors.
    pub impostors: Vec<ImpostorRecord>,
    /// The centre that the cubemaps' directions start from, in metres from the foot.
    pub cubemap_center_m: [f64; 3],
    /// How the crown was made, as recorded by the program that made it.
    pub recipe: Value,
}

/// What a shader must know of an impostor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ImpostorRecord {
    /// `full` or `hemisphere`.
    pub form: String,
    /// Frames along a side of the atlas; they stand row by row.
    pub frames: u32,
    /// Side of a frame, in pixels.
    pub frame_px: u32,
    /// What the middle of every frame shows, in metres from the foot.
    pub center_m: [f64; 3],
    /// Half the side of a frame, in metres.
    pub half_m: f64,
    /// The alpha of the normals is 1 − depth: 1 this far before the centre, 0 as far behind it; in
    /// metres.
    pub depth_m: f64,
}

/// A cut-out in numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CutoutRecord {
    /// Vertices of one card.
    pub vertices: usize,
    /// Triangles of one card.
    pub triangles: usize,
    /// Share of the rectangle's area that is not drawn.
    pub overdraw_saved: f64,
}

impl PresetLibrary {
    /// A library of `trees`.
    pub fn new(
        preset: &str,
        rights: LicenseRecord,
        trees: Vec<PresetTree>,
        files: BTreeMap<String, Vec<String>>,
    ) -> Self {
        Self {
            format: "boscage-export".to_owned(),
            version: VERSION,
            generator: concat!("boscage ", env!("CARGO_PKG_VERSION")).to_owned(),
            preset: preset.to_owned(),
            rights,
            trees,
            crowns: Vec::new(),
            files,
        }
    }

    /// The record as JSON.
    pub fn to_json(&self) -> String {
        let written = serde_json::to_string_pretty(self);
        written.unwrap_or_else(|_| unreachable!("records hold numbers and text only")) + "\n"
    }
}
