//! Randomness that depends on a seed alone: not on threads, machine, or the order of the work.
//!
//! Every random decision draws from a [`Random`] made from a [`Seed`] that was derived by name and
//! index ("tree", 3), so that item 3 of a job is the same whether it is made first, last or on
//! another machine. The generator is SplitMix64 (Steele, Lea & Flood, *Fast Splittable
//! Pseudorandom Number Generators*, 2014): 64 bits of state, passes BigCrush, four lines. No
//! transcendental function is used: those differ in the last bit between C libraries.

use super::hash::Hasher;

/// Where randomness comes from: what the user gives as `--seed`, and what is derived from it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Seed(pub u64);

impl Seed {
    /// The seed of item `index` of the job `name`, independent of all other items.
    pub fn derive(self, name: &str, index: u64) -> Self {
        let digest = Hasher::new("boscage seed")
            .with(&self.0.to_le_bytes())
            .with(name.as_bytes())
            .with(&index.to_le_bytes())
            .finish();
        Self(digest.leading_u64())
    }

    /// A generator that starts from this seed.
    pub fn random(self) -> Random {
        Random { state: self.0 }
    }
}

/// A stream of random numbers.
#[derive(Debug, Clone)]
pub struct Random {
    state: u64,
}

impl Random {
    /// The next 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Uniform in [`low`, `high`).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// A whole number in 0..`count`; `count` must not be 0.
    pub fn below(&mut self, count: usize) -> usize {
        // The bias of the multiply-shift is count / 2^64: nothing a picture could show.
        ((u128::from(self.bits()) * count as u128) >> 64) as usize
    }

    /// `chosen` different whole numbers below `count`, in random order (all of them at most).
    pub fn choose(&mut self, count: usize, chosen: usize) -> Vec<usize> {
        let mut pool: Vec<usize> = (0..count).collect();
        let chosen = chosen.min(count);
        for i in 0..chosen {
            let j = i + self.below(count - i);
            pool.swap(i, j);
        }
        pool.truncate(chosen);
        pool
    }

    /// `count` non-negative weights of sum 1, uniform on the simplex (flat Dirichlet): the gaps
    /// between sorted uniform numbers.
    pub fn convex_weights(&mut self, count: usize) -> Vec<f64> {
        let mut cuts: Vec<f64> = (1..count).map(|_| self.unit()).collect();
        cuts.sort_by(f64::total_cmp);
        cuts.push(1.0);
        let mut last = 0.0;
        cuts.iter()
            .map(|&cut| {
                let weight = cut - last;
                last = cut;
                weight
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derived_seeds_differ_by_name_and_index_and_repeat() {
        let seed = Seed(7);
        assert_eq!(seed.derive("tree", 3), seed.derive("tree", 3));
        assert_ne!(seed.derive("tree", 3), seed.derive("tree", 4));
        assert_ne!(seed.derive("tree", 3), seed.derive("leaf", 3));
        assert_ne!(seed.derive("tree", 3), Seed(8).derive("tree", 3));
    }

    #[test]
    fn the_stream_is_splitmix64() {
        // First outputs of the reference implementation for seed 1234567.
        let mut random = Seed(1_234_567).random();
        assert_eq!(random.bits(), 6_457_827_717_110_365_317);
        assert_eq!(random.bits(), 3_203_168_211_198_807_973);
    }

    #[test]
    fn weights_are_convex() {
        let mut random = Seed(1).random();
        for count in 1..6 {
            let weights = random.convex_weights(count);
            assert_eq!(weights.len(), count);
            assert!(weights.iter().all(|&w| w >= 0.0));
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn chosen_numbers_are_different() {
        let mut random = Seed(2).random();
        let mut chosen = random.choose(10, 7);
        chosen.sort_unstable();
        chosen.dedup();
        assert_eq!(chosen.len(), 7);
        assert_eq!(random.choose(3, 9).len(), 3);
    }
}
