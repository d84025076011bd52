//! `boscage export`: the files of one tree.

use super::export::ExportSettings;
use super::failure::Failure;
use super::input::PictureFile;
use super::output::recipe;
use super::records::TreeRecord;
use super::run::Run;
use crate::base::Digest;
use crate::export::{
    BlockFormat, CompressedLevels, Cutout, CutoutRecord, GalleryTree, Material, Preset, PresetTree,
    Sprite, TextureStyle, TreeModel, cutout, data_mips, encode_dds, encode_ktx2, gallery_tree,
    lod_glb, mips, normal_mips,
};
use crate::geometry::Point;
use crate::pipeline::{DEPTH_SHARE, TreeMaps, tree_maps};
use crate::raster::{
    Compression, Image, Rect, Straight, encode_grey_png, encode_opaque_png, encode_png,
};
use clap::ValueEnum;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

/// Vertices that a cut-out may have.
const CUTOUT_VERTICES: usize = 72;

/// A map beside the colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ExportMap {
    /// Tangent-space normals, Y+
    Normal,
    /// Height towards the viewer
    Depth,
    /// Ambient occlusion
    Ao,
    /// Light that comes through from behind
    Translucency,
}

impl ExportMap {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::Depth => "depth",
            Self::Ao => "ao",
            Self::Translucency => "translucency",
        }
    }

    /// The map on the canvas of `sprite`.
    fn of(self, maps: &TreeMaps, sprite: &Sprite) -> Picture {
        let grey = |map: &Image<u8>| Picture::Grey(sprite.map(map));
        match self {
            Self::Normal => Picture::Opaque(sprite.map(&maps.normal)),
            Self::Depth => grey(&maps.depth),
            Self::Ao => grey(&maps.ao),
            Self::Translucency => grey(&maps.translucency),
        }
    }
}

/// A picture of a tree, with no more channels than it needs: writing PNG files takes most of the time
/// of an export.
enum Picture {
    /// Colour and alpha.
    Color(Image<Straight>),
    /// Three channels; alpha means nothing.
    Opaque(Image<Straight>),
    /// One.
    Grey(Image<u8>),
}

impl Picture {
    fn png(&self) -> Vec<u8> {
        match self {
            Self::Color(image) => encode_png(image, Compression::Fast),
            Self::Opaque(image) => encode_opaque_png(image, Compression::Fast),
            Self::Grey(image) => encode_grey_png(image, Compression::Fast),
        }
    }

    /// With all channels, for texture files.
    fn texels(&self) -> Cow<'_, Image<Straight>> {
        match self {
            Self::Color(image) | Self::Opaque(image) => Cow::Borrowed(image),
            Self::Grey(image) => Cow::Owned(image.map(|&v| Straight([v, v, v, 255]))),
        }
    }
}

/// A form of texture files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum TextureForm {
    /// PNG, without mip levels
    Png,
    /// DDS with all mip levels
    Dds,
    /// KTX2 of BC7 with all mip levels, for desktops
    Ktx2,
    /// KTX2 of UASTC (Basis Universal) with all mip levels, for all cards
    Uastc,
}

impl TextureForm {
    /// What the form adds to the name of a map in `library.json`, and the ending of its files.
    pub(crate) fn suffix(self) -> (&'static str, &'static str) {
        match self {
            Self::Png => ("", "png"),
            Self::Dds => ("_dds", "dds"),
            Self::Ktx2 => ("_ktx2", "ktx2"),
            Self::Uastc => ("_uastc", "uastc.ktx2"),
        }
    }
}

/// What the pictures inside models are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum ModelTextures {
    /// PNG, which everybody reads
    #[default]
    Png,
    /// UASTC with all mip levels, which stays packed on the card (`KHR_texture_basisu`)
    Basisu,
}

/// A tree that was exported.
pub(crate) struct ExportedTree {
    pub(crate) record: PresetTree,
    /// Kept of trees that the sample scene shows.
    pub(crate) sample: Option<Sample>,
}

/// What a scene needs of a tree.
pub(crate) struct Sample {
    pub(crate) name: String,
    pub(crate) sprite: Sprite,
    pub(crate) cutout: Cutout,
    /// Its pictures as PNG files, by map.
    pub(crate) pngs: BTreeMap<&'static str, Vec<u8>>,
    /// The same as KTX2 files, where models hold such.
    pub(crate) packed: BTreeMap<&'static str, Vec<u8>>,
}

impl Sample {
    /// The tree as a model with the levels of `settings`.
    pub(crate) fn model<'a>(&'a self, lods: &'a [crate::export::Lod]) -> TreeModel<'a> {
        let file = |map: &str| {
            let file = self.packed.get(map).or_else(|| self.pngs.get(map));
            file.map(Vec::as_slice)
        };
        TreeModel {
            name: &self.name,
            sprite: &self.sprite,
            cutout: &self.cutout,
            material: Material {
                albedo: file("albedo"),
                normal: file("normal"),
                occlusion: file("ao"),
                is_solid: false,
                ..Material::white(&self.name)
            },
            lods,
        }
    }
}

/// Names and places of a tree's files, by what they are; paths relative to the folder.
pub(crate) fn tree_files(settings: &ExportSettings, name: &str) -> BTreeMap<String, String> {
    let mut files = BTreeMap::new();
    let style = settings.preset.style();
    for map in settings.map_names() {
        for form in &settings.textures {
            let (suffix, ending) = form.suffix();
            let file = format!("textures/{}.{ending}", style.file(name, map));
            files.insert(format!("{map}{suffix}"), file);
        }
    }
    if settings.preset.has_models() {
        files.insert("model".to_owned(), settings.preset.model(name));
    }
    if settings.preset == Preset::Web {
        files.insert("gallery".to_owned(), format!("gallery/{name}.js"));
    }
    files
}

/// Makes and writes the files of one tree.
///
/// The colour PNG is written last and carries the recipe: when it is there and whole, so are the
/// others, and `--resume` leaves the tree alone.
pub(crate) fn export_tree(
    settings: &ExportSettings,
    folder: &Path,
    tree: &TreeRecord,
    is_sample: bool,
    session: &Run<'_>,
) -> Result<ExportedTree, Failure> {
    let path = folder.join(&tree.file);
    let file = PictureFile::read(&path)?;
    let made_from = settings.recipe(tree, file.digest());
    let name = tree.name();
    let files = tree_files(settings, name);
    let albedo = settings.out.join(&files["albedo"]);
    let is_there = || files.values().all(|file| settings.out.join(file).is_file());
    let noted = session.output.ready_note(&albedo, made_from);
    let noted = noted.filter(|_| is_there());
    let noted = noted.and_then(|note| recorded(tree, &files, &note));
    let is_ready = noted.is_some();
    if let Some(record) = noted.filter(|_| !is_sample) {
        return Ok(ExportedTree {
            record,
            sample: None,
        });
    }
    let image = file.decoded()?;
    drop(file);
    let [x, y] = tree.pins.bottom;
    let sprite = Sprite::new(&image, Point::new(x, y), settings.sprite)
        .map_err(|error| Failure::of(path.display(), error))?;
    session.cancel.check()?;
    let cut = cutout(&sprite, CUTOUT_VERTICES);
    session.cancel.check()?;
    let record = record(settings, tree, &sprite, &cut, &files);
    let images = pictures(settings, &image, &sprite, session)?;
    drop(image);
    let mut pngs = BTreeMap::new();
    for (map, image) in &images {
        session.cancel.check()?;
        pngs.insert(*map, image.png());
    }
    let sample = Sample {
        name: name.to_owned(),
        sprite,
        cutout: cut,
        pngs,
        packed: packed(settings, &images, session)?,
    };
    if !is_ready {
        session.output.outdate(&albedo)?;
        write_textures(settings, &files, &images, &sample, session)?;
        if let Some(model) = files.get("model") {
            let lods = settings.preset.lods(settings.planes);
            let model_of = sample.model(&lods);
            let copyright = settings.rights.copyright();
            let bytes = lod_glb(&model_of, settings.lod_style(), copyright.as_deref());
            let bytes = bytes.map_err(|error| Failure::of(name, error))?;
            session.output.write(&settings.out.join(model), &bytes)?;
        }
        if let Some(script) = files.get("gallery") {
            let png = |map: &str| sample.pngs.get(map).map(Vec::as_slice);
            let text = gallery_tree(&GalleryTree {
                record: &record,
                albedo: &sample.pngs["albedo"],
                normal: png("normal"),
                depth: png("depth"),
            });
            session
                .output
                .write(&settings.out.join(script), text.as_bytes())?;
        }
        let png = sample.pngs["albedo"].clone();
        let note = note(&record);
        session
            .output
            .write_noted_item(&albedo, png, &note, made_from)?;
    }
    Ok(ExportedTree {
        record,
        sample: is_sample.then_some(sample),
    })
}

/// The pictures of a tree on its canvas, by map.
fn pictures(
    settings: &ExportSettings,
    image: &Image<Straight>,
    sprite: &Sprite,
    session: &Run<'_>,
) -> Result<Vec<(&'static str, Picture)>, Failure> {
    let mut pictures = vec![("albedo", Picture::Color(sprite.image.clone()))];
    if !settings.maps.is_empty() {
        let maps = tree_maps(image, session.cancel)?;
        for map in &settings.maps {
            session.cancel.check()?;
            pictures.push((map.name(), map.of(&maps, sprite)));
        }
    }
    Ok(pictures)
}

/// The pictures of models as KTX2 files by map, if models hold such.
fn packed(
    settings: &ExportSettings,
    images: &[(&'static str, Picture)],
    session: &Run<'_>,
) -> Result<BTreeMap<&'static str, Vec<u8>>, Failure> {
    if settings.model_textures == ModelTextures::Png || !settings.preset.has_models() {
        return Ok(BTreeMap::new());
    }
    /// What a material of glTF takes.
    const IN_MODELS: [&str; 3] = ["albedo", "normal", "ao"];
    let inside = images.iter().filter(|(map, _)| IN_MODELS.contains(map));
    inside
        .map(|(map, image)| {
            let levels = map_levels(map, &image.texels(), &[], session)?;
            let blocks = CompressedLevels::of(&levels, BlockFormat::Uastc, session.cancel)?;
            let file = encode_ktx2(&blocks, *map == "albedo", session.cancel)?;
            Ok((*map, file))
        })
        .collect()
}

/// All mip levels of a map; coverage is kept in each of `regions`, see [`mips`].
pub(crate) fn map_levels(
    map: &str,
    texels: &Image<Straight>,
    regions: &[Rect],
    session: &Run<'_>,
) -> Result<Vec<Image<Straight>>, Failure> {
    Ok(match map {
        "albedo" => mips(texels, regions, session.cancel)?,
        "normal" => normal_mips(texels, session.cancel)?,
        _ => data_mips(texels, session.cancel)?,
    })
}

/// All texture files but the colour PNG.
fn write_textures(
    settings: &ExportSettings,
    files: &BTreeMap<String, String>,
    images: &[(&'static str, Picture)],
    sample: &Sample,
    session: &Run<'_>,
) -> Result<(), Failure> {
    for (map, image) in images {
        let loose = settings.loose(map, image);
        if let Some(file) = files.get(*map).filter(|_| *map != "albedo") {
            let path = settings.out.join(file);
            match &loose {
                None => session.output.write(&path, &sample.pngs[map])?,
                Some(picture) => session.output.write(&path, &picture.png())?,
            }
        }
        let image = loose.as_ref().unwrap_or(image);
        let others = settings.textures.iter().filter_map(|&form| {
            let is_other = form != TextureForm::Png;
            let file = files.get(&format!("{map}{}", form.suffix().0))?;
            is_other.then_some((file.as_str(), form))
        });
        let forms: Vec<_> = others.collect();
        if forms.is_empty() {
            continue;
        }
        let levels = map_levels(map, &image.texels(), &[], session)?;
        let textures = encoded_textures(settings, &levels, *map == "albedo", forms, session)?;
        for (file, bytes) in textures {
            session.output.write(&settings.out.join(file), &bytes)?;
        }
    }
    Ok(())
}

/// The mip chain `levels` as files of several forms; blocks that several of them hold are encoded
/// once.
pub(crate) fn encoded_textures<N>(
    settings: &ExportSettings,
    levels: &[Image<Straight>],
    srgb: bool,
    forms: Vec<(N, TextureForm)>,
    session: &Run<'_>,
) -> Result<Vec<(N, Vec<u8>)>, Failure> {
    let mut ready: Vec<CompressedLevels> = Vec::new();
    let mut out = Vec::new();
    for (name, form) in forms {
        let format = match form {
            TextureForm::Png => continue,
            TextureForm::Dds => settings.blocks,
            TextureForm::Ktx2 => BlockFormat::Bc7,
            TextureForm::Uastc => BlockFormat::Uastc,
        };
        let at = match ready.iter().position(|blocks| blocks.format() == format) {
            Some(at) => at,
            None => {
                ready.push(CompressedLevels::of(levels, format, session.cancel)?);
                ready.len() - 1
            }
        };
        let bytes = match form {
            TextureForm::Dds => encode_dds(&ready[at], srgb),
            _ => encode_ktx2(&ready[at], srgb, session.cancel)?,
        };
        out.push((name, bytes));
    }
    Ok(out)
}

/// What is kept of a tree's record in its picture: all that would have to be measured again. ASCII.
fn note(record: &PresetTree) -> String {
    let measured = PresetTree {
        name: String::new(),
        files: BTreeMap::new(),
        recipe: None,
        ..record.clone()
    };
    serde_json::to_string(&measured).unwrap_or_default()
}

/// The record of `tree` with what [`note`] kept of it.
fn recorded(tree: &TreeRecord, files: &BTreeMap<String, String>, note: &str) -> Option<PresetTree> {
    let measured: PresetTree = serde_json::from_str(note).ok()?;
    Some(PresetTree {
        name: tree.name().to_owned(),
        files: files.clone(),
        recipe: serde_json::to_value(tree).ok(),
        ..measured
    })
}

fn record(
    settings: &ExportSettings,
    tree: &TreeRecord,
    sprite: &Sprite,
    cut: &Cutout,
    files: &BTreeMap<String, String>,
) -> PresetTree {
    let longer = f64::from(sprite.frame.width.max(sprite.frame.height));
    let depth_m = DEPTH_SHARE * longer * sprite.metres_per_pixel;
    PresetTree {
        name: tree.name().to_owned(),
        files: files.clone(),
        size_px: [sprite.image.width(), sprite.image.height()],
        frame: sprite.frame,
        pivot_px: sprite.pivot.to_array(),
        metres_per_pixel: sprite.metres_per_pixel,
        size_m: sprite.size_m(),
        depth_m: settings.maps.contains(&ExportMap::Depth).then_some(depth_m),
        cutout: CutoutRecord {
            vertices: cut.flat.vertices.len(),
            triangles: cut.flat.triangles.len(),
            overdraw_saved: 1.0 - cut.area,
        },
        recipe: serde_json::to_value(tree).ok(),
    }
}

impl ExportSettings {
    /// The maps that are made, colours first.
    pub(crate) fn map_names(&self) -> Vec<&'static str> {
        let maps = self.maps.iter().map(|map| map.name());
        std::iter::once("albedo").chain(maps).collect()
    }

    /// The digest of all that a tree's files are made from.
    fn recipe(&self, tree: &TreeRecord, picture: Digest) -> Digest {
        let settings = format!(
            "{:?} {:?} {:?} {:?} {:?} {:?} {} {:?} {:?}",
            self.preset,
            self.sprite,
            self.maps,
            self.textures,
            self.model_textures,
            self.blocks,
            self.planes,
            self.wind,
            self.rights
        );
        recipe("export")
            .with(picture.bytes())
            .with(tree.to_json().as_bytes())
            .with(settings.as_bytes())
            .finish()
    }

    /// The picture of a loose file where it differs from that inside models.
    fn loose(&self, map: &str, picture: &Picture) -> Option<Picture> {
        /// Roughness of leaves, for packed maps.
        const ROUGHNESS: u8 = 230;
        if self.preset.style() != TextureStyle::Unreal {
            return None;
        }
        let image = match (map, picture) {
            ("normal", Picture::Opaque(image)) => {
                image.map(|p| Straight([p.0[0], 255 - p.0[1], p.0[2], 255]))
            }
            ("ao", Picture::Grey(image)) => image.map(|&v| Straight([v, ROUGHNESS, 0, 255])),
            _ => return None,
        };
        Some(Picture::Opaque(image))
    }
}

/// The block format that a flag names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(crate) enum BlockName {
    /// Better colours and alpha
    #[default]
    Bc7,
    /// For old cards and readers (DXT5)
    Bc3,
}

impl BlockName {
    pub(crate) fn format(self) -> BlockFormat {
        match self {
            Self::Bc7 => BlockFormat::Bc7,
            Self::Bc3 => BlockFormat::Bc3,
        }
    }
}
