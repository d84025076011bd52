//! What a job is given: where to tell, stop and write, and which part of it to do.

use super::output::Output;
use crate::base::{Cancel, Cancelled, Progress};
use crate::raster::{Image, Straight};
use std::str::FromStr;

/// The surroundings of one job. Its work runs inside a thread pool already.
pub(crate) struct Run<'a> {
    /// Same inputs, settings and seed: same files.
    pub(crate) seed: u64,
    /// The part that this process does.
    pub(crate) shard: Shard,
    /// Where algorithms tell of their stages, and where warnings go.
    pub(crate) progress: Progress<'a>,
    /// Raised when the job is to stop.
    pub(crate) cancel: &'a Cancel,
    /// Where files are written.
    pub(crate) output: Output,
    /// Called before each item: returns at once, or when a pause is over.
    pub(crate) gate: Option<Gate<'a>>,
    /// Told of each tree's picture, for those who watch.
    pub(crate) shown: Option<Shown<'a>>,
}

/// Who watches a job.
pub(crate) type Shown<'a> = &'a (dyn Fn(&Image<Straight>) + Sync);

/// What may hold up the items of a job.
pub(crate) type Gate<'a> = &'a (dyn Fn() -> Result<(), Cancelled> + Sync);

impl Run<'_> {
    /// Waits while the job is paused.
    ///
    /// # Errors
    /// [`Cancelled`] once the job is to stop.
    pub(crate) fn check(&self) -> Result<(), Cancelled> {
        self.gate.map_or(Ok(()), |gate| gate())?;
        self.cancel.check()
    }
}

/// The part of a job that this process does: items `index`, `index + count`, ….
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Shard {
    index: u64,
    count: u64,
}

impl Shard {
    /// Whether this part is the whole job.
    pub(crate) fn is_whole(self) -> bool {
        self.count == 1
    }

    /// Whether item `index` of the job belongs to this part.
    pub(crate) fn contains(self, index: u64) -> bool {
        index % self.count == self.index
    }
}

impl Default for Shard {
    fn default() -> Self {
        Self { index: 0, count: 1 }
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form = || "expected I/N, two whole numbers, such as 0/4".to_owned();
        let (index, count) = text.split_once('/').ok_or_else(form)?;
        let number = |digits: &str| {
            let plain = digits.bytes().all(|b| b.is_ascii_digit());
            plain.then(|| digits.parse::<u64>().ok()).flatten()
        };
        let index = number(index).ok_or_else(form)?;
        let count = number(count).ok_or_else(form)?;
        if index >= count {
            return Err(format!("part {index} of {count} does not exist"));
        }
        Ok(Self { index, count })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_divide_a_job_without_gap_or_overlap() {
        let shards: Vec<Shard> = ["0/3", "1/3", "2/3"].map(|s| s.parse().unwrap()).to_vec();
        for item in 0..20 {
            let owners = shards.iter().filter(|shard| shard.contains(item)).count();
            assert_eq!(owners, 1);
        }
        assert!(shards[1].contains(4));
    }

    #[test]
    fn shards_that_do_not_exist_are_refused() {
        for text in [
            "3/3", "0/0", "1", "-1/2", "+0/2", "a/b", "0/", "/1", "0/1/2",
        ] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
    }
}
