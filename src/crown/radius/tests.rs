//! Radii of shapes whose radii are known.

use super::*;
use glam::dvec3;

/// A sphere of `radius` around `middle`, of latitudes and longitudes.
fn sphere(middle: DVec3, radius: f64, rings: u32) -> Mesh {
    let segments = 2 * rings;
    let mut positions = vec![middle + DVec3::Y * radius];
    for ring in 1..rings {
        let polar = std::f64::consts::PI * f64::from(ring) / f64::from(rings);
        for segment in 0..segments {
            let turn = std::f64::consts::TAU * f64::from(segment) / f64::from(segments);
            let flat = libm::sin(polar);
            let unit = dvec3(
                flat * libm::cos(turn),
                libm::cos(polar),
                flat * libm::sin(turn),
            );
            positions.push(middle + unit * radius);
        }
    }
    positions.push(middle - DVec3::Y * radius);
    let last = positions.len() as u32 - 1;
    let vertex = |ring: u32, segment: u32| 1 + (ring - 1) * segments + segment % segments;
    let mut triangles = Vec::new();
    for s in 0..segments {
        triangles.push([0, vertex(1, s + 1), vertex(1, s)]);
        triangles.push([last, vertex(rings - 1, s), vertex(rings - 1, s + 1)]);
        for ring in 1..rings - 1 {
            let [a, b] = [vertex(ring, s), vertex(ring, s + 1)];
            let [c, d] = [vertex(ring + 1, s), vertex(ring + 1, s + 1)];
            triangles.extend([[a, b, c], [b, d, c]]);
        }
    }
    Mesh {
        positions,
        triangles,
    }
}

fn radii(map: &Cubemap<f32>) -> impl Iterator<Item = f32> {
    map.faces().iter().flat_map(|face| face.pixels()).copied()
}

#[test]
fn a_sphere_has_its_radius_everywhere_and_no_hole() {
    let middle = dvec3(3.0, 7.0, -2.0);
    let mesh = sphere(middle, 5.0, 64);
    for size in [1, 7, 64, 100] {
        let hits = hits(&[&mesh], middle, size, &Cancel::new()).unwrap();
        for radius in radii(&hits) {
            assert!((4.98..=5.0001).contains(&radius), "{size}: {radius}");
        }
    }
}

#[test]
fn radii_from_another_place_follow_the_sphere_equation() {
    let mesh = sphere(DVec3::ZERO, 1.0, 128);
    let center = dvec3(0.3, -0.5, 0.2);
    let map = radius_cubemap(&mesh, center, 32, &Cancel::new()).unwrap();
    let expected = Cubemap::from_directions(32, |direction| {
        let d = direction.normalize();
        let along = center.dot(d);
        (-along + (along * along - center.length_squared() + 1.0).sqrt()) as f32
    });
    for (found, expected) in radii(&map).zip(radii(&expected)) {
        assert!((found - expected).abs() < 2e-3, "{found} {expected}");
    }
}

#[test]
fn the_farthest_of_nested_surfaces_counts() {
    let spheres = [1.0, 3.0, 2.0].map(|radius| sphere(DVec3::ZERO, radius, 32));
    let map = merged_radius_cubemap(&spheres, DVec3::ZERO, 16, &Cancel::new()).unwrap();
    assert!(radii(&map).all(|radius| (2.97..=3.0).contains(&radius)));
}

/// The slow reference: every ray against every triangle (Möller & Trumbore).
fn reference(mesh: &Mesh, center: DVec3, direction: DVec3) -> f64 {
    let d = direction.normalize();
    let mut farthest = 0.0f64;
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| mesh.positions[i as usize] - center);
        let (e1, e2) = (b - a, c - a);
        let p = d.cross(e2);
        let det = e1.dot(p);
        let u = (-a).dot(p) / det;
        let q = (-a).cross(e1);
        let (v, t) = (d.dot(q) / det, e2.dot(q) / det);
        if u >= -1e-9 && v >= -1e-9 && u + v <= 1.0 + 1e-9 && t > 0.0 {
            farthest = farthest.max(t);
        }
    }
    farthest
}

#[test]
fn random_triangles_agree_with_rays_against_each() {
    let mut random = crate::base::Seed(3).random();
    for _ in 0..30 {
        let mut point = || {
            let mut axis = || random.between(-1.0, 1.0);
            dvec3(axis(), axis(), axis())
        };
        let positions: Vec<DVec3> = (0..12).map(|_| point()).collect();
        let mesh = Mesh {
            positions,
            triangles: vec![[0, 1, 2], [3, 4, 5], [6, 7, 8], [9, 10, 11]],
        };
        let map = hits(&[&mesh], DVec3::ZERO, 16, &Cancel::new()).unwrap();
        let expected = Cubemap::from_directions(16, |d| reference(&mesh, DVec3::ZERO, d) as f32);
        for (found, expected) in radii(&map).zip(radii(&expected)) {
            assert!((found - expected).abs() < 1e-5, "{found} {expected}");
        }
    }
}

#[test]
fn a_centre_outside_gets_a_radius_in_every_direction() {
    let mesh = sphere(dvec3(5.0, 0.0, 0.0), 1.0, 32);
    let map = radius_cubemap(&mesh, DVec3::ZERO, 32, &Cancel::new()).unwrap();
    assert!(radii(&map).all(|radius| radius > 0.0 && radius <= 6.0));
    assert!((map.nearest(DVec3::X) - 6.0).abs() < 0.05);
    // The rim of what is seen lies between the tangents' length (4.9) and the far pole, and the hole
    // is a membrane over it.
    assert!((4.8..5.8).contains(&map.nearest(DVec3::NEG_X)));
}

#[test]
fn crossed_copies_of_a_plank_are_wide_from_both_sides() {
    let mut plank = sphere(DVec3::ZERO, 1.0, 32);
    for point in &mut plank.positions {
        point.z *= 0.1;
    }
    let copies = turned_copies(&plank, DVec3::ZERO, 2);
    let map = merged_radius_cubemap(&copies, DVec3::ZERO, 32, &Cancel::new()).unwrap();
    for direction in [DVec3::X, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Z] {
        assert!(map.nearest(direction) > 0.85, "{direction}");
    }
}

#[test]
fn nothing_around_the_centre_is_an_error() {
    let cancel = Cancel::new();
    let empty = radius_cubemap(&Mesh::default(), DVec3::ZERO, 4, &cancel);
    assert_eq!(empty, Err(RadiusError::Empty));
    cancel.cancel();
    let cancelled = radius_cubemap(&sphere(DVec3::ZERO, 1.0, 4), DVec3::ZERO, 4, &cancel);
    assert_eq!(cancelled, Err(RadiusError::Cancelled(Cancelled)));
}

#[test]
fn a_mirrored_surface_is_its_front_and_back() {
    let mut random = crate::base::Seed(8).random();
    let mut point = || {
        let mut axis = || random.between(-1.0, 1.0);
        dvec3(axis(), axis(), axis())
    };
    for _ in 0..20 {
        let front: Vec<DVec3> = (0..12).map(|_| point()).collect();
        let back = front.iter().map(|p| dvec3(p.x, p.y, -p.z));
        let positions: Vec<DVec3> = front.iter().copied().chain(back).collect();
        let mut triangles: Vec<[u32; 3]> = (0..4).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        triangles.extend((4..8).map(|i| [3 * i, 3 * i + 2, 3 * i + 1]));
        assert!(front_of(&positions, &triangles).is_some());
        let mesh = |triangles: &[[u32; 3]]| Mesh {
            positions: positions.clone(),
            triangles: triangles.to_vec(),
        };
        let whole = hits(&[&mesh(&triangles)], DVec3::ZERO, 16, &Cancel::new()).unwrap();
        // In another order nobody notices.
        triangles.swap(0, 1);
        assert!(front_of(&positions, &triangles).is_none());
        let slowly = hits(&[&mesh(&triangles)], DVec3::ZERO, 16, &Cancel::new()).unwrap();
        assert_eq!(whole, slowly);
    }
}
