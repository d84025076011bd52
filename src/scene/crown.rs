//! A crown, ready to be drawn.

use super::StemLook;
use crate::geometry::Mesh;
use crate::raster::{CubeFace, Cubemap, Straight};
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
    /// How much of the crown's outline leaves fill, as one sees it: 0 nothing, 1 no sky shows through.
    pub cover: f32,
    /// What its picture shows of the stem, if anything.
    pub stem: Option<StemLook>,
}

impl Crown {
    /// A ball of 2 m, 5 m above the ground, with cubemaps of `size`, for tests.
    #[cfg(test)]
    pub(crate) fn ball(size: u32) -> Self {
        Self {
            center_m: DVec3::new(0.0, 5.0, 0.0),
            radius_m: Cubemap::filled(size, 2.0),
            color: Cubemap::filled(size, Straight([90, 120, 60, 255])),
            height: Cubemap::filled(size, 0.5),
            base_mesh: Mesh::default(),
            cover: 1.0,
            stem: None,
        }
    }

    /// The smallest and largest radius, R_min and R_max of thesis §5.1, metres.
    pub fn radius_range_m(&self) -> (f32, f32) {
        let texels = self.radius_m.faces().iter().flat_map(|face| face.pixels());
        texels.fold((f32::INFINITY, 0.0), |(low, high), &radius| {
            (low.min(radius), high.max(radius))
        })
    }

    /// The mean of all texels of the radius, metres.
    pub fn mean_radius_m(&self) -> f64 {
        let faces = self.radius_m.faces();
        let sums = faces
            .iter()
            .map(|face| face.pixels().iter().map(|&r| f64::from(r)).sum::<f64>());
        let count = 6 * faces[0].pixels().len();
        sums.sum::<f64>() / count as f64
    }

    /// The middle of the whole tree, half-way between its base and its top above or below the
    /// crown's centre, and the radius of a ball around it that holds the tree; metres.
    pub fn tree_bounds(&self) -> (DVec3, f64) {
        let mut points = vec![DVec3::ZERO];
        let size = self.radius_m.size();
        let place = |i: usize| (2.0 * i as f64 + 1.0) / f64::from(size) - 1.0;
        for face in CubeFace::ALL {
            for (i, &radius) in self.radius_m.face(face).pixels().iter().enumerate() {
                let (x, y) = (i % size as usize, i / size as usize);
                let direction = face.direction(place(x), place(y)).normalize();
                points.push(self.center_m + direction * f64::from(radius));
            }
        }
        let heights = points.iter().map(|point| point.y);
        let (low, high) =
            heights.fold((0.0f64, 0.0f64), |(low, high), y| (low.min(y), high.max(y)));
        let middle = DVec3::new(self.center_m.x, 0.5 * (low + high), self.center_m.z);
        let distances = points.iter().map(|point| point.distance_squared(middle));
        (middle, distances.fold(0.0, f64::max).sqrt())
    }
}
