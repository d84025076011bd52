//! How thick a skeleton's limbs are.
//!
//! The pipe model (Shinozaki et al., *A Quantitative Analysis of Plant Form: the Pipe Model
//! Theory*, 1964) with Murray's generalised exponent: the n-th powers of the radii of the children
//! add up to that of the parent. We give the radius of stem and tips and take the exponent that
//! connects them, so a species' stem is as thick as its table says however many tips have grown.

use super::skeleton::Skeleton;

/// Thickness of a skeleton, node by node.
#[derive(Debug, Clone)]
pub struct Girth {
    /// Radius in metres.
    pub radius_m: Vec<f32>,
    /// Number of tips above the node; 1 at a tip.
    pub tips: Vec<u32>,
    /// Length of wood from the root to the node, in metres.
    pub path_m: Vec<f32>,
}

/// The girth of `skeleton` with `stem_m` as the radius of its root and `tip_m` of its tips.
///
/// Along an unbranched run the radius shrinks a little as well, as grown wood does.
pub fn girth(skeleton: &Skeleton, stem_m: f32, tip_m: f32) -> Girth {
    let count = skeleton.nodes.len();
    let mut tips = vec![0u32; count];
    for index in (0..count).rev() {
        tips[index] = tips[index].max(1);
        if let Some(parent) = skeleton.nodes[index].parent {
            tips[parent as usize] += tips[index];
        }
    }
    let mut path_m = vec![0.0f32; count];
    for (index, node) in skeleton.nodes.iter().enumerate() {
        if let Some(parent) = node.parent {
            let before = skeleton.nodes[parent as usize].position;
            path_m[index] = path_m[parent as usize] + node.position.distance(before);
        }
    }
    // radius = tip · tips^(1/n), with 1/n such that the root gets the stem's radius.
    let all_tips = tips.first().map_or(2, |&all| all.max(2)) as f32;
    let inverse_exponent = libm::logf(stem_m / tip_m) / libm::logf(all_tips);
    let longest_m = path_m.iter().copied().fold(1e-6, f32::max);
    let radius_m = tips
        .iter()
        .zip(&path_m)
        .map(|(&tips, path)| {
            let pipe = tip_m * libm::expf(inverse_exponent * libm::logf(tips as f32));
            pipe * (1.0 - 0.25 * path / longest_m)
        })
        .collect();
    Girth {
        radius_m,
        tips,
        path_m,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn a_fork_follows_the_pipe_model() {
        let mut skeleton = Skeleton::default();
        let root = skeleton.grow(Vec3::ZERO, None);
        let fork = skeleton.grow(Vec3::Y * 1e-3, Some(root));
        skeleton.grow(Vec3::new(1e-3, 2e-3, 0.0), Some(fork));
        skeleton.grow(Vec3::new(-1e-3, 2e-3, 0.0), Some(fork));
        let girth = girth(&skeleton, 0.2, 0.1);
        assert_eq!(girth.tips, [2, 2, 1, 1]);
        assert!((girth.radius_m[0] - 0.2).abs() < 1e-6);
        assert!(girth.radius_m[2] <= 0.1 && girth.radius_m[2] > 0.07);
    }
}
