//! A row of houses across the street: plain fronts with windows under tiled roofs.

use super::Scene;
use super::frame::Frame;
use super::shown;
use crate::base::Random;
use crate::branches::noise::{noise3, ramp};
use glam::Vec3;

/// One house, in metres: x of its left wall, width, height of the eaves, rise of the roof.
struct House {
    left_m: f32,
    width_m: f32,
    eaves_m: f32,
    roof_m: f32,
    storeys: u32,
    axes: u32,
    wall: Vec3,
    tiles: Vec3,
    shutters: Option<Vec3>,
    salt: u32,
}

/// Paints houses whose fronts stand `away_m` off.
pub(super) fn paint(frame: &mut Frame, scene: &Scene, away_m: f32) {
    let camera = &scene.camera;
    let scale = camera.focal_px / away_m;
    let mut random = scene.seed.derive("houses", 0).random();
    let mut x = -camera.middle_px / scale - random.between(1.0, 5.0) as f32;
    while x < (frame.width as f32 - camera.middle_px) / scale {
        let house = house(x, &mut random);
        x += house.width_m;
        house.paint(frame, scene, away_m);
        // Now and then a gap with a garden.
        if random.unit() < 0.35 {
            x += random.between(1.5, 4.0) as f32;
        }
    }
}

fn house(left_m: f32, random: &mut Random) -> House {
    const WALLS: [[f32; 3]; 5] = [
        [0.60, 0.55, 0.46],
        [0.52, 0.44, 0.33],
        [0.62, 0.60, 0.56],
        [0.44, 0.34, 0.27],
        [0.50, 0.50, 0.44],
    ];
    const TILES: [[f32; 3]; 3] = [
        [0.23, 0.10, 0.065],
        [0.14, 0.10, 0.085],
        [0.19, 0.085, 0.06],
    ];
    const SHUTTERS: [[f32; 3]; 3] = [[0.05, 0.10, 0.08], [0.10, 0.05, 0.04], [0.08, 0.10, 0.14]];
    let pick = |colours: &[[f32; 3]], random: &mut Random| {
        Vec3::from_array(colours[random.below(colours.len())])
    };
    let storeys = 2 + random.below(2) as u32;
    House {
        left_m,
        width_m: random.between(7.5, 12.0) as f32,
        eaves_m: 0.9 + 2.85 * storeys as f32,
        roof_m: random.between(2.4, 3.6) as f32,
        storeys,
        axes: 3 + random.below(2) as u32,
        wall: pick(&WALLS, random),
        tiles: pick(&TILES, random),
        shutters: (random.unit() < 0.6).then(|| pick(&SHUTTERS, random)),
        salt: random.bits() as u32,
    }
}

impl House {
    fn paint(&self, frame: &mut Frame, scene: &Scene, away_m: f32) {
        let camera = &scene.camera;
        let scale = camera.focal_px / away_m;
        let (left, top) = camera.pixel(self.left_m - 0.4, self.eaves_m + self.roof_m, away_m);
        let (right, foot) = camera.pixel(self.left_m + self.width_m + 0.4, 0.0, away_m);
        for y in top.max(0.0) as i64..(foot.max(0.0) as i64).min(frame.height as i64) {
            for x in left.max(0.0) as i64..(right.max(0.0) as i64).min(frame.width as i64) {
                let at_x = (x as f32 + 0.5 - camera.middle_px) / scale - self.left_m;
                let at_y = camera.height_m - (y as f32 + 0.5 - camera.horizon_px) / scale;
                if let Some(light) = self.light(scene, at_x, at_y) {
                    let colour = scene.sky.through_air(shown(light), 1.3 * away_m);
                    frame.blend(x, y, colour, 1.0);
                }
            }
        }
    }

    /// Linear light from the place at x from the left wall and y above the ground.
    fn light(&self, scene: &Scene, x: f32, y: f32) -> Option<Vec3> {
        let daylight = &scene.sky.daylight;
        let front = daylight.sun * daylight.to_sun.z.max(0.0) * 0.9 + daylight.sky * 0.55;
        let roof_y = y - self.eaves_m;
        if roof_y > -0.12 {
            let inset = 0.25 * roof_y.max(0.0);
            let is_roof = x > inset - 0.35 && x < self.width_m + 0.35 - inset;
            return is_roof.then(|| self.roof(scene, x, roof_y));
        }
        if !(0.0..self.width_m).contains(&x) {
            return None;
        }
        // The eaves shade the wall below them.
        let shade = 1.0 - 0.45 * ramp(-0.75, -0.15, roof_y);
        Some(match self.window(x, y) {
            Some(light) => light * (0.4 + 0.6 * shade) + daylight.sky * 0.03,
            None => self.plaster(x, y) * front * shade,
        })
    }

    fn plaster(&self, x: f32, y: f32) -> Vec3 {
        let stain = noise3(x * 0.6, y * 0.35, 0.0, self.salt);
        let grain = noise3(x * 11.0, y * 11.0, 0.0, self.salt);
        // Splashes and damp near the ground.
        let damp = 1.0 - 0.32 * ramp(0.9 + 0.3 * stain, 0.1, y);
        self.wall * (1.0 + 0.09 * stain + 0.05 * grain) * damp
    }

    fn roof(&self, scene: &Scene, x: f32, y: f32) -> Vec3 {
        let daylight = &scene.sky.daylight;
        if y < 0.02 {
            return Vec3::splat(0.10);
        }
        let row = y / 0.27;
        let tile = noise3(x * 4.4, libm::floorf(row) * 3.3, 0.0, self.salt);
        let edge = 1.0 - 0.3 * ramp(0.75, 1.0, row.fract());
        let moss = 1.0 + 0.2 * noise3(x * 0.7, y * 0.7, 4.0, self.salt);
        let up = Vec3::new(0.0, 0.70, 0.71).dot(daylight.to_sun).max(0.0);
        let light = daylight.sun * up + daylight.sky * 0.8;
        self.tiles * (1.0 + 0.22 * tile) * edge * moss * light
    }

    /// Light from a window, its frame, its shutters or the door, if one is there.
    fn window(&self, x: f32, y: f32) -> Option<Vec3> {
        let axis_m = self.width_m / self.axes as f32;
        let column = libm::floorf(x / axis_m);
        let storey = libm::floorf((y - 0.75) / 2.85);
        if (storey < 0.0 && y <= 0.05) || storey >= self.storeys as f32 {
            return None;
        }
        let aside = (x - (column + 0.5) * axis_m).abs();
        let up = y - 0.75 - 2.85 * storey.max(0.0) - 0.75;
        let is_door = storey <= 0.0 && column as u32 == self.salt % self.axes;
        if is_door {
            let inside = aside < 0.52 && y < 2.35 && y > 0.1;
            let panel = aside > 0.42 || y > 2.25;
            let wood = self.shutters.unwrap_or(Vec3::new(0.09, 0.05, 0.03));
            return inside.then_some(if panel { Vec3::splat(0.34) } else { wood * 1.6 });
        }
        if !(-0.08..1.5).contains(&up) {
            return None;
        }
        if let Some(colour) = self.shutters
            && (0.56..1.02).contains(&aside)
            && up > 0.0
        {
            let slat = 0.75 + 0.35 * (up * 9.0).fract();
            return Some(colour * slat * 2.0);
        }
        if aside > 0.54 {
            return None;
        }
        let on_frame = !(0.035..=0.46).contains(&aside)
            || !(0.06..1.42).contains(&up)
            || (up - 1.0).abs() < 0.03;
        Some(if on_frame {
            Vec3::splat(if up < 0.0 { 0.5 } else { 0.75 })
        } else {
            self.glass(x, y, column + 7.0 * storey)
        })
    }

    /// Dark rooms, sky mirrored in the panes, a curtain here and there.
    fn glass(&self, x: f32, y: f32, number: f32) -> Vec3 {
        let own = noise3(number * 3.1, 0.5, 0.5, self.salt);
        let mirrored = noise3(x * 1.4 + own * 9.0, y * 0.9, number, self.salt);
        let sky = Vec3::new(0.30, 0.38, 0.48) * ramp(-0.3, 0.5, mirrored + own);
        let room = Vec3::new(0.025, 0.027, 0.03);
        let curtain = if own > 0.25 {
            Vec3::splat(0.10)
        } else {
            Vec3::ZERO
        };
        room + curtain + sky * 0.55
    }
}
