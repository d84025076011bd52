//! Atlases: many sprites on few pages, one layout for all maps.
//!
//! Places are found by `guillotiere` (guillotine cuts; Jylänki, *A thousand ways to pack the bin*,
//! 2010), tallest sprite first. A page is the smallest rectangle of power-of-two sides that takes
//! all sprites, or the largest page allowed, filled as far as it goes. Between sprites lies padding,
//! and places are multiples of the alignment, so that the first log₂(alignment) mip levels never
//! mix two sprites and blocks of compressed textures hold one sprite each. The padding is filled
//! with the sprites' own colours by [`bled`](super::bled): an extrusion in all directions.

use super::bleed::{bled, bled_from};
use crate::raster::{Image, Rect, Straight};
use guillotiere::{AllocatorOptions, AtlasAllocator, size2};

/// How sprites are laid out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AtlasSettings {
    /// Longest side of a page, a power of two.
    pub page_px: u32,
    /// Clear pixels around each sprite.
    pub padding_px: u32,
    /// Places and sizes are multiples of this power of two.
    pub alignment_px: u32,
}

impl Default for AtlasSettings {
    fn default() -> Self {
        Self {
            page_px: 4096,
            padding_px: 8,
            alignment_px: 8,
        }
    }
}

/// Why sprites cannot be laid out.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum AtlasError {
    /// A sprite is larger than a page.
    #[error("a sprite of {width}×{height} pixels does not fit on a page of {page_px}")]
    TooLarge {
        /// The sprite's width.
        width: u32,
        /// The sprite's height.
        height: u32,
        /// The page's side.
        page_px: u32,
    },
}

/// Where a sprite went.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Placed {
    /// Index of the page.
    pub page: usize,
    /// The sprite's own pixels there.
    pub frame: Rect,
}

/// Pages and places.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SpriteLayout {
    /// Width and height of each page.
    pub pages: Vec<[u32; 2]>,
    /// The place of each sprite, in the order they were given.
    pub placed: Vec<Placed>,
}

impl SpriteLayout {
    /// The frames on `page` with the indices of their sprites.
    pub fn on_page(&self, page: usize) -> impl Iterator<Item = (usize, Rect)> + '_ {
        let placed = self.placed.iter().enumerate();
        placed
            .filter(move |(_, placed)| placed.page == page)
            .map(|(index, placed)| (index, placed.frame))
    }
}

/// A layout for sprites of these widths and heights.
///
/// # Errors
/// [`AtlasError`].
pub fn atlas_layout(
    sizes: &[[u32; 2]],
    settings: AtlasSettings,
) -> Result<SpriteLayout, AtlasError> {
    let cell = |side: u32| (side + 2 * settings.padding_px).next_multiple_of(settings.alignment_px);
    if let Some(&[width, height]) = sizes
        .iter()
        .find(|size| size.iter().any(|&side| cell(side) > settings.page_px))
    {
        let page_px = settings.page_px;
        return Err(AtlasError::TooLarge {
            width,
            height,
            page_px,
        });
    }
    let mut waiting: Vec<usize> = (0..sizes.len()).collect();
    waiting.sort_by_key(|&i| {
        (
            std::cmp::Reverse(sizes[i][1]),
            std::cmp::Reverse(sizes[i][0]),
            i,
        )
    });
    let mut layout = SpriteLayout {
        pages: Vec::new(),
        placed: vec![
            Placed {
                page: 0,
                frame: Rect {
                    x: 0,
                    y: 0,
                    width: 0,
                    height: 0
                }
            };
            sizes.len()
        ],
    };
    while !waiting.is_empty() {
        let (size, places) = fullest_page(&waiting, sizes, settings, cell);
        for &(index, x, y) in &places {
            layout.placed[index] = Placed {
                page: layout.pages.len(),
                frame: Rect {
                    x: x + settings.padding_px,
                    y: y + settings.padding_px,
                    width: sizes[index][0],
                    height: sizes[index][1],
                },
            };
        }
        layout.pages.push(size);
        waiting.retain(|index| !places.iter().any(|(placed, _, _)| placed == index));
    }
    Ok(layout)
}

/// Index of a sprite with its cell's place.
type CellPlace = (usize, u32, u32);

/// The smallest page that takes all of `waiting`, or the largest with as many as it takes.
fn fullest_page(
    waiting: &[usize],
    sizes: &[[u32; 2]],
    settings: AtlasSettings,
    cell: impl Fn(u32) -> u32,
) -> ([u32; 2], Vec<CellPlace>) {
    let area: u64 = waiting
        .iter()
        .map(|&i| {
            sizes[i]
                .map(|side| u64::from(cell(side)))
                .iter()
                .product::<u64>()
        })
        .sum();
    let mut size = [settings.alignment_px.next_power_of_two(); 2];
    loop {
        let last = size == [settings.page_px; 2];
        if last || u64::from(size[0]) * u64::from(size[1]) >= area {
            let places = places(size, waiting, sizes, settings, &cell);
            if last || places.len() == waiting.len() {
                return (size, places);
            }
        }
        // Square, then twice as wide, then square again.
        let grown = usize::from(size[0] > size[1]);
        size[grown] = (size[grown] * 2).min(settings.page_px);
    }
}

fn places(
    size: [u32; 2],
    waiting: &[usize],
    sizes: &[[u32; 2]],
    settings: AtlasSettings,
    cell: impl Fn(u32) -> u32,
) -> Vec<CellPlace> {
    let alignment = settings.alignment_px as i32;
    let options = AllocatorOptions {
        alignment: size2(alignment, alignment),
        ..Default::default()
    };
    let mut page = AtlasAllocator::with_options(size2(size[0] as i32, size[1] as i32), &options);
    waiting
        .iter()
        .filter_map(|&index| {
            let [width, height] = sizes[index].map(|side| cell(side) as i32);
            let place = page.allocate(size2(width, height))?.rectangle;
            Some((index, place.min.x as u32, place.min.y as u32))
        })
        .collect()
}

/// What a page shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PageContent {
    /// Colours with alpha: gaps stay clear.
    Color,
    /// A map without alpha: gaps are as opaque as the sprites.
    Data,
}

/// A page of one map: each picture in its frame, and its values continued into the gaps from where
/// the sprites' alphas are above 0. `sprite` gives the picture and the alpha of each frame by the
/// index of its sprite.
pub fn atlas_page<'a>(
    layout: &SpriteLayout,
    page: usize,
    content: PageContent,
    mut sprite: impl FnMut(usize) -> (&'a Image<Straight>, &'a Image<u8>),
) -> Image<Straight> {
    let [width, height] = layout.pages[page];
    let mut image = Image::filled(width, height, Straight([0; 4]));
    let mut alphas = Image::filled(width, height, 0u8);
    for (index, frame) in layout.on_page(page) {
        let (picture, alpha) = sprite(index);
        let columns = frame.x as usize..(frame.x + frame.width) as usize;
        for y in 0..frame.height {
            image.row_mut(frame.y + y)[columns.clone()].copy_from_slice(picture.row(y));
            alphas.row_mut(frame.y + y)[columns.clone()].copy_from_slice(alpha.row(y));
        }
    }
    match content {
        PageContent::Color => bled(&image),
        PageContent::Data => bled_from(&image, &alphas),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn cells_never_touch_and_stay_on_their_page(
            sizes in prop::collection::vec((1u32..200, 1u32..200), 1..60)
        ) {
            let sizes: Vec<[u32; 2]> = sizes.into_iter().map(|(w, h)| [w, h]).collect();
            let settings = AtlasSettings { page_px: 512, ..Default::default() };
            let layout = atlas_layout(&sizes, settings).unwrap();
            let padding = settings.padding_px;
            for (index, placed) in layout.placed.iter().enumerate() {
                let [width, height] = layout.pages[placed.page];
                let frame = placed.frame;
                prop_assert_eq!([frame.width, frame.height], sizes[index]);
                prop_assert!(frame.x >= padding && frame.x + frame.width + padding <= width);
                prop_assert!(frame.y >= padding && frame.y + frame.height + padding <= height);
                prop_assert_eq!((frame.x - padding) % settings.alignment_px, 0);
                for other in &layout.placed[..index] {
                    let o = other.frame;
                    let apart = other.page != placed.page
                        || o.x + o.width + 2 * padding <= frame.x
                        || frame.x + frame.width + 2 * padding <= o.x
                        || o.y + o.height + 2 * padding <= frame.y
                        || frame.y + frame.height + 2 * padding <= o.y;
                    prop_assert!(apart);
                }
            }
        }
    }

    #[test]
    fn a_sprite_too_large_is_refused_and_pages_are_no_larger_than_needed() {
        let settings = AtlasSettings {
            page_px: 256,
            ..Default::default()
        };
        assert!(atlas_layout(&[[250, 10]], settings).is_err());
        let layout = atlas_layout(&[[100, 100]; 2], settings).unwrap();
        assert_eq!(layout.pages, [[256, 128]]);
    }

    #[test]
    fn gaps_get_the_colour_of_the_sprite_beside_them() {
        let layout = atlas_layout(&[[8, 8], [8, 8]], AtlasSettings::default()).unwrap();
        let pictures =
            [[200, 0, 0, 255], [0, 0, 200, 255]].map(|p| Image::filled(8, 8, Straight(p)));
        let opaque = Image::filled(8, 8, 255u8);
        let page = atlas_page(&layout, 0, PageContent::Color, |i| (&pictures[i], &opaque));
        for (index, frame) in layout.on_page(0) {
            let beside = page.at(frame.x - 2, frame.y + 4).0;
            assert!(beside[2 * index] > 150, "{index}: {beside:?}");
            assert_eq!(beside[3], 0, "gaps of colours stay clear");
        }
    }
}
