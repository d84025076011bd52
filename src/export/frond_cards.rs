//! The fronds of a palm's crown as bent cards that go from its heart to its surface.
//!
//! Each frond is a strip along its rib, which rises in an arch and comes down to the surface; its two halves hang
//! from the rib like a roof. It has two sides of its own, back to back, for the reasons that
//! [`super::leaf_cards`] gives. A level of detail has fewer, wider fronds with fewer bends.

use super::leaf_cards::{
    COLOR_CELLS, SHADES, SPREAD, TWIG_PX, TWIGS, averaged, grouped, in_front, picture,
};
use super::model_mesh::ModelMesh;
use super::stem::Stand;
use crate::base::Seed;
use crate::crown::leaf_points;
use crate::raster::{Image, Straight, smoothed_cubemap};
use crate::render::{FROND_ARCH, FROND_SLENDER, fronds};
use crate::scene::Crown;
use glam::DVec3;

/// How far the edges of a frond hang below its rib, by half its width.
const HANGING: f64 = 0.35;

/// Distance between the two sides, as a share of a frond's length.
const SIDE_GAP: f64 = 1e-3;

/// Light of the fronds that hang lowest, and what rises adds to it.
const LOW_LIGHT: f64 = 0.75;
const HIGH_LIGHT: f64 = 0.35;

/// A frond before it is a card.
#[derive(Debug, Clone, Copy)]
struct Frond {
    /// From the heart to the tip, metres.
    rib: DVec3,
    /// Turn about its rib, radians.
    roll: f64,
    phase: f64,
    picture: u32,
    shade: usize,
}

/// All fronds of a crown, best beginning first, and their picture.
#[derive(Debug, Clone)]
pub(super) struct FrondCards {
    fronds: Vec<Frond>,
    heart: DVec3,
    /// Fronds in a row, shades below one another; colour bled under clear texels.
    pub(super) picture: Image<Straight>,
}

impl FrondCards {
    /// The `count` fronds of `crown`.
    pub(super) fn new(crown: &Crown, count: usize, seed: Seed) -> Self {
        let radius = smoothed_cubemap(&crown.radius_m, f64::from(crown.radius_m.size()) / 24.0);
        let colors = averaged(&crown.color, COLOR_CELLS);
        let mut random = seed.derive("frond cards", 0).random();
        let (mut all, mut wanted) = (Vec::new(), Vec::new());
        for point in leaf_points(count, seed) {
            let direction = point.try_normalize().unwrap_or(DVec3::Y);
            let reach = f64::from(radius.sampled(direction)) * random.between(0.86, 1.04);
            let light =
                LOW_LIGHT + HIGH_LIGHT * (0.5 + 0.5 * direction.y) + random.between(-0.1, 0.1);
            let color = colors.nearest(direction);
            wanted.push(color.map(|channel| channel * light as f32));
            all.push(Frond {
                rib: direction * reach,
                roll: random.between(-0.5, 0.5),
                phase: random.unit(),
                picture: random.below(TWIGS as usize) as u32,
                shade: 0,
            });
        }
        let (palette, shades) = grouped(&wanted);
        for (frond, shade) in all.iter_mut().zip(shades) {
            frond.shade = shade;
        }
        Self {
            fronds: all,
            heart: crown.center_m,
            picture: picture(&fronds(TWIG_PX, TWIGS, seed), &palette),
        }
    }

    /// The first `count` fronds, each with `bends` pieces.
    pub(super) fn cards(&self, count: usize, bends: u32, stand: &Stand) -> ModelMesh {
        let mut mesh = ModelMesh::default();
        let count = count.min(self.fronds.len());
        let wider = (self.fronds.len() as f64 / count.max(1) as f64).sqrt();
        for frond in &self.fronds[..count] {
            for side in [1.0, -1.0] {
                frond.add(
                    &mut mesh,
                    self.heart + stand.shift,
                    (wider, bends),
                    side,
                    stand,
                );
            }
        }
        mesh
    }
}

impl Frond {
    /// The place and the direction of the rib at a share of its length, from the heart.
    fn at(&self, share: f64) -> (DVec3, DVec3) {
        let arch = f64::from(FROND_ARCH) * self.rib.x.hypot(self.rib.z);
        let place = self.rib * share + DVec3::Y * (arch * 4.0 * share * (1.0 - share));
        let along = self.rib + DVec3::Y * (arch * 4.0 * (1.0 - 2.0 * share));
        (place, along.normalize_or(DVec3::Y))
    }

    /// Adds the upper side, or the lower one when `side` is −1.
    fn add(
        &self,
        mesh: &mut ModelMesh,
        heart: DVec3,
        (wider, bends): (f64, u32),
        side: f64,
        stand: &Stand,
    ) {
        let first = mesh.positions.len() as u32;
        let length = self.rib.length();
        let outward = self.rib.normalize_or(DVec3::Y);
        let half_width = 0.5 * f64::from(FROND_SLENDER) * length * wider.min(1.6);
        for bend in 0..=bends {
            let share = f64::from(bend) / f64::from(bends);
            let (place, along) = self.at(share);
            let level = along.cross(DVec3::Y);
            let level = level.try_normalize().unwrap_or(DVec3::X);
            let above = level.cross(along);
            let across = level * libm::cos(self.roll) + above * libm::sin(self.roll);
            let above = across.cross(along);
            for edge in [-1.0, 0.0, 1.0] {
                let hanging = HANGING * f64::abs(edge);
                let aside = (across * edge - above * hanging) * half_width;
                // The upper side of this half of the roof.
                let facing = (above + across * (HANGING * edge)).normalize() * side;
                let at = heart + place + aside + above * (side * SIDE_GAP * length);
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
        let cards = FrondCards::new(&crown, 20, Seed(1));
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
        for corners in mesh.indices.as_chunks::<3>().0 {
            let [a, b, c] = corners.map(|i| place(i as usize));
            let Some(face) = (b - a).cross(c - a).try_normalize() else {
                continue;
            };
            for corner in corners {
                let normal = Vec3::from(mesh.normals[*corner as usize]);
                assert!(normal.dot(face) > 0.0, "{normal} {face}");
            }
        }
    }
}
