//! Networks made ready to run, shared by all threads of the process.
//!
//! A session runs one picture at a time, on the thread that asks: with both runtimes the sums are then
//! the same however many threads there are. Several threads get several sessions, made when they are
//! needed, a few at most; who comes later waits.

use super::super::SegmentError;
use super::card::Card;
use super::runtime::Runtime;
use crate::base::{one_line, without_panics};
use ort::session::Session;
use ort::session::builder::GraphOptimizationLevel;
use ort::value::TensorRef;
use std::borrow::Cow;
use std::sync::{Condvar, Mutex, PoisonError};

/// Most sessions of one model. Each holds the weights again, and more than this many pictures at once
/// wait for the memory, not for the processor.
const MOST_SESSIONS: usize = 8;

/// A model's sessions.
pub(super) struct Sessions {
    model: Cow<'static, [u8]>,
    pool: Mutex<Pool>,
    returned: Condvar,
}

#[derive(Default)]
struct Pool {
    idle: Vec<Session>,
    /// Sessions that exist, at work or not, or are being made.
    made: usize,
    /// Whether one of them is being made for whoever comes next.
    is_coming: bool,
}

impl Sessions {
    pub(super) fn new(model: Cow<'static, [u8]>) -> Self {
        Self {
            model,
            pool: Mutex::default(),
            returned: Condvar::new(),
        }
    }

    /// The model's file.
    pub(super) fn model(&self) -> &[u8] {
        &self.model
    }

    /// What the network answers to `tensor`: one plane of numbers for each class, in the card's order.
    ///
    /// # Errors
    /// [`SegmentError::Model`] with the runtime's reason, or when the answer has another shape than
    /// the card says.
    pub(super) fn run(&self, card: &Card, tensor: &[f32]) -> Result<Vec<f32>, SegmentError> {
        let mut session = self.session(card)?;
        let answer = without_panics(|| answer(&mut session, card, tensor))
            .map_err(|panicked| panicked.message);
        let mut pool = self.pool();
        match &answer {
            Ok(_) => pool.idle.push(session),
            // What panicked may be broken.
            Err(_) => pool.made -= 1,
        }
        drop(pool);
        self.returned.notify_one();
        answer.and_then(|answer| answer).map_err(model_error)
    }

    fn pool(&self) -> std::sync::MutexGuard<'_, Pool> {
        self.pool.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Makes a first session if there is none yet. What goes wrong is told to who wants to run it.
    pub(super) fn prepare(&self, card: &Card) {
        let mut pool = self.pool();
        if pool.made > 0 {
            return;
        }
        (pool.made, pool.is_coming) = (1, true);
        drop(pool);
        let made = self.fresh(card);
        let mut pool = self.pool();
        pool.is_coming = false;
        match made {
            Ok(session) => pool.idle.push(session),
            Err(_) => pool.made -= 1,
        }
        drop(pool);
        self.returned.notify_all();
    }

    /// A session for the caller alone.
    fn session(&self, card: &Card) -> Result<Session, SegmentError> {
        let mut pool = self.pool();
        while pool.idle.is_empty() && (pool.made == MOST_SESSIONS || pool.is_coming) {
            pool = self
                .returned
                .wait(pool)
                .unwrap_or_else(PoisonError::into_inner);
        }
        if let Some(session) = pool.idle.pop() {
            return Ok(session);
        }
        pool.made += 1;
        drop(pool);
        let made = self.fresh(card);
        if made.is_err() {
            self.pool().made -= 1;
            self.returned.notify_one();
        }
        made
    }

    /// A session of its own, checked.
    fn fresh(&self, card: &Card) -> Result<Session, SegmentError> {
        Runtime::of_process().and_then(|runtime| {
            without_panics(|| session_of(runtime, &self.model))
                .map_err(|panicked| panicked.message)
                .and_then(|made| made.map_err(|error| error.to_string()))
                .and_then(|session| checked(session, card))
                .map_err(model_error)
        })
    }
}

fn model_error(reason: String) -> SegmentError {
    SegmentError::Model(one_line(&reason))
}

fn session_of(runtime: &Runtime, model: &[u8]) -> ort::Result<Session> {
    let mut builder = Session::builder(&runtime.environment)?
        .with_optimization_level(GraphOptimizationLevel::Level3)?;
    if runtime.is_native() {
        builder = builder.with_intra_threads(1)?;
    }
    builder.commit_from_memory(model)
}

/// The session if it takes and gives what the card says.
fn checked(session: Session, card: &Card) -> Result<Session, String> {
    let (height, width) = card.size();
    let expected = |planes: usize| [1, planes as i64, height as i64, width as i64];
    let (input, output) = (&card.input.name, &card.output.name);
    let [own] = session.inputs() else {
        return Err(format!("it has {} inputs, not one", session.inputs().len()));
    };
    if own.name() != input {
        return Err(format!("it has no input {input:?} but {:?}", own.name()));
    }
    fits("input", own.dtype(), expected(card.channels()))?;
    let Some(own) = session.outputs().iter().find(|own| own.name() == output) else {
        return Err(format!("it has no output {output:?}"));
    };
    fits("output", own.dtype(), expected(3))?;
    Ok(session)
}

/// Whether a tensor of the declared type may have the shape `expected`.
fn fits(what: &str, declared: &ort::value::ValueType, expected: [i64; 4]) -> Result<(), String> {
    let ort::value::ValueType::Tensor { ty, shape, .. } = declared else {
        return Err(format!("its {what} is no tensor"));
    };
    if *ty != ort::value::TensorElementType::Float32 {
        return Err(format!("its {what} holds {ty}, not 32-bit floating point"));
    }
    let open = |own: i64, expected: i64| own < 0 || own == expected;
    let agrees = shape.len() == 4 && shape.iter().zip(expected).all(|(&own, e)| open(own, e));
    if agrees {
        Ok(())
    } else {
        let (found, expected) = (dimensions(shape), dimensions(&expected));
        Err(format!("its {what} is {found}, not {expected}"))
    }
}

fn dimensions(shape: &[i64]) -> String {
    let one = |&side: &i64| {
        if side < 0 {
            "any".to_owned()
        } else {
            side.to_string()
        }
    };
    let sides: Vec<String> = shape.iter().map(one).collect();
    format!("[{}]", sides.join(", "))
}

fn answer(session: &mut Session, card: &Card, tensor: &[f32]) -> Result<Vec<f32>, String> {
    let told = |error: ort::Error| error.to_string();
    let (height, width) = card.size();
    let shape = [1, card.channels(), height, width];
    let input = TensorRef::from_array_view((shape, tensor)).map_err(told)?;
    let outputs = session
        .run(ort::inputs![card.input.name.as_str() => input])
        .map_err(told)?;
    let Some(output) = outputs.get(card.output.name.as_str()) else {
        return Err(format!("it gives no output {:?}", card.output.name));
    };
    let (shape, values) = output.try_extract_tensor::<f32>().map_err(told)?;
    let expected = [1, 3, height as i64, width as i64];
    if shape.len() != 4 || shape.iter().zip(expected).any(|(&own, e)| own != e) {
        let (found, expected) = (dimensions(shape), dimensions(&expected));
        return Err(format!("its output is {found}, not {expected}"));
    }
    Ok(values.to_vec())
}
