//! Segmentation models that users bring.
//!
//! A malformed model makes a runtime panic across a border that panics may not cross, eat all memory,
//! or never end. So a file from outside first runs in a process of its own, this same program with a
//! command that no help lists, behind limits of time and memory; only what comes through is run here.
//! Models with loops or branches are refused before ([`crate::segment::ModelError`]), so that what one
//! trial does, every picture will.

use super::failure::Failure;
use crate::base::{Cancel, read_limited};
use crate::segment::{Learned, ModelError, Runtime};
use std::borrow::Cow;
use std::io::{Read as _, Write as _};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// Name of the command that [`crate::cli`] answers with [`try_out`].
pub(crate) const TRIAL: &str = "try-model";

/// Largest model that is read: some hundred times ours.
const LARGEST_BYTES: u64 = 512 << 20;

/// Largest description.
const LARGEST_CARD: u64 = 1 << 20;

/// Processor time of a trial: ours needs less than a second for its three pictures.
const MOST_SECONDS: u64 = 20;

/// A trial's time by the clock, where the processor is shared with many others.
const MOST_WAITING: Duration = Duration::from_secs(120);

/// Memory of a trial.
const MOST_BYTES: u64 = 4 << 30;

/// The model in the file `path`, described by the file of its name ending in `.json` or by itself,
/// and tried out elsewhere, by `program` if that is not the one that runs.
///
/// # Errors
/// [`Failure::BadInput`] naming the file, with the reason; [`Failure::Cancelled`].
pub(crate) fn learned_from(
    path: &Path,
    program: Option<&Path>,
    cancel: &Cancel,
) -> Result<Learned, Failure> {
    let model = read_limited(path, LARGEST_BYTES)?;
    let beside = path.with_extension("json");
    let sidecar = match beside.is_file() {
        true => Some(read_limited(&beside, LARGEST_CARD)?),
        false => None,
    };
    let learned = Learned::new(Cow::Owned(model), sidecar.as_deref()).map_err(|error| {
        let is_beside = sidecar.is_some() && matches!(error, ModelError::Card(_));
        let file = if is_beside { beside.as_path() } else { path };
        Failure::of(file.display(), error)
    })?;
    match tried_out(&learned, program, cancel)? {
        None => Ok(learned),
        Some(reason) => Err(Failure::of(path.display(), reason)),
    }
}

/// Why `learned` may not run here, if so.
fn tried_out(
    learned: &Learned,
    program: Option<&Path>,
    cancel: &Cancel,
) -> Result<Option<String>, Failure> {
    let failed = |error: std::io::Error| {
        Failure::Environment(format!("a model cannot be tried out: {error}"))
    };
    let card = String::from_utf8_lossy(&learned.card().to_json()).into_owned();
    let mut command = match program {
        Some(program) => Command::new(program),
        None => Command::new(std::env::current_exe().map_err(failed)?),
    };
    command.args([TRIAL, "--card", &card]);
    if let Some(library) = Runtime::asked_for() {
        command.arg("--onnx-runtime").arg(library);
    } else {
        command.env_remove("ORT_DYLIB_PATH");
    }
    command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null());
    let mut child = command.spawn().map_err(failed)?;
    let input = child.stdin.take();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            // A child that ended early reads no more: that is told by how it ended.
            input.map(|mut input| input.write_all(learned.model()))
        });
        let ended = waited_for(&mut child, cancel);
        if !matches!(ended, Ok(Some(_))) {
            // It may have ended meanwhile.
            let _ = child.kill();
            let _ = child.wait();
        }
        match ended {
            Ok(Some(status)) => Ok(verdict(&mut child, status)),
            Ok(None) => Ok(Some(too_long())),
            Err(failure) => Err(failure),
        }
    })
}

/// How `child` ended; `None` when it did not in time.
fn waited_for(child: &mut Child, cancel: &Cancel) -> Result<Option<ExitStatus>, Failure> {
    /// Between two looks.
    const PAUSE: Duration = Duration::from_millis(5);
    let begin = Instant::now();
    while begin.elapsed() < MOST_WAITING {
        cancel.check()?;
        let ended = child.try_wait();
        if let Some(status) = ended.map_err(|error| Failure::Environment(error.to_string()))? {
            return Ok(Some(status));
        }
        std::thread::sleep(PAUSE);
    }
    Ok(None)
}

/// What the end of a trial means; `None`: nothing is wrong.
fn verdict(child: &mut Child, status: ExitStatus) -> Option<String> {
    /// One line of a runtime.
    const LONGEST_REASON: u64 = 4096;
    if status.success() {
        return None;
    }
    let mut reason = String::new();
    let output = child.stdout.take()?;
    let is_text = output.take(LONGEST_REASON).read_to_string(&mut reason);
    match reason.trim() {
        told if is_text.is_ok() && !told.is_empty() => Some(told.to_owned()),
        _ if ran_out_of_time(status) => Some(too_long()),
        _ => {
            let gigabytes = MOST_BYTES >> 30;
            Some(format!(
                "it makes the runtime crash or needs more than {gigabytes} GB of memory"
            ))
        }
    }
}

fn too_long() -> String {
    format!("it needs more than {MOST_SECONDS} s for three pictures")
}

#[cfg(unix)]
fn ran_out_of_time(status: ExitStatus) -> bool {
    use std::os::unix::process::ExitStatusExt as _;
    /// Numbers of SIGXCPU and of SIGKILL, which is sent a second after it.
    const OUT_OF_TIME: [i32; 2] = [24, 9];
    status
        .signal()
        .is_some_and(|signal| OUT_OF_TIME.contains(&signal))
}

#[cfg(not(unix))]
fn ran_out_of_time(_: ExitStatus) -> bool {
    false
}

/// The other side: limits this process, reads a model from the standard input and runs it as `card`
/// says; why it may not run, if so.
///
/// # Errors
/// [`Failure::Environment`] when the limits cannot be set or nothing can be read.
pub(crate) fn try_out(card: &str) -> Result<Option<String>, Failure> {
    limit_process()
        .map_err(|error| Failure::Environment(format!("limits cannot be set: {error}")))?;
    let mut model = Vec::new();
    let input = std::io::stdin().lock();
    input
        .take(LARGEST_BYTES + 1)
        .read_to_end(&mut model)
        .map_err(|error| Failure::Environment(error.to_string()))?;
    let tried = Learned::new(Cow::Owned(model), Some(card.as_bytes()))
        .and_then(|learned| learned.try_out().map_err(ModelError::Run));
    Ok(tried.err().map(|error| error.to_string()))
}

#[cfg(unix)]
fn limit_process() -> std::io::Result<()> {
    use rlimit::Resource;
    let at_most = |resource: Resource, most: u64| {
        let (_, hard) = resource.get()?;
        resource.set(most.min(hard), most.saturating_add(1).min(hard))
    };
    at_most(Resource::CORE, 0)?;
    at_most(Resource::CPU, MOST_SECONDS)?;
    at_most(Resource::AS, MOST_BYTES)
}

#[cfg(not(unix))]
fn limit_process() -> std::io::Result<()> {
    Ok(())
}
