//! `boscage export`: the files of one tree.

use super::export::ExportSettings;
use super::failure::Failure;
use super::input::PictureFile;
use super::output::recipe;
use super::records::TreeRecord;
use super::session::Session;
use crate::base::Digest;
use crate::export::{
    BlockFormat, Cutout, CutoutRecord, GalleryTree, Material, Preset, PresetTree, Sprite,
    TreeModel, cutout, data_mips, encode_dds, encode_ktx2, gallery_tree, mips, normal_mips,
    tree_glb,
};
use crate::geometry::Point;
use crate::pipeline::{DEPTH_SHARE, TreeMaps, tree_maps};
use crate::raster::{Compression, Image, Straight, encode_png};
use clap::ValueEnum;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Vertices that a cut-out may have.
const CUTOUT_VERTICES: usize = 72;

/// A map beside the colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum ExportMap {
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
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::Depth => "depth",
            Self::Ao => "ao",
            Self::Translucency => "translucency",
        }
    }

    fn of(self, maps: &TreeMaps) -> Image<Straight> {
        let grey = |image: &Image<u8>| image.map(|&v| Straight([v, v, v, 255]));
        match self {
            Self::Normal => maps.normal.clone(),
            Self::Depth => grey(&maps.depth),
            Self::Ao => grey(&maps.ao),
            Self::Translucency => grey(&maps.translucency),
        }
    }
}

/// A form of texture files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub(super) enum TextureForm {
    /// PNG, without mip levels
    Png,
    /// DDS with all mip levels
    Dds,
    /// KTX2, BC7 packed by Zstandard, with all mip levels
    Ktx2,
}

/// A tree that was exported.
pub(super) struct ExportedTree {
    pub(super) record: PresetTree,
    /// Kept of trees that the sample scene shows.
    pub(super) sample: Option<Sample>,
}

/// What a scene needs of a tree.
pub(super) struct Sample {
    pub(super) name: String,
    pub(super) sprite: Sprite,
    pub(super) cutout: Cutout,
    pub(super) pngs: BTreeMap<&'static str, Vec<u8>>,
}

impl Sample {
    /// The tree as a model with the levels of `settings`.
    pub(super) fn model<'a>(
        &'a self,
        settings: &ExportSettings,
        lods: &'a [crate::export::Lod],
    ) -> TreeModel<'a> {
        let png = |map: &str| self.pngs.get(map).map(Vec::as_slice);
        TreeModel {
            name: &self.name,
            sprite: &self.sprite,
            cutout: &self.cutout,
            material: Material {
                name: &self.name,
                albedo: png("albedo").unwrap_or_default(),
                normal: png("normal"),
                occlusion: png("ao"),
                is_solid: false,
            },
            lods,
            grouped: settings.preset.groups_lods(),
            wind: settings.wind,
        }
    }
}

/// Names and places of a tree's files, by what they are; paths relative to the folder.
pub(super) fn tree_files(settings: &ExportSettings, name: &str) -> BTreeMap<String, String> {
    let mut files = BTreeMap::new();
    let style = settings.preset.style();
    for map in settings.map_names() {
        for form in &settings.textures {
            let (key, ending) = match form {
                TextureForm::Png => (map.to_owned(), "png"),
                TextureForm::Dds => (format!("{map}_dds"), "dds"),
                TextureForm::Ktx2 => (format!("{map}_ktx2"), "ktx2"),
            };
            files.insert(key, format!("textures/{}.{ending}", style.file(name, map)));
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
pub(super) fn export_tree(
    settings: &ExportSettings,
    folder: &Path,
    tree: &TreeRecord,
    is_sample: bool,
    session: &Session<'_>,
) -> Result<ExportedTree, Failure> {
    let path = folder.join(&tree.file);
    let file = PictureFile::read(&path)?;
    let made_from = settings.recipe(tree, file.digest());
    let image = file.decoded()?;
    drop(file);
    let [x, y] = tree.pins.bottom;
    let sprite = Sprite::new(&image, Point::new(x, y), settings.sprite)
        .map_err(|error| Failure::of(path.display(), error))?;
    session.cancel.check()?;
    let cut = cutout(&sprite, CUTOUT_VERTICES);
    session.cancel.check()?;
    let name = tree.name();
    let files = tree_files(settings, name);
    let paths: Vec<PathBuf> = files.values().map(|file| settings.out.join(file)).collect();
    let albedo = settings.out.join(&files["albedo"]);
    let is_ready =
        session.output.is_ready(&albedo, made_from) && paths.iter().all(|path| path.is_file());
    let record = record(settings, tree, &sprite, &cut, &files);
    if is_ready && !is_sample {
        return Ok(ExportedTree {
            record,
            sample: None,
        });
    }
    let images = pictures(settings, &image, &sprite, session)?;
    drop(image);
    let mut pngs = BTreeMap::new();
    for (map, image) in &images {
        session.cancel.check()?;
        pngs.insert(*map, encode_png(image, Compression::Fast));
    }
    let sample = Sample {
        name: name.to_owned(),
        sprite,
        cutout: cut,
        pngs,
    };
    if !is_ready {
        write_textures(settings, &files, &images, &sample, session)?;
        if let Some(model) = files.get("model") {
            let lods = settings.preset.lods(settings.planes);
            let model_of = sample.model(settings, &lods);
            let bytes = tree_glb(&model_of, settings.rights.copyright().as_deref());
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
        session.output.write_item(&albedo, png, made_from)?;
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
    session: &Session<'_>,
) -> Result<Vec<(&'static str, Image<Straight>)>, Failure> {
    let mut pictures = vec![("albedo", sprite.image.clone())];
    if !settings.maps.is_empty() {
        let maps = tree_maps(image, session.cancel)?;
        for map in &settings.maps {
            session.cancel.check()?;
            pictures.push((map.name(), sprite.map(&map.of(&maps))));
        }
    }
    Ok(pictures)
}

/// All texture files but the colour PNG.
fn write_textures(
    settings: &ExportSettings,
    files: &BTreeMap<String, String>,
    images: &[(&'static str, Image<Straight>)],
    sample: &Sample,
    session: &Session<'_>,
) -> Result<(), Failure> {
    for (map, image) in images {
        let loose = settings.loose(map, image);
        if let Some(file) = files.get(*map).filter(|_| *map != "albedo") {
            let path = settings.out.join(file);
            match &loose {
                None => session.output.write(&path, &sample.pngs[map])?,
                Some(image) => session
                    .output
                    .write(&path, &encode_png(image, Compression::Fast))?,
            }
        }
        let image = loose.as_ref().unwrap_or(image);
        let (dds, ktx2) = (
            files.get(&format!("{map}_dds")),
            files.get(&format!("{map}_ktx2")),
        );
        if dds.is_none() && ktx2.is_none() {
            continue;
        }
        let levels = match *map {
            "albedo" => mips(image, &[], session.cancel)?,
            "normal" => normal_mips(image, session.cancel)?,
            _ => data_mips(image, session.cancel)?,
        };
        let srgb = *map == "albedo";
        if let Some(file) = dds {
            let bytes = encode_dds(&levels, settings.blocks, srgb, session.cancel)?;
            session.output.write(&settings.out.join(file), &bytes)?;
        }
        if let Some(file) = ktx2 {
            let bytes = encode_ktx2(&levels, srgb, session.cancel)?;
            session.output.write(&settings.out.join(file), &bytes)?;
        }
    }
    Ok(())
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
    pub(super) fn map_names(&self) -> Vec<&'static str> {
        let maps = self.maps.iter().map(|map| map.name());
        std::iter::once("albedo").chain(maps).collect()
    }

    /// The digest of all that a tree's files are made from.
    fn recipe(&self, tree: &TreeRecord, picture: Digest) -> Digest {
        let settings = format!(
            "{:?} {:?} {:?} {:?} {:?} {} {:?} {:?}",
            self.preset,
            self.sprite,
            self.maps,
            self.textures,
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
    fn loose(&self, map: &str, image: &Image<Straight>) -> Option<Image<Straight>> {
        /// Roughness of leaves, for packed maps.
        const ROUGHNESS: u8 = 230;
        match (self.preset.style(), map) {
            (crate::export::TextureStyle::Unreal, "normal") => {
                Some(image.map(|p| Straight([p.0[0], 255 - p.0[1], p.0[2], p.0[3]])))
            }
            (crate::export::TextureStyle::Unreal, "ao") => {
                Some(image.map(|p| Straight([p.0[0], ROUGHNESS, 0, 255])))
            }
            _ => None,
        }
    }
}

/// The block format that a flag names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(super) enum BlockName {
    /// Better colours and alpha
    #[default]
    Bc7,
    /// For old cards and readers (DXT5)
    Bc3,
}

impl BlockName {
    pub(super) fn format(self) -> BlockFormat {
        match self {
            Self::Bc7 => BlockFormat::Bc7,
            Self::Bc3 => BlockFormat::Bc3,
        }
    }
}
