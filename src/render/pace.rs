//! How finely a view in motion is drawn, so that it follows the hand on any card.
//!
//! A ladder of levels, from the whole picture to a quarter of its sides. The time of each picture
//! says whether the next may be finer: one step down at once when a picture took too long, one step
//! up when the level above would have been fast enough several times in a row. The cost of a level
//! is taken to follow its samples; what a picture costs at any size makes that guess too high, so
//! that a step up is never followed by a step down on a quiet machine.
//!
//! Limits: a picture that took long for another reason, such as a window that slept, costs one step
//! for some pictures.

use super::settings::{ReliefSettings, RenderSettings};

/// Time for a picture in motion, milliseconds: at 15 pictures a second this leaves a quarter for
/// the window itself.
const MOVING_MS: f64 = 50.0;

/// Time for a part of a picture at rest, milliseconds: a hand that moves again waits that long.
const PART_MS: f64 = 30.0;

/// Share of the time that the level above may be expected to take.
const SPARE: f64 = 0.8;

/// Pictures in a row that must have allowed for a step up.
const PATIENCE: u32 = 3;

/// Share of the picture's sides that is drawn at each level. At level 0 the picture is final, at
/// level 1 it has all pixels, but one sample each and fewer steps.
const SCALES: [f32; 6] = [1.0, 1.0, 0.75, 0.5, 0.375, 0.25];

/// How much more the final picture costs than level 1, for each of its samples.
const FINAL_COST: f64 = 2.0;

/// The level of a view in motion.
#[derive(Debug, Clone)]
pub(super) struct Pace {
    level: usize,
    /// Pictures in a row that would have allowed for more.
    fast: u32,
}

impl Pace {
    /// Begins half-way on a program that plays a card, and at the top on a card.
    pub(super) fn new(is_software: bool) -> Self {
        Self {
            level: if is_software { 3 } else { 0 },
            fast: 0,
        }
    }

    /// Whether a picture in motion is as good as one at rest.
    pub(super) fn is_final(&self) -> bool {
        self.level == 0
    }

    /// How a picture in motion is drawn that is drawn with `settings` at rest.
    pub(super) fn settings(&self, settings: &RenderSettings) -> RenderSettings {
        if self.is_final() {
            return *settings;
        }
        RenderSettings {
            scale: settings.scale * SCALES[self.level],
            fineness: 1,
            relief: ReliefSettings {
                shortcut: settings.relief.shortcut,
                ..ReliefSettings::quick()
            },
            ..*settings
        }
    }

    /// Learns that a picture of this level took `ms` milliseconds, `settings` being those at rest.
    pub(super) fn record(&mut self, ms: f64, settings: &RenderSettings) {
        let samples = f64::from(settings.fineness * settings.fineness);
        let cost = |level: usize| {
            let area = f64::from(SCALES[level] * SCALES[level]);
            if level == 0 {
                area * samples * FINAL_COST
            } else {
                area
            }
        };
        if ms > MOVING_MS {
            self.level = (self.level + 1).min(SCALES.len() - 1);
            self.fast = 0;
            return;
        }
        let Some(above) = self.level.checked_sub(1) else {
            return;
        };
        let expected = ms * cost(above) / cost(self.level);
        self.fast = if expected <= MOVING_MS * SPARE {
            self.fast + 1
        } else {
            0
        };
        if self.fast == PATIENCE {
            self.level = above;
            self.fast = 0;
        }
    }
}

/// How much of a picture at rest is drawn at once, as a share of its rows.
#[derive(Debug, Clone)]
pub(super) struct Portion {
    share: f64,
}

impl Portion {
    /// Begins with little on a program that plays a card.
    pub(super) fn new(is_software: bool) -> Self {
        Self {
            share: if is_software { 1.0 / 32.0 } else { 0.25 },
        }
    }

    /// Rows of `count` to be drawn next; at least one.
    pub(super) fn rows(&self, count: u32) -> u32 {
        ((f64::from(count) * self.share) as u32).clamp(1, count.max(1))
    }

    /// Learns that a part took `ms` milliseconds. Parts differ: some are sky.
    pub(super) fn record(&mut self, ms: f64) {
        let change = (PART_MS / ms.max(0.1)).clamp(0.25, 2.0);
        self.share = (self.share * change).clamp(1.0 / 256.0, 1.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The scales that are drawn when a picture takes `time` of its share of the samples.
    fn scales(pace: &mut Pace, count: usize, time: impl Fn(usize, f64) -> f64) -> Vec<f32> {
        let settings = RenderSettings::default();
        let drawn = (0..count).map(|i| {
            let moving = pace.settings(&settings);
            let fine = f64::from(moving.fineness * moving.fineness);
            let area = f64::from(moving.scale * moving.scale) * fine;
            pace.record(time(i, area), &settings);
            moving.scale * moving.fineness as f32
        });
        drawn.collect()
    }

    #[test]
    fn a_fast_card_draws_final_pictures() {
        let mut pace = Pace::new(false);
        assert_eq!(scales(&mut pace, 20, |_, area| area), [2.0; 20]);
        assert!(pace.is_final());
    }

    #[test]
    fn a_slow_card_steps_down_and_stays() {
        // 10 ms for anything, 250 ms for all pixels.
        let mut pace = Pace::new(false);
        let drawn = scales(&mut pace, 40, |_, area| 10.0 + 250.0 * area);
        assert_eq!(drawn[..5], [2.0, 1.0, 0.75, 0.5, 0.375]);
        assert!(drawn[5..].iter().all(|&scale| scale == 0.375));
    }

    #[test]
    fn a_card_that_becomes_free_is_used() {
        let mut pace = Pace::new(true);
        let busy = scales(&mut pace, 10, |_, area| 900.0 * area);
        assert_eq!(busy[9], 0.25);
        let free = scales(&mut pace, 40, |_, area| 20.0 * area);
        assert_eq!(free[39], 1.0, "{free:?}");
        assert!(!pace.is_final(), "four samples would take too long");
    }

    #[test]
    fn one_late_picture_costs_one_step_for_a_while() {
        let mut pace = Pace::new(true);
        let time = |i: usize, area: f64| if i == 10 { 4000.0 } else { 120.0 * area };
        let drawn = scales(&mut pace, 30, time);
        assert_eq!(drawn[9..16], [0.5, 0.5, 0.375, 0.375, 0.375, 0.5, 0.5]);
    }

    #[test]
    fn nothing_is_drawn_smaller_than_the_last_level() {
        let mut pace = Pace::new(true);
        let drawn = scales(&mut pace, 10, |_, _| 1e6);
        assert_eq!(drawn[9], 0.25);
    }

    #[test]
    fn portions_grow_and_shrink_to_their_time() {
        let mut portion = Portion::new(true);
        for _ in 0..20 {
            let rows = portion.rows(1600);
            portion.record(f64::from(rows) * 0.5);
        }
        assert!((55..=65).contains(&portion.rows(1600)));
        portion.record(1e9);
        assert!(portion.rows(1600) < 20 && portion.rows(3) == 1);
    }
}
