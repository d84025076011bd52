//! A library of trees → a folder that a consumer takes as it is: what `boscage export` and the
//! studio's export do.

use super::export_crown::CrownExportSettings;
use super::export_pages::{write_atlas, write_flightgear};
use super::export_shared::{Files, SAMPLES, shared_files, write_library, write_scene};
use super::export_tree::{
    ExportMap, ExportedTree, ModelTextures, Sample, TextureForm, export_tree, tree_files,
};
use super::failure::Failure;
use super::items;
use super::records::TreeRecord;
use super::run::Run;
use crate::export::{
    BlockFormat, LicenseRecord, LodStyle, Preset, PresetTree, SpriteSettings, TreeModel,
    WindChannels,
};
use std::path::{Path, PathBuf};

/// A checked job's settings.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ExportSettings {
    pub(crate) out: PathBuf,
    pub(crate) preset: Preset,
    pub(crate) sprite: SpriteSettings,
    pub(crate) planes: u32,
    pub(crate) maps: Vec<ExportMap>,
    pub(crate) textures: Vec<TextureForm>,
    pub(crate) model_textures: ModelTextures,
    pub(crate) blocks: BlockFormat,
    pub(crate) atlas: bool,
    pub(crate) atlas_tree: u32,
    pub(crate) evergreen: bool,
    pub(crate) wind: WindChannels,
    pub(crate) rights: LicenseRecord,
    pub(crate) crowns: CrownExportSettings,
}

impl ExportSettings {
    /// How levels of detail and wind are told to the consumer.
    pub(crate) fn lod_style(&self) -> LodStyle {
        LodStyle {
            grouped: self.preset.groups_lods(),
            wind: self.wind,
        }
    }
}

/// Fails for trees that are no plain files in the library's folder.
pub(crate) fn check_trees(trees: &[TreeRecord], file: &Path) -> Result<(), Failure> {
    if trees.is_empty() {
        return Err(Failure::of(file.display(), "lists no trees"));
    }
    let mut names = std::collections::BTreeSet::new();
    for tree in trees {
        if !tree.is_in_folder() {
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

/// What was exported.
pub(crate) struct Exported {
    pub(crate) records: Vec<PresetTree>,
    /// Why trees were left out.
    pub(crate) refused: Vec<String>,
    /// Files that belong to no single tree, by what they are.
    pub(crate) files: Files,
}

/// A checked job.
pub(crate) struct Export<'a> {
    pub(crate) settings: &'a ExportSettings,
    pub(crate) trees: &'a [TreeRecord],
    /// Where their pictures lie.
    pub(crate) folder: &'a Path,
}

impl Export<'_> {
    /// Makes the trees of this shard and, when that is all of them, what they share.
    pub(crate) fn run(&self, session: &Run<'_>) -> Result<Exported, Failure> {
        let whole = session.shard.is_whole();
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
        Ok(Exported {
            records,
            refused: made.refused.into_iter().map(|(_, reason)| reason).collect(),
            files,
        })
    }

    /// Fails before the work when something is in the way.
    fn check(&self, whole: bool, session: &Run<'_>) -> Result<(), Failure> {
        let out = &self.settings.out;
        let ours = (0u64..)
            .zip(self.trees)
            .filter(|(i, _)| session.shard.contains(*i));
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
        session: &Run<'_>,
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
