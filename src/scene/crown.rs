//! A crown, ready to be drawn.

use crate::geometry::Mesh;
use crate::raster::{Cubemap, Straight};
use glam::DVec3;

/// The crown of a tree: how far it reaches and what it looks like in every direction from its
/// centre (thesis §4.6).
#[derive(Debug, Clone, PartialEq)]
pub struct Crown {
    /// Where the centre of the crown is, metres, in the frame of the tree (base at the origin).
    pub center_m: DVec3,
    /// Distance from the centre to the surface, metres, > 0; relief included. Its texel size may
    /// differ from that of `color`.
    pub radius_m: Cubemap<f32>,
    /// Colour of the surface, opaque, sRGB.
    pub color: Cubemap<Straight>,
    /// Relief: 0 deep between the leaves, 1 far out (the h of thesis §4.6). Of the size of `color`.
    pub height: Cubemap<f32>,
    /// The base mesh before relief, metres, in the frame of the tree.
    pub base_mesh: Mesh,
}

impl Crown {
    /// The smallest and largest radius, R_min and R_max of thesis §5.1, metres.
    pub fn radius_range_m(&self) -> (f32, f32) {
        let texels = self.radius_m.faces().iter().flat_map(|face| face.pixels());
        texels.fold((f32::INFINITY, 0.0), |(low, high), &radius| {
            (low.min(radius), high.max(radius))
        })
    }
}
