//! The fronds of a palm's crown as bent cards that go from its heart to its surface, and the boughs of a conifer's
//! that go there from its axis.
//!
//! Each is a strip along its rib, which rises in an arch and comes down to the surface; its two halves hang
//! from the rib like a roof. It has two sides of its own, back to back, for the reasons that
//! [`super::leaf_cards`] gives. A level of detail has fewer, wider ones with fewer bends.

use super::leaf_cards::{
    COLOR_CELLS, SHADES, SPREAD, TWIG_PX, TWIGS, averaged, grouped, in_front, picture,
};
use super::model_mesh::ModelMesh;
use super::stem::Stand;
use crate::base::Seed;
use crate::branches::leaf_name::LeafName;
use crate::crown::leaf_points;
use crate::raster::{Image, Straight, smoothed_cubemap};
use crate::render::{
    EVEN, INNER, Ribs, RibsFrom, WIDEST, bough_root, in_tiers, leaf_area, leaf_pictures,
};
use crate::scene::Crown;
use glam::DVec3;

/// How far the edges of a strip hang below its rib, by half its width.
const HANGING: f64 = 0.35;

/// Distance between the two sides, as a share of a rib's length.
const SIDE_GAP: f64 = 1e-3;

/// Light of those that hang lowest, and what rises adds to it.
const LOW_LIGHT: f64 = 0.75;
const HIGH_LIGHT: f64 = 0.35;

/// A frond or bough before it is a card.
#[derive(Debug, Clone, Copy)]
struct Rib {
    /// From the centre of the crown to where it begins, metres.
    root: DVec3,
    /// From there to its tip, metres.
    rib: DVec3,
    /// Of its strip, metres.
    half_width: f64,
    /// Turn about its rib, radians.
    roll: f64,
    phase: f64,
    picture: u32,
    shade: usize,
}

/// All fronds or boughs of a crown, best beginning first, and their picture.
#[derive(Debug, Clone)]
pub(super) struct RibCards {
    leaves: Vec<Rib>,
    center: DVec3,
    arch: f64,
    /// Pictures in a row, shades below one another; colour bled under clear texels.
    pub(super) picture: Image<Straight>,
}

impl RibCards {
    /// The `count` fronds or boughs of `crown`, which `ribs` describes; `leaf` is which of both.
    pub(super) fn new(
        crown: &Crown,
        (leaf, ribs): (LeafName, &Ribs),
        count: usize,
        seed: Seed,
    ) -> Self {
        let (_, most) = crown.radius_range_m();
        let mean_radius = crown.mean_radius_m();
        let slender = f64::from(ribs.slender) * f64::from(leaf_area(crown.cover)).sqrt();
        let is_tiered = ribs.from == RibsFrom::Axis;
        let radius = smoothed_cubemap(&crown.radius_m, f64::from(crown.radius_m.size()) / 24.0);
        let colors = averaged(&crown.color, COLOR_CELLS);
        let mut random = seed.derive("frond cards", 0).random();
        let (mut all, mut wanted) = (Vec::new(), Vec::new());
        for point in leaf_points(count, seed) {
            let mut direction = point.try_normalize().unwrap_or(DVec3::Y);
            if is_tiered {
                direction = in_tiers(direction.as_vec3()).as_dvec3();
            }
            let reach = f64::from(radius.sampled(direction)) * random.between(0.86, 1.04);
            let inner = if is_tiered { random.unit() } else { 0.0 };
            let reach = reach * (1.0 - INNER * inner * inner);
            let light =
                LOW_LIGHT + HIGH_LIGHT * (0.5 + 0.5 * direction.y) + random.between(-0.1, 0.1);
            let light = light * (1.0 - 0.5 * inner * inner);
            let color = colors.nearest(direction);
            wanted.push(color.map(|channel| channel * light as f32));
            let tip = direction * reach;
            let (root, length) = if is_tiered {
                let root = bough_root(tip.as_vec3(), most, mean_radius as f32).as_dvec3();
                let own = tip.distance(root);
                (root, own + (mean_radius - own) * EVEN)
            } else {
                (DVec3::ZERO, reach)
            };
            all.push(Rib {
                root,
                rib: tip - root,
                half_width: 0.5 * slender * length,
                roll: random.between(-0.5, 0.5),
                phase: random.unit(),
                picture: random.below(TWIGS as usize) as u32,
                shade: 0,
            });
        }
        let (palette, shades) = grouped(&wanted);
        for (leaf, shade) in all.iter_mut().zip(shades) {
            leaf.shade = shade;
        }
        Self {
            leaves: all,
            center: crown.center_m,
            arch: f64::from(ribs.arch),
            picture: picture(&leaf_pictures(leaf, TWIG_PX, TWIGS, seed), &palette),
        }
    }

    /// The first `count`, each with `bends` pieces.
    pub(super) fn cards(&self, count: usize, bends: u32, stand: &Stand) -> ModelMesh {
        let mut mesh = ModelMesh::default();
        let count = count.min(self.leaves.len());
        let wider = (self.leaves.len() as f64 / count.max(1) as f64).sqrt();
        let center = self.center + stand.shift;
        for leaf in &self.leaves[..count] {
            let drawn = Rib {
                root: center + leaf.root,
                half_width: leaf.half_width * wider.min(WIDEST),
                ..*leaf
            };
            for side in [1.0, -1.0] {
                drawn.add(&mut mesh, (self.arch, bends), side, (center, stand));
            }
        }
        mesh
    }
}

impl Rib {
    /// The place and the direction of the rib at a share of its length.
    fn at(&self, share: f64, arch: f64) -> (DVec3, DVec3) {
        let arch = arch * self.rib.x.hypot(self.rib.z);
        let place = self.root + self.rib * share + DVec3::Y * (arch * 4.0 * share * (1.0 - share));
        let along = self.rib + DVec3::Y * (arch * 4.0 * (1.0 - 2.0 * share));
        (place, along.normalize_or(DVec3::Y))
    }

    /// Adds the upper side, or the lower one when `side` is −1.
    fn add(
        &self,
        mesh: &mut ModelMesh,
        (arch, bends): (f64, u32),
        side: f64,
        (center, stand): (DVec3, &Stand),
    ) {
        let first = mesh.positions.len() as u32;
        let length = self.rib.length();
        let outward = (self.root + self.rib - center).normalize_or(DVec3::Y);
        for bend in 0..=bends {
            let share = f64::from(bend) / f64::from(bends);
            let (place, along) = self.at(share, arch);
            let level = along.cross(DVec3::Y);
            let level = level.try_normalize().unwrap_or(DVec3::X);
            let above = level.cross(along);
            let across = level * libm::cos(self.roll) + above * libm::sin(self.roll);
            let above = across.cross(along);
            for edge in [-1.0, 0.0, 1.0] {
                let hanging = HANGING * f64::abs(edge);
                let aside = (across * edge - above * hanging) * self.half_width;
                // The upper side of this half of the roof.
                let facing = (above + across * (HANGING * edge)).normalize() * side;
                let at = place + aside + above * (side * SIDE_GAP * length);
                let bent = (facing + outward * SPREAD).normalize_or(facing);
                let u = (f64::from(self.picture) + 0.5 + 0.5 * edge) / f64::from(TWIGS);
                let v = (self.shade as f64 + 1.0 - share) / SHADES as f64;
                mesh.positions.push(at.as_vec3().to_array());
                mesh.normals
                    .push(in_front(bent, facing).as_vec3().to_array());
                mesh.uvs.push([u as f32, v as f32]);
                let wind = [share, self.phase, stand.sway(at.y)];
                mesh.wind.push(wind.map(|weight| weight as f32));
            }
        }
        for bend in 0..bends {
            for half in 0..2 {
                let corner = first + bend * 3 + half;
                let (near, far) = ([corner, corner + 1], [corner + 3, corner + 4]);
                let quads = if side < 0.0 {
                    [near[0], far[1], near[1], near[0], far[0], far[1]]
                } else {
                    [near[0], near[1], far[1], near[0], far[1], far[0]]
                };
                mesh.indices.extend(quads);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn fronds_go_from_the_heart_to_the_surface_with_normals_in_front_of_their_sides() {
        let crown = Crown::ball(32);
        let stand = Stand {
            height_m: 7.0,
            shift: DVec3::ZERO,
        };
        let ribs = Ribs::of(LeafName::Frond).unwrap();
        let cards = RibCards::new(&crown, (LeafName::Frond, &ribs), 20, Seed(1));
        let mesh = cards.cards(20, 4, &stand);
        assert_eq!(mesh.positions.len(), 20 * 2 * 15);
        assert_eq!(mesh.indices.len(), 20 * 2 * 4 * 2 * 6);
        let place = |i: usize| Vec3::from(mesh.positions[i]);
        for frond in 0..40 {
            let rib = |row: usize| place(frond * 15 + row * 3 + 1) - Vec3::new(0.0, 5.0, 0.0);
            assert!(rib(0).length() < 0.01);
            assert!((1.7..2.1).contains(&rib(4).length()));
            // The arch: the middle of a rib is above the line between its ends.
            assert!(rib(2).y >= 0.5 * rib(4).y - 0.01);
        }
        assert!(least_facing(&mesh) > 0.0);
    }

    /// The least cosine between the normals of a mesh and the triangles they belong to.
    fn least_facing(mesh: &ModelMesh) -> f32 {
        let place = |i: u32| Vec3::from(mesh.positions[i as usize]);
        let triangles = mesh.indices.as_chunks::<3>().0.iter();
        let facing = triangles.filter_map(|corners| {
            let [a, b, c] = corners.map(place);
            let face = (b - a).cross(c - a).try_normalize()?;
            let normals = corners.map(|i| Vec3::from(mesh.normals[i as usize]).dot(face));
            normals.into_iter().reduce(f32::min)
        });
        facing.fold(1.0, f32::min)
    }

    #[test]
    fn boughs_go_from_beside_the_axis_to_the_surface_in_front_of_their_sides() {
        let crown = Crown::ball(32);
        let stand = Stand {
            height_m: 7.0,
            shift: DVec3::ZERO,
        };
        let ribs = Ribs::of(LeafName::Bough).unwrap();
        let cards = RibCards::new(&crown, (LeafName::Bough, &ribs), 60, Seed(1));
        let mesh = cards.cards(60, 2, &stand);
        assert_eq!(mesh.positions.len(), 60 * 2 * 9);
        let place = |i: usize| Vec3::from(mesh.positions[i]) - Vec3::new(0.0, 5.0, 0.0);
        let aside = |place: Vec3| place.x.hypot(place.z);
        for bough in 0..120 {
            let [root, tip] = [1, 7].map(|i| place(bough * 9 + i));
            assert!((1.0..2.1).contains(&tip.length()), "{tip}");
            assert!(aside(root) < 0.5 * aside(tip) + 0.02, "{root} {tip}");
        }
        assert!(least_facing(&mesh) > 0.0);
    }
}
