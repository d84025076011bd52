//! Grows the built-in trees anew and writes them with their digests to `assets/samples`, or to the
//! folder given, with an optional height in pixels: `regenerate_samples [FOLDER [HEIGHT [NAME]]]`.

use anyhow::Context as _;
use boscage::base::{Cancel, Digest, write_atomic};
use boscage::branches::samples::{BUNDLED_HEIGHT_PX, samples};
use boscage::raster::{Compression, encode_grey_png, encode_png};
use std::path::PathBuf;

fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let bundled = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/samples");
    let given = arguments.next();
    let folder = PathBuf::from(given.as_deref().unwrap_or(bundled));
    let height_px = match arguments.next() {
        Some(text) => text.parse().context("the height is a number of pixels")?,
        None => BUNDLED_HEIGHT_PX,
    };
    let only = arguments.next();
    let mut digests = String::new();
    for sample in samples() {
        if only.as_ref().is_some_and(|name| name != sample.name()) {
            continue;
        }
        let start = std::time::Instant::now();
        let tree = sample.grow(height_px, &Cancel::new())?;
        let seconds = start.elapsed().as_secs_f64();
        let png = encode_png(&tree.image, Compression::Small);
        write_atomic(&folder.join(format!("{}.png", sample.name())), &png)?;
        {
            let mut webp = Vec::new();
            image::codecs::webp::WebPEncoder::new_lossless(&mut webp).encode(
                bytemuck::cast_slice(tree.image.pixels()),
                tree.image.width(),
                tree.image.height(),
                image::ExtendedColorType::Rgba8,
            )?;
            say(&format!("webp {}", webp.len()));
        }
        if given.is_some() {
            let labels = encode_grey_png(&tree.labels, Compression::Small);
            write_atomic(
                &folder.join(format!("{}.labels.png", sample.name())),
                &labels,
            )?;
        }
        let digest = Digest::of(bytemuck::cast_slice(tree.image.pixels()));
        digests += &format!("{digest} {}\n", sample.name());
        let (width, height) = (tree.image.width(), tree.image.height());
        let name = sample.name();
        say(&format!(
            "{name}: {width}×{height}, {seconds:.2} s, {} bytes",
            png.len()
        ));
    }
    write_atomic(&folder.join("digests.txt"), digests.as_bytes())?;
    Ok(())
}

/// Writes a line to the standard output; a closed pipe is no failure.
fn say(line: &str) {
    use std::io::Write as _;
    let _ = writeln!(std::io::stdout(), "{line}");
}
