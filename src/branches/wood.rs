//! Painting wood: stem, limbs, root spurs and twigs.
//!
//! Wood is painted as tapered pieces between skeleton nodes: in the picture each is the set of
//! points nearer to its axis than its radius there, so round ends join bent limbs without gaps.
//! A sample's normal is that of a round limb; bark is a function of the place around and along.

use super::canvas::{Canvas, Part};
use super::light::{Reached, TO_SUN};
use super::noise::{noise2, ramp};
use super::render::{SKY, STRAY, SUN, Subject, View, bytes, covered, linear_from_srgb, shown};
use glam::{Vec2, Vec3};

/// A tapered, straight piece of wood between two points.
struct Piece {
    from: Vec3,
    to: Vec3,
    /// Radii at both ends in metres.
    radius_m: (f32, f32),
    /// Length of wood from the root to `from`, in metres.
    path_m: f32,
    part: Part,
    salt: u32,
}

/// Paints the skeleton's limbs and the foot of the stem.
pub(super) fn paint_wood(canvas: &mut Canvas, view: &View, subject: &Subject<'_>) {
    let stem_m = subject.girth.radius_m.first().copied().unwrap_or(0.1);
    for (index, node) in subject.skeleton.nodes.iter().enumerate() {
        let Some(parent) = node.parent else { continue };
        let from = subject.skeleton.nodes[parent as usize].position;
        let radius = |node: usize, y: f32| subject.girth.radius_m[node] * flare(y, stem_m);
        // A branch starts no thicker than twice its own radius inside its parent.
        let thin = radius(index, node.position.y);
        let thick = radius(parent as usize, from.y).min(thin * 1.25);
        let low = from.y.min(node.position.y) < subject.crown_base_m;
        let piece = Piece {
            from,
            to: node.position,
            radius_m: (thick, thin),
            path_m: subject.girth.path_m[parent as usize],
            part: if low && thin > 0.22 * stem_m {
                Part::Trunk
            } else {
                Part::Crown
            },
            salt: 0,
        };
        paint_piece(canvas, view, subject, &piece);
    }
    paint_roots(canvas, view, subject, stem_m);
}

/// Widening of the stem towards the ground.
fn flare(y: f32, stem_m: f32) -> f32 {
    1.0 + 0.42 * libm::expf(-y.max(0.0) / (1.9 * stem_m))
}

/// Root spurs that run from the foot into the ground.
fn paint_roots(canvas: &mut Canvas, view: &View, subject: &Subject<'_>, stem_m: f32) {
    if stem_m < 0.09 {
        return;
    }
    // Radii, heights and reaches in stem radii; three points make a spur's hollow curve.
    for spur in 0..7u32 {
        let chance = |salt: u32| noise2(spur as f32 * 5.13 + 0.4, stem_m * 50.0, salt);
        let angle = spur as f32 * 0.93 + 0.4 * chance(77);
        let out = Vec3::new(libm::cosf(angle), 0.0, libm::sinf(angle)) * stem_m;
        let up = Vec3::Y * stem_m;
        let reach = 1.65 + 0.45 * chance(78);
        let points = [
            (out * 0.42 + up * (2.5 + 0.6 * chance(79)), 0.50),
            (out * 0.78 + up * 0.95, 0.36),
            (out * reach - up * 0.12, 0.24),
        ];
        for pair in points.windows(2) {
            let piece = Piece {
                from: pair[0].0,
                to: pair[1].0,
                radius_m: (stem_m * pair[0].1, stem_m * pair[1].1),
                path_m: spur as f32 * 0.7,
                part: Part::Trunk,
                salt: spur,
            };
            paint_piece(canvas, view, subject, &piece);
        }
    }
}

/// Paints the twigs that bear leaves.
pub(super) fn paint_twigs(canvas: &mut Canvas, view: &View, subject: &Subject<'_>) {
    for twig in &subject.leafage.twigs {
        let piece = Piece {
            from: twig.from,
            to: twig.to,
            radius_m: (0.006, 0.003),
            path_m: 0.0,
            part: Part::Crown,
            salt: 0,
        };
        paint_piece(canvas, view, subject, &piece);
    }
}

fn paint_piece(canvas: &mut Canvas, view: &View, subject: &Subject<'_>, piece: &Piece) {
    /// Thinnest radius in samples: thinner wood would break into dots.
    const THINNEST: f32 = 0.75;
    let (from, to) = (
        view.samples_from_tree(piece.from),
        view.samples_from_tree(piece.to),
    );
    let radius = (
        (piece.radius_m.0 * view.scale).max(THINNEST),
        (piece.radius_m.1 * view.scale).max(THINNEST),
    );
    let widest = Vec2::splat(radius.0.max(radius.1) + 1.0);
    let Some((columns, rows)) = covered(canvas, from.min(to) - widest, from.max(to) + widest)
    else {
        return;
    };
    let axis = to - from;
    let length_squared = axis.length_squared().max(1e-6);
    let wood = Wood::new(view, subject, piece);
    for y in rows {
        for x in columns.clone() {
            let offset = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) - from;
            let t = (offset.dot(axis) / length_squared).clamp(0.0, 1.0);
            let here = radius.0 + (radius.1 - radius.0) * t;
            let aside = offset - axis * t;
            let across = aside.length() / here;
            if across >= 1.0 {
                continue;
            }
            let toward = (1.0 - across * across).sqrt();
            let depth = piece.from.z + (piece.to.z - piece.from.z) * t + toward * here / view.scale;
            if canvas.sees(x, y, depth) {
                let normal = Vec3::new(aside.x / here, -aside.y / here, toward);
                let along = offset.dot(axis) / length_squared;
                canvas.put(x, y, depth, wood.colour(normal, t, along), piece.part);
            }
        }
    }
}

/// What the samples of one piece of wood have in common.
struct Wood<'a> {
    subject: &'a Subject<'a>,
    piece: &'a Piece,
    ends: [Reached; 2],
    length_m: f32,
    right: Vec3,
    fine: bool,
}

impl<'a> Wood<'a> {
    fn new(view: &View, subject: &'a Subject<'a>, piece: &'a Piece) -> Self {
        let toward = Vec3::Z * 0.3;
        let axis = piece.to - piece.from;
        Self {
            subject,
            piece,
            ends: [piece.from, piece.to].map(|end| subject.light.at(end + toward)),
            length_m: axis.length(),
            right: axis.cross(Vec3::Z).normalize_or(Vec3::X),
            fine: piece.radius_m.0 * view.scale > 2.5,
        }
    }

    /// sRGB colour of a sample with the unit normal `normal`.
    fn colour(&self, normal: Vec3, t: f32, along: f32) -> [u8; 3] {
        let radius_m = self.piece.radius_m.0 + (self.piece.radius_m.1 - self.piece.radius_m.0) * t;
        let place = self.piece.from.lerp(self.piece.to, t);
        let along_m = self.piece.path_m + along * self.length_m;
        let around = normal.dot(self.right).clamp(-1.0, 1.0);
        let relief = if self.fine {
            let around_m = libm::asinf(around) * radius_m + self.piece.salt as f32 * 3.7;
            self.subject.bark.relief(around_m, along_m, radius_m)
        } else {
            1.0
        };
        let bark = self.subject.bark.colour(place.y / self.subject.height_m);
        let albedo = linear_from_srgb(bark * relief.clamp(0.1, 1.6).sqrt());
        let (a, b) = (self.ends[0], self.ends[1]);
        let sun = a.sun + (b.sun - a.sun) * t;
        let sky = a.sky + (b.sky - a.sky) * t;
        // Sun flecks wander over shaded wood.
        let wander = noise2(place.x * 5.0 + around, along_m * 3.0, 55);
        let fleck = 1.0 + (ramp(-0.3, 0.4, wander) - 0.6) * 1.7 * sun * (1.0 - sun);
        let cosine = (normal.dot(TO_SUN) * 0.9 + 0.1).max(0.0);
        let foot = 0.6 + 0.4 * ramp(0.0, 0.05, place.y / self.subject.height_m);
        let light = SUN * (cosine * sun * fleck * 0.8)
            + SKY * (sky * (0.68 + 0.25 * normal.y + 0.4 * normal.z)) * foot
            + STRAY;
        bytes(shown(albedo * light * relief.clamp(0.55, 1.25)))
    }
}
