//! What is kept between sessions, in the file and the form that eframe keeps it in: both windows share
//! preferences, layouts and the size of the window.

use crate::base::{read_limited, write_atomic};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// A file of preferences is not larger.
const LIMIT_BYTES: u64 = 64 << 20;

/// A file of RON that names strings.
pub(super) struct Storage {
    path: PathBuf,
    kept: BTreeMap<String, String>,
    is_changed: bool,
}

impl Storage {
    /// What the file holds; nothing if it cannot be read.
    pub(super) fn at(path: PathBuf) -> Self {
        let bytes = read_limited(&path, LIMIT_BYTES).unwrap_or_default();
        let kept = ron::de::from_bytes(&bytes).unwrap_or_default();
        Self {
            path,
            kept,
            is_changed: false,
        }
    }
}

impl eframe::Storage for Storage {
    fn get_string(&self, key: &str) -> Option<String> {
        self.kept.get(key).cloned()
    }

    fn set_string(&mut self, key: &str, value: String) {
        let before = self.kept.insert(key.to_owned(), value);
        self.is_changed |= before.as_ref() != self.kept.get(key);
    }

    fn remove_string(&mut self, key: &str) {
        self.is_changed |= self.kept.remove(key).is_some();
    }

    /// Writes the file. What cannot be written is lost with the session, as preferences may be.
    fn flush(&mut self) {
        if !std::mem::take(&mut self.is_changed) {
            return;
        }
        if let Ok(text) = ron::ser::to_string_pretty(&self.kept, ron::ser::PrettyConfig::default())
        {
            let _ = write_atomic(&self.path, text.as_bytes());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::Storage as _;

    #[test]
    fn what_is_kept_is_there_again_in_the_form_of_eframe() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new/studio.ron");
        let mut storage = Storage::at(path.clone());
        assert_eq!(storage.get_string("a"), None);
        eframe::set_value(&mut storage, "a", &vec![1, 2]);
        storage.set_string("b", "two \"words\"\n".to_owned());
        storage.flush();
        let mut again = Storage::at(path.clone());
        assert_eq!(eframe::get_value(&again, "a"), Some(vec![1, 2]));
        assert_eq!(again.get_string("b").as_deref(), Some("two \"words\"\n"));
        again.remove_string("a");
        again.flush();
        // As eframe reads it.
        let text = std::fs::read_to_string(path).unwrap();
        let map: std::collections::HashMap<String, String> = ron::from_str(&text).unwrap();
        assert_eq!(map.len(), 1);
    }
}
