//! `boscage inflate`: a mask becomes a base mesh.

use super::failure::Failure;
use super::input::{PictureFile, coverage};
use super::output::recipe;
use super::regions::{Region, from_json, region_masks, regions_from, usual_k};
use super::session::Session;
use super::{Job, Stages};
use crate::base::Digest;
use crate::crown::{
    BaseMeshError, Crossing, DistanceShape, Envelope, IterativeSettings, Method, PRESETS, Profile,
    SubCrown, Tangent, base_mesh, copies_merged, crown_center, envelope, into_world, star_cells,
    sub_crowns_merged,
};
use crate::export::{Glb, Material, ModelMesh, obj};
use crate::geometry::{Mesh, Topology};
use crate::raster::{Image, Mask, Premultiplied, Rect, Straight, opaque_bounds, resized};
use clap::{Args, ValueEnum};
use glam::DVec3;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Linear colour of an exported mesh: the green of foliage in the shade.
const FOLIAGE: [f32; 4] = [0.10, 0.19, 0.05, 1.0];

/// Blow up the mask of a crown into a closed mesh
///
/// A pixel belongs to the crown when its grey is 128 or more or, in a picture with clear pixels, when
/// its alpha is. The mask is scaled so that its longer side has --size pixels. An .obj file is in
/// pixels of that mask, y down: its first vertices are the mask's pixels by rows, front side. A .glb
/// file is in metres, upright, standing on the ground.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  boscage inflate oak.mask.png --out oak.obj
  boscage inflate pine.mask.png --k '1+4*j' --height 18 --out pine.glb --json
  boscage inflate ash.mask.png --envelope --copies 3 --out ash.glb
  boscage inflate clumps.png --regions clumps.json --out clumps.glb
with clumps.json: {\"regions\":[{\"label\":100,\"k\":2},{\"label\":200,\"k\":\"1+j\",\"depth_px\":20}]}")]
pub(super) struct Flags {
    /// The mask
    mask: PathBuf,
    /// How it becomes a body
    #[arg(long, value_enum, default_value_t, value_name = "NAME")]
    method: MethodName,
    /// How steeply the crown leaves its silhouette: a number or a formula in i and j, 0 … 1 from left
    /// and top of the crown [default: 2]
    #[arg(long, value_name = "EXPR", allow_hyphen_values = true)]
    k: Option<String>,
    /// A named formula for --k
    #[arg(long, value_name = "NAME", value_parser = presets(), conflicts_with = "k")]
    preset: Option<String>,
    /// A curve along the silhouette for --k: {"components":[[[t,k],…],…]}, t from 0 to 1 from the
    /// bottom, counter-clockwise
    #[arg(long, value_name = "FILE.json", conflicts_with_all = ["k", "preset"])]
    profile: Option<PathBuf>,
    /// Pixels along the longer side of the mask
    #[arg(long, default_value_t = 256, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(1..=4096))]
    size: u32,
    /// Copies turned about the vertical axis and merged
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64))]
    copies: u32,
    /// Which crossing of the silhouette the radial method takes
    #[arg(long, value_enum, default_value_t, value_name = "WHICH")]
    crossing: CrossingName,
    /// Regions of the mask, by their grey values, each with its own k and depth
    #[arg(long, value_name = "FILE.json", conflicts_with_all = ["k", "preset", "profile", "envelope"])]
    regions: Option<PathBuf>,
    /// Inflate the crown's envelope instead of its mask: gaps, bays and loose twigs go, which would
    /// keep the crown flat; the mask is cropped to it
    #[arg(long)]
    envelope: bool,
    /// Height of the crown in a .glb file, metres
    #[arg(long, default_value_t = 10.0, value_name = "M")]
    height: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum MethodName {
    /// A thin plate bent at the silhouette, solved directly
    #[default]
    Bilaplacian,
    /// The silhouette turned about the vertical axis
    Radial,
    /// The distance to the silhouette as height
    Distance,
    /// A sine of the distance to the silhouette
    DistanceSine,
    /// The thin plate by 2000 steps of smoothing
    Iterative,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum CrossingName {
    /// Nothing outside the mask is added
    First,
    /// Nothing inside the mask is lost
    #[default]
    Last,
}

fn presets() -> clap::builder::PossibleValuesParser {
    PRESETS
        .map(|preset| {
            clap::builder::PossibleValue::new(preset.name)
                .help(format!("{}: {}", preset.formula, preset.about))
        })
        .into()
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Obj,
    Glb,
}

impl Job for Flags {
    fn stages(&self) -> Stages {
        &[
            ("read", 1.0),
            ("assemble", 1.0),
            ("factor", 5.0),
            ("solve", 2.0),
            ("surface", 1.0),
            ("merge", 1.0),
            ("write", 2.0),
        ]
    }

    fn run(&self, session: &Session<'_>) -> Result<(), Failure> {
        let out = session.options.out()?;
        let format = format_of(out)?;
        if !session.options.shard.contains(0) {
            return session.print_json(|| json!({"output": null, "seconds": session.seconds()}));
        }
        session.output.check([out])?;
        let crown = self.crown(session)?;
        let made = self.made(&crown, session)?;
        let topology = Topology::of(&made.mesh);
        let stage = session.progress.stage("write", 1);
        let bytes = self.file(&made.mesh, made.bounds, format)?;
        session.cancel.check()?;
        session.output.write_item(out, bytes, crown.recipe)?;
        stage.advance();
        drop(stage);
        session.print_json(|| self.description(&made, &topology, out, session))
    }
}

/// What is inflated.
struct Crown {
    shape: Shape,
    /// Of all inputs and settings.
    recipe: Digest,
}

enum Shape {
    Whole(Mask, Tangent),
    Regions(Vec<SubCrown>),
}

/// What came out of it.
struct Made {
    /// In the mask's frame.
    mesh: Mesh,
    bounds: Rect,
    /// Size of the scaled mask.
    size: [u32; 2],
    mask_pixels: usize,
    unknowns: usize,
}

impl Flags {
    fn method(&self) -> Method {
        match self.method {
            MethodName::Bilaplacian => Method::Bilaplacian,
            MethodName::Radial => Method::Radial(match self.crossing {
                CrossingName::First => Crossing::First,
                CrossingName::Last => Crossing::Last,
            }),
            MethodName::Distance => Method::Distance(DistanceShape::Linear),
            MethodName::DistanceSine => Method::Distance(DistanceShape::Sine),
            MethodName::Iterative => Method::Iterative(IterativeSettings::default()),
        }
    }

    /// Reads and checks all inputs.
    fn crown(&self, session: &Session<'_>) -> Result<Crown, Failure> {
        self.check()?;
        let stage = session.progress.stage("read", 1);
        let tangent = self.tangent()?;
        let file = PictureFile::read(&self.mask)?;
        let image = file.decoded()?;
        let recipe = recipe("inflate")
            .with(file.digest().bytes())
            .with(format!("{self:?}").as_bytes())
            .finish();
        let shape = match &self.regions {
            Some(path) => Shape::Regions(self.regions(path, &image, session)?),
            None => Shape::Whole(self.whole(&coverage(&image)), tangent),
        };
        if let Shape::Whole(mask, _) = &shape
            && mask.count() == 0
        {
            let reason = "no pixel of the mask is set: there is nothing to inflate";
            return Err(Failure::of(self.mask.display(), reason));
        }
        stage.advance();
        Ok(Crown { shape, recipe })
    }

    /// The mask or its envelope, scaled.
    fn whole(&self, coverage: &Image<u8>) -> Mask {
        let mask = scaled(coverage, self.size);
        if !self.envelope {
            return mask;
        }
        let set = coverage.map(|&value| value >= 128);
        envelope(&set, &Envelope::default())
            .map_or(mask, |(mask, _)| scaled(&mask.grey(), self.size))
    }

    fn check(&self) -> Result<(), Failure> {
        if !(self.height.is_finite() && self.height > 0.0) {
            return Err(Failure::of(
                "--height",
                "must be a number of metres above 0",
            ));
        }
        let given = [
            ("--k", self.k.is_some()),
            ("--preset", self.preset.is_some()),
            ("--profile", self.profile.is_some()),
        ];
        match given.iter().find(|(_, given)| *given) {
            Some((flag, _)) if !self.method().uses_tangent() => {
                Err(Failure::of(flag, "has no part in this --method"))
            }
            _ => Ok(()),
        }
    }

    fn tangent(&self) -> Result<Tangent, Failure> {
        if let Some(path) = &self.profile {
            return Ok(Tangent::Profile(from_json::<Profile>(path)?));
        }
        match (&self.k, &self.preset) {
            (Some(text), _) => {
                Tangent::parse(text).map_err(|error| Failure::of(format!("--k '{text}'"), error))
            }
            (None, Some(name)) => {
                Tangent::preset(name).map_err(|error| Failure::of("--preset", error))
            }
            (None, None) => Ok(usual_k()),
        }
    }

    /// The regions that the file names, scaled.
    fn regions(
        &self,
        path: &Path,
        image: &Image<Straight>,
        session: &Session<'_>,
    ) -> Result<Vec<SubCrown>, Failure> {
        let regions = regions_from(path)?;
        let masks = region_masks(&regions, path, image, &self.mask, session)?;
        let sub_crown = |(region, mask): (Region, Mask)| {
            let mask = scaled(&mask.grey(), self.size);
            let label = region.label;
            if mask.count() == 0 {
                let reason = format!("nothing is left of the region {label} at this --size");
                return Err(Failure::of(path.display(), reason));
            }
            Ok(SubCrown {
                mask,
                tangent: region.k,
                depth_px: region.depth_px,
            })
        };
        regions.into_iter().zip(masks).map(sub_crown).collect()
    }

    /// Makes the mesh.
    fn made(&self, crown: &Crown, session: &Session<'_>) -> Result<Made, Failure> {
        let refused = |error| self.refusal(error);
        let (progress, cancel) = (session.progress, session.cancel);
        let (mesh, center, mask, unknowns) = match &crown.shape {
            Shape::Whole(mask, tangent) => {
                let made =
                    base_mesh(mask, tangent, self.method(), progress, cancel).map_err(refused)?;
                let center = crown_center(mask).unwrap_or_default().extend(0.0);
                (made.mesh, center, mask.clone(), made.unknowns)
            }
            Shape::Regions(regions) => {
                let (mesh, center) =
                    sub_crowns_merged(regions, self.method(), progress, cancel).map_err(refused)?;
                (mesh, center, union(regions), 0)
            }
        };
        let bounds = opaque_bounds(&mask).unwrap_or(Rect {
            x: 0,
            y: 0,
            width: 1,
            height: 1,
        });
        Ok(Made {
            mesh: self
                .with_copies(mesh, center, bounds, session)
                .map_err(refused)?,
            bounds,
            size: [mask.width(), mask.height()],
            mask_pixels: mask.count(),
            unknowns,
        })
    }

    /// Names the input that is at fault.
    fn refusal(&self, error: BaseMeshError) -> Failure {
        match (&error, &self.k, &self.profile, &self.regions) {
            _ if error.is_cancelled() => Failure::Cancelled,
            (BaseMeshError::Tangent(_), Some(text), ..) => {
                Failure::of(format!("--k '{text}'"), error)
            }
            (BaseMeshError::Tangent(_), _, Some(file), _)
            | (BaseMeshError::Tangent(_), _, _, Some(file)) => Failure::of(file.display(), error),
            _ => Failure::of(self.mask.display(), error),
        }
    }

    fn with_copies(
        &self,
        mesh: Mesh,
        center: DVec3,
        bounds: Rect,
        session: &Session<'_>,
    ) -> Result<Mesh, BaseMeshError> {
        if self.copies == 1 {
            return Ok(mesh);
        }
        let _stage = session.progress.stage("merge", 0);
        let cells = star_cells(bounds);
        Ok(copies_merged(
            &mesh,
            center,
            self.copies,
            cells,
            session.cancel,
        )?)
    }

    fn metres_per_pixel(&self, bounds: Rect) -> f64 {
        self.height / f64::from(bounds.height)
    }

    fn file(&self, mesh: &Mesh, bounds: Rect, format: Format) -> Result<Vec<u8>, Failure> {
        if format == Format::Obj {
            let comments = [
                "Boscage: the base mesh of a crown, in pixels of its mask: x right, y down, z to the viewer",
                "the first vertices are the front of the mask's pixels, by rows from the top",
            ];
            let told = if self.keeps_pixels() {
                &comments[..]
            } else {
                &comments[..1]
            };
            return Ok(obj(mesh, told));
        }
        let upright = into_world(mesh, bounds, self.metres_per_pixel(bounds), 0.0).without_unused();
        let mut glb = Glb::new(None);
        let green = glb.material(&Material {
            color: FOLIAGE,
            ..Material::white("crown")
        });
        let crown = glb.mesh("crown", &ModelMesh::from(&upright), green, false);
        let node = glb.node("crown", crown);
        glb.show(node);
        let bytes = glb.into_bytes();
        bytes.map_err(|error| Failure::of(self.mask.display(), error))
    }

    /// Whether the mesh begins with the pixels of the mask.
    fn keeps_pixels(&self) -> bool {
        self.copies == 1 && self.regions.is_none() && self.method != MethodName::Radial
    }

    fn description(
        &self,
        made: &Made,
        topology: &Topology,
        out: &Path,
        session: &Session<'_>,
    ) -> Value {
        let mut seconds = json!(session.seconds());
        for stage in ["assemble", "factor", "solve"] {
            if seconds.get(stage).is_none() {
                seconds[stage] = json!(0.0);
            }
        }
        let (low, high) = made.mesh.bounds().unwrap_or_default();
        json!({
            "file": self.mask.display().to_string(),
            "output": out.display().to_string(),
            "size": made.size,
            "bounds": [made.bounds.x, made.bounds.y, made.bounds.width, made.bounds.height],
            "mask_pixels": made.mask_pixels,
            "unknowns": made.unknowns,
            "height": {"max": high.z, "min": low.z},
            "volume": made.mesh.volume(),
            "vertices": topology.vertices,
            "triangles": topology.triangles,
            "components": topology.components,
            "euler": topology.euler(),
            "watertight": topology.is_watertight(),
            "genus": topology.genus(),
            "metres_per_pixel": self.metres_per_pixel(made.bounds),
            "seconds": seconds,
        })
    }
}

fn format_of(out: &Path) -> Result<Format, Failure> {
    let extension = out
        .extension()
        .map(|e| e.to_string_lossy().to_ascii_lowercase());
    match extension.as_deref() {
        Some("obj") => Ok(Format::Obj),
        Some("glb") => Ok(Format::Glb),
        _ => Err(Failure::of(out.display(), "must end in .obj or .glb")),
    }
}

/// The mask of what is covered by half or more, its longer side scaled to `size` pixels.
fn scaled(coverage: &Image<u8>, size: u32) -> Mask {
    let (width, height) = (coverage.width(), coverage.height());
    let longer = width.max(height);
    if longer == size {
        return coverage.map(|&value| value >= 128);
    }
    let side = |side: u32| {
        let scaled = u64::from(side) * u64::from(size) + u64::from(longer) / 2;
        ((scaled / u64::from(longer)) as u32).max(1)
    };
    let image = coverage.map(|&value| Premultiplied([0, 0, 0, value]));
    resized(&image, image.rect(), side(width), side(height)).map(|pixel| pixel.alpha() >= 128)
}

fn union(regions: &[SubCrown]) -> Mask {
    let mut all = regions[0].mask.clone();
    for region in &regions[1..] {
        for (all, &own) in all.pixels_mut().iter_mut().zip(region.mask.pixels()) {
            *all |= own;
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mask_of_the_right_size_passes_untouched_and_others_keep_their_shape() {
        let pixels = (0..64u32)
            .map(|i| if i % 8 < 4 { 128 } else { 127 })
            .collect();
        let grey = Image::from_pixels(8, 8, pixels);
        assert_eq!(scaled(&grey, 8), grey.map(|&value| value >= 128));
        let twice = scaled(&Image::filled(6, 3, 255u8), 12);
        assert_eq!((twice.width(), twice.height(), twice.count()), (12, 6, 72));
        let line = scaled(&Image::filled(1000, 1, 255u8), 100);
        assert_eq!((line.width(), line.height()), (100, 1));
    }
}
