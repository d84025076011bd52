//! Measurements of foliage synthesis and of what follows it on the way to a crown.

use super::super::failure::Failure;
use super::row::{Baseline, Row, measured, measured_long};
use crate::base::{Cancel, Progress, Seed};
use crate::branches::samples::sample_named;
use crate::crown::{height_cubemap, radius_cubemap, radius_with_relief};
use crate::pipeline::{CrownError, CrownSettings, crown_shape};
use crate::raster::{Cubemap, Image, Mask, Rect, Straight, resized};
use crate::synth::{
    Exemplar, ExemplarSettings, SynthesisError, SynthesisSettings, Wrapping, assembled, texture,
    texture_around, wrapped,
};
use std::hint::black_box;

/// The sample whose foliage is taken.
const SAMPLE: &str = "oak_02";

/// Texels along a face.
const SIZE: u32 = 256;

/// Pixels across a ball whose circumference is four faces.
const ACROSS: u32 = 326;

/// The textures of the thesis: that of the lateral faces, the top and the bottom.
const SIDES: [[u32; 2]; 3] = [[1056, 320], [256, 256], [256, 256]];

const THESIS_TEXTURES: Baseline = Baseline {
    what: "Argudo (2014): 40 to 45 min; Embark: 34 s of CPU, Python quilting: 7 s",
    ms: 2_400_000.0,
};
const EMBARK: Baseline = Baseline {
    what: "Embark texture-synthesis: 34 s of CPU for the three",
    ms: 34_000.0,
};
const THESIS_ASSEMBLY: Baseline = Baseline {
    what: "Argudo (2014): 20 to 25 s",
    ms: 20_000.0,
};

/// All measurements, on the crown of a built-in sample.
pub(super) fn rows(cancel: &Cancel) -> Result<Vec<Row>, Failure> {
    let (photo, mask) = crown_picture()?;
    let exemplar = || exemplar(&photo, &mask, cancel);
    let mut rows = vec![
        measured("foliage: preparation", cancel, || exemplar().map(drop))?,
        measured("foliage: preparation to preview", cancel, || {
            preview(&exemplar()?, cancel)
        })?
        .target(500.0),
        measured_long("foliage: preparation and 3 textures", cancel, || {
            textures(&exemplar()?, cancel).map(drop)
        })?
        .target(4_000.0)
        .against(THESIS_TEXTURES),
    ];
    let exemplar = exemplar()?;
    let lateral = measured_long("texture of 1056 x 320", cancel, || {
        one_texture(&exemplar, SIDES[0], 0, cancel).map(drop)
    })?;
    rows.push(lateral.against(EMBARK));
    let textures = textures(&exemplar, cancel)?;
    let color = || cubemap(&textures, cancel);
    let assembly = measured("cubemap of three textures, 256", cancel, || {
        color().map(drop)
    })?;
    rows.push(assembly.target(300.0).against(THESIS_ASSEMBLY));
    rows.extend(relief_rows(&mask, &color()?, cancel)?);
    Ok(rows)
}

/// From a base mesh and colours to the radius of a crown.
fn relief_rows(
    mask: &Mask,
    color: &Cubemap<Straight>,
    cancel: &Cancel,
) -> Result<[Row; 2], Failure> {
    let settings = CrownSettings::default();
    let shape = crown_shape(mask, &settings, Progress::silent(), cancel).map_err(crown_failure)?;
    let base = || {
        radius_cubemap(&shape.base_mesh, shape.frame.center_m, SIZE, cancel)
            .map_err(|error| crown_failure(error.into()))
    };
    let rasterised = measured("radius cubemap of a base mesh, 256", cancel, || {
        base().map(drop)
    })?;
    let base = base()?;
    let relief = measured("relief and composition, 256", cancel, || {
        let height = height_cubemap(color, &settings.relief, cancel)?;
        let steepest = settings.relief.steepest;
        black_box(radius_with_relief(&base, &height, settings.rho, steepest));
        Ok::<(), Failure>(())
    })?;
    Ok([rasterised, relief.target(100.0)])
}

/// The cubemap of the three textures on a ball.
fn cubemap(
    [lateral, top, bottom]: &[Image<Straight>; 3],
    cancel: &Cancel,
) -> Result<Cubemap<Straight>, Failure> {
    let wrapping = Wrapping::round(SIZE);
    let lattice = assembled(lateral, top, bottom, wrapping.size(), cancel)?;
    Ok(wrapped(&lattice, &wrapping, SIZE, cancel)?)
}

/// The upper half of the sample, which is all crown, and its mask, at the scale that a crown's
/// cubemap of [`SIZE`] asks for.
fn crown_picture() -> Result<(Image<Straight>, Mask), Failure> {
    let missing = || Failure::Environment("a built-in sample is missing".into());
    let picture = sample_named(SAMPLE)
        .ok_or_else(missing)?
        .trimmed()
        .map_err(|error| Failure::Environment(error.to_string()))?;
    let upper = Rect {
        x: 0,
        y: 0,
        width: picture.width(),
        height: picture.height() / 2,
    };
    let height = (ACROSS * upper.height).div_ceil(upper.width);
    let picture = resized(&picture.premultiplied(), upper, ACROSS, height).straight();
    let mask = picture.map(|pixel| pixel.alpha() > 127);
    Ok((picture, mask))
}

fn exemplar(photo: &Image<Straight>, mask: &Mask, cancel: &Cancel) -> Result<Exemplar, Failure> {
    Exemplar::new(photo, mask, &ExemplarSettings::default(), cancel).map_err(failure)
}

fn one_texture(
    exemplar: &Exemplar,
    [width, height]: [u32; 2],
    number: u64,
    cancel: &Cancel,
) -> Result<Image<Straight>, Failure> {
    let settings = SynthesisSettings::default();
    let (seed, progress) = (Seed(number), Progress::silent());
    texture(exemplar, width, height, &settings, seed, &progress, cancel).map_err(failure)
}

fn textures(exemplar: &Exemplar, cancel: &Cancel) -> Result<[Image<Straight>; 3], Failure> {
    let made = |number: usize| one_texture(exemplar, SIDES[number], number as u64, cancel);
    Ok([made(0)?, made(1)?, made(2)?])
}

/// The largest texture as far as its preview, then stopped.
fn preview(exemplar: &Exemplar, cancel: &Cancel) -> Result<(), Failure> {
    let [width, height] = SIDES[0];
    let nothing = Image::filled(width, height, None);
    let (settings, seed, progress) = (SynthesisSettings::default(), Seed(0), Progress::silent());
    let stop = Cancel::new();
    let shown = |picture| {
        black_box(picture);
        stop.cancel();
    };
    let made = texture_around(exemplar, &nothing, &settings, seed, shown, &progress, &stop);
    match made {
        Err(SynthesisError::Cancelled(_)) => Ok(cancel.check()?),
        Err(other) => Err(failure(other)),
        Ok(_) => Err(Failure::Environment("there was no preview".to_owned())),
    }
}

fn failure(error: SynthesisError) -> Failure {
    match error {
        SynthesisError::Cancelled(cancelled) => cancelled.into(),
        other => Failure::Environment(other.to_string()),
    }
}

fn crown_failure(error: CrownError) -> Failure {
    match error {
        error if error.is_cancelled() => Failure::Cancelled,
        other => Failure::Environment(other.to_string()),
    }
}
