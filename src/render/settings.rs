//! How a scene is drawn.

/// The form in which crowns are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mode {
    /// The radius cubemap, marched along the rays of the eye (thesis §5.1).
    #[default]
    Relief,
    /// Pictures of twigs that face the eye (thesis §5.2).
    Leaves,
    /// No crowns: only the meshes of the scene, such as a crown's surface.
    Mesh,
    /// Leaves when near, relief when far, see [`SwitchSettings`].
    Switched,
}

/// What the picture shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u32)]
pub enum View {
    /// The scene.
    #[default]
    Picture = 0,
    /// Reads of the radius cubemap, white at the most that a ray may take.
    Steps = 1,
    /// Normals in the world frame, 0 … 1 for −1 … 1.
    Normals = 2,
    /// 1 / (1 + distance / metre).
    Depth = 3,
    /// How far the point that was found is from the surface, white at a hundredth of R_max.
    RadiusError = 4,
    /// The scene with the edges of its triangles.
    Wireframe = 5,
}

/// Where crowns change between leaves and relief (thesis §6.3.1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SwitchSettings {
    /// No crown changes nearer than this, metres.
    pub nearest_m: f64,
    /// No crown changes farther than this, metres.
    pub farthest_m: f64,
    /// Both forms are mixed over this stretch around the distance where a crown changes, metres.
    pub band_m: f64,
}

impl Default for SwitchSettings {
    /// The range of the thesis; a tree of 10 m is then some hundred pixels high.
    fn default() -> Self {
        Self {
            nearest_m: 100.0,
            farthest_m: 200.0,
            band_m: 25.0,
        }
    }
}

impl SwitchSettings {
    /// The share of leaves, 0 … 1, in a crown at a distance that changes at the share `switch_at`
    /// of the range.
    pub fn leaf_share(&self, distance_m: f64, switch_at: f64) -> f32 {
        let middle = self.nearest_m + (self.farthest_m - self.nearest_m) * switch_at;
        let before = (middle - distance_m) / self.band_m.max(1e-6) + 0.5;
        before.clamp(0.0, 1.0) as f32
    }
}

/// What makes the inside of a crown darker than its outside.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u32)]
pub enum Occlusion {
    /// Baked ambient occlusion and the shadow of the crown on itself.
    #[default]
    Baked = 0,
    /// The height in the crown and the distance from its centre, as thesis §5.3.
    Terms = 1,
}

/// Ways to spend less on a ray (thesis §5.1, Fig. 5.3).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u32)]
pub enum Shortcut {
    /// March the whole way through the proxy.
    None = 0,
    /// Leave out rays that miss the sphere of R_max, and march between the spheres of R_max and
    /// R_min only: the first crossing is always found.
    #[default]
    Bounded = 1,
    /// As the thesis: rays that meet the sphere of R_min go without the linear search. May find
    /// another crossing than the first where the surface folds.
    BinaryOnly = 2,
}

/// How rays find a relief crown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReliefSettings {
    /// Linear steps through the diameter of the R_max sphere for each pixel of its radius.
    pub steps_a_pixel: f32,
    /// Least linear steps through the diameter.
    pub least_steps: u32,
    /// Most linear steps through the diameter; bounds the cost of a close view.
    pub most_steps: u32,
    /// Halvings of the interval that the linear search found.
    pub halvings: u32,
    /// Steps towards the sun for the crown's shadow on itself; 0 for none.
    pub shadow_steps: u32,
    /// What may be left out.
    pub shortcut: Shortcut,
}

impl Default for ReliefSettings {
    /// For pictures that are kept. At 96 steps the error of a silhouette is below a pixel up to a
    /// radius of about 400; below 12 steps whole branches of a far crown are stepped over.
    fn default() -> Self {
        Self {
            steps_a_pixel: 0.5,
            least_steps: 12,
            most_steps: 96,
            halvings: 7,
            shadow_steps: 10,
            shortcut: Shortcut::Bounded,
        }
    }
}

impl ReliefSettings {
    /// For a view in motion on a slow adapter: a third of the cost.
    pub fn quick() -> Self {
        Self {
            steps_a_pixel: 0.25,
            most_steps: 32,
            halvings: 5,
            shadow_steps: 4,
            ..Self::default()
        }
    }
}

/// What keeps leaves within the crown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u32)]
pub enum LeafClip {
    /// Each leaf's centre lies within the crown and the leaf is drawn whole: outlines are leaves.
    /// The points of the ball are not dropped outside the crown, as the thesis' future work has it,
    /// but drawn to the same share of the radius in their direction: none is wasted.
    #[default]
    Center = 0,
    /// Leaves fill the R_max sphere and are cut off at the surface, as in the thesis.
    Fragment = 1,
}

/// How leaf crowns are drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeafSettings {
    /// Leaves for each pixel of the crown's radius.
    pub leaves_a_pixel: f32,
    /// Least leaves of a crown.
    pub least: u32,
    /// Most leaves of a crown.
    pub most: u32,
    /// Half the side of a leaf's picture in radii of the crown, for a single leaf; with n leaves it
    /// is divided by √n, so that they cover the crown alike in any number. Below 4 the crown gets
    /// holes, above 6 single twigs stand out of its outline.
    pub size: f32,
    /// What keeps leaves within the crown.
    pub clip: LeafClip,
}

impl Default for LeafSettings {
    fn default() -> Self {
        Self {
            leaves_a_pixel: 8.0,
            least: 64,
            most: 2048,
            size: 5.0,
            clip: LeafClip::Center,
        }
    }
}

/// How a picture is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RenderSettings {
    /// Width and height of the picture, pixels, > 0.
    pub size: (u32, u32),
    /// Samples along each side of a pixel, 1 … 4.
    pub fineness: u32,
    /// Share of the picture's sides that is drawn, 0 … 1, for a picture that is stretched when it
    /// is shown: it has the same leaves as one of full size. See [`RenderSettings::drawn_size`].
    pub scale: f32,
    /// The form of the crowns.
    pub mode: Mode,
    /// Where [`Mode::Switched`] changes the form.
    pub switch: SwitchSettings,
    /// What the picture shows.
    pub view: View,
    /// What darkens the inside.
    pub occlusion: Occlusion,
    /// How relief crowns are found.
    pub relief: ReliefSettings,
    /// How leaf crowns are drawn.
    pub leaves: LeafSettings,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            size: (800, 800),
            fineness: 2,
            scale: 1.0,
            mode: Mode::default(),
            switch: SwitchSettings::default(),
            view: View::default(),
            occlusion: Occlusion::default(),
            relief: ReliefSettings::default(),
            leaves: LeafSettings::default(),
        }
    }
}

impl RenderSettings {
    /// Width and height of what is drawn, pixels.
    pub fn drawn_size(&self) -> (u32, u32) {
        let scaled = |side: u32| ((side as f32 * self.scale).round() as u32).max(1);
        (scaled(self.size.0), scaled(self.size.1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_shrinks_what_is_drawn_but_to_a_pixel() {
        let settings = RenderSettings {
            size: (801, 1),
            scale: 0.375,
            ..RenderSettings::default()
        };
        assert_eq!(settings.drawn_size(), (300, 1));
    }

    #[test]
    fn the_share_of_leaves_falls_over_the_band() {
        let switch = SwitchSettings::default();
        assert_eq!(switch.leaf_share(80.0, 0.0), 1.0);
        assert_eq!(switch.leaf_share(100.0, 0.0), 0.5);
        assert_eq!(switch.leaf_share(120.0, 0.0), 0.0);
        assert_eq!(switch.leaf_share(180.0, 1.0), 1.0);
    }
}
