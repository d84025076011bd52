//! Photographs that never were: grown trees in front of sky, meadow, hedge and houses, each with the
//! exact mask of its crown.
//!
//! A photograph is put together from back to front, as a stage painter would: sky, what stands far
//! away, the ground, the tree with its shadow, grass in front of its foot. What is far away is
//! paler and bluer (aerial perspective) and out of focus; then the lens darkens the corners and
//! softens, and the sensor adds its noise. Everything is a function of the [`Photo`] alone; only
//! the JPEG file depends on the encoder's version.

mod backdrop;
mod frame;
mod ground;
mod houses;
mod lens;
mod sky;

use super::individual::Individual;
use super::species::species_named;
use super::tree::{GrownTree, Tree};
use crate::base::{Cancel, Cancelled, Seed};
use crate::raster::{Image, Straight};
use frame::{Camera, Frame};
use glam::Vec3;

/// What stands behind the tree.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Backdrop {
    /// A meadow up to the edge of a wood.
    Meadow,
    /// Far hills.
    Hills,
    /// Other trees of a park.
    Park,
    /// A trimmed hedge.
    Hedge,
    /// A row of houses.
    Houses,
}

/// One photograph.
#[derive(Debug, Clone, Copy)]
pub struct Photo {
    name: &'static str,
    species: &'static str,
    individual: u32,
    size: (u32, u32),
    /// Where the stem stands, a share of the width.
    place: f32,
    /// Height of the tree, a share of the picture's.
    fill: f32,
    /// Height of the lower edge of the tree above that of the picture, a share of its height.
    foot: f32,
    /// Height of the camera above the ground in metres.
    camera_m: f32,
    backdrop: Backdrop,
    seed: u64,
}

/// A photograph as it comes from the camera.
#[derive(Debug, Clone, PartialEq)]
pub struct DevelopedPhoto {
    /// Opaque.
    pub image: Image<Straight>,
    /// 255 where the crown is, 0 elsewhere.
    pub mask: Image<u8>,
}

const LANDSCAPE: (u32, u32) = (1440, 1080);
const PORTRAIT: (u32, u32) = (1080, 1440);

/// How far behind the tree a hedge and houses stand, in metres.
const HEDGE_M: f32 = 5.5;
const HOUSES_M: f32 = 11.0;

static PHOTOS: [Photo; 6] = [
    Photo {
        name: "meadow_oak",
        species: "oak",
        individual: 2,
        size: LANDSCAPE,
        place: 0.47,
        fill: 0.78,
        foot: 0.13,
        camera_m: 1.7,
        backdrop: Backdrop::Meadow,
        seed: 1,
    },
    Photo {
        name: "garden_apple",
        species: "apple",
        individual: 3,
        size: LANDSCAPE,
        place: 0.55,
        fill: 0.76,
        foot: 0.15,
        camera_m: 1.6,
        backdrop: Backdrop::Hedge,
        seed: 2,
    },
    Photo {
        name: "street_maple",
        species: "maple",
        individual: 1,
        size: PORTRAIT,
        place: 0.52,
        fill: 0.74,
        foot: 0.12,
        camera_m: 1.65,
        backdrop: Backdrop::Houses,
        seed: 3,
    },
    Photo {
        name: "heath_pine",
        species: "pine",
        individual: 2,
        size: PORTRAIT,
        place: 0.45,
        fill: 0.82,
        foot: 0.09,
        camera_m: 1.7,
        backdrop: Backdrop::Hills,
        seed: 4,
    },
    Photo {
        name: "park_willow",
        species: "willow",
        individual: 2,
        size: LANDSCAPE,
        place: 0.5,
        fill: 0.78,
        foot: 0.12,
        camera_m: 1.6,
        backdrop: Backdrop::Park,
        seed: 5,
    },
    Photo {
        name: "yard_birch",
        species: "birch",
        individual: 3,
        size: PORTRAIT,
        place: 0.5,
        fill: 0.80,
        foot: 0.10,
        camera_m: 1.6,
        backdrop: Backdrop::Houses,
        seed: 6,
    },
];

/// The photographs, in the order they are shown.
pub fn photos() -> &'static [Photo] {
    &PHOTOS
}

/// What all painters of a photograph need.
struct Scene {
    camera: Camera,
    /// Distance of the tree in metres.
    distance_m: f32,
    /// Column of the stem and row of its foot.
    foot: (f32, f32),
    sky: sky::Sky,
    /// Distance in metres up to which the ground is bare of trees and walls.
    clear_m: f32,
    with_street: bool,
    seed: Seed,
}

impl Photo {
    /// Its name, also of its file.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Takes the photograph, `scale` times as large as usual.
    ///
    /// # Errors
    /// [`Cancelled`].
    ///
    /// # Panics
    /// Never: the table names species that exist.
    pub fn developed(&self, scale: f32, cancel: &Cancel) -> Result<DevelopedPhoto, Cancelled> {
        let side = |length: u32| ((length as f32 * scale) as u32).max(16);
        let size = (side(self.size.0), side(self.size.1));
        let species = species_named(self.species).expect("photographs show species that exist");
        let individual = Individual::new(species, self.individual);
        let tree = individual.grow(cancel)?;
        let canvas = (size.0, ((size.1 as f32 * self.fill) as u32).max(8));
        let picture = tree.picture(canvas, false, cancel)?;
        let scene = self.scene(size, &individual, &picture);
        let mut frame = Frame::new(size.0, size.1);
        sky::paint(&mut frame, &scene);
        ground::paint_far(&mut frame, &scene);
        cancel.check()?;
        self.paint_backdrop(&mut frame, &scene, cancel)?;
        frame.blur(1.25 * size.1 as f32 / 1080.0);
        cancel.check()?;
        let corner = self.paint_tree(&mut frame, &scene, (&tree, &picture), cancel)?;
        lens::expose(&mut frame, &scene);
        Ok(DevelopedPhoto {
            image: frame.image(),
            mask: self.mask(size, corner, &picture, &scene),
        })
    }

    fn scene(&self, size: (u32, u32), individual: &Individual, picture: &GrownTree) -> Scene {
        let (width, height) = (size.0 as f32, size.1 as f32);
        // As wide as a telephone sees.
        let focal_px = 1.15 * width.max(height);
        let distance_m = focal_px / picture.pixels_of_metre;
        let foot = (self.place * width, (1.0 - self.foot) * height);
        Scene {
            camera: Camera {
                focal_px,
                middle_px: foot.0,
                horizon_px: foot.1 - picture.pixels_of_metre * self.camera_m,
                height_m: self.camera_m,
            },
            distance_m,
            foot,
            sky: sky::Sky::new(individual.daylight, individual.traits().softness),
            clear_m: match self.backdrop {
                Backdrop::Meadow | Backdrop::Hills => 3.5 * distance_m,
                Backdrop::Park => 2.2 * distance_m,
                Backdrop::Hedge => distance_m + HEDGE_M,
                Backdrop::Houses => distance_m + HOUSES_M,
            },
            with_street: self.backdrop == Backdrop::Houses,
            seed: Seed(self.seed).derive("photograph", 0),
        }
    }

    fn paint_backdrop(
        &self,
        frame: &mut Frame,
        scene: &Scene,
        cancel: &Cancel,
    ) -> Result<(), Cancelled> {
        let away = scene.distance_m;
        match self.backdrop {
            Backdrop::Meadow => backdrop::wood(frame, scene, (7.0 * away, 70), cancel)?,
            Backdrop::Hills => {
                backdrop::hills(frame, scene);
                backdrop::wood(frame, scene, (9.0 * away, 46), cancel)?;
            }
            Backdrop::Park => {
                backdrop::wood(frame, scene, (6.0 * away, 50), cancel)?;
                backdrop::wood(frame, scene, (2.8 * away, 5), cancel)?;
            }
            Backdrop::Hedge => {
                backdrop::wood(frame, scene, (5.0 * away, 28), cancel)?;
                backdrop::hedge(frame, scene, away + HEDGE_M, cancel)?;
            }
            Backdrop::Houses => {
                backdrop::wood(frame, scene, (5.0 * away, 20), cancel)?;
                houses::paint(frame, scene, away + HOUSES_M);
            }
        }
        Ok(())
    }

    /// Ground with the shadow, tree, grass before it; returns where the tree's picture begins.
    fn paint_tree(
        &self,
        frame: &mut Frame,
        scene: &Scene,
        (tree, picture): (&Tree, &GrownTree),
        cancel: &Cancel,
    ) -> Result<(i64, i64), Cancelled> {
        let shadow = ground::Shadow::new(picture, tree, scene);
        ground::paint_near(frame, scene, &shadow);
        cancel.check()?;
        let (width, height) = (picture.image.width(), picture.image.height());
        let corner = (
            (scene.foot.0 - 0.5 * width as f32) as i64,
            scene.foot.1 as i64 - i64::from(height),
        );
        ground::paint_grass(frame, scene, &shadow, true);
        // A little air lies between the tree and the camera, and it takes the light of the place.
        let air = 1.0 - libm::expf(-scene.distance_m / 900.0);
        let haze = scene.sky.haze();
        frame.draw(&picture.image, corner, |colour| colour.lerp(haze, air));
        ground::paint_tuft(frame, scene, &shadow);
        ground::paint_grass(frame, scene, &shadow, false);
        Ok(corner)
    }

    fn mask(
        &self,
        size: (u32, u32),
        corner: (i64, i64),
        picture: &GrownTree,
        scene: &Scene,
    ) -> Image<u8> {
        let grass = scene.foot.1 as i64 - ground::grass_px(scene) as i64;
        let pixels = (0..i64::from(size.1)).flat_map(|y| {
            (0..i64::from(size.0)).map(move |x| {
                let label = picture.labels.get(x - corner.0, y - corner.1);
                if label == Some(255) && y < grass {
                    255
                } else {
                    0
                }
            })
        });
        Image::from_pixels(size.0, size.1, pixels.collect())
    }
}

/// Linear light as it is shown, sRGB in 0..255.
fn shown(light: Vec3) -> Vec3 {
    super::render::shown(light)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Digest;
    use rayon::prelude::*;

    /// Lines of `NAME WIDTH DIGEST MASK_DIGEST`, of the usual and of a small size.
    const DIGESTS: &str = include_str!("../../../assets/photos/digests.txt");

    /// Scale of the small size.
    const SMALL: f32 = 0.1;

    fn line(photo: &Photo, developed: &DevelopedPhoto) -> String {
        let image = Digest::of(bytemuck::cast_slice(developed.image.pixels()));
        let mask = Digest::of(developed.mask.pixels());
        format!(
            "{} {} {image} {mask}",
            photo.name(),
            developed.image.width()
        )
    }

    fn assert_listed(line: &str) {
        assert!(
            DIGESTS.lines().any(|listed| listed == line),
            "{line} is not listed"
        );
    }

    #[test]
    fn a_small_photograph_is_the_listed_one_and_shows_its_crown_where_the_mask_says() {
        let photo = &photos()[3];
        let developed = photo.developed(SMALL, &Cancel::new()).unwrap();
        let (image, mask) = (&developed.image, &developed.mask);
        assert_eq!(
            (image.width(), image.height()),
            (mask.width(), mask.height())
        );
        assert!(image.pixels().iter().all(|pixel| pixel.alpha() == 255));
        // Sky around, crown in the middle: the mask tells dark from light.
        let upper = mask.pixels().len() / 3;
        let mean = |inside: u8| {
            let pairs = image.pixels().iter().zip(mask.pixels()).take(upper);
            let chosen: Vec<f32> = pairs
                .filter(|(_, m)| **m == inside)
                .map(|(pixel, _)| f32::from(pixel.0[2]))
                .collect();
            assert!(chosen.len() > upper / 20);
            chosen.iter().sum::<f32>() / chosen.len() as f32
        };
        assert!(mean(0) > mean(255) + 40.0);
        assert_listed(&line(photo, &developed));
    }

    /// With `REGENERATE=1` it writes the digests instead; `boscage samples --photos --out
    /// assets/photos` writes the files.
    #[test]
    #[ignore = "takes a minute; last passed on 2026-11-28"]
    fn every_photograph_taken_anew_is_the_listed_one() {
        let lines: Vec<String> = photos()
            .par_iter()
            .with_max_len(1)
            .flat_map_iter(|photo| {
                [1.0, SMALL].map(|scale| {
                    let developed = photo.developed(scale, &Cancel::new()).unwrap();
                    line(photo, &developed)
                })
            })
            .collect();
        if std::env::var_os("REGENERATE").is_some() {
            let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
            let file = root.join("assets/photos/digests.txt");
            std::fs::write(file, lines.join("\n") + "\n").unwrap();
        } else {
            lines.iter().for_each(|line| assert_listed(line));
        }
    }
}
