//! The `boscage` program: parses the command line and runs the command.

fn main() -> std::process::ExitCode {
    std::process::ExitCode::SUCCESS
}
