//! Grows the built-in trees anew: `regenerate_samples [FOLDER [NAME]]`.
//!
//! Writes lossless WebP pictures and `digests.txt` to `assets/samples`. With a FOLDER (and a NAME
//! of one tree) it writes there instead, with the labels beside the pictures.

use anyhow::Context as _;
use boscage::base::{Cancel, Digest, write_atomic};
use boscage::branches::samples::{BUNDLED_HEIGHT_PX, SMALL_HEIGHT_PX};
use boscage::branches::{Sample, samples};
use boscage::raster::{Compression, Image, Straight, encode_grey_png};
use std::io::Write as _;
use std::path::{Path, PathBuf};

fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let given = arguments.next().map(PathBuf::from);
    let only = arguments.next();
    let bundled = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/samples");
    let folder = given.as_ref().unwrap_or(&bundled);
    let mut digests = String::new();
    for sample in samples() {
        if only.as_ref().is_none_or(|name| name == sample.name()) {
            digests += &regenerated(sample, folder, given.is_some())?;
        }
    }
    write_atomic(&folder.join("digests.txt"), digests.as_bytes())?;
    Ok(())
}

/// Writes one tree's files; returns its lines of `digests.txt`.
fn regenerated(sample: &Sample, folder: &Path, with_labels: bool) -> anyhow::Result<String> {
    let name = sample.name();
    let start = std::time::Instant::now();
    let tree = sample.grow(BUNDLED_HEIGHT_PX, &Cancel::new())?;
    let seconds = start.elapsed().as_secs_f64();
    let file = lossless_webp(&tree.image)?;
    write_atomic(&folder.join(format!("{name}.webp")), &file)?;
    if with_labels {
        let labels = encode_grey_png(&tree.labels, Compression::Small);
        write_atomic(&folder.join(format!("{name}.labels.png")), &labels)?;
    }
    let (width, height) = (tree.image.width(), tree.image.height());
    writeln!(
        std::io::stdout(),
        "{name}: {width}×{height}, {seconds:.2} s, {} bytes",
        file.len()
    )?;
    let small = sample.grow(SMALL_HEIGHT_PX, &Cancel::new())?;
    Ok(digest_line(name, &tree.image) + &digest_line(name, &small.image))
}

fn digest_line(name: &str, image: &Image<Straight>) -> String {
    let digest = Digest::of(bytemuck::cast_slice(image.pixels()));
    format!("{name} {} {digest}\n", image.height())
}

fn lossless_webp(image: &Image<Straight>) -> anyhow::Result<Vec<u8>> {
    let mut file = Vec::new();
    image::codecs::webp::WebPEncoder::new_lossless(&mut file)
        .encode(
            bytemuck::cast_slice(image.pixels()),
            image.width(),
            image.height(),
            image::ExtendedColorType::Rgba8,
        )
        .context("the picture does not fit a WebP file")?;
    Ok(file)
}
