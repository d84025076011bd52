//! Exports: files that belong to no single tree.

use super::export::ExportSettings;
use super::failure::Failure;
use super::run::Run;
use crate::base::Seed;
use crate::export::{
    LodModel, Preset, PresetCrown, PresetLibrary, PresetTree, ScatterSettings, gallery_list,
    gallery_page, scattered,
};
use std::collections::BTreeMap;

/// Trees in the sample scene.
pub(crate) const SAMPLES: usize = 6;

/// Trees along a side of its ground.
const SCATTER_SIDE: u32 = 10;

/// The sample scene.
const SCENE: &str = "scatter.glb";

/// Lists of files by what they are.
pub(crate) type Files = BTreeMap<String, Vec<String>>;

/// Names of the files that this module writes.
pub(crate) fn shared_files(preset: Preset) -> Vec<&'static str> {
    let mut files = vec!["library.json", "README.txt"];
    if preset.has_models() {
        files.push(SCENE);
    }
    if preset == Preset::Web {
        files.extend(["index.html", "gallery.js"]);
    }
    files
}

/// Writes the sample scene of `models`, of which the widest is `widest_m` wide; none without models.
pub(crate) fn write_scene(
    settings: &ExportSettings,
    models: &[impl LodModel],
    widest_m: f64,
    files: &mut Files,
    session: &Run<'_>,
) -> Result<(), Failure> {
    session.cancel.check()?;
    if models.is_empty() {
        return Ok(());
    }
    let scatter = ScatterSettings {
        side: SCATTER_SIDE,
        spacing_m: 1.1 * widest_m,
        instanced: settings.preset.knows_instancing(),
        wind: settings.wind,
    };
    let (seed, copyright) = (Seed(session.seed), settings.rights.copyright());
    let scene = scattered(models, scatter, seed, copyright.as_deref())
        .map_err(|error| Failure::of(SCENE, error))?;
    session.output.write(&settings.out.join(SCENE), &scene)?;
    files.insert("scene".to_owned(), vec![SCENE.to_owned()]);
    Ok(())
}

/// Writes the gallery of the web preset, the README and, last, `library.json`.
pub(crate) fn write_library(
    settings: &ExportSettings,
    (trees, crowns): (&[PresetTree], &[PresetCrown]),
    readme: &str,
    mut files: Files,
    session: &Run<'_>,
) -> Result<Files, Failure> {
    session.cancel.check()?;
    let write = |file: &str, text: &str| {
        let path = settings.out.join(file);
        session.output.write(&path, text.as_bytes())
    };
    if settings.preset == Preset::Web {
        let title = settings.rights.copyright();
        let page = gallery_page(title.as_deref().unwrap_or("Trees"));
        write("index.html", &page)?;
        write("gallery.js", &gallery_list(trees, crowns))?;
        let names = ["index.html", "gallery.js"].map(str::to_owned);
        files.insert("gallery".to_owned(), names.to_vec());
    }
    write("README.txt", readme)?;
    let (name, rights) = (settings.preset.name(), settings.rights.clone());
    let mut library = PresetLibrary::new(name, rights, trees.to_vec(), files.clone());
    library.crowns = crowns.to_vec();
    write("library.json", &library.to_json())?;
    Ok(files)
}
