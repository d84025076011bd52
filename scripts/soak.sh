#!/usr/bin/env bash
# Tries to break Boscage for as long as you like, and writes what came of it to docs/reliability.md.
#
#   scripts/soak.sh [--minutes N] [--corpus DIR] [--program FILE] [PART…]
#
# Parts: files saves cancel farm slurm levels limits device gestures fuzz; without any, all but slurm
# (which needs a running Slurm), levels (a release build) and fuzz (a nightly compiler). Each part's
# lines replace those of its last run in the table; lines of parts that were not run stay.
set -uo pipefail
cd "$(dirname "$0")/.."

minutes=10 corpus='' program=target/debug/boscage parts=()
while (($#)); do
    case $1 in
    --minutes) minutes=$2 && shift ;;
    --corpus) corpus=$2 && shift ;;
    --program) program=$2 && shift ;;
    *) parts+=("$1") ;;
    esac
    shift
done
((${#parts[@]})) || parts=(files saves cancel farm limits device gestures)

tests() { cargo test --locked --quiet "$@" -- --nocapture 2>&1; }
passed() { # passed WHAT COMMAND…: a line that says how it ended
    if "${@:2}" >/tmp/soak.$$ 2>&1; then
        echo "$1: held"
    else
        echo "$1: FAILED: $(grep -m 1 panicked /tmp/soak.$$)"
    fi
}

run_files() { scripts/reliability/bad_files.py "$program" ${corpus:+--corpus "$corpus"} | grep -v ^FAIL; }
run_saves() { BOSCAGE_KILLS=1000 tests --test killed_saves | grep kills; }
run_cancel() { scripts/reliability/cancel.py "$program" --times 20 | grep ^cancel; }
run_farm() { scripts/reliability/farm.py "$program" --kills 100 --count 100; }
run_slurm() { scripts/reliability/farm.py "$program" --kills 30 --slurm; }
run_levels() { scripts/levels.sh target/release/boscage; }
run_limits() { passed 'no memory, no threads, a full disk' tests --test limits; }
run_device() { passed 'graphics card lost while drawing' tests --test render_gpu lost; }
run_gestures() {
    BOSCAGE_SOAK_SECONDS=$((60 * minutes)) cargo test --locked --quiet --test studio_soak -- \
        --ignored --nocapture 2>&1 | grep -e '^soak' -e panicked
}
run_fuzz() { scripts/fuzz.sh $((60 * minutes)) ${corpus:+"$corpus"}; }

report=docs/reliability.md
for part in "${parts[@]}"; do
    echo "== $part" >&2
    lines=$("run_$part")
    printf '%s\n' "$lines" >&2
    rows=$(printf '%s\n' "$lines" | grep . | sed -E 's/\|/\\|/g; s/^([^:]*): (.*)$/| \1 | \2 |/')
    build=$([[ $program == *release* ]] && echo release || echo debug)
    # The rows between this part's marks are replaced.
    awk -v part="$part" -v rows="$rows" -v when="$(date -u +%Y-%m-%d), $build build, $(git rev-parse --short HEAD)" '
        $0 == "<!-- " part " -->" { print; print ""; print "| What (" when ") | What came of it |"; print "|---|---|"; print rows; print ""; skipped = 1; next }
        /^<!-- end -->$/ { skipped = 0 }
        !skipped { print }
    ' "$report" >"$report.new" && mv "$report.new" "$report"
done
rm -f /tmp/soak.$$
