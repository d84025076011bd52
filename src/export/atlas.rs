//! The six faces of a cubemap in one picture, for meshes whose textures are flat.
//!
//! Three faces in a row, two rows, in the order of the faces. Around each face stands a gutter with
//! the texels of its neighbours, as they follow on the cube: filters and the first levels of
//! smaller copies find the right colours beyond the edge, so the mesh shows no seam.

use crate::raster::{CubeFace, Cubemap, Image, Straight, folded};

/// Faces in a row of the picture.
const COLUMNS: u32 = 3;

/// Where the faces stand in an atlas of faces of a given size.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AtlasLayout {
    size: u32,
    gutter: u32,
}

impl AtlasLayout {
    /// The layout for faces of `size` texels a side. The gutter is a sixteenth of it, so that four
    /// levels of smaller copies stay clean.
    pub fn new(size: u32) -> Self {
        let gutter = (size / 16).max(2).min(size);
        Self { size, gutter }
    }

    /// Width and height of the picture.
    pub fn picture_size(self) -> [u32; 2] {
        let cell = self.size + 2 * self.gutter;
        [COLUMNS * cell, 2 * cell]
    }

    /// Texture coordinates of the place (`u`, `v`) of `face`, −1 … 1 from left and top: 0 … 1 from the
    /// left and the top of the picture, as glTF has them.
    pub fn texture_coordinates(self, face: CubeFace, u: f64, v: f64) -> [f32; 2] {
        let [left, top] = self.corner(face);
        let [width, height] = self.picture_size();
        let along = |from: u32, u: f64, whole: u32| {
            let texel = f64::from(from) + (u + 1.0) / 2.0 * f64::from(self.size);
            (texel / f64::from(whole)) as f32
        };
        [along(left, u, width), along(top, v, height)]
    }

    /// The first texel of `face`, behind its gutter.
    fn corner(self, face: CubeFace) -> [u32; 2] {
        let cell = self.size + 2 * self.gutter;
        let index = face as u32;
        [
            index % COLUMNS * cell + self.gutter,
            index / COLUMNS * cell + self.gutter,
        ]
    }
}

/// The faces of `map` with their gutters, laid out by [`AtlasLayout`].
pub fn atlas(map: &Cubemap<Straight>) -> Image<Straight> {
    let size = map.size();
    let layout = AtlasLayout::new(size);
    let [width, height] = layout.picture_size();
    let mut picture = Image::filled(width, height, Straight::default());
    let last = i64::from(size) - 1;
    let gutter = i64::from(layout.gutter);
    for face in CubeFace::ALL {
        let [left, top] = layout.corner(face);
        for y in -gutter..=last + gutter {
            for x in -gutter..=last + gutter {
                // Beyond a corner there is nothing: the next texel above or below is taken.
                let outside = !(0..=last).contains(&x);
                let row = if outside { y.clamp(0, last) } else { y };
                let (there, u, v) = folded(face, x, row, size);
                let texel = map.face(there).at(u, v);
                let place = [i64::from(left) + x, i64::from(top) + y];
                picture.set(place[0] as u32, place[1] as u32, texel);
            }
        }
    }
    picture
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_and_gutters_hold_the_right_texels() {
        let map = Cubemap::from_directions(32, |d| {
            let d = d.normalize() * 100.0 + 128.0;
            Straight([d.x as u8, d.y as u8, d.z as u8, 255])
        });
        let picture = atlas(&map);
        let layout = AtlasLayout::new(32);
        assert_eq!([picture.width(), picture.height()], layout.picture_size());
        for face in CubeFace::ALL {
            for (u, v) in [(0.0, 0.0), (0.9, -0.7), (-1.0, 0.3), (0.2, 1.0)] {
                let [s, t] = layout.texture_coordinates(face, u, v);
                let x =
                    (f64::from(s) * f64::from(picture.width())).min(f64::from(picture.width() - 1));
                let y = (f64::from(t) * f64::from(picture.height()))
                    .min(f64::from(picture.height() - 1));
                let found = picture.at(x as u32, y as u32).0;
                let expected = map.nearest(face.direction(u, v)).0;
                for channel in 0..3 {
                    assert!(
                        found[channel].abs_diff(expected[channel]) <= 8,
                        "{face:?} {u} {v}"
                    );
                }
            }
        }
    }
}
