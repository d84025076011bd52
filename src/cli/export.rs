//! `boscage export`: a library of trees → a folder that a consumer takes as it is.

use super::export_crown::{
    CrownExport, CrownExportSettings, ImpostorName, LeafName, crown_folders,
};
use super::export_pages::{write_atlas, write_flightgear};
use super::export_shared::{Files, SAMPLES, shared_files, write_library, write_scene};
use super::export_tree::{
    BlockName, ExportMap, ExportedTree, Sample, TextureForm, export_tree, tree_files,
};
use super::failure::Failure;
use super::records::{LibraryRecord, TreeRecord};
use super::session::Session;
use super::{Job, Stages, items};
use crate::export::{
    BlockFormat, LicenseRecord, LodStyle, Preset, PresetTree, SpriteSettings, TreeModel,
    WindChannels,
};
use clap::{Args, ValueEnum};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Write a library or crowns for an engine
///
/// Takes the folder that `boscage vary` wrote. Pictures are trimmed and their colour is continued
/// under clear pixels; models stand on their foot in metres; library.json tells all about each tree.
///
/// Or takes the folder that `boscage crown` wrote, or a folder of such: leaf-card and surface models
/// with levels of detail, octahedral impostors with shaders, and cubemaps.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  boscage export new --preset godot --out game/trees
  boscage export new --preset unreal --textures png,dds --atlas --out Content/Trees
  boscage export oak-crown --preset godot --leaves lobed --out game/oak
  boscage export new --preset web --author 'A. Author' --license CC-BY-4.0 --out gallery")]
pub(super) struct Flags {
    /// Folder with library.json, or that file; or the folder of a crown, or one of crowns
    #[arg(value_name = "LIBRARY")]
    library: PathBuf,
    /// Who will read it
    #[arg(long, value_enum, value_name = "NAME")]
    preset: PresetName,
    /// Height of each tree, in metres (crowns have their own)
    #[arg(long, default_value_t = 10.0, value_name = "METRES")]
    height: f64,
    /// Keep sides that are no powers of two (multiples of 4 instead)
    #[arg(long)]
    any_size: bool,
    /// Crossed cards of the finest model
    #[arg(long, default_value_t = 3, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4))]
    planes: u32,
    /// Further pictures of each tree, separated by commas
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = [ExportMap::Normal, ExportMap::Ao], value_name = "MAPS")]
    maps: Vec<ExportMap>,
    /// No pictures but the colours
    #[arg(long, conflicts_with = "maps")]
    no_maps: bool,
    /// Forms of texture files, separated by commas; PNG is always written
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = [TextureForm::Png], value_name = "FORMS")]
    textures: Vec<TextureForm>,
    /// Block format of DDS files
    #[arg(long, value_enum, default_value_t, value_name = "FORMAT")]
    blocks: BlockName,
    /// Also put all trees on atlas pages
    #[arg(long)]
    atlas: bool,
    /// Longer side of a tree on an atlas page, in pixels
    #[arg(long, default_value_t = 256, value_name = "PX", value_parser = clap::value_parser!(u32).range(16..=2048))]
    atlas_tree: u32,
    /// FlightGear: trees keep their leaves in winter
    #[arg(long)]
    evergreen: bool,
    /// Also write wind weights as vertex colours
    #[arg(long)]
    wind_colors: bool,
    /// Crowns: octahedral impostors, separated by commas
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = [ImpostorName::Full, ImpostorName::Hemisphere], value_name = "FORMS")]
    impostors: Vec<ImpostorName>,
    /// Crowns: no impostors
    #[arg(long, conflicts_with = "impostors")]
    no_impostors: bool,
    /// Crowns: frames along a side of an impostor
    #[arg(long, default_value_t = 8, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=32))]
    impostor_frames: u32,
    /// Crowns: side of an impostor's frame, in pixels
    #[arg(long, default_value_t = 256, value_name = "PX", value_parser = clap::value_parser!(u32).range(16..=1024))]
    impostor_frame: u32,
    /// Crowns: also write the faces of the cubemaps as OpenEXR: linear colours, radii in metres
    #[arg(long)]
    exr: bool,
    /// Crowns: shape of the leaves on cards
    #[arg(long, value_enum, default_value_t, value_name = "SHAPE")]
    leaves: LeafName,
    /// Whose work it is
    #[arg(long, value_name = "NAME")]
    author: Option<String>,
    /// What others may do with it, such as CC-BY-4.0
    #[arg(long, value_name = "SPDX")]
    license: Option<String>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum PresetName {
    /// GLB models and loose textures
    Blender,
    /// GLB models and loose textures
    Godot,
    /// GLB models for glTFast, levels of detail by name
    Unity,
    /// GLB models, Unreal's names and packing
    Unreal,
    /// A gallery that opens from disk
    Web,
    /// One atlas, four seasons
    Flightgear,
}

impl PresetName {
    fn preset(self) -> Preset {
        match self {
            Self::Blender => Preset::Blender,
            Self::Godot => Preset::Godot,
            Self::Unity => Preset::Unity,
            Self::Unreal => Preset::Unreal,
            Self::Web => Preset::Web,
            Self::Flightgear => Preset::FlightGear,
        }
    }
}

/// A checked job's settings.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ExportSettings {
    pub(super) out: PathBuf,
    pub(super) preset: Preset,
    pub(super) sprite: SpriteSettings,
    pub(super) planes: u32,
    pub(super) maps: Vec<ExportMap>,
    pub(super) textures: Vec<TextureForm>,
    pub(super) blocks: BlockFormat,
    pub(super) atlas: bool,
    pub(super) atlas_tree: u32,
    pub(super) evergreen: bool,
    pub(super) wind: WindChannels,
    pub(super) rights: LicenseRecord,
    pub(super) crowns: CrownExportSettings,
}

impl ExportSettings {
    /// How levels of detail and wind are told to the consumer.
    pub(super) fn lod_style(&self) -> LodStyle {
        LodStyle {
            grouped: self.preset.groups_lods(),
            wind: self.wind,
        }
    }
}

impl Job for Flags {
    fn stages(&self) -> Stages {
        &[("export", 85.0), ("atlas", 10.0), ("scene", 5.0)]
    }

    fn run(&self, session: &Session<'_>) -> Result<(), Failure> {
        let crowns = crown_folders(&self.library)?;
        if !crowns.is_empty() {
            let settings = &self.checked(session)?;
            let crowns = &crowns;
            return CrownExport { settings, crowns }.run(session);
        }
        let file = if self.library.is_dir() {
            self.library.join("library.json")
        } else {
            self.library.clone()
        };
        let library = LibraryRecord::read(&file)?;
        check_trees(&library.trees, &file)?;
        let settings = self.checked(session)?;
        let folder = file.parent().unwrap_or(Path::new("."));
        Export {
            settings: &settings,
            trees: &library.trees,
            folder,
        }
        .run(session)
    }
}

/// Fails for trees that are no plain files in the library's folder.
fn check_trees(trees: &[TreeRecord], file: &Path) -> Result<(), Failure> {
    if trees.is_empty() {
        return Err(Failure::of(file.display(), "lists no trees"));
    }
    let mut names = std::collections::BTreeSet::new();
    for tree in trees {
        if tree.name().contains(['/', '\\']) || tree.name().starts_with('.') {
            return Err(Failure::of(
                file.display(),
                format!("{}: lies outside the folder", tree.file),
            ));
        }
        if !names.insert(tree.name()) {
            return Err(Failure::of(
                file.display(),
                format!("{}: is listed twice", tree.file),
            ));
        }
    }
    Ok(())
}

impl Flags {
    fn checked(&self, session: &Session<'_>) -> Result<ExportSettings, Failure> {
        if !(0.01..=1000.0).contains(&self.height) {
            return Err(Failure::of("--height", "must be from 0.01 to 1000 metres"));
        }
        let preset = self.preset.preset();
        let mut textures = self.textures.clone();
        textures.push(TextureForm::Png);
        textures.sort();
        textures.dedup();
        let mut maps = if self.no_maps {
            Vec::new()
        } else {
            self.maps.clone()
        };
        maps.sort_by_key(|map| map.name());
        maps.dedup();
        if preset == Preset::Web && !maps.contains(&ExportMap::Depth) && !self.no_maps {
            // The gallery turns trees by their depth.
            maps.push(ExportMap::Depth);
        }
        let whole = session.options.shard.is_whole();
        if (self.atlas || preset == Preset::FlightGear) && !whole {
            let reason = "an atlas shows all trees; make it with --resume once all shards are done";
            return Err(Failure::of("--shard", reason));
        }
        Ok(ExportSettings {
            out: session.options.out()?.to_owned(),
            preset,
            sprite: SpriteSettings {
                height_m: self.height,
                power_of_two: !self.any_size,
            },
            planes: self.planes,
            maps,
            textures,
            blocks: self.blocks.format(),
            atlas: self.atlas,
            atlas_tree: self.atlas_tree,
            evergreen: self.evergreen,
            wind: if self.wind_colors {
                WindChannels::AttributeAndColors
            } else {
                WindChannels::Attribute
            },
            rights: LicenseRecord {
                author: self.author.clone(),
                license: self.license.clone(),
            },
            crowns: self.crowns()?,
        })
    }
}

impl Flags {
    fn crowns(&self) -> Result<CrownExportSettings, Failure> {
        /// Textures that every graphics card takes.
        const LARGEST_SIDE: u32 = 8192;
        if self.impostor_frames * self.impostor_frame > LARGEST_SIDE {
            let reason =
                format!("frames of that number and size are more than {LARGEST_SIDE} wide");
            return Err(Failure::of("--impostor-frame", reason));
        }
        let mut impostors = if self.no_impostors {
            Vec::new()
        } else {
            self.impostors.clone()
        };
        impostors.sort();
        impostors.dedup();
        Ok(CrownExportSettings {
            impostors,
            frames: self.impostor_frames,
            frame_px: self.impostor_frame,
            leaves: self.leaves,
            exr: self.exr,
        })
    }
}

/// A checked job.
struct Export<'a> {
    settings: &'a ExportSettings,
    trees: &'a [TreeRecord],
    folder: &'a Path,
}

impl Export<'_> {
    fn run(&self, session: &Session<'_>) -> Result<(), Failure> {
        let whole = session.options.shard.is_whole();
        self.check(whole, session)?;
        let indexed: Vec<(usize, &TreeRecord)> = self.trees.iter().enumerate().collect();
        let models = self.settings.preset.has_models();
        let made = items::made(session, "export", &indexed, |_, (index, tree)| {
            let is_sample = whole && models && *index < SAMPLES;
            export_tree(self.settings, self.folder, tree, is_sample, session)
        })?;
        let (records, samples) = parted(made.ready);
        let files = if whole {
            self.write_shared(&records, &samples, session)?
        } else {
            Files::new()
        };
        session.print_json(|| {
            let saved: f64 = records.iter().map(|tree| tree.cutout.overdraw_saved).sum();
            json!({
                "preset": self.settings.preset.name(),
                "trees": records.len(),
                "refused": made.refused.into_iter().map(|(_, reason)| reason).collect::<Vec<_>>(),
                "files": files,
                "overdraw_saved": saved / records.len().max(1) as f64,
                "seconds": session.seconds(),
            })
        })
    }

    /// Fails before the work when something is in the way.
    fn check(&self, whole: bool, session: &Session<'_>) -> Result<(), Failure> {
        let out = &self.settings.out;
        let ours = (0u64..)
            .zip(self.trees)
            .filter(|(i, _)| session.options.shard.contains(*i));
        for (_, tree) in ours {
            let files = tree_files(self.settings, tree.name());
            session
                .output
                .check(files.values().map(|file| out.join(file)))?;
        }
        if whole {
            session
                .output
                .check(self.shared_files().iter().map(|file| out.join(file)))?;
        }
        Ok(())
    }

    /// Files that belong to no single tree and whose names are known before the work.
    fn shared_files(&self) -> Vec<&'static str> {
        let mut files = shared_files(self.settings.preset);
        if self.settings.preset == Preset::FlightGear {
            files.extend(["trees.png", "trees-normal.png"]);
        }
        files
    }

    /// Atlas, sample scene, gallery, README and, last, `library.json`.
    fn write_shared(
        &self,
        records: &[PresetTree],
        samples: &[Sample],
        session: &Session<'_>,
    ) -> Result<Files, Failure> {
        let settings = self.settings;
        let mut files = Files::new();
        if settings.atlas {
            files.extend(write_atlas(settings, records, session)?);
        }
        if settings.preset == Preset::FlightGear {
            files.extend(write_flightgear(settings, records, session)?);
        }
        let stage = session.progress.stage("scene", 1);
        let lods = settings.preset.lods(settings.planes);
        let models: Vec<TreeModel<'_>> = samples.iter().map(|s| s.model(&lods)).collect();
        let widths = samples.iter().map(|sample| sample.sprite.size_m()[0]);
        let widest = widths.fold(0.0, f64::max);
        write_scene(settings, &models, widest, &mut files, session)?;
        let readme = settings.preset.readme();
        let files = write_library(settings, (records, &[]), readme, files, session)?;
        stage.advance();
        Ok(files)
    }
}

fn parted(ready: Vec<(usize, ExportedTree)>) -> (Vec<PresetTree>, Vec<Sample>) {
    let (mut records, mut samples) = (Vec::new(), Vec::new());
    for (_, tree) in ready {
        records.push(tree.record);
        samples.extend(tree.sample);
    }
    (records, samples)
}
