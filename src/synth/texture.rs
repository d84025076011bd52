//! Textures of any size from an exemplar: from pieces at the coarsest level to pixels.

use super::SynthesisError;
use super::canvas::{Canvas, Given, Known};
use super::exemplar::Exemplar;
use super::patches::{Blocks, filled, laid, piece_count};
use super::refine::corrected;
use crate::base::{Cancel, Progress, Seed};
use crate::raster::{Image, Straight};

/// How a texture is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct SynthesisSettings {
    /// Side of the pieces, pixels of the photograph; smaller ones are taken when the crown is too
    /// small. Larger keeps larger structures and repeats more.
    pub patch: u32,
    /// Corrections of each level.
    pub passes: u32,
    /// Whether the right edge continues at the left one. The width should be a multiple of the
    /// coarsest step (4 with three levels); otherwise fewer levels are used.
    pub tiles_x: bool,
}

impl Default for SynthesisSettings {
    fn default() -> Self {
        Self {
            patch: 64,
            passes: 2,
            tiles_x: false,
        }
    }
}

/// Fewest pixels of a side at the coarsest level.
const SMALLEST_SIDE: u32 = 8;

/// A texture and where it comes from.
#[derive(Debug, Clone)]
pub struct Texture {
    /// The texture, opaque.
    pub image: Image<Straight>,
    /// For each pixel the pixel (x, y) of the photograph that it was taken from; `None` for pixels
    /// that were given.
    pub sources: Image<Option<[u32; 2]>>,
}

/// A texture of `width` × `height` pixels; one of its pixels is as large as one of the photograph.
///
/// # Errors
/// [`SynthesisError::Cancelled`].
///
/// # Panics
/// When a side is 0.
pub fn texture(
    exemplar: &Exemplar,
    width: u32,
    height: u32,
    settings: &SynthesisSettings,
    seed: Seed,
    progress: &Progress<'_>,
    cancel: &Cancel,
) -> Result<Image<Straight>, SynthesisError> {
    let nothing = Image::filled(width, height, None);
    let made = texture_around(exemplar, &nothing, settings, seed, |_| {}, progress, cancel)?;
    Ok(made.image)
}

/// A texture of the size of `known` whose known pixels stay as they are and into which the rest
/// grows. `preview` gets a first picture of full size early on, before seams are corrected.
///
/// # Errors
/// [`SynthesisError::Cancelled`].
pub fn texture_around(
    exemplar: &Exemplar,
    known: &Known,
    settings: &SynthesisSettings,
    seed: Seed,
    mut preview: impl FnMut(Image<Straight>),
    progress: &Progress<'_>,
    cancel: &Cancel,
) -> Result<Texture, SynthesisError> {
    let size = [known.width(), known.height()];
    let levels = level_count(exemplar, size, settings.tiles_x);
    let is_free = known.pixels().iter().all(Option::is_none);
    let given = (!is_free).then(|| Given::levels(known, levels));
    let given = |number: usize| given.as_ref().map(|given| &given[number]);

    let coarsest = levels - 1;
    let level = &exemplar.levels[coarsest];
    let mut canvas = Canvas::empty(size, level.step, settings.tiles_x, given(coarsest));
    let wanted = (settings.patch as usize).div_ceil(level.step);
    let blocks = Blocks::new(level, wanted);
    let stage = progress.stage("patches", piece_count(&canvas, blocks.side));
    laid(
        &mut canvas,
        &blocks,
        seed.derive("pieces", 0),
        &stage,
        cancel,
    )?;
    filled(&mut canvas, exemplar, coarsest, seed.derive("gaps", 0));
    drop(stage);
    preview(preview_of(&canvas, exemplar, coarsest, size, &given));

    let stage = progress.stage("refine", levels as u64 * u64::from(settings.passes));
    for number in (0..levels).rev() {
        if number < coarsest {
            cancel.check()?;
            canvas = canvas.refined(exemplar, number, size, given(number));
        }
        for pass in 0..settings.passes {
            let level = &exemplar.levels[number];
            let seed = seed.derive("search", (number as u64) << 32 | u64::from(pass));
            corrected(&mut canvas, level, &exemplar.similar[number], seed, cancel)?;
            stage.advance();
        }
    }
    Ok(Texture {
        sources: sources(&canvas, exemplar),
        image: canvas.picture(),
    })
}

/// How many levels suit a texture of this size.
fn level_count(exemplar: &Exemplar, size: [u32; 2], tiles_x: bool) -> usize {
    let suits = |number: usize| {
        let step = 1u32 << number;
        let large = size.iter().all(|side| side / step >= SMALLEST_SIDE);
        large && (!tiles_x || size[0].is_multiple_of(step))
    };
    let finer = (1..exemplar.levels.len()).take_while(|&number| suits(number));
    finer.count() + 1
}

/// The canvas in full size, pieces as they were cut.
fn preview_of<'a>(
    canvas: &Canvas,
    exemplar: &Exemplar,
    coarsest: usize,
    size: [u32; 2],
    given: &impl Fn(usize) -> Option<&'a Given>,
) -> Image<Straight> {
    let mut canvas = canvas.clone();
    for number in (0..coarsest).rev() {
        canvas = canvas.refined(exemplar, number, size, given(number));
    }
    canvas.picture()
}

fn sources(canvas: &Canvas, exemplar: &Exemplar) -> Image<Option<[u32; 2]>> {
    let bounds = exemplar.bounds();
    let source = |(&place, &given): (&u32, &bool)| {
        (!given).then(|| {
            let (x, y) = exemplar.levels[0].place(place as usize);
            [bounds.x + x as u32, bounds.y + y as u32]
        })
    };
    let pixels = canvas.places.iter().zip(&canvas.given).map(source);
    Image::from_pixels(canvas.width as u32, canvas.height as u32, pixels.collect())
}
