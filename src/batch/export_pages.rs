//! `boscage export`: atlas pages of all trees, from the textures written before.

use super::export::ExportSettings;
use super::export_shared::Files;
use super::failure::Failure;
use super::input::PictureFile;
use super::run::Run;
use crate::export::{
    AtlasSettings, AtlasSprite, PageContent, PresetTree, SpriteLayout, atlas_json_array,
    atlas_json_hash, atlas_layout, atlas_page, mips,
};
use crate::raster::{Compression, Image, Rect, Straight, encode_opaque_png, encode_png, resized};
use crate::variation::{Histogram, Transfer};
use rayon::prelude::*;
use std::collections::BTreeMap;

use super::export_tree::{TextureForm, encoded_textures};

/// One picture of a tree, cut to its frame and made small.
fn small(
    settings: &ExportSettings,
    tree: &PresetTree,
    map: &str,
    size: [u32; 2],
    session: &Run<'_>,
) -> Result<Image<Straight>, Failure> {
    session.cancel.check()?;
    let Some(file) = tree.files.get(map) else {
        return Err(Failure::of(&tree.name, format!("has no {map}")));
    };
    let image = PictureFile::read(&settings.out.join(file))?.decoded()?;
    let Rect {
        x,
        y,
        width,
        height,
    } = tree.frame;
    if x + width > image.width() || y + height > image.height() {
        return Err(Failure::of(file, "is smaller than the tree in it"));
    }
    let image = resized(&image.premultiplied(), tree.frame, size[0], size[1]);
    Ok(image.straight())
}

/// The frame of a tree, scaled so that its longer side has `longer` pixels.
fn small_size(tree: &PresetTree, longer: u32) -> [u32; 2] {
    let scale = f64::from(longer) / f64::from(tree.frame.width.max(tree.frame.height));
    let scale = scale.min(1.0);
    [tree.frame.width, tree.frame.height]
        .map(|side| ((f64::from(side) * scale).round() as u32).max(1))
}

/// Writes the atlas of each map, one page after the other, with both lists a page.
pub(crate) fn write_atlas(
    settings: &ExportSettings,
    trees: &[PresetTree],
    session: &Run<'_>,
) -> Result<Files, Failure> {
    let sizes: Vec<[u32; 2]> = trees
        .iter()
        .map(|tree| small_size(tree, settings.atlas_tree))
        .collect();
    let layout = atlas_layout(&sizes, AtlasSettings::default())
        .map_err(|error| Failure::of("--atlas-tree", error))?;
    let maps = settings.map_names();
    let stage = session
        .progress
        .stage("atlas", (layout.pages.len() * maps.len()) as u64);
    let mut files = Files::new();
    for page in 0..layout.pages.len() {
        let on_page: Vec<(usize, Rect)> = layout.on_page(page).collect();
        let pictures = |map: &str| {
            let tree = |(index, _): &(usize, Rect)| {
                small(settings, &trees[*index], map, sizes[*index], session)
                    .map(|image| (*index, image))
            };
            on_page
                .par_iter()
                .map(tree)
                .collect::<Result<BTreeMap<_, _>, Failure>>()
        };
        let colors = pictures("albedo")?;
        let alphas: BTreeMap<usize, Image<u8>> = colors
            .iter()
            .map(|(&i, image)| (i, image.map(|p| p.alpha())))
            .collect();
        for map in &maps {
            let loaded = if *map == "albedo" {
                None
            } else {
                Some(pictures(map)?)
            };
            let of_map = loaded.as_ref().unwrap_or(&colors);
            let image = atlas_page(&layout, page, content(map), |i| (&of_map[&i], &alphas[&i]));
            let name = format!(
                "atlas/{}",
                settings.preset.style().file(&format!("atlas_{page}"), map)
            );
            write_page(settings, &name, map, &image, &on_page, session, &mut files)?;
            stage.advance();
        }
        write_lists(settings, trees, &layout, page, session, &mut files)?;
    }
    Ok(files)
}

/// Whether a map has alpha.
fn content(map: &str) -> PageContent {
    if map == "albedo" {
        PageContent::Color
    } else {
        PageContent::Data
    }
}

/// One page of one map in all forms asked for.
fn write_page(
    settings: &ExportSettings,
    name: &str,
    map: &str,
    image: &Image<Straight>,
    frames: &[(usize, Rect)],
    session: &Run<'_>,
    files: &mut Files,
) -> Result<(), Failure> {
    let mut write = |ending: &str, bytes: &[u8]| -> Result<(), Failure> {
        let file = format!("{name}.{ending}");
        session.output.write(&settings.out.join(&file), bytes)?;
        files.entry(format!("atlas_{map}")).or_default().push(file);
        Ok(())
    };
    let png = match content(map) {
        PageContent::Color => encode_png(image, Compression::Fast),
        PageContent::Data => encode_opaque_png(image, Compression::Fast),
    };
    write("png", &png)?;
    let others = settings
        .textures
        .iter()
        .filter(|&&form| form != TextureForm::Png);
    let others: Vec<_> = others.map(|form| (form.suffix().1, *form)).collect();
    if others.is_empty() {
        return Ok(());
    }
    let regions: Vec<Rect> = frames.iter().map(|(_, frame)| *frame).collect();
    let levels = match map {
        "albedo" => mips(image, &regions, session.cancel)?,
        "normal" => crate::export::normal_mips(image, session.cancel)?,
        _ => crate::export::data_mips(image, session.cancel)?,
    };
    for (ending, bytes) in encoded_textures(settings, &levels, map == "albedo", others, session)? {
        write(ending, &bytes)?;
    }
    Ok(())
}

/// The two lists of a page.
fn write_lists(
    settings: &ExportSettings,
    trees: &[PresetTree],
    layout: &SpriteLayout,
    page: usize,
    session: &Run<'_>,
    files: &mut Files,
) -> Result<(), Failure> {
    let sprites: Vec<AtlasSprite> = layout
        .on_page(page)
        .map(|(index, frame)| atlas_sprite(&trees[index], frame))
        .collect();
    let picture = settings
        .preset
        .style()
        .file(&format!("atlas_{page}"), "albedo")
        + ".png";
    let size = layout.pages[page];
    let lists = [
        ("hash", atlas_json_hash(&sprites, &picture, size)),
        ("array", atlas_json_array(&sprites, &picture, size)),
    ];
    for (form, text) in lists {
        let file = format!("atlas/atlas_{page}.{form}.json");
        session
            .output
            .write(&settings.out.join(&file), text.as_bytes())?;
        files.entry(format!("atlas_{form}")).or_default().push(file);
    }
    Ok(())
}

/// A tree in the list of a page: its untrimmed picture is its canvas.
fn atlas_sprite(tree: &PresetTree, frame: Rect) -> AtlasSprite {
    let scale = f64::from(frame.width) / f64::from(tree.frame.width);
    let scaled = |pixels: u32| (f64::from(pixels) * scale).round() as u32;
    let (x, y) = (scaled(tree.frame.x), scaled(tree.frame.y));
    let source = [
        scaled(tree.size_px[0]).max(x + frame.width),
        scaled(tree.size_px[1]).max(y + frame.height),
    ];
    AtlasSprite {
        name: tree.name.clone(),
        frame,
        in_source: Rect {
            x,
            y,
            width: frame.width,
            height: frame.height,
        },
        source,
        anchor: [0, 1].map(|axis| tree.pivot_px[axis] / f64::from(tree.size_px[axis])),
    }
}

/// Side of a cell of FlightGear's atlas, in pixels, across for 8 thin or 4 broad varieties.
const CELL_HEIGHT: u32 = 256;

/// Rows of the atlas.
const SEASONS: u32 = 4;

/// Writes FlightGear's atlas: columns of varieties, rows of seasons, and the normal map.
pub(crate) fn write_flightgear(
    settings: &ExportSettings,
    trees: &[PresetTree],
    session: &Run<'_>,
) -> Result<Files, Failure> {
    let stage = session.progress.stage("atlas", 2);
    let ratio = |tree: &PresetTree| f64::from(tree.frame.width) / f64::from(tree.frame.height);
    let mut ratios: Vec<f64> = trees.iter().map(ratio).collect();
    ratios.sort_by(f64::total_cmp);
    let columns: u32 = if ratios[ratios.len() / 2] < 0.6 { 8 } else { 4 };
    let cell = [SEASONS * CELL_HEIGHT / columns, CELL_HEIGHT];
    let side = SEASONS * CELL_HEIGHT;
    let mut pages = [("albedo", "trees.png"), ("normal", "trees-normal.png")].map(|(map, file)| {
        (
            map,
            file,
            Image::filled(side, side, Straight([0; 4])),
            Image::filled(side, side, 0u8),
        )
    });
    for column in 0..columns {
        let tree = &trees[column as usize % trees.len()];
        let size = fitted(tree, cell);
        let color = small(settings, tree, "albedo", size, session)?;
        let alpha = color.map(|pixel| pixel.alpha());
        for (map, _, page, alphas) in &mut pages {
            if !tree.files.contains_key(*map) {
                continue;
            }
            let flat = (*map != "albedo").then(|| small(settings, tree, map, size, session));
            let flat = flat.transpose()?;
            for season in 0..SEASONS {
                let image = flat
                    .clone()
                    .unwrap_or_else(|| in_season(&color, season, settings.evergreen));
                // Standing on the cell's lower edge, in its middle.
                let x = column * cell[0] + (cell[0] - size[0]) / 2;
                let y = (season + 1) * cell[1] - size[1];
                for row in 0..size[1] {
                    let range = x as usize..(x + size[0]) as usize;
                    page.row_mut(y + row)[range.clone()].copy_from_slice(image.row(row));
                    alphas.row_mut(y + row)[range].copy_from_slice(alpha.row(row));
                }
            }
        }
    }
    let mut files = Files::new();
    for (map, file, page, alphas) in &pages {
        if alphas.pixels().iter().all(|&alpha| alpha == 0) {
            continue;
        }
        let page = crate::export::bled_from(page, alphas);
        let page = Image::from_pixels(side, side, {
            let texels = page.pixels().iter().zip(alphas.pixels());
            let with = |(p, &a): (&Straight, &u8)| {
                let a = if *map == "albedo" { a } else { 255 };
                Straight([p.0[0], p.0[1], p.0[2], a])
            };
            texels.map(with).collect()
        });
        session.output.write(
            &settings.out.join(file),
            &encode_png(&page, Compression::Fast),
        )?;
        files.insert(format!("flightgear_{map}"), vec![(*file).to_owned()]);
        stage.advance();
    }
    files.insert("flightgear_varieties".to_owned(), vec![columns.to_string()]);
    Ok(files)
}

/// The size of a tree that fills a cell but for a margin against its neighbours.
fn fitted(tree: &PresetTree, cell: [u32; 2]) -> [u32; 2] {
    const MARGIN: u32 = 4;
    let room = [cell[0] - 2 * MARGIN, cell[1] - MARGIN];
    let scale = [0, 1]
        .map(|axis| f64::from(room[axis]) / f64::from([tree.frame.width, tree.frame.height][axis]));
    let scale = scale[0].min(scale[1]);
    [tree.frame.width, tree.frame.height]
        .map(|side| ((f64::from(side) * scale).round() as u32).max(1))
}

/// A tree as it looks in row `season` of the atlas: summer, snowy summer, winter, snowy winter.
///
/// Winter's colours come by matching the histogram of its light with those of dry bark and dead
/// leaves, unless it is `evergreen`; snow lies where light falls: the brighter half of the pixels is
/// matched with the colours of snow. Light alone is matched, not channel by channel: that would turn
/// brown trunks purple.
fn in_season(summer: &Image<Straight>, season: u32, evergreen: bool) -> Image<Straight> {
    /// Darkest and lightest colour of the palettes; values between are spread evenly.
    const WINTER: [[u8; 3]; 2] = [[34, 27, 22], [150, 128, 104]];
    const SNOW: [[u8; 3]; 2] = [[168, 180, 196], [250, 252, 255]];
    let grey = summer.map(|pixel| {
        let value = (light(*pixel) / 256) as u8;
        Straight([value, value, value, pixel.alpha()])
    });
    let mut image = summer.clone();
    if season >= 2 && !evergreen {
        image = grey.clone();
        Transfer::between(&Histogram::of(&grey), &palette(WINTER)).apply(&mut image);
    }
    if season % 2 == 1 {
        let lit = median_light(summer);
        let is_lit = |pixel: &Straight| pixel.alpha() > 0 && light(*pixel) >= lit;
        let bright = grey.pixels().iter().zip(summer.pixels());
        let bright = bright.filter(|(_, summer)| is_lit(summer));
        let bright = Histogram::of_pixels(bright.map(|(grey, _)| *grey));
        let map = Transfer::between(&bright, &palette(SNOW));
        let pixels = grey.pixels().iter().zip(summer.pixels());
        for (out, (grey, summer)) in image.pixels_mut().iter_mut().zip(pixels) {
            if is_lit(summer) {
                *out = map.applied(*grey);
            }
        }
    }
    image
}

fn light(pixel: Straight) -> u32 {
    let [r, g, b, _] = pixel.0.map(u32::from);
    54 * r + 183 * g + 19 * b
}

fn median_light(image: &Image<Straight>) -> u32 {
    let seen = image.pixels().iter().filter(|pixel| pixel.alpha() > 0);
    let mut lights: Vec<u32> = seen.map(|pixel| light(*pixel)).collect();
    lights.sort_unstable();
    lights.get(lights.len() / 2).copied().unwrap_or(0)
}

/// The histogram of the colours between two.
fn palette([dark, light]: [[u8; 3]; 2]) -> Histogram {
    Histogram::of_pixels((0..=255u32).map(|share| {
        let mixed = |c: usize| {
            ((u32::from(dark[c]) * (255 - share) + u32::from(light[c]) * share) / 255) as u8
        };
        Straight([mixed(0), mixed(1), mixed(2), 255])
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn crown() -> Image<Straight> {
        let pixels = (0..64u8).map(|i| Straight([40 + i, 90 + 2 * i, 20, 255]));
        Image::from_pixels(8, 8, pixels.collect())
    }

    #[test]
    fn seasons_are_brown_white_or_as_they_were() {
        let summer = crown();
        assert_eq!(in_season(&summer, 0, false), summer);
        assert_eq!(in_season(&summer, 2, true), summer);
        for pixel in in_season(&summer, 2, false).pixels() {
            let [r, g, b, _] = pixel.0;
            assert!(r >= g && g >= b, "{pixel:?}");
        }
        let snowy = in_season(&summer, 1, false);
        let white = snowy.pixels().iter().filter(|p| p.0[2] >= 168).count();
        assert!((30..=36).contains(&white), "{white}");
        assert_eq!(snowy.at(0, 0), summer.at(0, 0));
    }
}
