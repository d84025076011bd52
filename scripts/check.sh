#!/usr/bin/env bash
# Everything that must hold before a change goes in; CI runs this and nothing else.
set -euo pipefail
cd "$(dirname "$0")/.."

step() {
    printf '\n== %s\n' "$*"
    "$@"
}

scripts/consumers.sh --fetch >/dev/null 2>&1 &
step cargo fmt --all --check
step cargo clippy --locked --all-targets -- -D warnings
# Tests of the library, the binary and the folders tests/ and examples/, then those in the comments.
step cargo test --locked
# Exports, read by programs that are not ours where those can be had.
step scripts/consumers.sh
if cargo deny --version >/dev/null 2>&1; then
    step cargo deny --locked check
else
    printf '\n== cargo deny is not installed: licences and advisories were not checked\n'
fi
