//! `boscage export`: atlas pages of all trees, from the textures written before.

use super::export::ExportSettings;
use super::export_shared::Files;
use super::failure::Failure;
use super::input::PictureFile;
use super::run::Run;
use crate::base::{Cancel, Seed};
use crate::export::{
    AtlasSettings, AtlasSprite, PageContent, PresetTree, SpriteLayout, atlas_json_array,
    atlas_json_hash, atlas_layout, atlas_page,
};
use crate::raster::{Compression, Image, Rect, Straight, encode_opaque_png, encode_png, resized};
use crate::segment::{Classical, SegmentError, Segmenter as _};
use crate::variation::{Season, SeasonSettings, Tree, put_in_season};
use rayon::prelude::*;
use std::collections::BTreeMap;

use super::export_tree::{TextureForm, encoded_textures, map_levels};

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
    let levels = map_levels(map, image, &regions, session)?;
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
            let rows = match flat.transpose()? {
                Some(flat) => [0; SEASONS as usize].map(|_| flat.clone()),
                None => {
                    let seed = Seed(session.seed).derive("season", u64::from(column));
                    in_seasons(color.clone(), settings.evergreen, seed, session.cancel)?
                }
            };
            for (season, image) in (0u32..).zip(&rows) {
                let alpha = match *map == "albedo" {
                    true => image.map(|pixel| pixel.alpha()),
                    false => alpha.clone(),
                };
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

/// Snow of the snowy rows.
const SNOW: f64 = 0.6;

/// A tree as it looks in each row of the atlas: summer, snowy summer, winter, snowy winter. Trees that
/// look evergreen, and all where they are said to be, keep their leaves.
fn in_seasons(
    summer: Image<Straight>,
    evergreen: bool,
    seed: Seed,
    cancel: &Cancel,
) -> Result<[Image<Straight>; SEASONS as usize], Failure> {
    let labels = Classical.segment(&summer, cancel);
    let labels = labels.map_err(|error| match error {
        SegmentError::Cancelled(cancelled) => cancelled.into(),
        error => Failure::BadInput(error.to_string()),
    })?;
    let tree = Tree {
        image: summer,
        labels,
    };
    let evergreen = evergreen.then_some(true);
    let row = |season: Option<Season>, snow: f64| {
        let mut tree = tree.clone();
        let settings = SeasonSettings {
            amount: f64::from(u8::from(season.is_some())),
            snow,
            season: season.unwrap_or(Season::Summer),
        };
        put_in_season(&mut tree, &settings, evergreen, None, seed, cancel)?;
        Ok::<_, Failure>(tree.image)
    };
    Ok([
        row(None, 0.0)?,
        row(None, SNOW)?,
        row(Some(Season::Winter), 0.0)?,
        row(Some(Season::Winter), SNOW)?,
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A round green crown on a brown trunk.
    fn tree() -> Image<Straight> {
        let mut image = Image::filled(96, 128, Straight([0; 4]));
        for y in 0..128u32 {
            for x in 0..96u32 {
                let (dx, dy) = (f64::from(x) - 48.0, f64::from(y) - 48.0);
                let light = ((x * 7 + y * 13) % 40) as u8;
                if dx.hypot(dy) < 44.0 {
                    image.set(x, y, Straight([40 + light, 90 + 2 * light, 20, 255]));
                } else if y > 80 && dx.abs() < 6.0 {
                    image.set(x, y, Straight([70 + light, 54 + light, 40, 255]));
                }
            }
        }
        image
    }

    #[test]
    fn seasons_are_bare_white_or_as_they_were() {
        let summer = tree();
        let rows =
            |evergreen| in_seasons(summer.clone(), evergreen, Seed(1), &Cancel::new()).unwrap();
        let seen =
            |image: &Image<Straight>| image.pixels().iter().filter(|p| p.alpha() > 127).count();
        let white = |image: &Image<Straight>| {
            image
                .pixels()
                .iter()
                .filter(|p| p.alpha() > 127 && p.0[2] >= 148)
                .count()
        };
        let [own, snowy, bare, snowy_bare] = rows(false);
        assert_eq!(own, summer);
        assert!(white(&snowy) > seen(&summer) / 5, "{}", white(&snowy));
        assert!(seen(&bare) < seen(&summer) * 3 / 4, "{}", seen(&bare));
        assert!(white(&snowy_bare) > white(&bare));
        let is_green = |p: &&Straight| p.alpha() > 127 && p.0[1] > p.0[0] + 30;
        assert!(bare.pixels().iter().filter(is_green).count() < seen(&bare) / 50);
        assert_eq!(rows(true)[2], summer);
    }
}
