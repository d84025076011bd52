//! From a sheet of heights over a mask to a closed surface: the front sheet and its mirror image,
//! welded along the silhouette (thesis §4.3.2), for *any* mask.
//!
//! **Idea.** The pixels are vertices. Where a 2×2 block holds four mask pixels there are two
//! triangles, where it holds three there is one: a flat figure whose edge runs through silhouette
//! pixels, where z = 0. Two copies of the figure, front and back, glued along its edge, are a closed
//! surface, provided that the figure is a proper surface with an edge and that no inner edge of it
//! joins two points of its rim (front and back would coincide there). Three things are done to make
//! it so:
//!
//! - *Thin places* ([`thin`]): pixels that are in no triangle (lines of one pixel, single pixels) or in
//!   several fans of triangles (necks of one pixel, touching corners) get a rim around them, half a
//!   pixel away, and are lifted like the middle of a strip one pixel wide.
//! - *Chords* ([`plan`]): an inner edge between two points of the rim, as in a strip two pixels wide,
//!   gets a vertex in its middle, lifted likewise.
//! - *Lone triangles*: one without anything lifted gets a vertex in its middle.
//!
//! So mask pixels hang together as in [`crate::raster::labelled_components`] (to all eight neighbours;
//! the background to four): the surface has one part for each component of the mask and one handle
//! for each hole, down to holes of one pixel. The lift is that of an inflated strip of half-width r:
//! z = k r / 2, its height in the middle (ALGORITHMS: z = k R / 2 · (1 − t²)).
//!
//! **Order of vertices.** First the sheet, vertex i being mask pixel i by rows from the top; then
//! vertices added for thin places and chords; then the back. A pixel of a thin place keeps its
//! vertex in the list, at z = 0, but no triangle uses it.
//!
//! **Frame.** That of the mask: x to the right, y *down*, z towards the viewer, in pixels. The
//! triangles are counter-clockwise from outside when these numbers are read in a right-handed frame;
//! [`into_world`] turns the crown upright and keeps them so.
//!
//! **Limits.** A sheet with heights below 0 gives a surface that passes through itself; topology does
//! not mind. Vertices that the inflation moves sideways are taken where they are.

mod plan;
mod thin;

use crate::geometry::{Mesh, Point};
use crate::raster::{Image, Mask, Rect};
use glam::DVec3;
use plan::Plan;

/// The number of each mask pixel in rows from the top, [`NO_PIXEL`] elsewhere.
pub(super) fn numbered(mask: &Mask) -> Image<u32> {
    let mut next = 0;
    mask.map(|&inside| {
        if !inside {
            return NO_PIXEL;
        }
        next += 1;
        next - 1
    })
}

/// Where no pixel of the mask is.
pub(super) const NO_PIXEL: u32 = u32::MAX;

/// The closed surface of a sheet over `mask`; see the module.
///
/// `sheet` holds a position for each mask pixel by rows from the top, in pixels, z = 0 for
/// silhouette pixels (those with one of four neighbours outside). `slope` gives the tangent parameter
/// k ≥ 0 at a place of the mask, for parts too thin to have inner pixels.
///
/// ```
/// use boscage::crown::closed_surface;
/// use boscage::geometry::Topology;
/// use boscage::raster::Image;
/// use glam::DVec3;
/// let mask = Image::filled(1, 1, true);
/// let mesh = closed_surface(&mask, &[DVec3::ZERO], |_| 2.0);
/// assert!(Topology::of(&mesh).is_watertight());
/// assert_eq!(mesh.bounds().unwrap().1, DVec3::splat(0.5));
/// ```
///
/// # Panics
/// When `sheet` has another length than the mask has pixels.
pub fn closed_surface(mask: &Mask, sheet: &[DVec3], slope: impl Fn(Point) -> f64) -> Mesh {
    assert_eq!(sheet.len(), mask.count(), "one position a mask pixel");
    let mut plan = Plan::of_pixels(mask, sheet);
    thin::widen(&mut plan, mask, &slope);
    plan.divide_flat_triangles(&slope);
    plan.doubled()
}

/// A mesh over a mask, as [`closed_surface`] makes it, in the world's frame: metres, +Y up, the
/// lowest row of `bounds` at `base_m` above the ground, its middle at x = 0, the picture's plane at
/// z = 0.
pub fn into_world(mesh: &Mesh, bounds: Rect, metres_per_pixel: f64, base_m: f64) -> Mesh {
    let middle = f64::from(bounds.x) + f64::from(bounds.width - 1) / 2.0;
    let bottom = f64::from(bounds.y + bounds.height) - 0.5;
    let upright = mesh.moved(|p| {
        let up = DVec3::new(p.x - middle, bottom - p.y, p.z);
        up * metres_per_pixel + DVec3::Y * base_m
    });
    upright.reversed()
}
