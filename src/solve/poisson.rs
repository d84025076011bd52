//! Poisson's equation on the pixels of a mask, zero around them.

use super::grid::{GridSystem, Stencil};
use super::solver::{Method, Solver};
use crate::base::{Cancel, Cancelled};
use crate::raster::{Image, Mask};

/// The image u with 4 u(x, y) − u(x − 1, y) − u(x + 1, y) − u(x, y − 1) − u(x, y + 1) = `right`(x, y),
/// that is −Δu = `right`, at every pixel of `unknown`, and u = 0 at all others and around the image.
///
/// For zero on the silhouette of a shape, `unknown` is the shape without its silhouette. `right` is
/// read at the pixels of `unknown` only.
///
/// # Errors
/// When the work is cancelled.
///
/// # Panics
/// When the images differ in size.
///
/// ```
/// use boscage::base::Cancel;
/// use boscage::raster::Image;
/// use boscage::solve::poisson;
/// let unknown = Image::from_pixels(4, 1, vec![false, true, true, false]);
/// let right = Image::from_pixels(4, 1, vec![9.0, 3.0, 3.0, 9.0]);
/// let u = poisson(&unknown, &right, &Cancel::new()).unwrap();
/// let exact = [0.0, 1.0, 1.0, 0.0];
/// assert!(u.pixels().iter().zip(exact).all(|(u, exact)| (u - exact).abs() < 1e-12));
/// ```
pub fn poisson(
    unknown: &Mask,
    right: &Image<f64>,
    cancel: &Cancel,
) -> Result<Image<f64>, Cancelled> {
    let (width, height) = (unknown.width(), unknown.height());
    assert_eq!((right.width(), right.height()), (width, height), "one size");
    let system = GridSystem::new(unknown, Stencil::Laplacian);
    let solver = Solver::new(system, Method::Automatic, cancel)?;
    let pixels = solver.system().pixels();
    let values: Vec<f64> = pixels.iter().map(|&(x, y)| right.at(x, y)).collect();
    let solution = solver.solution(&values, None, cancel)?;
    let mut image = Image::filled(width, height, 0.0);
    for (&(x, y), &value) in pixels.iter().zip(&solution) {
        image.set(x, y, value);
    }
    Ok(image)
}
