//! A library of trees → a folder that a consumer takes as it is: what `boscage export` and the
//! studio's export do.

use super::export_crown::CrownExportSettings;
use super::export_pages::{write_atlas, write_flightgear};
use super::export_tree::{ExportMap, ExportedTree, Sample, TextureForm, export_tree, tree_files};
use super::failure::Failure;
use super::items;
use super::records::TreeRecord;
use super::run::Run;
use crate::base::Seed;
use crate::export::{
    BlockFormat, LicenseRecord, Preset, PresetLibrary, PresetTree, ScatterSettings, SpriteSettings,
    TreeModel, WindChannels, gallery_list, gallery_page, scattered,
};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Trees in the sample scene, and the sides of its ground.
const SAMPLES: usize = 6;
const SCATTER_SIDE: u32 = 10;

/// A checked job's settings.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ExportSettings {
    pub(crate) out: PathBuf,
    pub(crate) preset: Preset,
    pub(crate) sprite: SpriteSettings,
    pub(crate) planes: u32,
    pub(crate) maps: Vec<ExportMap>,
    pub(crate) textures: Vec<TextureForm>,
    pub(crate) blocks: BlockFormat,
    pub(crate) atlas: bool,
    pub(crate) atlas_tree: u32,
    pub(crate) evergreen: bool,
    pub(crate) wind: WindChannels,
    pub(crate) rights: LicenseRecord,
    pub(crate) crowns: CrownExportSettings,
}

/// Fails for trees that are no plain files in the library's folder.
pub(crate) fn check_trees(trees: &[TreeRecord], file: &Path) -> Result<(), Failure> {
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

/// What was exported.
pub(crate) struct Exported {
    pub(crate) records: Vec<PresetTree>,
    /// Why trees were left out.
    pub(crate) refused: Vec<String>,
    /// Files that belong to no single tree, by what they are.
    pub(crate) files: BTreeMap<String, Vec<String>>,
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
            BTreeMap::new()
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
        let mut files = vec!["library.json", "README.txt"];
        match self.settings.preset {
            Preset::FlightGear => files.extend(["trees.png", "trees-normal.png"]),
            Preset::Web => files.extend(["scatter.glb", "index.html", "gallery.js"]),
            _ => files.push("scatter.glb"),
        }
        files
    }

    /// Atlas, sample scene, gallery, README and, last, `library.json`.
    fn write_shared(
        &self,
        records: &[PresetTree],
        samples: &[Sample],
        session: &Run<'_>,
    ) -> Result<BTreeMap<String, Vec<String>>, Failure> {
        let settings = self.settings;
        let mut files = BTreeMap::new();
        if settings.atlas {
            files.extend(write_atlas(settings, records, session)?);
        }
        if settings.preset == Preset::FlightGear {
            files.extend(write_flightgear(settings, records, session)?);
        }
        let stage = session.progress.stage("scene", 1);
        if !samples.is_empty() {
            let scene = self.scene(samples, session);
            session
                .output
                .write(&settings.out.join("scatter.glb"), &scene)?;
            files.insert("scene".to_owned(), vec!["scatter.glb".to_owned()]);
        }
        session.cancel.check()?;
        if settings.preset == Preset::Web {
            let title = settings.rights.copyright();
            let page = gallery_page(title.as_deref().unwrap_or("Trees"));
            session
                .output
                .write(&settings.out.join("index.html"), page.as_bytes())?;
            let list = gallery_list(records);
            session
                .output
                .write(&settings.out.join("gallery.js"), list.as_bytes())?;
            let names = ["index.html", "gallery.js"].map(str::to_owned);
            files.insert("gallery".to_owned(), names.to_vec());
        }
        let readme = settings.preset.readme();
        session
            .output
            .write(&settings.out.join("README.txt"), readme.as_bytes())?;
        let library = PresetLibrary::new(
            settings.preset.name(),
            settings.rights.clone(),
            records.to_vec(),
            files.clone(),
        );
        let json = library.to_json();
        session
            .output
            .write(&settings.out.join("library.json"), json.as_bytes())?;
        stage.advance();
        Ok(files)
    }

    fn scene(&self, samples: &[Sample], session: &Run<'_>) -> Vec<u8> {
        let settings = self.settings;
        let lods = settings.preset.lods(settings.planes);
        let models: Vec<TreeModel<'_>> = samples
            .iter()
            .map(|sample| sample.model(settings, &lods))
            .collect();
        let widest = samples
            .iter()
            .map(|sample| sample.sprite.size_m()[0])
            .fold(0.0, f64::max);
        let scatter = ScatterSettings {
            side: SCATTER_SIDE,
            spacing_m: 1.1 * widest,
            instanced: settings.preset.knows_instancing(),
        };
        let seed = Seed(session.seed);
        scattered(
            &models,
            scatter,
            seed,
            settings.rights.copyright().as_deref(),
        )
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
