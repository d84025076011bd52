//! A crown as a folder of files, and back.
//!
//! - `crown.json`: [`CrownRecord`], what the other files mean and what the crown was made from;
//! - `color_px.png` … `color_nz.png`: the colour cubemap, 8-bit sRGB;
//! - `height_px.png` …: the height cubemap, 16-bit grey, 0 … 1;
//! - `radius_px.png` …: the radius cubemap, 16-bit grey, metres = R_max · value / 65535;
//! - `base_mesh.ply`: the base mesh before relief, metres;
//! - `crown.glb`: the crown as a textured mesh, for other programs; it is not read back.
//!
//! Faces are in the order +X −X +Y −Y +Z −Z and oriented as in Vulkan, KTX and glTF, in a
//! right-handed world with +Y up, the tree's base at the origin. What goes through the files loses
//! at most R_max / 131,070 of a radius (0.1 mm of 10 m) and a 131,070th of a height.

use super::crown_mesh::crown_glb;
use super::glb::GlbError;
use super::ply::{PlyError, decode_ply, encode_ply};
use crate::base::{Cancel, Cancelled};
use crate::raster::{
    Compression, CubeFace, Cubemap, Grey16Error, Image, ImageError, ReadLimits, Straight,
    decode_grey16_png, encode_grey16_png, encode_png, read_image_from_memory,
};
use crate::scene::{Crown, StemLook};
use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The name of the record.
pub const CROWN_RECORD: &str = "crown.json";

/// The name of the base mesh.
const BASE_MESH: &str = "base_mesh.ply";

/// The name of the textured mesh.
const TEXTURED: &str = "crown.glb";

const FORMAT: &str = "boscage-crown";

/// Version of the format; readers refuse others.
const VERSION: u32 = 1;

/// Farthest that anything may lie from the origin and widest that a crown may be, metres: beyond it
/// single precision has no centimetres left.
const FARTHEST_M: f64 = 1e5;

/// Longest side of a face that is read.
const LARGEST_FACE: u32 = 4096;

/// What stands in `crown.json`. What a reader does not know it ignores.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CrownRecord {
    /// `boscage-crown`.
    pub format: String,
    /// Version of the format.
    pub version: u32,
    /// Program and version that wrote it.
    pub generator: String,
    /// The frame, in words.
    pub frame: String,
    /// How values in the files become lengths, in words.
    pub encoding: String,
    /// The faces, in the order of layers: `px`, `nx`, `py`, `ny`, `pz`, `nz`.
    pub faces: Vec<String>,
    /// Texels along a face of the colour and height cubemaps.
    pub size: u32,
    /// Centre of the crown, metres above and beside the tree's base.
    pub center_m: [f64; 3],
    /// R_min, metres.
    pub radius_min_m: f32,
    /// R_max, metres.
    pub radius_max_m: f32,
    /// How much of its outline leaves fill, 0 to 1; where it is not told, all.
    #[serde(default = "closed", skip_serializing_if = "is_closed")]
    pub cover: f32,
    /// What its picture shows of the stem; where it is not told, one that suits the tree's height.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stem: Option<StemLook>,
    /// What the crown was made from: inputs, digests, settings, seed.
    pub recipe: serde_json::Value,
}

/// No sky shows through.
fn closed() -> f32 {
    1.0
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks for it")]
fn is_closed(cover: &f32) -> bool {
    *cover >= 1.0
}

impl CrownRecord {
    /// The record of `crown`, made from `recipe`.
    pub fn new(crown: &Crown, recipe: serde_json::Value) -> Self {
        let (radius_min_m, radius_max_m) = crown.radius_range_m();
        Self {
            format: FORMAT.to_owned(),
            version: VERSION,
            generator: concat!("boscage ", env!("CARGO_PKG_VERSION")).to_owned(),
            frame: "right-handed, +Y up, metres, the tree's base at the origin, the photograph's \
                    plane at z = 0, its viewer at +Z; faces as in Vulkan, KTX and glTF"
                .to_owned(),
            encoding: "color_*.png: sRGB; height_*.png: value / 65535; radius_*.png: metres = \
                       radius_max_m * value / 65535, linear"
                .to_owned(),
            faces: CubeFace::ALL.map(|face| face.name().to_owned()).to_vec(),
            size: crown.color.size(),
            center_m: crown.center_m.to_array(),
            radius_min_m,
            radius_max_m,
            cover: crown.cover,
            stem: crown.stem,
            recipe,
        }
    }

    /// Reads a record.
    ///
    /// # Errors
    /// [`CrownFolderError::Record`] when `bytes` is none, or of another version.
    pub fn read(bytes: &[u8]) -> Result<Self, CrownFolderError> {
        let failed = |reason: String| CrownFolderError::Record(reason);
        let record: Self =
            serde_json::from_slice(bytes).map_err(|error| failed(error.to_string()))?;
        if record.format != FORMAT || record.version != VERSION {
            let found = format!("{} version {}", record.format, record.version);
            return Err(failed(format!("{found} is not known to this version")));
        }
        let is_near = |along: &f64| along.abs() <= FARTHEST_M;
        let center_is_near = record.center_m.iter().all(is_near);
        let radius = f64::from(record.radius_max_m);
        let radius_is_real = radius > 0.0 && is_near(&radius);
        let size_is_real = (1..=LARGEST_FACE).contains(&record.size);
        let cover_is_share = (0.0..=1.0).contains(&record.cover);
        let stem_is_sound = record.stem.is_none_or(|stem| stem.is_sound());
        if !(center_is_near && radius_is_real && size_is_real && cover_is_share && stem_is_sound) {
            return Err(failed(
                "its centre, radius, size, cover or stem is out of range".to_owned(),
            ));
        }
        Ok(record)
    }
}

/// A crown could not be made into files.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CrownFilesError {
    /// Its radii are not finite.
    #[error(transparent)]
    Mesh(#[from] GlbError),
    /// The work was asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// A crown could not be read.
#[derive(Debug, thiserror::Error)]
pub enum CrownFolderError {
    /// `crown.json` is not a record of a crown.
    #[error("{CROWN_RECORD}: not the record of a crown: {0}")]
    Record(String),
    /// A colour face is no picture.
    #[error("{0}")]
    Color(#[from] ImageError),
    /// A height or radius face is not 16-bit grey.
    #[error("{name}: {reason}")]
    Grey {
        /// The file.
        name: String,
        /// Why.
        reason: Grey16Error,
    },
    /// The faces of a cubemap are not squares of one size.
    #[error("{name}: is {width}×{height} where {size}×{size} are expected")]
    Size {
        /// The file.
        name: String,
        /// Its width.
        width: u32,
        /// Its height.
        height: u32,
        /// The side expected.
        size: u32,
    },
    /// The base mesh is no mesh.
    #[error("{BASE_MESH}: {0}")]
    Mesh(#[from] PlyError),
}

/// The names of all files that [`crown_files`] makes, the record last.
pub fn crown_file_names() -> Vec<String> {
    let faces = ["color", "height", "radius"]
        .into_iter()
        .flat_map(|kind| CubeFace::ALL.map(|face| face_name(kind, face)));
    let others = [BASE_MESH, TEXTURED, CROWN_RECORD].map(str::to_owned);
    faces.chain(others).collect()
}

/// `crown` as files, names and contents, in the order of [`crown_file_names`]: the record comes
/// last, so that a folder that has it has all.
///
/// # Errors
/// [`CrownFilesError`].
pub fn crown_files(
    crown: &Crown,
    recipe: serde_json::Value,
    cancel: &Cancel,
) -> Result<Vec<(String, Vec<u8>)>, CrownFilesError> {
    let record = CrownRecord::new(crown, recipe);
    let longest = f64::from(record.radius_max_m);
    // A radius of 0 would be no radius.
    let grey = |value: f64, least: f64| (65_535.0 * value).round().clamp(least, 65_535.0) as u16;
    let encoded = |&(kind, face): &(usize, CubeFace)| match kind {
        0 => encode_png(crown.color.face(face), Compression::Fast),
        1 => {
            let heights = crown.height.face(face).map(|&h| grey(f64::from(h), 0.0));
            encode_grey16_png(&heights, Compression::Fast)
        }
        _ => {
            let radii = crown.radius_m.face(face);
            let radii = radii.map(|&r| grey(f64::from(r) / longest, 1.0));
            encode_grey16_png(&radii, Compression::Fast)
        }
    };
    let jobs: Vec<(usize, CubeFace)> = (0..3)
        .flat_map(|kind| CubeFace::ALL.map(|face| (kind, face)))
        .collect();
    let encoded = jobs.par_iter().map(|job| {
        cancel.check()?;
        Ok(encoded(job))
    });
    let mut contents: Vec<Vec<u8>> = encoded.collect::<Result<_, Cancelled>>()?;
    cancel.check()?;
    contents.push(encode_ply(&crown.base_mesh));
    cancel.check()?;
    contents.push(crown_glb(crown)?);
    cancel.check()?;
    let record = serde_json::to_string_pretty(&record)
        .unwrap_or_else(|_| unreachable!("records hold numbers and text only"));
    contents.push((record + "\n").into_bytes());
    Ok(crown_file_names().into_iter().zip(contents).collect())
}

/// The crown whose files `read` gives by name, and its record.
///
/// # Errors
/// Those of `read`, and [`CrownFolderError`].
pub fn crown_from_files<E: From<CrownFolderError>>(
    mut read: impl FnMut(&str) -> Result<Vec<u8>, E>,
) -> Result<(Crown, CrownRecord), E> {
    let record = CrownRecord::read(&read(CROWN_RECORD)?)?;
    let size = record.size;
    let color = cubemap_from("color", Some(size), &mut read, color_face)?;
    let height = cubemap_from("height", Some(size), &mut read, grey_face)?;
    let radius = cubemap_from("radius", None, &mut read, grey_face)?;
    let longest = f64::from(record.radius_max_m);
    let metres = |&value: &u16| (longest * f64::from(value.max(1)) / 65_535.0) as f32;
    let crown = Crown {
        center_m: DVec3::from_array(record.center_m),
        radius_m: radius.map(metres),
        color,
        height: height.map(|&value| (f64::from(value) / 65_535.0) as f32),
        base_mesh: decode_ply(&read(BASE_MESH)?).map_err(CrownFolderError::from)?,
        cover: record.cover,
        stem: record.stem,
    };
    Ok((crown, record))
}

fn face_name(kind: &str, face: CubeFace) -> String {
    format!("{kind}_{}.png", face.name())
}

/// The cubemap `kind`; its faces must have the side `size`, or any one when `None`.
fn cubemap_from<P: Copy, E: From<CrownFolderError>>(
    kind: &str,
    size: Option<u32>,
    read: &mut impl FnMut(&str) -> Result<Vec<u8>, E>,
    decode: impl Fn(&str, &[u8]) -> Result<Image<P>, CrownFolderError>,
) -> Result<Cubemap<P>, E> {
    let mut faces = Vec::with_capacity(6);
    let mut expected = size;
    for face in CubeFace::ALL {
        let name = face_name(kind, face);
        let image = decode(&name, &read(&name)?)?;
        let (width, height) = (image.width(), image.height());
        let size = *expected.get_or_insert(width);
        if width != size || height != size {
            let error = CrownFolderError::Size {
                name,
                width,
                height,
                size,
            };
            return Err(error.into());
        }
        faces.push(image);
    }
    let faces: [Image<P>; 6] = faces
        .try_into()
        .unwrap_or_else(|_| unreachable!("a cube has six faces"));
    Ok(Cubemap::from_faces(faces))
}

fn color_face(name: &str, bytes: &[u8]) -> Result<Image<Straight>, CrownFolderError> {
    let limits = ReadLimits {
        pixels: u64::from(LARGEST_FACE) * u64::from(LARGEST_FACE),
        ..Default::default()
    };
    Ok(read_image_from_memory(bytes, Path::new(name), limits)?)
}

fn grey_face(name: &str, bytes: &[u8]) -> Result<Image<u16>, CrownFolderError> {
    decode_grey16_png(bytes, LARGEST_FACE).map_err(|reason| CrownFolderError::Grey {
        name: name.to_owned(),
        reason,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Mesh;
    use std::collections::BTreeMap;

    fn crown() -> Crown {
        Crown {
            center_m: DVec3::new(0.25, 7.5, -1.0),
            radius_m: Cubemap::from_directions(9, |d| (3.0 + d.x + 0.5 * d.y) as f32),
            color: Cubemap::from_directions(8, |d| {
                let d = d * 100.0 + 128.0;
                Straight([d.x as u8, d.y as u8, d.z as u8, 255])
            }),
            height: Cubemap::from_directions(8, |d| (0.5 + 0.5 * d.z) as f32),
            cover: 1.0,
            stem: None,
            base_mesh: Mesh {
                positions: vec![DVec3::X, DVec3::Y, DVec3::Z, DVec3::splat(-1.0)],
                triangles: vec![[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]],
            },
        }
    }

    fn back(files: &BTreeMap<String, Vec<u8>>) -> Result<(Crown, CrownRecord), CrownFolderError> {
        crown_from_files(|name| {
            files
                .get(name)
                .cloned()
                .ok_or_else(|| CrownFolderError::Record(format!("no {name}")))
        })
    }

    #[test]
    fn a_crown_comes_back_from_its_files() {
        let crown = crown();
        let recipe = serde_json::json!({"seed": 7});
        let files: BTreeMap<_, _> = crown_files(&crown, recipe.clone(), &Cancel::new())
            .unwrap()
            .into_iter()
            .collect();
        let (found, record) = back(&files).unwrap();
        assert_eq!(record.recipe, recipe);
        assert_eq!(
            (found.center_m, &found.base_mesh),
            (crown.center_m, &crown.base_mesh)
        );
        assert_eq!(found.color, crown.color);
        let radii = |crown: &Crown| {
            crown
                .radius_m
                .faces()
                .iter()
                .flat_map(|f| f.pixels().to_vec())
                .collect::<Vec<f32>>()
        };
        for (found, expected) in radii(&found).iter().zip(radii(&crown)) {
            assert!((found - expected).abs() < 1e-4, "{found} {expected}");
        }
        let again = crown_files(&found, recipe, &Cancel::new()).unwrap();
        let names: Vec<&String> = again.iter().map(|(name, _)| name).collect();
        assert_eq!(names.last().unwrap().as_str(), CROWN_RECORD);
        for (name, content) in &again {
            assert!(
                name == CROWN_RECORD || name == TEXTURED || files[name] == *content,
                "{name} changed"
            );
        }
    }

    #[test]
    fn a_cancelled_crown_becomes_no_files() {
        let cancel = Cancel::new();
        cancel.cancel();
        let files = crown_files(&crown(), serde_json::Value::Null, &cancel);
        assert_eq!(files.unwrap_err(), CrownFilesError::Cancelled(Cancelled));
    }

    #[test]
    fn missing_foreign_and_ill_sized_files_are_named() {
        let whole: BTreeMap<_, _> = crown_files(&crown(), serde_json::Value::Null, &Cancel::new())
            .unwrap()
            .into_iter()
            .collect();
        let read = |name: &String| name != TEXTURED;
        for name in crown_file_names().into_iter().filter(read) {
            let mut files = whole.clone();
            files.remove(&name);
            assert!(back(&files).is_err(), "{name}");
            files.insert(name.clone(), b"nonsense".to_vec());
            let message = back(&files).unwrap_err().to_string();
            assert!(message.contains(&name), "{message}");
        }
        let mut files = whole;
        files.insert(
            "height_ny.png".into(),
            encode_grey16_png(&Image::filled(4, 8, 0), Compression::Fast),
        );
        let message = back(&files).unwrap_err().to_string();
        assert_eq!(message, "height_ny.png: is 4×8 where 8×8 are expected");
    }
}
