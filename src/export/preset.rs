//! Presets: how a library is laid out for one consumer.
//!
//! All presets hold the same trees; they differ in how files are called, which maps are packed, how
//! levels of detail are told, and what the README says.

use super::tree_model::Lod;

/// A consumer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Preset {
    /// Blender.
    Blender,
    /// Godot.
    Godot,
    /// Unity with a glTF importer.
    Unity,
    /// Unreal Engine.
    Unreal,
    /// A page that opens from disk.
    Web,
    /// FlightGear's tree atlas.
    FlightGear,
}

/// How loose textures are called and packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TextureStyle {
    /// `NAME_albedo`, `NAME_normal` (Y+), `NAME_ao`, `NAME_depth`, `NAME_translucency`.
    Plain,
    /// `T_NAME_D`, `T_NAME_N` (Y−, as Unreal reads loose files), `T_NAME_ORM`, `T_NAME_H`, `T_NAME_SSS`.
    Unreal,
}

impl TextureStyle {
    /// The file of `map` of tree `tree`, without ending.
    pub fn file(self, tree: &str, map: &str) -> String {
        match self {
            Self::Plain => format!("{tree}_{map}"),
            Self::Unreal => {
                let suffix = match map {
                    "albedo" => "D",
                    "normal" => "N",
                    "ao" => "ORM",
                    "depth" => "H",
                    "translucency" => "SSS",
                    other => other,
                };
                format!("T_{tree}_{suffix}")
            }
        }
    }
}

impl Preset {
    /// Its name on the command line and in `library.json`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Blender => "blender",
            Self::Godot => "godot",
            Self::Unity => "unity",
            Self::Unreal => "unreal",
            Self::Web => "web",
            Self::FlightGear => "flightgear",
        }
    }

    /// Levels of detail of a tree, whose finest crosses `planes` cut-outs.
    pub fn lods(self, planes: u32) -> Vec<Lod> {
        vec![Lod::CutOut(planes), Lod::Rectangle(2), Lod::Rectangle(1)]
    }

    /// Whether levels stand side by side, to be grouped by name.
    pub fn groups_lods(self) -> bool {
        matches!(self, Self::Unity)
    }

    /// Whether the consumer knows `EXT_mesh_gpu_instancing`.
    pub fn knows_instancing(self) -> bool {
        matches!(self, Self::Blender | Self::Web | Self::Unity)
    }

    /// Whether there are models at all.
    pub fn has_models(self) -> bool {
        self != Self::FlightGear
    }

    /// How loose textures are called.
    pub fn style(self) -> TextureStyle {
        match self {
            Self::Unreal => TextureStyle::Unreal,
            _ => TextureStyle::Plain,
        }
    }

    /// The model file of tree `tree`.
    pub fn model(self, tree: &str) -> String {
        match self {
            Self::Unreal => format!("models/SM_{tree}.glb"),
            _ => format!("models/{tree}.glb"),
        }
    }

    /// The README: three lines.
    pub fn readme(self) -> &'static str {
        match self {
            Self::Blender => {
                "File > Import > glTF 2.0: models/*.glb are the trees (origin at the foot, metres), scatter.glb a sample scene.\n\
                 Materials are ready (alpha clip at 0.5); textures/ holds the pictures. If crossed cards darken each other in Cycles, switch off Object > Visibility > Ray Visibility > Shadow.\n\
                 Wind weights are the vertex attribute _WIND: red edge flutter, green phase, blue sway.\n"
            }
            Self::Godot => {
                "Copy this folder into the project: models/*.glb import as scenes (origin at the foot, metres), scatter.glb as a sample.\n\
                 Leaves use alpha scissor at 0.5; loose textures are in textures/ (normal maps Y+).\n\
                 For many trees put the mesh of a model into a MultiMeshInstance3D; LOD1 and LOD2 are in the file's MSFT_lod.\n"
            }
            Self::Unity => {
                "Install the package com.unity.cloud.gltfast, then copy this folder into Assets: models/*.glb import as prefabs, children NAME_LOD0 to _LOD2.\n\
                 For loose textures set Alpha Is Transparency, Mip Maps Preserve Coverage and an alpha reference of 0.5.\n\
                 Wind weights are the attribute _WIND, or vertex colours if exported with --wind-colors.\n"
            }
            Self::Unreal => {
                "Drop models/SM_*.glb into the content browser (Interchange converts to Z-up centimetres, pivot at the foot).\n\
                 Loose textures: T_*_D colour, T_*_N normal (Y-), T_*_ORM occlusion, roughness and metal, T_*_H height, T_*_SSS light from behind.\n\
                 Set Mask Clip Value 0.5 and Preserve Coverage (alpha threshold 0.5) on T_*_D.\n"
            }
            Self::Web => {
                "Open index.html in a browser, from disk or from a server: all trees, to be turned with the mouse.\n\
                 models/*.glb and scatter.glb load in three.js, Babylon.js and model-viewer.\n\
                 Nothing here needs the network.\n"
            }
            Self::FlightGear => {
                "Copy trees.png and trees-normal.png into Textures/Trees of a scenery or of FGData, and name them as <tree-texture> and <normal-map> in a material.\n\
                 Columns are varieties (<tree-varieties> in library.json); rows are, from the top, summer, snowy summer, winter, snowy winter.\n\
                 tree-height-m and tree-width-m of each variety stand in library.json.\n"
            }
        }
    }

    /// The README of exported crowns: three lines.
    pub fn crown_readme(self) -> String {
        let models = match self {
            Self::Blender => {
                "File > Import > glTF 2.0: models/NAME.glb has leaf cards, models/NAME_surface.glb a closed surface; origin at the foot, metres. In Cycles set Light Paths > Transparent to 64: crowns are many clear layers."
            }
            Self::Godot => {
                "Copy this folder into the project: models/NAME.glb (leaf cards) and NAME_surface.glb (closed surface) import as scenes, origin at the foot, metres."
            }
            Self::Unity => {
                "Install com.unity.cloud.gltfast, then copy this folder into Assets: models/NAME.glb (leaf cards) and NAME_surface.glb import with children _LOD0 to _LOD3."
            }
            Self::Unreal => {
                "Drop models/SM_NAME.glb (leaf cards) and SM_NAME_surface.glb into the content browser; pivot at the foot."
            }
            Self::Web => {
                "Open index.html in a browser, from disk or from a server: all crowns, to be turned with the mouse. models/NAME.glb (leaf cards) and NAME_surface.glb load in three.js and Babylon.js."
            }
            Self::FlightGear => {
                "models/NAME.glb (leaf cards) and NAME_surface.glb (closed surface) load in three.js, Babylon.js and model-viewer; origin at the foot, metres."
            }
        };
        format!(
            "{models}\n\
             impostors/NAME_full and _hemisphere: octahedral impostors, albedo with alpha, and normals (tree's frame, n/2 + 1/2) with 1 - depth; shaders/ has samples for Godot and three.js, library.json their numbers.\n\
             cubemaps/NAME: colours (sRGB) and radii (metres) as KTX2 and PNG, faces +X -X +Y -Y +Z -Z as in Vulkan and glTF; crown.json tells the encoding.\n"
        )
    }

    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Blender,
        Self::Godot,
        Self::Unity,
        Self::Unreal,
        Self::Web,
        Self::FlightGear,
    ];
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_readme_has_three_lines_and_every_map_a_name_of_its_own() {
        for preset in Preset::ALL {
            assert_eq!(preset.readme().lines().count(), 3, "{preset:?}");
            assert_eq!(preset.crown_readme().lines().count(), 3, "{preset:?}");
            let maps = ["albedo", "normal", "ao", "depth", "translucency"];
            let mut files = maps.map(|map| preset.style().file("a", map));
            files.sort();
            assert!(files.windows(2).all(|pair| pair[0] != pair[1]));
        }
    }
}
