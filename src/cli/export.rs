//! `boscage export`: a library of trees, crowns, or a project → a folder that a consumer takes as it is.

use super::failure::Failure;
use super::records::LibraryRecord;
use super::session::Session;
use super::{Job, Stages};
use crate::batch::export::{Export, ExportSettings, check_trees};
use crate::batch::export_crown::{
    CrownExport, CrownExportSettings, ImpostorName, check_preset, crown_folders,
};
use crate::batch::export_tree::{BlockName, ExportMap, ModelTextures, TextureForm};
use crate::batch::project_crowns::{ProjectCrowns, crowned};
use crate::branches::leaf_name::LeafName;
use crate::document::store::{self, StoreError};
use crate::export::{LicenseRecord, Preset, SpriteSettings, WindChannels};
use clap::{Args, ValueEnum};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Write a library or crowns for an engine
///
/// Takes the folder that `boscage vary` wrote. Pictures are trimmed and their colour is continued
/// under clear pixels; models stand on their foot in metres; library.json tells all about each tree.
///
/// Or takes the folder that `boscage crown` wrote, or a folder of such: leaf-card and surface models
/// with levels of detail, octahedral impostors with shaders, and cubemaps. Of a project (.boscage) all
/// crowns are made first, into OUT/crowns.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  boscage export new --preset godot --out game/trees
  boscage export new --preset unreal --textures png,dds --atlas --out Content/Trees
  boscage export oak-crown --preset godot --leaves lobed --out game/oak
  boscage export trees.boscage --preset blender --out crowns
  boscage export new --preset web --author 'A. Author' --license CC-BY-4.0 --out gallery")]
pub(super) struct Flags {
    /// Folder with library.json, or that file; the folder of a crown, or one of crowns; or a project
    #[arg(value_name = "PROJECT|LIBRARY")]
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
    /// Pictures inside models
    #[arg(long, value_enum, default_value_t, value_name = "FORM")]
    model_textures: ModelTextures,
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
    /// Crowns: shape of the leaves on cards [default: the crown's own]
    #[arg(long, value_enum, value_name = "SHAPE")]
    leaves: Option<LeafName>,
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

/// Whether `path` names the file of a project.
fn is_project(path: &Path) -> bool {
    path.extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("boscage"))
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

impl Job for Flags {
    fn stages(&self) -> Stages {
        match is_project(&self.library) {
            true => &[("make crowns", 70.0), ("export", 25.0), ("scene", 5.0)],
            false => &[("export", 85.0), ("atlas", 10.0), ("scene", 5.0)],
        }
    }

    fn run(&self, session: &Session<'_>) -> Result<(), Failure> {
        if is_project(&self.library) {
            let settings = self.checked(session)?;
            let crowns = self.project_crowns(&settings, session)?;
            return export_crowns(&settings, &crowns, session);
        }
        let crowns = crown_folders(&self.library)?;
        if !crowns.is_empty() {
            return export_crowns(&self.checked(session)?, &crowns, session);
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
        let export = Export {
            settings: &settings,
            trees: &library.trees,
            folder,
        };
        let made = export.run(session)?;
        session.print_json(|| {
            let trees = &made.records;
            let saved: f64 = trees.iter().map(|tree| tree.cutout.overdraw_saved).sum();
            json!({
                "preset": settings.preset.name(),
                "trees": trees.len(),
                "refused": made.refused,
                "files": made.files,
                "overdraw_saved": saved / trees.len().max(1) as f64,
                "seconds": session.seconds(),
            })
        })
    }
}

/// Exports crowns that lie in folders, and tells of them.
fn export_crowns(
    settings: &ExportSettings,
    crowns: &[(String, PathBuf)],
    session: &Session<'_>,
) -> Result<(), Failure> {
    let made = CrownExport { settings, crowns }.run(session)?;
    session.print_json(|| {
        json!({
            "preset": settings.preset.name(),
            "crowns": made.records,
            "refused": made.refused,
            "seconds": session.seconds(),
        })
    })
}

impl Flags {
    /// Makes the crowns of a project.
    fn project_crowns(
        &self,
        settings: &ExportSettings,
        session: &Session<'_>,
    ) -> Result<Vec<(String, PathBuf)>, Failure> {
        check_preset(settings.preset)?;
        let failed = |error: StoreError| match error {
            StoreError::File(error) => error.into(),
            error => Failure::BadInput(error.to_string()),
        };
        let (decoded, _) = store::open(&self.library).map_err(failed)?;
        for note in &decoded.notes {
            session
                .progress
                .warn(&format!("{}: {note}", self.library.display()));
        }
        let project = &decoded.document;
        let crowns = ProjectCrowns::of(project, &crowned(project.state()), self.leaves);
        if crowns.is_empty() {
            let reason = "has no crown: paint one in the studio, or export a library of trees";
            return Err(Failure::of(self.library.display(), reason));
        }
        crowns.make(&settings.out, session)
    }

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
            model_textures: self.model_textures,
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
            crowns: self.crown_settings()?,
        })
    }
}

impl Flags {
    fn crown_settings(&self) -> Result<CrownExportSettings, Failure> {
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
