//! The studio that trees are shown in: backdrop, floor, shadows.

use super::paint::Canvas;
use crate::geometry::Point;
use crate::raster::{Image, Mask, Premultiplied, Rect, opaque_bounds, resized};

/// Backdrop at the top and at the bottom of a sheet: warm greys, dark enough for snow and light
/// enough for firs.
const BACKDROP: [[f64; 3]; 2] = [[222.0, 219.0, 213.0], [201.0, 197.0, 189.0]];

/// Colour that shadows tend to.
const SHADOW: [f64; 3] = [52.0, 47.0, 42.0];

/// Alpha from which a pixel counts as part of the tree when it is placed.
const SEEN_ALPHA: u8 = 24;

/// A canvas with the backdrop on it.
pub(super) fn backdrop(width: u32, height: u32) -> Canvas {
    let mut canvas = Canvas::new(width, height, [0, 0, 0, 255]);
    let last = f64::from(height.max(2) - 1);
    canvas.shade(|_, y, _| {
        let t = f64::from(y) / last;
        std::array::from_fn(|i| BACKDROP[0][i] * (1.0 - t) + BACKDROP[1][i] * t)
    });
    canvas
}

/// A tree cut out of its picture, at its final size.
pub(super) struct Standing {
    /// The tree.
    image: Image<Premultiplied>,
    /// Where it touches the ground: first and last column of `image`.
    foot: (f64, f64),
}

/// The part of `image` that shows a tree; `None` when it is clear.
pub(super) fn tree_bounds(image: &Image<Premultiplied>) -> Option<Rect> {
    opaque_bounds(&seen(image))
}

fn seen(image: &Image<Premultiplied>) -> Mask {
    image.map(|pixel| pixel.alpha() >= SEEN_ALPHA)
}

impl Standing {
    /// The part `bounds` of `image`, `scale` times as large.
    pub(super) fn new(image: &Image<Premultiplied>, bounds: Rect, scale: f64) -> Self {
        let side = |pixels: u32| ((f64::from(pixels) * scale).round() as u32).max(1);
        Self::whole(resized(
            image,
            bounds,
            side(bounds.width),
            side(bounds.height),
        ))
    }

    /// All of `image`, at its size.
    pub(super) fn whole(image: Image<Premultiplied>) -> Self {
        let foot = foot(&image);
        Self { image, foot }
    }

    /// The tree.
    pub(super) fn into_image(self) -> Image<Premultiplied> {
        self.image
    }

    /// Puts the tree on the ground line `ground` pixels from the top, centred on x = `middle`.
    pub(super) fn draw(&self, canvas: &mut Canvas, middle: f64, ground: u32) {
        let left = (middle - f64::from(self.image.width()) / 2.0).round() as i64;
        let top = i64::from(ground) - i64::from(self.image.height());
        canvas.lay(&self.image, left, top, 1.0);
    }

    /// The shadows below the tree: a wide soft one of the crown, a tight one at the foot.
    pub(super) fn shadows(&self, middle: f64, ground: u32) -> [Shadow; 2] {
        let width = f64::from(self.image.width());
        let left = middle - width / 2.0;
        let foot_middle = left + (self.foot.0 + self.foot.1) / 2.0;
        let foot_width = self.foot.1 - self.foot.0 + 1.0;
        let at = |x: f64| Point::new(x, f64::from(ground) - 0.5);
        let of_crown = 0.46 * width;
        let of_foot = 0.62 * foot_width + 0.025 * width;
        [
            Shadow {
                centre: at((middle + foot_middle) / 2.0),
                radii: Point::new(of_crown, (0.13 * of_crown).max(2.0)),
                strength: 0.26,
            },
            Shadow {
                centre: at(foot_middle),
                radii: Point::new(of_foot, (0.16 * of_foot).max(1.5)),
                strength: 0.42,
            },
        ]
    }
}

/// First and last column of the tree within a little height above the ground.
fn foot(image: &Image<Premultiplied>) -> (f64, f64) {
    let high = (image.height() / 40).max(1);
    let low = image.cropped(0, image.height() - high, image.width(), high);
    match opaque_bounds(&seen(&low)) {
        Some(bounds) => (f64::from(bounds.x), f64::from(bounds.x + bounds.width - 1)),
        None => (0.0, f64::from(image.width() - 1)),
    }
}

/// A soft ellipse on the floor.
pub(super) struct Shadow {
    centre: Point,
    radii: Point,
    /// Darkness at the centre, 0 to 1.
    strength: f64,
}

impl Shadow {
    /// Darkness at a point, 0 to 1: a bell that ends smoothly at the ellipse.
    fn at(&self, point: Point) -> f64 {
        let r = ((point - self.centre) / self.radii).length_squared();
        if r >= 1.0 {
            return 0.0;
        }
        self.strength * (1.0 - r) * (1.0 - r)
    }
}

/// Draws shadows; where several meet the light that is left is the product.
pub(super) fn draw_shadows(canvas: &mut Canvas, shadows: &[Shadow]) {
    for shadow in shadows {
        let low = (shadow.centre - shadow.radii).floor().max(Point::ZERO);
        let high = (shadow.centre + shadow.radii).ceil().max(Point::ZERO);
        let (columns, rows) = (low.x as u32..high.x as u32, low.y as u32..high.y as u32);
        canvas.shade_part(columns, rows, |x, y, color| {
            let dark = shadow.at(Point::new(f64::from(x), f64::from(y)));
            std::array::from_fn(|i| color[i] + (SHADOW[i] - color[i]) * dark)
        });
    }
}
