#!/usr/bin/env bash
# Tries to break Boscage for as long as you like, and writes what came of it to docs/reliability.md.
#
#   scripts/soak.sh [--quick] [--corpus DIR] [--program FILE] [PART…]
#
# Parts: supply files projects saves cancel farm slurm limits device library gestures levels fuzz; without
# any, all but slurm (which needs a running Slurm) and levels (a release build and QEMU). A whole run takes
# a night; --quick takes an hour or two and says so in its rows by their numbers. Each part's lines replace
# those of its last run; those of parts that were not run stay.
set -uo pipefail
cd "$(dirname "$0")/.."

quick='' corpus='' program=target/debug/boscage parts=()
while (($#)); do
    case $1 in
    --quick) quick=1 ;;
    --corpus) corpus=$2 && shift ;;
    --program) program=$2 && shift ;;
    *) parts+=("$1") ;;
    esac
    shift
done
((${#parts[@]})) || parts=(supply files projects saves cancel farm limits device library gestures fuzz)

# usually QUICK WHOLE: the number for this run
usually() { if [[ $quick ]]; then echo "$1"; else echo "$2"; fi; }
tests() { cargo test --locked --quiet "$@" -- --nocapture 2>&1; }
# told PATTERN: the lines that tell, and those of what failed
told() { grep -E "$1|panicked at" | sed -E 's/^thread .* panicked at ([^:]*):.*/FAILED: see \1/'; }
passed() { # passed WHAT COMMAND…: a line that says how it ended
    if "${@:2}" >/tmp/soak.$$ 2>&1; then
        echo "$1: held"
    else
        echo "$1: FAILED: $(grep -m 1 panicked /tmp/soak.$$)"
    fi
}

run_supply() {
    passed 'licences, sources and banned crates (cargo deny)' cargo deny --locked --offline check licenses bans sources
    passed 'no unsafe code but where it is listed, no network (tests/house/supply.rs)' tests --test house supply::
}
run_files() {
    scripts/reliability/bad_files.py "$program" --every "$(usually 10 1)" ${corpus:+--corpus "$corpus"} | grep -v ^FAIL
}
run_projects() { tests --test commands damaged | told '^damaged'; }
run_saves() { BOSCAGE_KILLS=$(usually 100 1000) tests --test killed_saves | told kills; }
run_cancel() { scripts/reliability/cancel.py "$program" --busy --times "$(usually 5 20)" | grep ^cancel; }
run_farm() { scripts/reliability/farm.py "$program" --kills "$(usually 20 100)" --count "$(usually 32 100)"; }
run_slurm() { scripts/reliability/farm.py "$program" --kills "$(usually 20 100)" --count "$(usually 32 100)" --slurm; }
run_levels() { scripts/levels.sh target/release/boscage; }
run_limits() { passed 'no memory, no threads, a full disk' tests --test commands limits::; }
run_device() {
    passed 'graphics card lost while a picture is drawn' tests --test render_gpu lost
    BOSCAGE_LOSSES=$(usually 6 50) tests --test studio card:: | told '^graphics card lost in'
}
run_library() {
    BOSCAGE_LIBRARY=$(usually 2000 10000) BOSCAGE_PHOTO=$(usually 8000 20000) cargo test --locked --quiet \
        --test studio library:: -- --ignored --nocapture --test-threads 1 2>&1 | told '^(library|200|photograph)'
}
run_gestures() {
    BOSCAGE_SOAK_GESTURES=$(usually 1500 28800) cargo test --locked --quiet --test studio soak:: -- \
        --ignored --nocapture 2>&1 | told '^random'
}
run_fuzz() { scripts/fuzz.sh "$(usually 60 1800)" ${corpus:+"$corpus"}; }

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
