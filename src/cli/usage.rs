//! What `clap` has to say, made one line where it is an error.

use super::failure::Failure;
use super::reporter::print_failure;
use clap::error::ErrorKind;
use std::process::ExitCode;

/// Prints help or version and gives 0, or the usage error on one line and gives 2.
pub(super) fn answered(error: &clap::Error) -> ExitCode {
    match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => {
            // A closed pipe (`--help | head`) is no failure.
            let _ = error.print();
            ExitCode::SUCCESS
        }
        _ => {
            let failure = Failure::BadInput(summary(&error.render().to_string()));
            print_failure(&failure);
            failure.exit_code()
        }
    }
}

/// The message of a usage error without its leading word, its usage line and its line breaks.
fn summary(rendered: &str) -> String {
    let lines = rendered
        .lines()
        .map(str::trim)
        .take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more"))
        .filter(|line| !line.is_empty());
    let line = lines.collect::<Vec<_>>().join(" ").replace(" tip: ", "; ");
    let message = line.strip_prefix("error: ").unwrap_or(&line);
    format!("{message} (see `boscage --help`)")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_usage_error_keeps_its_message_and_its_tip() {
        let rendered = "error: unexpected argument '--ou' found\n\n  tip: a similar argument \
                        exists: '--out'\n\nUsage: boscage segment\n\nFor more information, try";
        assert_eq!(
            summary(rendered),
            "unexpected argument '--ou' found; a similar argument exists: '--out' \
             (see `boscage --help`)"
        );
    }
}
