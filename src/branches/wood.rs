//! Painting wood: stem, limbs and twigs.
//!
//! A limb is painted as tapered pieces between its rings: in the picture each is the set of points
//! nearer to its axis than its radius there, so round ends join bent limbs without gaps. A sample's
//! normal is that of a round limb; where it lies in the frame of the ring tells its place on the
//! bark, whose relief turns the light a little, and the sun's picture of the crown dapples it. The
//! stem is not round: it swells to roots at the ground, more on some sides than on others.

use super::bark::BarkKind;
use super::canvas::{Canvas, Dab, Part};
use super::light::Reached;
use super::noise::{noise3, ramp};
use super::render::{Subject, View, bytes, covered, linear_from_srgb, shown};
use super::spline::{Limb, Ring};
use glam::{Vec2, Vec3};

/// A tapered, straight piece of wood between two rings.
struct Piece {
    from: Ring,
    to: Ring,
    part: Part,
    /// Factors on the radius at the left and the right edge, for both rings: roots and flutes.
    swell: [[f32; 2]; 2],
}

/// Paints all limbs.
pub(super) fn paint_wood(canvas: &mut Canvas, view: &View, subject: &Subject<'_>) {
    for limb in subject.limbs {
        paint_limb(canvas, view, subject, limb);
    }
}

fn paint_limb(canvas: &mut Canvas, view: &View, subject: &Subject<'_>, limb: &Limb) {
    for pair in limb.rings.windows(2) {
        let [from, to] = [pair[0], pair[1]];
        let low = from.centre.y.min(to.centre.y) < subject.crown_base_m;
        let thick = to.radius_m > 0.22 * subject.stem_m;
        let piece = Piece {
            swell: [swells(subject, limb, &from), swells(subject, limb, &to)],
            part: if low && thick {
                Part::Trunk
            } else {
                Part::Crown
            },
            from,
            to,
        };
        paint_piece(canvas, view, subject, &piece);
    }
}

/// Factors on a ring's radius at its left and right edge in the picture.
fn swells(subject: &Subject<'_>, limb: &Limb, ring: &Ring) -> [f32; 2] {
    [Vec3::NEG_X, Vec3::X].map(|side| {
        if subject.bark.kind == BarkKind::Rings {
            // Palms have no roots that show.
            1.0
        } else if limb.is_stem || ring.centre.y < 0.4 {
            stem_swell(subject.stem_m, side, ring.centre.y)
        } else {
            1.0 + 0.06 * noise3(ring.path_m * 5.0, side.x * 3.0, ring.radius_m * 90.0, 71)
        }
    })
}

/// Factor on the stem's radius in the direction `side` at the height `y`.
fn stem_swell(stem_m: f32, side: Vec3, y: f32) -> f32 {
    // Each tree its own roots: the radius is as good as a name.
    let salt = 72 ^ (stem_m * 4096.0) as u32;
    let y = y.max(0.0);
    let root = 0.85 + 0.4 * noise3(side.x * 1.9, 0.6, side.z * 1.9, salt);
    let steep = libm::expf(-y / (0.62 * stem_m)) * 0.55 * root;
    let long = libm::expf(-y / (3.5 * stem_m)) * 0.2 * root;
    let flutes = 0.05 * noise3(side.x * 1.6, y / (stem_m * 9.0), side.z * 1.6, salt + 1);
    1.0 + steep + long + flutes
}

/// Paints the twigs that bear leaves.
pub(super) fn paint_twigs(canvas: &mut Canvas, view: &View, subject: &Subject<'_>) {
    // Twigs are as thick as their leaves are large.
    let thick_m = 0.042 * subject.leaf_m;
    for twig in &subject.leafage.twigs {
        let ring = |centre: Vec3, radius_m: f32| Ring {
            centre,
            across: [Vec3::X, Vec3::Z],
            radius_m,
            path_m: 0.0,
        };
        let piece = Piece {
            from: ring(twig.from, thick_m),
            to: ring(twig.to, 0.5 * thick_m),
            part: Part::Crown,
            swell: [[1.0; 2]; 2],
        };
        paint_piece(canvas, view, subject, &piece);
    }
}

fn paint_piece(canvas: &mut Canvas, view: &View, subject: &Subject<'_>, piece: &Piece) {
    /// Thinnest radius in samples: thinner wood would break into dots.
    const THINNEST: f32 = 0.75;
    let (from, to) = (
        view.samples_from_tree(piece.from.centre),
        view.samples_from_tree(piece.to.centre),
    );
    let radius = |ring: &Ring, swell: f32| (ring.radius_m * swell * view.scale).max(THINNEST);
    let [start, end] = [0, 1].map(|side| {
        (
            radius(&piece.from, piece.swell[0][side]),
            radius(&piece.to, piece.swell[1][side]),
        )
    });
    let widest = Vec2::splat(start.0.max(start.1).max(end.0).max(end.1) + 1.0);
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
            let along = offset.dot(axis) / length_squared;
            let t = along.clamp(0.0, 1.0);
            let aside = offset - axis * t;
            let side = if aside.x < 0.0 { start } else { end };
            let here = side.0 + (side.1 - side.0) * t;
            let across = aside.length() / here;
            if across >= 1.0 {
                continue;
            }
            let toward = (1.0 - across * across).sqrt();
            let (z, far) = (piece.from.centre.z, piece.to.centre.z);
            let depth = z + (far - z) * t + toward * here / view.scale;
            if canvas.sees(x, y, depth) {
                let normal = Vec3::new(aside.x / here, -aside.y / here, toward);
                canvas.put(x, y, depth, &wood.dab(normal, t, along));
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
    fine: bool,
}

impl<'a> Wood<'a> {
    fn new(view: &View, subject: &'a Subject<'a>, piece: &'a Piece) -> Self {
        let toward = Vec3::Z * 0.3;
        let ends = [piece.from.centre, piece.to.centre];
        Self {
            subject,
            piece,
            ends: ends.map(|end| subject.light.at(end + toward)),
            length_m: ends[0].distance(ends[1]),
            fine: piece.from.radius_m * view.scale > 2.5,
        }
    }

    /// What shows where the round limb faces `normal`, at the share `t` of the piece, or `along`
    /// beyond its round ends.
    fn dab(&self, normal: Vec3, t: f32, along: f32) -> Dab {
        let (from, to) = (&self.piece.from, &self.piece.to);
        let radius_m = from.radius_m + (to.radius_m - from.radius_m) * t;
        let centre = from.centre.lerp(to.centre, t);
        let [right, away] = [0, 1].map(|i| from.across[i].lerp(to.across[i], t));
        let path_m = from.path_m + along * self.length_m;
        let on_bark = |normal: Vec3| {
            let (x, z) = (normal.dot(right), normal.dot(away));
            Vec3::new(x * radius_m, path_m, z * radius_m)
        };
        let (relief, normal) = if self.fine {
            self.carved(normal, &on_bark, radius_m)
        } else {
            (1.0, normal)
        };
        let colour = self.colour(normal, relief, centre, t);
        Dab {
            colour,
            part: self.piece.part,
            normal,
        }
    }

    /// The bark's relief, and the normal turned by its slope.
    fn carved(&self, normal: Vec3, on_bark: &dyn Fn(Vec3) -> Vec3, radius_m: f32) -> (f32, Vec3) {
        /// Distance over which the slope is taken in metres, and how deep the bark is against it.
        const REACH_M: f32 = 0.012;
        const DEPTH: f32 = 0.55;
        let bark = self.subject.bark;
        let place = on_bark(normal);
        let here = bark.relief(place, radius_m);
        let step = REACH_M / radius_m.max(REACH_M);
        let beside = bark.relief(
            on_bark((normal + Vec3::X * step).normalize_or(normal)),
            radius_m,
        );
        let above = bark.relief(place + Vec3::Y * REACH_M, radius_m);
        let tilt = Vec3::new(here - beside, here - above, 0.0) * DEPTH;
        (here, (normal + tilt).normalize_or(normal))
    }

    /// sRGB colour of a sample with the unit normal `normal`.
    fn colour(&self, normal: Vec3, relief: f32, centre: Vec3, t: f32) -> [u8; 3] {
        let subject = self.subject;
        let daylight = subject.daylight;
        let bark = subject.bark.colour(centre.y / subject.height_m);
        let albedo = linear_from_srgb(bark * relief.clamp(0.1, 1.6).sqrt());
        let (a, b) = (self.ends[0], self.ends[1]);
        let average = a.sun + (b.sun - a.sun) * t;
        let sky = a.sky + (b.sky - a.sky) * t;
        let radius_m = self.piece.from.radius_m;
        let surface = centre + normal * radius_m;
        let sun = subject.sun_at(surface, average);
        let cosine = (normal.dot(daylight.to_sun) * 0.95 + 0.05).max(0.0);
        let foot = 0.5 + 0.5 * ramp(0.0, 0.06, centre.y / subject.height_m);
        // Crevices see less of the sky.
        let open = sky * (0.60 + 0.25 * normal.y + 0.42 * normal.z) * foot;
        let light = daylight.sun * (cosine * sun * 0.85) + daylight.sky * open + daylight.stray;
        bytes(shown(albedo * light * relief.clamp(0.45, 1.25)))
    }
}
