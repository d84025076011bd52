//! Limbs as smooth curves with frames.
//!
//! A skeleton is taken apart into limbs: at every fork the strongest child goes on, the others
//! begin limbs of their own. A limb is an open uniform cubic B-spline with the skeleton's nodes as
//! control points, carried by a frame that is moved along without twist (parallel transport:
//! Hanson & Ma, 1995). After Neubert, *Modeling and Rendering of Plants* (thesis, §5.2.1–5.2.2);
//! departures: end points are doubled by reflection instead of repeated knots, and a limb begins
//! in its parent's axis with a collar, so that there is no gap and no cut.

use super::limbs::Girth;
use super::skeleton::Skeleton;
use glam::Vec3;

/// A cross-section of a limb.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ring {
    /// Its middle, in metres.
    pub centre: Vec3,
    /// Two unit vectors across the limb, at right angles to it and to each other.
    pub across: [Vec3; 2],
    /// Radius in metres.
    pub radius_m: f32,
    /// Length of wood from the root, in metres.
    pub path_m: f32,
}

/// A limb from its beginning in the parent's axis to its tip.
#[derive(Debug, Clone, PartialEq)]
pub struct Limb {
    /// Two cross-sections or more.
    pub rings: Vec<Ring>,
    /// Whether it starts from the ground.
    pub is_stem: bool,
}

/// All limbs of a skeleton, the stem first.
pub fn limbs(skeleton: &Skeleton, girth: &Girth) -> Vec<Limb> {
    let next = strongest_children(skeleton, girth);
    let on_curve = curve_points(skeleton, &next);
    let mut limbs = Vec::new();
    for (index, node) in skeleton.nodes.iter().enumerate() {
        let start = match node.parent {
            None => None,
            Some(parent) if next[parent as usize] == Some(index as u32) => continue,
            Some(parent) => Some(parent),
        };
        let mut chain = vec![index as u32];
        while let Some(child) = next[chain[chain.len() - 1] as usize] {
            chain.push(child);
        }
        if start.is_some() || chain.len() > 1 {
            limbs.push(limb(skeleton, girth, &on_curve, start, &chain));
        }
    }
    limbs
}

/// For each node the child that carries most tips: the limb goes on there.
fn strongest_children(skeleton: &Skeleton, girth: &Girth) -> Vec<Option<u32>> {
    let mut next: Vec<Option<u32>> = vec![None; skeleton.nodes.len()];
    for (index, node) in skeleton.nodes.iter().enumerate() {
        let Some(parent) = node.parent else { continue };
        let tips = |node: u32| girth.tips[node as usize];
        let best = &mut next[parent as usize];
        if best.is_none_or(|old| tips(old) < tips(index as u32)) {
            *best = Some(index as u32);
        }
    }
    next
}

/// Where each node's limb passes it: B-splines do not touch their control points.
fn curve_points(skeleton: &Skeleton, next: &[Option<u32>]) -> Vec<Vec3> {
    let at = |node: u32| skeleton.nodes[node as usize].position;
    let point = |(index, node): (usize, &super::skeleton::Node)| match (node.parent, next[index]) {
        (Some(parent), Some(child)) => (at(parent) + 4.0 * node.position + at(child)) / 6.0,
        _ => node.position,
    };
    skeleton.nodes.iter().enumerate().map(point).collect()
}

/// The limb along `chain`, which leaves the node `start` of its parent.
fn limb(
    skeleton: &Skeleton,
    girth: &Girth,
    on_curve: &[Vec3],
    start: Option<u32>,
    chain: &[u32],
) -> Limb {
    let mut control: Vec<Vec3> = start.iter().map(|&p| on_curve[p as usize]).collect();
    let mut radii: Vec<f32> = Vec::new();
    let mut paths: Vec<f32> = Vec::new();
    if let Some(parent) = start {
        let own = girth.radius_m[chain[0] as usize];
        radii.push(girth.radius_m[parent as usize].min(1.7 * own));
        paths.push(girth.path_m[parent as usize]);
    }
    for &node in chain {
        control.push(skeleton.nodes[node as usize].position);
        radii.push(girth.radius_m[node as usize]);
        paths.push(girth.path_m[node as usize]);
    }
    let mut rings = Vec::new();
    for segment in 0..control.len() - 1 {
        let four = four_points(&control, segment);
        let steps = steps(&four);
        let first = u32::from(segment > 0);
        for step in first..=steps {
            let u = step as f32 / steps as f32;
            rings.push(Ring {
                centre: spline(&four, u),
                across: [Vec3::X, Vec3::Z],
                radius_m: radii[segment] + (radii[segment + 1] - radii[segment]) * u,
                path_m: paths[segment] + (paths[segment + 1] - paths[segment]) * u,
            });
        }
    }
    carry_frames(&mut rings);
    Limb {
        rings,
        is_stem: start.is_none(),
    }
}

/// The control points around a segment, reflected beyond the ends.
fn four_points(control: &[Vec3], segment: usize) -> [Vec3; 4] {
    let (b, c) = (control[segment], control[segment + 1]);
    let a = match segment {
        0 => 2.0 * b - c,
        _ => control[segment - 1],
    };
    let d = control.get(segment + 2).copied().unwrap_or(2.0 * c - b);
    [a, b, c, d]
}

/// Pieces a segment needs to look smooth: one when it is straight.
fn steps(four: &[Vec3; 4]) -> u32 {
    /// Cosine of the bend, about 4°, below which the eye sees no corner.
    const STRAIGHT: f32 = 0.9975;
    let [a, b, c, d] = *four;
    let [into, along, out] = [b - a, c - b, d - c].map(|v| v.normalize_or(Vec3::Y));
    if into.dot(along).min(along.dot(out)) > STRAIGHT {
        1
    } else {
        3
    }
}

/// The point of a uniform cubic B-spline segment at `u` in 0..=1.
fn spline([a, b, c, d]: &[Vec3; 4], u: f32) -> Vec3 {
    let (u2, u3) = (u * u, u * u * u);
    let v = 1.0 - u;
    (*a * (v * v * v)
        + *b * (4.0 - 6.0 * u2 + 3.0 * u3)
        + *c * (1.0 + 3.0 * u + 3.0 * u2 - 3.0 * u3)
        + *d * u3)
        / 6.0
}

/// Gives the rings frames, each turned from the one before by the smallest rotation.
fn carry_frames(rings: &mut [Ring]) {
    let tangent = |rings: &[Ring], index: usize| {
        let (low, high) = (index.saturating_sub(1), (index + 1).min(rings.len() - 1));
        (rings[high].centre - rings[low].centre).normalize_or(Vec3::Y)
    };
    let mut along = tangent(rings, 0);
    // Bark begins behind the limb, where its seam would be least seen.
    let first = along.cross(Vec3::X).normalize_or(Vec3::Z);
    let mut across = [first, along.cross(first)];
    for index in 0..rings.len() {
        let next = tangent(rings, index);
        across = across.map(|vector| turned(vector, along, next));
        rings[index].across = across;
        along = next;
    }
}

/// `vector` under the smallest rotation that takes the unit vector `from` to `to`.
fn turned(vector: Vec3, from: Vec3, to: Vec3) -> Vec3 {
    let cosine = from.dot(to);
    if cosine < -0.999 {
        return -vector;
    }
    let sum = from + to;
    vector - sum * (vector.dot(sum) / (1.0 + cosine)) + to * (2.0 * vector.dot(from))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::branches::limbs::girth;

    /// A stem with a bend, and a side limb.
    fn forked() -> (Skeleton, Girth) {
        let mut skeleton = Skeleton::default();
        let root = skeleton.grow(Vec3::ZERO, None);
        let knee = skeleton.grow(Vec3::new(0.0, 1.0, 0.0), Some(root));
        let upper = skeleton.grow(Vec3::new(0.6, 2.0, 0.3), Some(knee));
        skeleton.grow(Vec3::new(0.6, 3.0, 0.0), Some(upper));
        skeleton.grow(Vec3::new(1.6, 2.5, 0.0), Some(upper));
        skeleton.grow(Vec3::new(-1.0, 1.5, 0.0), Some(knee));
        let girth = girth(&skeleton, 0.2, 0.02);
        (skeleton, girth)
    }

    #[test]
    fn limbs_cover_all_nodes_and_side_limbs_start_in_their_parent() {
        let (skeleton, girth) = forked();
        let limbs = limbs(&skeleton, &girth);
        assert_eq!(limbs.len(), 3);
        assert!(limbs[0].is_stem && !limbs[1].is_stem);
        assert_eq!(limbs[0].rings[0].centre, Vec3::ZERO);
        for limb in &limbs[1..] {
            let start = limb.rings[0].centre;
            let near = limbs[0]
                .rings
                .iter()
                .any(|ring| ring.centre.distance(start) < 1e-5);
            assert!(near, "{start} is not on the stem");
        }
    }

    #[test]
    fn frames_are_at_right_angles_and_hardly_twist() {
        let (skeleton, girth) = forked();
        for limb in limbs(&skeleton, &girth) {
            for pair in limb.rings.windows(2) {
                let [n, b] = pair[1].across;
                assert!(n.dot(b).abs() < 1e-4 && (n.length() - 1.0).abs() < 1e-4);
                assert!(n.dot(pair[0].across[0]) > 0.7);
            }
        }
    }

    #[test]
    fn a_straight_spline_is_the_line_itself() {
        let line = [0.0, 1.0, 2.0, 3.0].map(|x| Vec3::X * x);
        assert!(spline(&line, 0.25).distance(Vec3::X * 1.25) < 1e-6);
        assert_eq!(steps(&line), 1);
    }
}
