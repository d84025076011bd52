//! A crown of several regions, each inflated by itself and shifted in depth, merged by the largest
//! radius about one centre: the thesis' future work for crowns made of several clumps.

use super::base_mesh::{BaseMeshError, Method, base_mesh, star_around, star_cells};
use super::center::crown_center;
use super::inflation::InflationError;
use super::tangent::Tangent;
use crate::base::{Cancel, Progress};
use crate::geometry::{Mesh, Point};
use crate::raster::{Image, Mask, labelled_components, opaque_bounds};
use glam::DVec3;

/// A region of a crown.
#[derive(Debug, Clone, PartialEq)]
pub struct SubCrown {
    /// Its pixels; all regions of a crown have masks of one size.
    pub mask: Mask,
    /// How it leaves its own silhouette.
    pub tangent: Tangent,
    /// How far it is shifted towards the viewer, pixels.
    pub depth_px: f64,
}

/// The regions of a label picture: each value but 0, in rising order, with its mask.
///
/// ```
/// use boscage::{crown::labelled_regions, raster::Image};
/// let regions = labelled_regions(&Image::from_pixels(4, 1, vec![9, 0, 7, 9]));
/// let found: Vec<_> = regions.iter().map(|(value, mask)| (*value, mask.count())).collect();
/// assert_eq!(found, [(7, 1), (9, 2)]);
/// ```
pub fn labelled_regions(labels: &Image<u8>) -> Vec<(u8, Mask)> {
    let mut is_used = [false; 256];
    for &label in labels.pixels() {
        is_used[usize::from(label)] = true;
    }
    let values = (1..=255u8).filter(|&value| is_used[usize::from(value)]);
    values
        .map(|value| (value, labels.map(|&label| label == value)))
        .collect()
}

/// The merged regions as a watertight star-shaped mesh in the mask's frame, and its centre: that of
/// all regions' pixels, at their mean depth. Where regions lie apart it is in the gap between them:
/// seen from within one, another would be a cone with its walls along the rays.
///
/// # Errors
/// [`BaseMeshError`]; [`InflationError::Empty`] when there is no region or one has no pixel.
///
/// # Panics
/// When masks differ in size.
pub fn sub_crowns_merged(
    regions: &[SubCrown],
    method: Method,
    progress: Progress<'_>,
    cancel: &Cancel,
) -> Result<(Mesh, DVec3), BaseMeshError> {
    let first = regions.first().ok_or(InflationError::Empty)?;
    let mut union = first.mask.map(|_| false);
    let mut meshes = Vec::with_capacity(regions.len());
    let (mut depth_sum, mut count) = (0.0, 0);
    for region in regions {
        let made = base_mesh(&region.mask, &region.tangent, method, progress, cancel)?;
        meshes.push(made.mesh.moved(|p| p + DVec3::Z * region.depth_px));
        assert_eq!(
            region.mask.pixels().len(),
            union.pixels().len(),
            "masks of one size"
        );
        for (all, &own) in union.pixels_mut().iter_mut().zip(region.mask.pixels()) {
            *all |= own;
        }
        depth_sum += region.depth_px * region.mask.count() as f64;
        count += region.mask.count();
    }
    let (Some(center), Some(bounds)) = (center_of_all(&union), opaque_bounds(&union)) else {
        return Err(InflationError::Empty.into());
    };
    let center = center.extend(depth_sum / count as f64);
    let mesh = star_around(&meshes, center, star_cells(bounds), cancel)?;
    Ok((mesh, center))
}

/// The centre of regions whose pixels are `union`: [`crown_center`] of those that touch, the centroid of
/// others.
fn center_of_all(union: &Mask) -> Option<Point> {
    if *labelled_components(union).pixels().iter().max()? <= 1 {
        return crown_center(union);
    }
    let (mut sum, mut count) = (Point::ZERO, 0.0);
    for y in 0..union.height() {
        for x in (0..union.width()).filter(|&x| union.at(x, y)) {
            sum += Point::new(f64::from(x), f64::from(y));
            count += 1.0;
        }
    }
    Some(sum / count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Topology;

    #[test]
    fn regions_stand_at_their_depth_and_keep_their_own_k() {
        let side = 48i32;
        let disc = |cx: i32, radius: i32| {
            let inside = |i: i32| {
                let (x, y) = (i % side - cx, i / side - 24);
                x * x + y * y <= radius * radius
            };
            Image::from_pixels(48, 48, (0..side * side).map(inside).collect())
        };
        let region = |cx, k, depth_px| SubCrown {
            mask: disc(cx, 12),
            tangent: Tangent::Constant(k),
            depth_px,
        };
        let regions = [region(17, 2.0, 6.0), region(31, 1.0, -6.0)];
        let (mesh, center) = sub_crowns_merged(
            &regions,
            Method::Bilaplacian,
            Progress::silent(),
            &Cancel::new(),
        )
        .unwrap();
        assert!(Topology::of(&mesh).is_watertight());
        assert!((center - DVec3::new(24.0, 24.0, 0.0)).length() < 0.6);
        let (low, high) = mesh.bounds().unwrap();
        // In front the deep region: about 12 and its shift; behind, the flat one.
        assert!((high.z - 18.0).abs() < 2.0, "{high}");
        assert!((low.z + 12.0).abs() < 2.0, "{low}");
        // Apart, their centre is between them, and the gap is bridged at their own depth.
        let apart = [region(12, 2.0, 0.0), region(36, 2.0, 0.0)].map(|mut region| {
            for y in 0..48 {
                region.mask.row_mut(y)[22..26].fill(false);
            }
            region
        });
        let (mesh, center) = sub_crowns_merged(
            &apart,
            Method::Bilaplacian,
            Progress::silent(),
            &Cancel::new(),
        )
        .unwrap();
        assert!((center.x - 23.5).abs() < 0.6, "{center}");
        let (low, high) = mesh.bounds().unwrap();
        assert!(
            low.x < 1.5 && high.x > 46.0 && high.z < 13.0,
            "{low} {high}"
        );
        assert!(
            sub_crowns_merged(&[], Method::Bilaplacian, Progress::silent(), &Cancel::new())
                .is_err()
        );
    }
}
