//! Trees of a scene: which crown, where, how large, how turned.

use glam::DVec3;

/// One crown of a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrownInstance {
    /// Which of the scene's crowns.
    pub crown: usize,
    /// Where the base of the tree is, metres.
    pub base_m: DVec3,
    /// Turn around the vertical axis, degrees.
    pub yaw_deg: f64,
    /// Size, 1 that of the crown as it was made.
    pub scale: f64,
    /// Where in the range of switching distances this tree changes its form, 0 … 1 (thesis
    /// §6.3.1): drawn once a tree.
    pub switch_at: f64,
    /// Factor on the colours, linear.
    pub tint: [f32; 3],
}

impl CrownInstance {
    /// The crown as it was made, at the origin.
    pub const fn plain(crown: usize) -> Self {
        Self {
            crown,
            base_m: DVec3::ZERO,
            yaw_deg: 0.0,
            scale: 1.0,
            switch_at: 0.5,
            tint: [1.0; 3],
        }
    }
}
