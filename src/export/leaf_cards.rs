//! The leaves of a crown as cards: pairs of crossed pictures of twigs that face outwards.
//!
//! Places are those of [`leaf_points`], drawn to the crown's smoothed radius as the renderer does;
//! n cards have sides of 1/√n, so that any number covers the crown alike, and a level of detail is a
//! beginning of the list. Each card is tilted at random out of the surface and crossed with one at a
//! right angle: from no side is a crown seen edge-on. Normals are those of the smoothed crown, bent
//! towards the corners of the card, which shades a crown as one body.
//!
//! Sides. The card that faces outwards has a front only: its back would be seen from inside. The one
//! across it has two sides of its own, back to back, since readers turn normals of a material that
//! draws both sides round behind, and half of such cards would be dark. Each side's normals are kept
//! in front of it, or a path tracer would light it through the card. Cards have the outline of their
//! twig ([`octagon`]), not that of their square.
//!
//! Colours stand in the picture: each twig is there in some shades, which are means of groups of
//! leaves of like brightness, and a leaf takes the nearest. So no reader needs vertex colours, and
//! these stay free for wind.
//!
//! Limit: with eight shades the differences of hue within a crown are those between its bright and
//! its dark leaves.

use super::bleed::bled;
use super::leaf_alpha::lasting;
use super::model_mesh::ModelMesh;
use super::stem::Stand;
use super::twig_outline::octagon;
use crate::base::{Random, Seed};
use crate::branches::leaf_name::LeafName;
use crate::branches::twig_canvas::TwigTexel;
use crate::crown::leaf_points;
use crate::raster::{CubeFace, Cubemap, Image, Straight, smoothed_cubemap};
use crate::render::{leaf_area, leaf_pictures, linear, srgb_byte};
use crate::scene::Crown;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Texels along a side of a twig.
pub(super) const TWIG_PX: u32 = 256;
/// Different twigs, side by side.
pub(super) const TWIGS: u32 = 4;
/// Shades of each, one below the other.
pub(super) const SHADES: usize = 8;
/// Half the side of a card in mean radii of the crown, times the root of their number: between the
/// renderer's 4, whose leaves all face the eye, and 5, where single cards stand out.
const CARD_SIZE: f64 = 4.4;
/// How far into the crown leaves reach, as a share of its radius: what lies deeper is hidden.
const DEEPEST: f64 = 0.62;
/// How far cards are drawn back from the surface, in halves of their side.
const DRAWN_BACK: f64 = 0.45;
/// How far a card may tilt out of the surface: length of a random vector added to the unit normal.
const TILT: f64 = 0.7;
/// Distance of a side from the middle of its card, as a share of half its length; see
/// [`super::cards`].
const SIDE_GAP: f64 = 2e-3;
/// Least cosine between normals and the side they belong to.
const LEAST_FACING: f64 = 0.1;
/// Least coverage, of 255, that stays inside a twig's outline.
const LEAST_COVERAGE: u8 = 32;
/// How much normals spread over a card.
pub(super) const SPREAD: f64 = 0.5;
/// Texels along a face of the colours that leaves take: larger ones would be speckled.
pub(super) const COLOR_CELLS: u32 = 24;

/// A leaf before it is a card.
#[derive(Debug, Clone, Copy)]
struct Leaf {
    /// Direction from the crown's centre.
    direction: DVec3,
    /// Share of the way from [`DEEPEST`] to the surface.
    share: f64,
    /// Of the card's plane.
    facing: DVec3,
    /// Unit vector in that plane.
    right: DVec3,
    /// Normal of the smoothed crown.
    normal: DVec3,
    /// Radius in its direction, metres.
    reach: f64,
    /// Factor on its size.
    size: f64,
    phase: f64,
    twig: u32,
    shade: usize,
}

/// All leaves of a crown, best beginning first, and their picture.
#[derive(Debug, Clone)]
pub(super) struct LeafCards {
    leaves: Vec<Leaf>,
    center: DVec3,
    mean_radius: f64,
    /// Factor on the sides of cards: sparse crowns have smaller ones, with sky between them.
    smaller: f64,
    /// Outline of each twig, in halves of its card's side.
    outlines: Vec<[DVec2; 8]>,
    /// Twigs in a row, shades below one another; colour bled under clear texels.
    pub(super) picture: Image<Straight>,
}

impl LeafCards {
    /// The `count` leaves of `crown`.
    pub(super) fn new(crown: &Crown, kind: LeafName, count: usize, seed: Seed) -> Self {
        let size = crown.radius_m.size();
        let radius = smoothed_cubemap(&crown.radius_m, f64::from(size) / 24.0);
        let texels = radius.faces().iter().flat_map(|face| face.pixels());
        let sum: f64 = texels.map(|&r| f64::from(r)).sum();
        let mean_radius = sum / f64::from(6 * size * size);
        let colors = averaged(&crown.color, COLOR_CELLS);
        let mut random = seed.derive("leaf cards", 0).random();
        let (mut leaves, mut wanted) = (Vec::new(), Vec::new());
        for point in leaf_points(count, seed) {
            let leaf = placed(point, &radius, &mut random);
            let deep = 0.5 + 0.5 * leaf.share;
            let light = deep * random.between(0.88, 1.12);
            wanted.push(
                colors
                    .nearest(leaf.direction)
                    .map(|channel| channel * light as f32),
            );
            leaves.push(leaf);
        }
        let (palette, shades) = grouped(&wanted);
        for (leaf, shade) in leaves.iter_mut().zip(shades) {
            leaf.shade = shade;
        }
        let twigs = leaf_pictures(kind, TWIG_PX, TWIGS, seed);
        let shows = |twig: &Image<TwigTexel>| twig.map(|texel| texel.coverage >= LEAST_COVERAGE);
        Self {
            leaves,
            center: crown.center_m,
            mean_radius,
            smaller: f64::from(leaf_area(crown.cover)).sqrt(),
            outlines: twigs.iter().map(|twig| octagon(&shows(twig))).collect(),
            picture: picture(&twigs, &palette),
        }
    }

    /// The first `count` leaves as pairs of crossed cards.
    pub(super) fn cards(&self, count: usize, stand: &Stand) -> ModelMesh {
        let count = count.min(self.leaves.len());
        let side = CARD_SIZE * self.smaller * self.mean_radius / (count.max(1) as f64).sqrt();
        let mut mesh = ModelMesh::default();
        for leaf in &self.leaves[..count] {
            let half = side * leaf.size;
            let inner = DEEPEST + (1.0 - DEEPEST) * leaf.share;
            let out = (leaf.reach * inner - DRAWN_BACK * half).max(0.0);
            let center = self.center + stand.shift + leaf.direction * out;
            let [right, up, facing] =
                [leaf.right, leaf.facing.cross(leaf.right), leaf.facing].map(|axis| axis * half);
            let outline = &self.outlines[leaf.twig as usize];
            for (right, side) in [(right, 1.0), (facing, 1.0), (facing, -1.0)] {
                leaf.add(&mut mesh, outline, center, [right, up], side, stand);
            }
        }
        mesh
    }
}

impl Leaf {
    /// Adds one side of the card at `center` with the half axes `axes`: its front, or its back when
    /// `side` is −1.
    fn add(
        &self,
        mesh: &mut ModelMesh,
        outline: &[DVec2; 8],
        center: DVec3,
        axes: [DVec3; 2],
        side: f64,
        stand: &Stand,
    ) {
        let first = mesh.positions.len() as u32;
        let toward = axes[0].cross(axes[1]).normalize() * side;
        let half = axes[0].length();
        for corner in outline {
            let offset = axes[0] * corner.x + axes[1] * corner.y;
            let at = center + offset + toward * (SIDE_GAP * half);
            let bent = (self.normal + offset.normalize_or_zero() * SPREAD).normalize();
            let u = (f64::from(self.twig) + 0.5 + 0.5 * corner.x) / f64::from(TWIGS);
            let v = (self.shade as f64 + 0.5 - 0.5 * corner.y) / SHADES as f64;
            let free = if offset.dot(self.direction) > 0.0 {
                1.0
            } else {
                0.35
            };
            mesh.positions.push(at.as_vec3().to_array());
            mesh.normals
                .push(in_front(bent, toward).as_vec3().to_array());
            mesh.uvs.push([u as f32, v as f32]);
            mesh.wind
                .push([free, self.phase, stand.sway(at.y)].map(|weight| weight as f32));
        }
        let turned = |[a, b]: [u32; 2]| if side > 0.0 { [a, b] } else { [b, a] };
        let fan = (1..outline.len() as u32 - 1).flat_map(|i| {
            let [b, c] = turned([i, i + 1]);
            [0, b, c]
        });
        mesh.indices.extend(fan.map(|corner| first + corner));
    }
}

/// The unit vector `normal`, turned towards `side` until it is in front of it.
pub(super) fn in_front(normal: DVec3, side: DVec3) -> DVec3 {
    let facing = normal.dot(side);
    if facing >= LEAST_FACING {
        return normal;
    }
    let along = (normal - side * facing).normalize_or_zero();
    let share = (1.0 - LEAST_FACING * LEAST_FACING).sqrt();
    (along * share + side * LEAST_FACING).normalize()
}

/// The leaf at `point` of the unit ball.
fn placed(point: DVec3, radius: &Cubemap<f32>, random: &mut Random) -> Leaf {
    let direction = point.try_normalize().unwrap_or(DVec3::Y);
    let normal = surface_normal(radius, direction);
    let mut cube = || random.between(-1.0, 1.0);
    let tilt = DVec3::new(cube(), cube(), cube()) * TILT;
    let facing = (normal + tilt).try_normalize().unwrap_or(normal);
    let turn = random.between(0.0, std::f64::consts::TAU);
    let (across, along) = facing.any_orthonormal_pair();
    Leaf {
        direction,
        share: point.length(),
        facing,
        right: across * libm::cos(turn) + along * libm::sin(turn),
        normal,
        reach: f64::from(radius.sampled(direction)),
        size: random.between(0.8, 1.2),
        phase: random.unit(),
        twig: random.below(TWIGS as usize) as u32,
        shade: 0,
    }
}

/// The outward normal of the surface that `radius` stands for.
fn surface_normal(radius: &Cubemap<f32>, direction: DVec3) -> DVec3 {
    /// Over which it is taken, as a share of the radius: a leaf is not smaller.
    const STEP: f64 = 0.1;
    let (right, up) = direction.any_orthonormal_pair();
    let place = |aside: DVec3| {
        let toward = (direction + aside * STEP).normalize();
        toward * f64::from(radius.sampled(toward))
    };
    let across = place(right) - place(-right);
    let along = place(up) - place(-up);
    let normal = across.cross(along).try_normalize().unwrap_or(direction);
    normal * normal.dot(direction).signum()
}

/// Means of the linear colours in `cells` × `cells` squares of each face.
pub(super) fn averaged(color: &Cubemap<Straight>, cells: u32) -> Cubemap<[f32; 3]> {
    let size = color.size();
    let cells = cells.min(size);
    let faces = CubeFace::ALL.map(|face| {
        let texels = color.face(face);
        let range = |i: u32| i * size / cells..(i + 1) * size / cells;
        let mean = |i: u32| {
            let (mut sum, mut count) = ([0.0f64; 3], 0.0);
            for y in range(i / cells) {
                for x in range(i % cells) {
                    let Straight([r, g, b, _]) = texels.at(x, y);
                    for (sum, byte) in sum.iter_mut().zip([r, g, b]) {
                        *sum += f64::from(linear(byte));
                    }
                    count += 1.0;
                }
            }
            sum.map(|sum| (sum / count) as f32)
        };
        Image::from_pixels(cells, cells, (0..cells * cells).map(mean).collect())
    });
    Cubemap::from_faces(faces)
}

/// Means of [`SHADES`] groups of like brightness and like size, dark to bright, and the group of
/// each colour.
pub(super) fn grouped(colors: &[[f32; 3]]) -> (Vec<[f32; 3]>, Vec<usize>) {
    let light = |[r, g, b]: [f32; 3]| 0.2126 * r + 0.7152 * g + 0.0722 * b;
    let mut order: Vec<usize> = (0..colors.len()).collect();
    order.sort_by(|&a, &b| {
        light(colors[a])
            .total_cmp(&light(colors[b]))
            .then(a.cmp(&b))
    });
    let mut groups = vec![0; colors.len()];
    let mut palette = vec![[0.0; 3]; SHADES];
    for (group, mean) in palette.iter_mut().enumerate() {
        let members = &order[group * order.len() / SHADES..(group + 1) * order.len() / SHADES];
        let mut sum = [0.0f64; 3];
        for &member in members {
            groups[member] = group;
            for (sum, channel) in sum.iter_mut().zip(colors[member]) {
                *sum += f64::from(channel);
            }
        }
        *mean = sum.map(|sum| (sum / members.len().max(1) as f64) as f32);
    }
    (palette, groups)
}

/// The twigs in all colours of `palette`.
pub(super) fn picture(twigs: &[Image<TwigTexel>], palette: &[[f32; 3]]) -> Image<Straight> {
    let width = TWIG_PX * TWIGS;
    let texel = |x: u32, y: u32| {
        let twig = &twigs[(x / TWIG_PX) as usize];
        let texel = twig.at(x % TWIG_PX, y % TWIG_PX);
        let color = palette[(y / TWIG_PX) as usize];
        let [r, g, b] = color.map(|channel| {
            let shaded = channel * f32::from(texel.shade) / 128.0;
            srgb_byte(shaded.clamp(0.0, 1.0))
        });
        Straight([r, g, b, texel.coverage])
    };
    let rows: Vec<Straight> = (0..TWIG_PX * SHADES as u32)
        .into_par_iter()
        .flat_map_iter(|y| (0..width).map(move |x| texel(x, y)))
        .collect();
    lasting(&bled(&Image::from_pixels(
        width,
        TWIG_PX * SHADES as u32,
        rows,
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_of_like_brightness_and_size() {
        let colors: Vec<[f32; 3]> = (0..80).map(|i| [(i * 37 % 80) as f32 / 80.0; 3]).collect();
        let (palette, groups) = grouped(&colors);
        assert!(palette.windows(2).all(|pair| pair[0][0] < pair[1][0]));
        for (color, group) in colors.iter().zip(groups) {
            assert!((color[0] - palette[group][0]).abs() < 0.1);
        }
    }

    #[test]
    fn normals_stay_in_front_of_their_side() {
        let side = DVec3::Z;
        let slanted = DVec3::new(0.6, 0.0, 0.8);
        assert_eq!(in_front(slanted, side), slanted);
        let turned = in_front(DVec3::new(0.6, 0.0, -0.8), side);
        assert!((turned.length() - 1.0).abs() < 1e-12);
        assert!((turned.z - LEAST_FACING).abs() < 1e-12 && turned.x > 0.9);
        assert!(in_front(-side, side).distance(side) < 1e-12);
    }

    #[test]
    fn a_leaf_has_three_sides_whose_normals_are_in_front() {
        let crown = Crown::ball(32);
        let stand = Stand {
            height_m: 7.0,
            shift: DVec3::ZERO,
        };
        let leaves = LeafCards::new(&crown, LeafName::Ovate, 40, Seed(1));
        let mesh = leaves.cards(40, &stand);
        assert_eq!(mesh.positions.len(), 40 * 3 * 8);
        assert_eq!(mesh.indices.len(), 40 * 3 * 6 * 3);
        for corners in mesh.indices.as_chunks::<3>().0 {
            let [a, b, c] =
                corners.map(|i| glam::Vec3::from(mesh.positions[i as usize]).as_dvec3());
            let Some(face) = (b - a).cross(c - a).try_normalize() else {
                continue;
            };
            for corner in corners {
                let normal = glam::Vec3::from(mesh.normals[*corner as usize]).as_dvec3();
                assert!(normal.dot(face) > 0.05, "{normal} {face}");
            }
        }
    }

    #[test]
    fn averages_are_those_of_the_cells() {
        let mut map = Cubemap::filled(4, Straight([255; 4]));
        map.face_mut(CubeFace::ALL[2]).set(0, 0, Straight([0; 4]));
        let mean = averaged(&map, 2);
        assert_eq!(mean.face(CubeFace::ALL[2]).at(0, 0), [0.75; 3]);
        assert_eq!(mean.face(CubeFace::ALL[3]).at(1, 1), [1.0; 3]);
    }
}
