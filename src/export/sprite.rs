//! A picture of a tree, made ready for an engine: trimmed, on a canvas whose sides suit textures,
//! colour bled under clear texels, with the place of its foot and the size of a pixel in metres.

use super::bleed::{Nearest, bled_with};
use crate::geometry::Point;
use crate::raster::{Image, Rect, Straight, opaque_bounds};

/// Clear pixels around the trimmed tree where the canvas is made to measure: room for a cut-out mesh
/// and for filters. Canvases of powers of two have what room there is.
const MARGIN_PX: u32 = 4;

/// How a sprite is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpriteSettings {
    /// Height of the tree from its foot to its top, in metres.
    pub height_m: f64,
    /// Whether both sides of the canvas are powers of two; otherwise multiples of 4.
    pub power_of_two: bool,
}

impl Default for SpriteSettings {
    fn default() -> Self {
        Self {
            height_m: 10.0,
            power_of_two: true,
        }
    }
}

/// Why a picture is no sprite.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SpriteError {
    /// No pixel shows.
    #[error("the picture is empty")]
    Empty,
    /// The foot is not below the top of the tree.
    #[error("the foot at {foot_y} is not below the tree's top at {top_y}")]
    FootAboveTop {
        /// Row of the foot.
        foot_y: f64,
        /// Row of the highest pixel.
        top_y: u32,
    },
}

/// A tree's picture on its canvas. Positions are in pixels from the canvas' top-left *corner*.
#[derive(Debug, Clone, PartialEq)]
pub struct Sprite {
    /// The canvas, colour bled under clear texels.
    pub image: Image<Straight>,
    /// Width and height of the picture that it was trimmed from.
    pub source: [u32; 2],
    /// The part of the picture that shows.
    pub trim: Rect,
    /// Where that part lies on the canvas.
    pub frame: Rect,
    /// The trunk's foot: the middle of the foot's pixel across, its lower edge down.
    pub pivot: Point,
    /// Side of a pixel.
    pub metres_per_pixel: f64,
    /// Where clear texels of the canvas take their values from.
    nearest: Nearest,
}

impl Sprite {
    /// The sprite of `image`, a tree whose foot is the pixel `foot` (pixel centres at whole
    /// numbers).
    ///
    /// # Errors
    /// [`SpriteError`].
    pub fn new(
        image: &Image<Straight>,
        foot: Point,
        settings: SpriteSettings,
    ) -> Result<Self, SpriteError> {
        let trim = opaque_bounds(&image.map(|p| p.alpha() > 0)).ok_or(SpriteError::Empty)?;
        let ground = foot.y + 1.0;
        let height_px = ground - f64::from(trim.y);
        if height_px.is_nan() || height_px < 1.0 {
            return Err(SpriteError::FootAboveTop {
                foot_y: foot.y,
                top_y: trim.y,
            });
        }
        let side = |pixels: u32| {
            if settings.power_of_two {
                // A margin is not worth a picture of four times the size.
                pixels.next_power_of_two()
            } else {
                (pixels + 2 * MARGIN_PX).next_multiple_of(4)
            }
        };
        let (width, height) = (side(trim.width), side(trim.height));
        let frame = Rect {
            x: (width - trim.width) / 2,
            y: (height - trim.height) / 2,
            ..trim
        };
        let offset = Point::new(f64::from(frame.x), f64::from(frame.y))
            - Point::new(f64::from(trim.x), f64::from(trim.y));
        let mut canvas = Image::filled(width, height, Straight([0; 4]));
        blit(&mut canvas, frame, image, trim);
        let nearest = Nearest::of(&canvas.map(|pixel| pixel.alpha()));
        Ok(Self {
            image: bled_with(&canvas, &nearest),
            source: [image.width(), image.height()],
            trim,
            frame,
            pivot: Point::new(foot.x + 0.5, ground) + offset,
            metres_per_pixel: settings.height_m / height_px,
            nearest,
        })
    }

    /// A map of the source picture, brought onto the canvas and continued under clear texels.
    ///
    /// # Panics
    /// When `map` is not as large as the source picture was.
    pub fn map<P: Copy + Default>(&self, map: &Image<P>) -> Image<P> {
        assert_eq!(
            [map.width(), map.height()],
            self.source,
            "a map fits its picture"
        );
        let mut canvas = Image::filled(self.image.width(), self.image.height(), P::default());
        blit(&mut canvas, self.frame, map, self.trim);
        self.nearest.continued(&canvas)
    }

    /// Position in metres, foot at the origin, +Y up, of the canvas position `at`.
    pub fn metres(&self, at: Point) -> Point {
        let offset = at - self.pivot;
        Point::new(offset.x, -offset.y) * self.metres_per_pixel
    }

    /// Texture coordinates of the canvas position `at`: (0, 0) top left, (1, 1) bottom right.
    pub fn uv(&self, at: Point) -> Point {
        Point::new(
            at.x / f64::from(self.image.width()),
            at.y / f64::from(self.image.height()),
        )
    }

    /// The frame as a rectangle of positions: its top-left and bottom-right corners.
    pub fn corners(&self) -> [Point; 2] {
        let Rect {
            x,
            y,
            width,
            height,
        } = self.frame;
        [
            Point::new(f64::from(x), f64::from(y)),
            Point::new(f64::from(x + width), f64::from(y + height)),
        ]
    }

    /// Width and height of the part that shows, in metres.
    pub fn size_m(&self) -> [f64; 2] {
        [self.frame.width, self.frame.height].map(|px| f64::from(px) * self.metres_per_pixel)
    }
}

fn blit<P: Copy>(canvas: &mut Image<P>, frame: Rect, image: &Image<P>, from: Rect) {
    for y in 0..frame.height {
        let row = &image.row(from.y + y)[from.x as usize..(from.x + from.width) as usize];
        canvas.row_mut(frame.y + y)[frame.x as usize..(frame.x + frame.width) as usize]
            .copy_from_slice(row);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tree() -> Image<Straight> {
        let mut image = Image::filled(60, 50, Straight([0; 4]));
        for y in 10..40 {
            for x in 20..30 {
                image.set(x, y, Straight([40, 120, 30, 255]));
            }
        }
        image
    }

    #[test]
    fn the_foot_is_the_origin_and_the_top_is_at_the_height() {
        let foot = Point::new(24.0, 39.0);
        let sprite = Sprite::new(&tree(), foot, SpriteSettings::default()).unwrap();
        assert_eq!((sprite.image.width(), sprite.image.height()), (16, 32));
        let [top_left, bottom_right] = sprite.corners().map(|corner| sprite.metres(corner));
        assert!((top_left.y - 10.0).abs() < 1e-12 && bottom_right.y.abs() < 1e-12);
        let pixel = 10.0 / 30.0;
        assert!((top_left.x + 4.5 * pixel).abs() < 1e-12, "{top_left}");
        assert_eq!(
            sprite.image.at(sprite.frame.x, sprite.frame.y).0,
            [40, 120, 30, 255]
        );
        assert_eq!(sprite.image.at(0, 0).0, [40, 120, 30, 0]);
    }

    #[test]
    fn odd_pictures_are_refused() {
        let settings = SpriteSettings::default();
        let empty = Image::filled(4, 4, Straight([9, 9, 9, 0]));
        assert_eq!(
            Sprite::new(&empty, Point::ZERO, settings),
            Err(SpriteError::Empty)
        );
        let floating = Sprite::new(&tree(), Point::new(0.0, 3.0), settings);
        assert!(matches!(floating, Err(SpriteError::FootAboveTop { .. })));
    }
}
