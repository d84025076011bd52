//! Jobs of many items: this shard's share in parallel, and what becomes of the bad ones.

use super::failure::Failure;
use super::run::Run;
use rayon::prelude::*;

/// What came of the items of this shard.
pub(crate) struct Made<R> {
    /// Index in the job and result of each item that could be made, in order.
    pub(crate) ready: Vec<(usize, R)>,
    /// Index in the job and reason of each item of bad input, in order.
    pub(crate) refused: Vec<(usize, String)>,
}

/// Makes the items of this shard in parallel: `make(index in the job, item)`.
///
/// An item of bad input is warned of and the others go on.
///
/// # Errors
/// The first failure of the environment or cancellation; [`Failure::BadInput`] when this shard has
/// items and none of them can be made (with one item only: its own failure). No items at all,
/// beyond the end of the job, are no error.
pub(crate) fn made<T: Sync, R: Send>(
    session: &Run<'_>,
    stage: &'static str,
    items: &[T],
    make: impl Fn(usize, &T) -> Result<R, Failure> + Sync,
) -> Result<Made<R>, Failure> {
    let shard = session.shard;
    let ours: Vec<(usize, &T)> = items
        .iter()
        .enumerate()
        .filter(|(index, _)| shard.contains(*index as u64))
        .collect();
    let alone = ours.len() == 1;
    let stage = session.progress.stage(stage, ours.len() as u64);
    let outcomes: Vec<(usize, Result<R, String>)> = ours
        .into_par_iter()
        .with_max_len(1)
        .map(|(index, item)| {
            session.check()?;
            let outcome = match make(index, item) {
                Err(Failure::BadInput(reason)) if !alone => {
                    session.progress.warn(&reason);
                    Err(reason)
                }
                other => Ok(other?),
            };
            stage.advance();
            Ok((index, outcome))
        })
        .collect::<Result<_, Failure>>()?;
    sorted(outcomes)
}

fn sorted<R>(outcomes: Vec<(usize, Result<R, String>)>) -> Result<Made<R>, Failure> {
    let mut made = Made {
        ready: Vec::new(),
        refused: Vec::new(),
    };
    for (index, outcome) in outcomes {
        match outcome {
            Ok(result) => made.ready.push((index, result)),
            Err(reason) => made.refused.push((index, reason)),
        }
    }
    if made.ready.is_empty() && !made.refused.is_empty() {
        let count = made.refused.len();
        return Err(Failure::BadInput(format!(
            "none of the {count} inputs can be used"
        )));
    }
    Ok(made)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_good_item_is_enough() {
        let some = sorted(vec![(0, Err("a".to_owned())), (1, Ok(7))]).unwrap();
        assert_eq!(some.ready, [(1, 7)]);
        assert_eq!(some.refused.len(), 1);
        assert!(sorted::<u8>(vec![(0, Err("a".to_owned())), (2, Err("b".to_owned()))]).is_err());
        assert!(sorted::<u8>(Vec::new()).is_ok());
    }
}
