//! What is drawn so that fragments of a relief crown come into being: a solid around the ball of
//! R_max (thesis Fig. 5.2).

/// A solid around the unit ball.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Proxy {
    /// Twenty triangles; in the mean a seventh of its picture lies outside the ball.
    #[default]
    Icosahedron,
    /// Twelve triangles; nearly half of its picture lies outside.
    Cube,
}

/// The golden ratio.
const PHI: f32 = 1.618_034;

/// Circumradius of the icosahedron of inradius 1, over that of the corners below: √(1 + φ²) is
/// theirs, φ² / √3 their inradius.
const ICOSAHEDRON_SCALE: f32 = 0.661_585;

impl Proxy {
    /// The corners and the triangles, counter-clockwise from outside.
    pub fn triangles(self) -> (Vec<[f32; 3]>, Vec<[u16; 3]>) {
        match self {
            Self::Icosahedron => icosahedron(),
            Self::Cube => cube(),
        }
    }
}

fn icosahedron() -> (Vec<[f32; 3]>, Vec<[u16; 3]>) {
    let mut corners: Vec<[f32; 3]> = Vec::with_capacity(12);
    for one in [-1.0, 1.0] {
        for long in [-PHI, PHI] {
            corners.push([0.0, one, long]);
            corners.push([one, long, 0.0]);
            corners.push([long, 0.0, one]);
        }
    }
    let mut triangles = Vec::with_capacity(20);
    // Neighbours are 2 apart, all others further.
    let near = |a: usize, b: usize| {
        let (a, b): ([f32; 3], [f32; 3]) = (corners[a], corners[b]);
        (0..3).map(|i| (a[i] - b[i]) * (a[i] - b[i])).sum::<f32>() < 4.5
    };
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(a, c) {
                    triangles.push(outward(&corners, [a as u16, b as u16, c as u16]));
                }
            }
        }
    }
    let scaled = corners
        .iter()
        .map(|corner| corner.map(|x| x * ICOSAHEDRON_SCALE));
    (scaled.collect(), triangles)
}

fn cube() -> (Vec<[f32; 3]>, Vec<[u16; 3]>) {
    let end = |bit: usize| if bit == 0 { -1.0 } else { 1.0 };
    let corners: Vec<[f32; 3]> = (0..8)
        .map(|i| [end(i & 1), end(i & 2), end(i & 4)])
        .collect();
    let mut triangles = Vec::with_capacity(12);
    for axis in 0..3usize {
        let (right, up) = (1u16 << ((axis + 1) % 3), 1u16 << ((axis + 2) % 3));
        for side in [0, 1u16 << axis] {
            triangles.push(outward(&corners, [side, side | right, side | right | up]));
            triangles.push(outward(&corners, [side, side | right | up, side | up]));
        }
    }
    (corners, triangles)
}

/// The triangle in the order that is counter-clockwise from outside.
fn outward(corners: &[[f32; 3]], [a, b, c]: [u16; 3]) -> [u16; 3] {
    let at = |i: u16| glam::Vec3::from(corners[i as usize]);
    let normal = (at(b) - at(a)).cross(at(c) - at(a));
    if normal.dot(at(a)) > 0.0 {
        [a, b, c]
    } else {
        [a, c, b]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn proxies_are_closed_solids_that_touch_the_unit_ball() {
        for (proxy, count) in [(Proxy::Icosahedron, 20), (Proxy::Cube, 12)] {
            let (corners, triangles) = proxy.triangles();
            assert_eq!(triangles.len(), count);
            for &[a, b, c] in &triangles {
                let [a, b, c] = [a, b, c].map(|i| Vec3::from(corners[i as usize]));
                let normal = (b - a).cross(c - a).normalize();
                let plane = normal.dot(a);
                assert!((0.9999..1.0001).contains(&plane), "{proxy:?}: {plane}");
            }
            // Every edge is passed once in each direction.
            let edges: Vec<(u16, u16)> = triangles
                .iter()
                .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
                .collect();
            assert!(edges.iter().all(|&(a, b)| edges.contains(&(b, a))));
        }
    }
}
