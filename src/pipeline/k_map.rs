//! k, drawn: how steeply a crown leaves its silhouette, on all of its base mesh (thesis Fig. 4.14).

use super::crown::{CrownError, k_of_depth};
use crate::base::{Cancel, Progress};
use crate::crown::{Domain, Inflation, InflationError, Tangent};
use crate::geometry::{Mesh, Point};
use crate::raster::{Image, Mask};
use glam::{DVec2, DVec3};

/// Longer side of the silhouette on which k is looked up, pixels.
const LONGEST: f64 = 64.0;

/// k at each vertex of `mesh`, a base mesh in metres, seen from the photograph's viewer: that of the
/// formula at its place, or of the nearest point of the silhouette along which a curve runs. None stands
/// for the k that makes the crown as deep as half its width.
///
/// The silhouette is taken from the mesh; where copies widened it, formulas are spread over the whole.
///
/// # Errors
/// [`CrownError`]: a mesh without area, a formula that gives no k, cancellation.
pub fn k_on_mesh(
    mesh: &Mesh,
    tangent: Option<&Tangent>,
    cancel: &Cancel,
) -> Result<Vec<f64>, CrownError> {
    let front = Front::of(mesh).ok_or(InflationError::Empty)?;
    let domain = Domain::new(&front.mask)?;
    let Some(tangent) = tangent else {
        let depth = f64::from(domain.bounds().width) / 2.0;
        let inflation = Inflation::new(domain, Progress::silent(), cancel)?;
        let ring = k_of_depth(&inflation, depth, cancel)?;
        let k = ring.first().copied().unwrap_or_default();
        return Ok(vec![k; mesh.positions.len()]);
    };
    Ok(tangent.at(&domain, &front.places)?)
}

/// A mesh as it is seen from the front.
struct Front {
    mask: Mask,
    /// Its vertices, in pixels of the mask.
    places: Vec<Point>,
}

impl Front {
    fn of(mesh: &Mesh) -> Option<Self> {
        let all = mesh.positions.iter().copied();
        let low = all.clone().reduce(DVec3::min)?;
        let high = all.reduce(DVec3::max)?;
        let extent = (high - low).truncate();
        let scale = LONGEST / extent.max_element();
        if !scale.is_finite() {
            return None;
        }
        // A pixel's centre is at a whole number; one row and column stay free around.
        let place = |p: &DVec3| DVec2::new(p.x - low.x, high.y - p.y) * scale + 1.0;
        let places: Vec<Point> = mesh.positions.iter().map(place).collect();
        let side = |length: f64| (length * scale) as u32 + 3;
        let mut mask = Image::filled(side(extent.x), side(extent.y), false);
        for corners in &mesh.triangles {
            fill(&mut mask, corners.map(|corner| places[corner as usize]));
        }
        Some(Self { mask, places })
    }
}

/// Sets the pixels whose centres lie in a triangle, either way round, and those of its corners.
fn fill(mask: &mut Mask, corners: [Point; 3]) {
    let [a, b, c] = corners;
    for corner in corners {
        mask.set(corner.x.round() as u32, corner.y.round() as u32, true);
    }
    let (low, high) = (a.min(b).min(c).ceil(), a.max(b).max(c).floor());
    for y in low.y as u32..=high.y as u32 {
        for x in low.x as u32..=high.x as u32 {
            let at = DVec2::new(x.into(), y.into());
            let turns = [(a, b), (b, c), (c, a)].map(|(p, q)| (q - p).perp_dot(at - p));
            let is_inside = turns.iter().all(|t| *t >= 0.0) || turns.iter().all(|t| *t <= 0.0);
            if is_inside {
                mask.set(x, y, true);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::crown::{CrownSettings, CrownShape, crown_shape};
    use super::*;

    fn disc() -> Mask {
        let mut mask = Image::filled(200, 200, false);
        for (x, y) in (0..200).flat_map(|y| (0..200).map(move |x| (x, y))) {
            let at = DVec2::new(x.into(), y.into()) - 100.0;
            mask.set(x, y, at.length() < 80.0);
        }
        mask
    }

    /// The crown of a disc, and its k as it is drawn.
    fn k_of(k: Option<&str>) -> (CrownShape, Vec<f64>) {
        let settings = CrownSettings {
            k: k.map(|text| Tangent::parse(text).unwrap()),
            size: 96,
            ..CrownSettings::default()
        };
        let (progress, cancel) = (Progress::silent(), Cancel::new());
        let made = crown_shape(&disc(), &settings, progress, &cancel).unwrap();
        let k = k_on_mesh(&made.base_mesh, settings.k.as_ref(), &cancel).unwrap();
        (made, k)
    }

    #[test]
    fn a_formula_is_spread_from_top_to_bottom() {
        let (made, k) = k_of(Some("1+2*j"));
        let vertices = made.base_mesh.positions.iter().zip(&k);
        let (top, of_top) = vertices
            .clone()
            .max_by(|a, b| a.0.y.total_cmp(&b.0.y))
            .unwrap();
        let (foot, of_foot) = vertices.min_by(|a, b| a.0.y.total_cmp(&b.0.y)).unwrap();
        assert!(top.y > foot.y);
        assert!(
            (of_top - 1.0).abs() < 0.05 && (of_foot - 3.0).abs() < 0.05,
            "{of_top} {of_foot}"
        );
    }

    #[test]
    fn what_nobody_chose_is_the_one_k_that_was_found() {
        let (made, k) = k_of(None);
        assert!(k.iter().all(|&other| other == k[0]));
        let [found, _] = made.k.unwrap();
        assert!((k[0] / found - 1.0).abs() < 0.1, "{} {found}", k[0]);
    }

    #[test]
    fn a_mesh_without_area_has_no_silhouette() {
        let flat = Mesh {
            positions: vec![DVec3::ZERO; 3],
            triangles: vec![[0, 1, 2]],
        };
        assert!(k_on_mesh(&flat, None, &Cancel::new()).is_err());
    }
}
