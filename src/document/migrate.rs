//! Older versions of the small part of a project, brought up to date.
//!
//! The content is JSON, so that a migration works on names and values and not on today's types. For
//! each version there is one function to the next; a file goes through all of them that it needs.
//! Fields that merely came with a default need none.

use super::format::{FormatError, VERSION};
use serde_json::Value;

/// From the version before to the next.
type Migration = fn(Value) -> Result<Value, FormatError>;

/// Entry n leads from version n + 1 to n + 2; there is only version 1 yet.
const MIGRATIONS: [Migration; VERSION as usize - 1] = [];

/// `content` of a file of `version`, as today's version has it.
pub(super) fn migrated(content: Value, version: u32) -> Result<Value, FormatError> {
    through(&MIGRATIONS, content, version)
}

fn through(migrations: &[Migration], content: Value, version: u32) -> Result<Value, FormatError> {
    let done = version.saturating_sub(1) as usize;
    let mut needed = migrations.iter().skip(done);
    needed.try_fold(content, |content, migration| migration(content))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_file_goes_through_the_migrations_it_needs() {
        let rename: Migration = |mut value| {
            value["k"] = value["tangent"].take();
            Ok(value)
        };
        let double: Migration = |mut value| {
            let k = value["k"].as_f64().ok_or(FormatError::damaged("k"))?;
            value["k"] = json!(2.0 * k);
            Ok(value)
        };
        let steps = [rename, double];
        let from = |version, value| through(&steps, value, version);
        assert_eq!(from(1, json!({"tangent": 3.0})).unwrap()["k"], 6.0);
        assert_eq!(from(2, json!({"k": 3.0})).unwrap()["k"], 6.0);
        assert_eq!(from(3, json!({"k": 3.0})).unwrap()["k"], 3.0);
        assert!(from(2, json!({})).is_err());
    }
}
