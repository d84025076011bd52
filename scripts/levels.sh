#!/usr/bin/env bash
# Compares a release build with the table of golden results (tests/commands/determinism.rs), as this processor
# runs it and as older and newer ones would: `qemu-x86_64` of Debian's qemu-user shows the program
# another processor, so that whatever chooses code by it, here or in a library, chooses as there.
#
#   scripts/levels.sh [PROGRAM]
set -euo pipefail
cd "$(dirname "$0")/.."
program=$(realpath "${1:-target/release/boscage}")

compare() { # compare NAME PROGRAM [TESTS]
    if BOSCAGE_PROGRAM=$2 cargo test --locked --quiet --test commands "determinism::${3:-}" -- --test-threads 1 >/tmp/levels.$$ 2>&1; then
        printf 'level %s: as the table says\n' "$1"
    else
        printf 'level %s: DIFFERS or fails\n' "$1"
        grep -m 5 -e panicked -e '^[<>+-]' /tmp/levels.$$ || true
        failed=1
    fi
}

failed=0
compare 'this processor' "$program"
if command -v qemu-x86_64 >/dev/null; then
    # x86-64-v2 without AVX, and v3 with AVX2 and FMA. (QEMU has no AVX-512.) What does not depend on the
    # processor is not run again: under the emulator all takes a hundred times as long.
    widest=results_are_those_of_the_table_on_three_threads_with_the_widest
    compare 'Nehalem (emulated)' "qemu-x86_64 -cpu Nehalem $program" "$widest"
    compare 'Haswell (emulated)' "qemu-x86_64 -cpu Haswell $program" "$widest"
else
    echo 'level: qemu-x86_64 is not installed, other processors were not tried'
fi
rm -f /tmp/levels.$$
exit "$failed"
