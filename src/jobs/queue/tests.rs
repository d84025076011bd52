//! Every promise of the queue, with threads held at barriers rather than asleep.

use super::*;
use proptest::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

const PATIENCE: Duration = Duration::from_secs(20);

fn topic(item: u64) -> Topic {
    Topic { kind: "test", item }
}

/// A job that runs until told by the returned sender what to give.
fn held(jobs: &Jobs<u32>, item: u64, priority: Priority) -> (JobId, Sender<u32>, Receiver<()>) {
    let (tell, told) = channel();
    let (begun, has_begun) = channel();
    let id = jobs.submit(Request::new(
        "held",
        topic(item),
        priority,
        move |context| {
            begun.send(()).unwrap();
            loop {
                context.check()?;
                match told.recv_timeout(Duration::from_millis(1)) {
                    Ok(value) => return Ok(value),
                    Err(std::sync::mpsc::RecvTimeoutError::Timeout) => {}
                    Err(error) => return Err(JobError::failed(error)),
                }
            }
        },
    ));
    (id, tell, has_begun)
}

fn quick(jobs: &Jobs<u32>, item: u64, priority: Priority, value: u32) -> JobId {
    jobs.submit(Request::new("quick", topic(item), priority, move |_| {
        Ok(value)
    }))
}

fn ended(jobs: &Jobs<u32>) -> (JobId, Result<u32, JobError>) {
    loop {
        let message = jobs.wait(PATIENCE).expect("a job ends in time");
        if let Report::Ended(result) = message.report {
            return (message.id, result);
        }
    }
}

const CANCELLED: Result<u32, JobError> = Err(JobError::Cancelled(Cancelled));

#[test]
fn a_result_comes_back_and_wakes_its_owner() {
    let woken = Arc::new(AtomicUsize::new(0));
    let counter = Arc::clone(&woken);
    let jobs = Jobs::new(2, move || {
        counter.fetch_add(1, Ordering::SeqCst);
    });
    let id = jobs.submit(Request::new(
        "two",
        topic(1),
        Priority::Preview,
        |context| {
            context.publish(1);
            Ok(2)
        },
    ));
    let reports = [(); 2].map(|()| jobs.wait(PATIENCE).unwrap().report);
    assert_eq!(reports, [Report::Partial(1), Report::Ended(Ok(2))]);
    assert!(jobs.shut_down(PATIENCE) && jobs.is_idle());
    assert_eq!((woken.load(Ordering::SeqCst), id), (2, JobId(1)));
}

#[test]
fn the_urgent_goes_first_and_equals_keep_their_order() {
    let jobs = Jobs::new(1, || {});
    let (first, tell, begun) = held(&jobs, 0, Priority::Preview);
    begun.recv().unwrap();
    let late = quick(&jobs, 1, Priority::Background, 1);
    let early = [2, 3, 4].map(|item| quick(&jobs, item, Priority::Preview, item as u32));
    tell.send(9).unwrap();
    let order = [(); 5].map(|()| ended(&jobs).0);
    assert_eq!(order, [first, early[0], early[1], early[2], late]);
}

#[test]
fn interactive_jobs_wait_for_no_batch() {
    let jobs = Jobs::new(1, || {});
    let (batch, tell, begun) = held(&jobs, 0, Priority::Background);
    begun.recv().unwrap();
    let urgent = quick(&jobs, 1, Priority::Interactive, 5);
    assert_eq!(ended(&jobs), (urgent, Ok(5)));
    tell.send(1).unwrap();
    assert_eq!(ended(&jobs), (batch, Ok(1)));
}

#[test]
fn batches_leave_a_thread_to_previews() {
    let jobs = Jobs::new(2, || {});
    let (_, _tell, begun) = held(&jobs, 0, Priority::Background);
    begun.recv().unwrap();
    let (_, _other, other_begun) = held(&jobs, 1, Priority::Background);
    let preview = quick(&jobs, 2, Priority::Preview, 7);
    assert_eq!(ended(&jobs), (preview, Ok(7)));
    assert!(other_begun.try_recv().is_err());
}

#[test]
fn a_newer_job_of_a_topic_supersedes_the_older_ones() {
    let jobs = Jobs::new(1, || {});
    let (running, tell, begun) = held(&jobs, 1, Priority::Preview);
    begun.recv().unwrap();
    let waiting = quick(&jobs, 1, Priority::Preview, 2);
    assert_eq!(jobs.snapshot()[0].phase, Phase::Stopping);
    let newest = quick(&jobs, 1, Priority::Preview, 3);
    // Even if the old one finishes its work after all, its result is stale.
    let _ = tell.send(1);
    let mut results = [(); 3].map(|()| ended(&jobs));
    results.sort_by_key(|(id, _)| *id);
    assert_eq!(
        results,
        [(running, CANCELLED), (waiting, CANCELLED), (newest, Ok(3))]
    );
}

#[test]
fn results_that_lie_in_the_channel_go_stale_too() {
    let jobs = Jobs::new(1, || {});
    let old = jobs.submit(Request::new(
        "old",
        topic(1),
        Priority::Preview,
        |context| {
            context.publish(1);
            Ok(2)
        },
    ));
    while !jobs.is_idle() {
        thread::yield_now();
    }
    let new = quick(&jobs, 1, Priority::Preview, 3);
    let told: Vec<_> = std::iter::from_fn(|| jobs.wait(Duration::from_millis(500))).collect();
    let reports: Vec<_> = told.into_iter().map(|m| (m.id, m.report)).collect();
    assert_eq!(
        reports,
        [(old, Report::Ended(CANCELLED)), (new, Report::Ended(Ok(3)))]
    );
}

#[test]
fn a_cancelled_job_ends_within_its_next_look() {
    let jobs = Jobs::new(1, || {});
    let (id, _tell, begun) = held(&jobs, 1, Priority::Preview);
    begun.recv().unwrap();
    let waiting = quick(&jobs, 2, Priority::Preview, 2);
    jobs.cancel(waiting);
    assert_eq!(
        jobs.poll().map(|m| m.id),
        Some(waiting),
        "at once, though a job is before it"
    );
    let asked = Instant::now();
    jobs.cancel(id);
    assert_eq!(ended(&jobs), (id, CANCELLED));
    // The job looks every millisecond; the rest is for a machine that does much else.
    assert!(asked.elapsed() < Duration::from_secs(5));
    jobs.cancel(id);
    assert_eq!(jobs.poll(), None, "one that has ended is left alone");
}

#[test]
fn a_panic_harms_only_its_job() {
    let jobs = Jobs::new(1, || {});
    let bad = jobs.submit(Request::new("bad", topic(1), Priority::Preview, |_| {
        panic!("told to")
    }));
    let good = quick(&jobs, 2, Priority::Preview, 4);
    assert_eq!(
        ended(&jobs),
        (bad, Err(JobError::Panicked("told to".to_owned())))
    );
    assert_eq!(ended(&jobs), (good, Ok(4)));
}

#[test]
fn a_paused_job_stands_still_and_gives_its_place_away() {
    let jobs = Jobs::new(1, || {});
    let (id, tell, begun) = held(&jobs, 1, Priority::Background);
    begun.recv().unwrap();
    jobs.set_paused(id, true);
    let other = quick(&jobs, 2, Priority::Background, 2);
    assert_eq!(ended(&jobs), (other, Ok(2)));
    tell.send(1).unwrap();
    assert_eq!(jobs.wait(Duration::from_millis(50)), None);
    assert_eq!(jobs.snapshot()[0].phase, Phase::Paused);
    jobs.set_paused(id, false);
    assert_eq!(ended(&jobs), (id, Ok(1)));
}

#[test]
fn pausing_all_holds_jobs_to_come_but_not_the_users_hand() {
    let jobs = Jobs::new(2, || {});
    jobs.set_all_paused(true);
    let batch = quick(&jobs, 1, Priority::Background, 1);
    let hand = quick(&jobs, 2, Priority::Interactive, 2);
    assert_eq!(ended(&jobs), (hand, Ok(2)));
    assert_eq!(jobs.wait(Duration::from_millis(30)), None);
    jobs.set_all_paused(false);
    assert_eq!(ended(&jobs), (batch, Ok(1)));
}

#[test]
fn a_paused_job_can_be_cancelled() {
    let jobs = Jobs::new(1, || {});
    let (id, _tell, begun) = held(&jobs, 1, Priority::Background);
    begun.recv().unwrap();
    jobs.set_paused(id, true);
    jobs.cancel(id);
    assert_eq!(ended(&jobs), (id, CANCELLED));
}

#[test]
fn progress_is_seen_and_pauses_the_work() {
    let jobs = Jobs::new(1, || {});
    let (go, gone) = channel::<()>();
    let id = jobs.submit(Request::new(
        "steps",
        topic(1),
        Priority::Preview,
        move |context| {
            let stage = context.progress().stage("warp", 4);
            stage.advance();
            context.progress().warn("odd picture");
            gone.recv().unwrap();
            stage.advance();
            context.cancel().check()?;
            Ok(1)
        },
    ));
    let view = loop {
        let view = jobs.snapshot().remove(0);
        if !view.warnings.is_empty() {
            break view;
        }
        thread::yield_now();
    };
    assert_eq!((view.stage, view.fraction()), (Some("warp"), Some(0.25)));
    jobs.set_paused(id, true);
    go.send(()).unwrap();
    assert_eq!(jobs.wait(Duration::from_millis(50)), None);
    jobs.cancel(id);
    assert_eq!(ended(&jobs), (id, CANCELLED));
}

#[test]
fn shutting_down_stops_all_and_says_when_it_could_not() {
    let jobs = Jobs::new(2, || {});
    let (tell, told) = channel::<()>();
    let (begun, has_begun) = channel::<()>();
    jobs.submit(Request::new(
        "deaf",
        topic(1),
        Priority::Preview,
        move |_| {
            begun.send(()).unwrap();
            let _ = told.recv();
            Ok(1)
        },
    ));
    let waiting = held(&jobs, 2, Priority::Background);
    has_begun.recv().unwrap();
    assert!(!jobs.shut_down(Duration::from_millis(30)));
    tell.send(()).unwrap();
    assert!(jobs.shut_down(PATIENCE));
    assert!(jobs.is_idle());
    let late = quick(&jobs, 3, Priority::Interactive, 3);
    let results: Vec<_> = (0..3).map(|_| ended(&jobs)).collect();
    assert!(
        results.iter().all(|(_, result)| *result == CANCELLED),
        "{results:?}"
    );
    assert!(
        results
            .iter()
            .any(|(id, _)| *id == waiting.0 || *id == late)
    );
}

#[test]
fn dropping_the_queue_stops_its_jobs_and_drops_what_they_hold() {
    let jobs = Jobs::new(1, || {});
    let (_, _tell, begun) = held(&jobs, 1, Priority::Preview);
    begun.recv().unwrap();
    let shared = Arc::downgrade(&jobs.shared);
    drop(jobs);
    let until = Instant::now() + PATIENCE;
    while shared.strong_count() > 0 {
        assert!(Instant::now() < until, "the thread ends by itself");
        thread::yield_now();
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    /// Any interleaving of submissions, cancellations, pauses and polls: every job ends once, the
    /// newest of a topic that nobody cancelled gives its result, and of a topic nothing older is seen
    /// after something newer.
    #[test]
    fn every_job_ends_once_and_nothing_stale_is_seen(
        steps in prop::collection::vec((0u8..8, 0u64..3, 0u8..3), 1..20),
        threads in 1usize..4,
    ) {
        let jobs = Jobs::new(threads, || {});
        let mut submitted = Vec::new();
        let mut cancelled = Vec::new();
        let mut messages = Vec::new();
        for (step, item, priority) in steps {
            match step {
                0..=4 => {
                    let priority = [Priority::Interactive, Priority::Preview, Priority::Background]
                        [usize::from(priority)];
                    let id = jobs.submit(Request::new("p", topic(item), priority, |context| {
                        context.publish(context.id().0 as u32);
                        context.check()?;
                        Ok(context.id().0 as u32)
                    }));
                    submitted.push((id, item));
                }
                5 => if let Some(&(id, _)) = submitted.get(item as usize) {
                    jobs.cancel(id);
                    cancelled.push(id);
                },
                6 => jobs.set_all_paused(priority == 0),
                _ => messages.extend(jobs.poll().map(|m| (m, submitted.len()))),
            }
        }
        jobs.set_all_paused(false);
        let is_end = |(m, _): &&(Message<u32>, usize)| matches!(m.report, Report::Ended(_));
        while messages.iter().filter(is_end).count() < submitted.len() {
            messages.push((jobs.wait(PATIENCE).expect("all jobs end"), submitted.len()));
        }
        let mut ends: Vec<_> = messages.iter().filter(is_end).map(|(m, _)| m.id).collect();
        ends.sort_unstable();
        prop_assert_eq!(ends, submitted.iter().map(|(id, _)| *id).collect::<Vec<_>>());
        for (message, known) in &messages {
            let has_value = !matches!(message.report, Report::Ended(Err(_)));
            let newer = submitted[..*known].iter().any(|&(id, item)| {
                item == message.topic.item && id > message.id
            });
            prop_assert!(!(has_value && newer), "stale: {message:?}");
        }
        for item in 0..3 {
            let newest = submitted.iter().rev().find(|(_, own)| *own == item);
            if let Some(&(id, _)) = newest && !cancelled.contains(&id) {
                let value = Report::Ended(Ok(id.0 as u32));
                prop_assert!(messages.iter().any(|(m, _)| m.id == id && m.report == value));
            }
        }
    }
}
