//! What runs networks: ONNX Runtime where the user has one, otherwise tract, which is built in.
//!
//! Both stand behind the `ort` crate, which knows one of them in a process: the first call decides and
//! the choice holds. A library that is missing, foreign or too old (before 1.24) is passed over for
//! tract, with a note that says so.

use super::super::SegmentError;
use crate::base::{one_line, without_panics};
use ort::environment::Environment;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// A runtime of networks.
#[derive(Debug)]
pub struct Runtime {
    pub(super) environment: Environment,
    /// Its name and version.
    name: String,
    is_native: bool,
    /// Why it is not the one that was asked for.
    note: Option<String>,
}

/// The library that was asked for.
static NATIVE: OnceLock<Option<PathBuf>> = OnceLock::new();

static RUNTIME: OnceLock<Result<Runtime, SegmentError>> = OnceLock::new();

/// The name of the one built in.
const BUILT_IN: &str = "tract 0.23";

impl Runtime {
    /// Says which native library the process is to use, before anything else here is called; whether
    /// that is heard, because nobody said before.
    pub fn choose(native: Option<&Path>) -> bool {
        let native = native.filter(|path| !path.as_os_str().is_empty());
        NATIVE.set(native.map(Path::to_owned)).is_ok()
    }

    /// The native library that the process was asked to use.
    pub fn asked_for() -> Option<&'static Path> {
        NATIVE.get()?.as_deref()
    }

    /// The runtime of this process if it was started.
    pub fn started() -> Option<&'static Self> {
        RUNTIME.get()?.as_ref().ok()
    }

    /// The runtime of this process, started by the first call.
    ///
    /// # Errors
    /// [`SegmentError::Model`] when none starts.
    pub fn of_process() -> Result<&'static Self, SegmentError> {
        let native = NATIVE.get_or_init(|| None);
        let runtime = RUNTIME.get_or_init(|| match native {
            Some(path) => Self::native(path).or_else(|reason| {
                let path = path.display().to_string();
                let note = format!(
                    "{}: not used to run models: {reason}; {BUILT_IN} runs them",
                    one_line(&path)
                );
                Self::built_in(Some(note))
            }),
            None => Self::built_in(None),
        });
        runtime.as_ref().map_err(Clone::clone)
    }

    /// Its name and version.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether it is the user's, not the one built in.
    pub fn is_native(&self) -> bool {
        self.is_native
    }

    /// Why it is not the native one that was asked for.
    pub fn note(&self) -> Option<&str> {
        self.note.as_deref()
    }

    fn native(library: &Path) -> Result<Self, String> {
        let started = without_panics(|| {
            let builder = ort::init_from(library).map_err(|error| error.to_string())?;
            builder
                .with_telemetry(false)
                .with_name("boscage")
                .build()
                .map_err(|error| error.to_string())
        });
        let environment = started
            .map_err(|panicked| panicked.message)
            .and_then(|started| started)
            .map_err(|reason| one_line(&reason))?;
        Ok(Self {
            environment,
            name: native_name(),
            is_native: true,
            note: None,
        })
    }

    fn built_in(note: Option<String>) -> Result<Self, SegmentError> {
        ort::set_api(ort_tract::api());
        let started = without_panics(|| ort::init().with_telemetry(false).build());
        let failed = |reason: String| SegmentError::Model(one_line(&reason));
        let environment = started
            .map_err(|panicked| failed(panicked.message))?
            .map_err(|error| failed(error.to_string()))?;
        Ok(Self {
            environment,
            name: BUILT_IN.to_owned(),
            is_native: false,
            note,
        })
    }
}

/// The native runtime's name, with the commit that it was built from.
fn native_name() -> String {
    let info = ort::info();
    let commit = info
        .split([',', ' '])
        .find_map(|part| part.strip_prefix("git-commit-id="));
    match commit {
        Some(commit) => format!("ONNX Runtime {}", one_line(commit)),
        None => "ONNX Runtime".to_owned(),
    }
}
