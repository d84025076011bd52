//! `boscage export`: crowns → models, impostors and cubemaps.

use super::export::ExportSettings;
use super::export_shared::{Files, SAMPLES, shared_files, write_library, write_scene};
use super::export_tree::ModelTextures;
use super::failure::Failure;
use super::input::read_crown_and_record;
use super::items;
use super::output::recipe;
use super::run::Run;
use crate::base::{Digest, Seed};
use crate::branches::leaf_name::LeafName;
use crate::export::{
    CrownModel, CrownRecord, Impostor, ImpostorForm, ImpostorRecord, ImpostorSettings, Preset,
    PresetCrown, crown_files, encode_exr_colors, encode_exr_values, encode_ktx2_colors,
    encode_ktx2_radii, gallery_crown, godot_shader, impostor, leaf_model, lod_glb, portrait,
    surface_model, three_module,
};
use crate::raster::{Compression, CubeFace, encode_png};
use crate::scene::Crown;
use clap::ValueEnum;
use clap::builder::PossibleValue;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The file of a crown's cubemaps that is written last and carries the recipe of all.
const LAST: &str = "color_px.png";

/// Directions of an impostor's frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum ImpostorName {
    /// From all around
    Full,
    /// From the horizon and above
    Hemisphere,
}

/// The leaves that the crown of `record` was made for.
pub(crate) fn leaf_of(record: &CrownRecord) -> LeafName {
    let named = record.recipe.get("leaf");
    let known = named.and_then(|leaf| LeafName::deserialize(leaf).ok());
    known.unwrap_or_default()
}

impl ValueEnum for LeafName {
    fn value_variants<'a>() -> &'a [Self] {
        &Self::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let (name, help) = match self {
            Self::Ovate => ("ovate", "Egg-shaped: birch, apple"),
            Self::Round => ("round", "Nearly round: aspen, lime"),
            Self::Lobed => ("lobed", "Wavy lobes: oak"),
            Self::Palmate => ("palmate", "Pointed fingers: maple"),
            Self::Lance => ("lance", "Long and narrow: willow"),
            Self::Brush => ("brush", "Short needles: yew, juniper"),
            Self::Tuft => ("tuft", "Long needles: pine"),
            Self::Frond => ("frond", "Feathered, from the middle to the edge: palm"),
            Self::Bough => ("bough", "Boughs in tiers: spruce, fir"),
        };
        Some(PossibleValue::new(name).help(help))
    }
}

/// What is made of crowns alone.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CrownExportSettings {
    pub(crate) impostors: Vec<ImpostorName>,
    pub(crate) frames: u32,
    pub(crate) frame_px: u32,
    /// Shape of the leaves; none: the one that the crown's record names.
    pub(crate) leaves: Option<LeafName>,
    /// Whether faces are written as OpenEXR, too.
    pub(crate) exr: bool,
}

/// A crown that was exported.
struct ExportedCrown {
    record: PresetCrown,
    /// Kept of crowns that the sample scene shows.
    sample: Option<CrownModel>,
}

/// Side of the picture of a crown in the gallery's list.
const THUMBNAIL_PX: u32 = 192;

/// The crowns that `path` names: itself, or the folders in it that have a record; none when it holds
/// something else.
///
/// # Errors
/// [`Failure`] when the folder cannot be listed or a name is not text.
pub(crate) fn crown_folders(path: &Path) -> Result<Vec<(String, PathBuf)>, Failure> {
    let is_crown = |folder: &Path| folder.join(crate::export::CROWN_RECORD).is_file();
    let named = |folder: PathBuf| {
        let whole = folder.canonicalize().unwrap_or_else(|_| folder.clone());
        let name = whole.file_name().and_then(|name| name.to_str());
        match name {
            Some(name) => Ok((name.to_owned(), folder)),
            None => Err(Failure::of(folder.display(), "its name is no text")),
        }
    };
    if is_crown(path) {
        return Ok(vec![named(path.to_owned())?]);
    }
    if !path.is_dir() || path.join("library.json").is_file() {
        return Ok(Vec::new());
    }
    let failed = |error: std::io::Error| Failure::of(path.display(), error);
    let mut folders = Vec::new();
    for entry in std::fs::read_dir(path).map_err(failed)? {
        let folder = entry.map_err(failed)?.path();
        if is_crown(&folder) {
            folders.push(named(folder)?);
        }
    }
    folders.sort();
    Ok(folders)
}

/// Refuses presets whose reader knows no crowns.
///
/// # Errors
/// [`Failure::BadInput`].
pub(crate) fn check_preset(preset: Preset) -> Result<(), Failure> {
    if preset == Preset::FlightGear {
        let reason = "flightgear draws trees from pictures; export a library of them";
        return Err(Failure::of("--preset", reason));
    }
    Ok(())
}

/// What was exported.
pub(crate) struct ExportedCrowns {
    pub(crate) records: Vec<PresetCrown>,
    /// Why crowns were left out.
    pub(crate) refused: Vec<String>,
}

/// A checked job on crowns.
pub(crate) struct CrownExport<'a> {
    pub(crate) settings: &'a ExportSettings,
    pub(crate) crowns: &'a [(String, PathBuf)],
}

impl CrownExport<'_> {
    /// Makes the crowns of this shard and, when that is all of them, what they share.
    pub(crate) fn run(&self, session: &Run<'_>) -> Result<ExportedCrowns, Failure> {
        let out = &self.settings.out;
        check_preset(self.settings.preset)?;
        let whole = session.shard.is_whole();
        let ours = (0u64..)
            .zip(self.crowns)
            .filter(|(i, _)| session.shard.contains(*i));
        for (_, (name, _)) in ours {
            let files = self.files(name);
            session
                .output
                .check(files.values().map(|file| out.join(file)))?;
        }
        if whole {
            let shared = shared_files(self.settings.preset).into_iter();
            let files = shared.chain(shaders().map(|(file, _)| file));
            session.output.check(files.map(|file| out.join(file)))?;
        }
        let indexed: Vec<(usize, &(String, PathBuf))> = self.crowns.iter().enumerate().collect();
        let made = items::made(session, "export", &indexed, |_, (index, (name, folder))| {
            self.export_crown(name, folder, whole && *index < SAMPLES, session)
        })?;
        let (mut records, mut samples) = (Vec::new(), Vec::new());
        for (_, crown) in made.ready {
            records.push(crown.record);
            samples.extend(crown.sample);
        }
        if whole {
            self.write_shared(&records, &samples, session)?;
        }
        Ok(ExportedCrowns {
            records,
            refused: made.refused.into_iter().map(|(_, reason)| reason).collect(),
        })
    }

    /// Names and places of a crown's files, by what they are.
    fn files(&self, name: &str) -> BTreeMap<String, String> {
        let preset = self.settings.preset;
        let mut files = BTreeMap::new();
        let mut add = |key: &str, file: String| files.insert(key.to_owned(), file);
        add("model", preset.model(name));
        add("surface", preset.model(&format!("{name}_surface")));
        for form in &self.settings.crowns.impostors {
            let form = form.form().name();
            let file = |map: &str| format!("impostors/{name}_{form}_{map}.png");
            add(&format!("impostor_{form}"), file("albedo"));
            add(&format!("impostor_{form}_normal"), file("normal"));
        }
        add("colors", format!("cubemaps/{name}/color.ktx2"));
        add("radii", format!("cubemaps/{name}/radius.ktx2"));
        for file in cubemap_files() {
            let key = file.trim_end_matches(".png").trim_end_matches(".json");
            add(&format!("cubemap_{key}"), format!("cubemaps/{name}/{file}"));
        }
        if self.settings.crowns.exr {
            for file in exr_names() {
                add(
                    &format!("cubemap_{file}_exr"),
                    format!("cubemaps/{name}/{file}.exr"),
                );
            }
        }
        if preset == Preset::Web {
            add("gallery", format!("gallery/{name}.js"));
            add("thumbnail", format!("gallery/{name}.png"));
        }
        files
    }

    fn export_crown(
        &self,
        name: &str,
        folder: &Path,
        is_sample: bool,
        session: &Run<'_>,
    ) -> Result<ExportedCrown, Failure> {
        let settings = self.settings;
        let out = &settings.out;
        let (crown, record, digest) = read_crown_and_record(folder)?;
        let leaves = settings.crowns.leaves;
        let leaves = leaves.unwrap_or_else(|| leaf_of(&record));
        let made_from = self.recipe(name, (digest, leaves), session);
        let files = self.files(name);
        let last = out.join(format!("cubemaps/{name}/{LAST}"));
        let is_ready = session.output.is_ready(&last, made_from)
            && files.values().all(|file| out.join(file).is_file());
        let seed = Seed(session.seed);
        let mut leaves = leaf_model(&crown, name, leaves, seed);
        session.cancel.check()?;
        let mut surface = surface_model(&crown, &format!("{name}_surface"));
        session.cancel.check()?;
        if !is_ready {
            session.output.outdate(&last)?;
        }
        let mut impostors = Vec::new();
        for form in &settings.crowns.impostors {
            let wanted = settings.crowns.impostor(form.form());
            if is_ready {
                impostors.push(wanted.record(&leaves));
                continue;
            }
            let made = impostor(&leaves, &wanted, || (), session.cancel)?;
            self.write_impostor(&made, form.form().name(), &files, session)?;
            impostors.push(wanted.record(&leaves));
        }
        if !is_ready
            && let (Some(script), Some(picture)) = (files.get("gallery"), files.get("thumbnail"))
        {
            // Its page reads PNG alone.
            let model = self.glb(&leaves)?;
            self.write(script, gallery_crown(name, &model).as_bytes(), session)?;
            let portrait = portrait(&leaves, THUMBNAIL_PX, session.cancel)?;
            let png = encode_png(&portrait, Compression::Small);
            self.write(picture, &png, session)?;
        }
        if settings.model_textures == ModelTextures::Basisu {
            leaves.pack_pictures(session.cancel)?;
            surface.pack_pictures(session.cancel)?;
        }
        if !is_ready {
            self.write(&files["model"], &self.glb(&leaves)?, session)?;
            self.write(&files["surface"], &self.glb(&surface)?, session)?;
            self.write_exr(&crown, &files, session)?;
            self.write_cubemaps(&crown, &record, &files, made_from, session)?;
        }
        let record = crown_record(name, &crown, record, files, &leaves, &surface, impostors);
        Ok(ExportedCrown {
            record,
            sample: is_sample.then_some(leaves),
        })
    }

    fn write(&self, file: &str, bytes: &[u8], session: &Run<'_>) -> Result<(), Failure> {
        session.cancel.check()?;
        session.output.write(&self.settings.out.join(file), bytes)
    }

    fn write_impostor(
        &self,
        made: &Impostor,
        form: &str,
        files: &BTreeMap<String, String>,
        session: &Run<'_>,
    ) -> Result<(), Failure> {
        let key = format!("impostor_{form}");
        for (key, picture) in [
            (key.clone(), &made.albedo),
            (key + "_normal", &made.normal_depth),
        ] {
            self.write(
                &files[&key],
                &encode_png(picture, Compression::Small),
                session,
            )?;
        }
        Ok(())
    }

    /// Faces as OpenEXR, if they are asked for.
    fn write_exr(
        &self,
        crown: &Crown,
        files: &BTreeMap<String, String>,
        session: &Run<'_>,
    ) -> Result<(), Failure> {
        for face in CubeFace::ALL {
            let faces = [
                ("color", encode_exr_colors(crown.color.face(face))),
                ("radius", encode_exr_values(crown.radius_m.face(face))),
            ];
            for (kind, bytes) in faces {
                let key = format!("cubemap_{kind}_{}_exr", face.name());
                if let Some(file) = files.get(&key) {
                    self.write(file, &bytes, session)?;
                }
            }
        }
        Ok(())
    }

    /// KTX2 and PNG faces with their record, [`LAST`] last.
    fn write_cubemaps(
        &self,
        crown: &Crown,
        record: &CrownRecord,
        files: &BTreeMap<String, String>,
        made_from: Digest,
        session: &Run<'_>,
    ) -> Result<(), Failure> {
        let colors = encode_ktx2_colors(&crown.color, session.cancel)?;
        self.write(&files["colors"], &colors, session)?;
        self.write(
            &files["radii"],
            &encode_ktx2_radii(&crown.radius_m),
            session,
        )?;
        let made = crown_files(crown, record.recipe.clone(), session.cancel)
            .map_err(|error| Failure::of_crown_files("crown", &error))?;
        let wanted = cubemap_files();
        let folder = self.settings.out.join(&files["colors"]);
        let folder = folder.parent().unwrap_or(&self.settings.out);
        let mut last = None;
        for (file, bytes) in made.into_iter().filter(|(file, _)| wanted.contains(file)) {
            session.cancel.check()?;
            if file == LAST {
                last = Some(bytes);
            } else {
                session.output.write(&folder.join(file), &bytes)?;
            }
        }
        let last = last.unwrap_or_else(|| unreachable!("a cubemap has a first face"));
        session
            .output
            .write_item(&folder.join(LAST), last, made_from)
    }

    fn glb(&self, model: &CrownModel) -> Result<Vec<u8>, Failure> {
        let copyright = self.settings.rights.copyright();
        lod_glb(model, self.settings.lod_style(), copyright.as_deref())
            .map_err(|error| Failure::of(&model.name, error))
    }

    /// Sample shaders and scene, gallery, README and, last, `library.json`.
    fn write_shared(
        &self,
        records: &[PresetCrown],
        samples: &[CrownModel],
        session: &Run<'_>,
    ) -> Result<(), Failure> {
        let stage = session.progress.stage("scene", 1);
        let mut files = Files::new();
        for (file, text) in shaders() {
            self.write(file, text.as_bytes(), session)?;
            let key = file.rsplit('.').next().unwrap_or_default();
            files.insert(format!("impostor_{key}"), vec![file.to_owned()]);
        }
        let widths = records.iter().map(|crown| crown.size_m[0]);
        let widest = widths.fold(0.0, f64::max);
        write_scene(self.settings, samples, widest, &mut files, session)?;
        let readme = self.settings.preset.crown_readme();
        write_library(self.settings, (&[], records), &readme, files, session)?;
        stage.advance();
        Ok(())
    }

    /// The digest of all that a crown's files are made from.
    fn recipe(&self, name: &str, (crown, leaves): (Digest, LeafName), session: &Run<'_>) -> Digest {
        let settings = self.settings;
        let crowns = CrownExportSettings {
            leaves: Some(leaves),
            ..settings.crowns.clone()
        };
        let told = format!(
            "{name} {:?} {crowns:?} {:?} {:?} {:?}",
            settings.preset, settings.model_textures, settings.wind, settings.rights
        );
        recipe("export crown")
            .with(crown.bytes())
            .with(&session.seed.to_le_bytes())
            .with(told.as_bytes())
            .finish()
    }
}

impl ImpostorName {
    fn form(self) -> ImpostorForm {
        match self {
            Self::Full => ImpostorForm::Full,
            Self::Hemisphere => ImpostorForm::Hemisphere,
        }
    }
}

impl CrownExportSettings {
    fn impostor(&self, form: ImpostorForm) -> ImpostorSettings {
        ImpostorSettings {
            form,
            frames: self.frames,
            frame_px: self.frame_px,
        }
    }
}

/// Sample shaders of impostors, with their text.
fn shaders() -> [(&'static str, &'static str); 2] {
    [
        ("shaders/impostor.gdshader", godot_shader()),
        ("shaders/impostor.js", three_module()),
    ]
}

/// The files of a crown's folder that are exported as they are: all faces, and the record.
fn cubemap_files() -> Vec<String> {
    let names = crate::export::crown_file_names().into_iter();
    names
        .filter(|name| name.ends_with(".png") || name.ends_with(".json"))
        .collect()
}

/// Names of the faces that are written as OpenEXR, without ending.
fn exr_names() -> Vec<String> {
    let kinds = ["color", "radius"].into_iter();
    kinds
        .flat_map(|kind| CubeFace::ALL.map(|face| format!("{kind}_{}", face.name())))
        .collect()
}

fn crown_record(
    name: &str,
    crown: &Crown,
    record: CrownRecord,
    files: BTreeMap<String, String>,
    leaves: &CrownModel,
    surface: &CrownModel,
    impostors: Vec<ImpostorRecord>,
) -> PresetCrown {
    let [low, high] = leaves.bounds_m();
    let foot = crate::scene::Trunk::under(crown).base_m;
    PresetCrown {
        name: name.to_owned(),
        files,
        size_m: (high - low).to_array(),
        leaf_triangles: leaves.triangles(),
        surface_triangles: surface.triangles(),
        impostors,
        cubemap_center_m: (crown.center_m - foot).to_array(),
        recipe: record.recipe,
    }
}
