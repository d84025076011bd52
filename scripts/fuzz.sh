#!/usr/bin/env bash
# Fuzzes every reader: scripts/fuzz.sh SECONDS [FOLDER OF FILES THAT OTHERS WROTE] [TARGET…]
# Needs a C++ compiler; nothing else here does. Seeds are our own samples and fixtures and the files in the
# folder, by their endings. Prints a line a target; what broke a reader lies in fuzz/artifacts.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:?"usage: scripts/fuzz.sh SECONDS [FOLDER] [TARGET…]"}
folder=${2:-}
targets=("${@:3}")
scripts=$PWD/scripts

seed() { # seed TARGET FILE…
    mkdir -p "fuzz/corpus/$1"
    local file
    for file in "${@:2}"; do
        # Larger ones only slow the fuzzer down.
        [[ -f $file && $(stat -c %s "$file") -le 65536 ]] || continue
        cp "$file" "fuzz/corpus/$1/$(sha256sum "$file" | cut -c1-16)"
    done
}

seed project tests/fixtures/*.boscage
seed image docs/pictures/* tests/golden/*/*.png
seed model models/segmenter.json
program=$(ls -t target/*/boscage 2>/dev/null | head -1)
if [[ -n $program ]]; then
    made=$(mktemp -d)
    (
        program=$PWD/$program
        cd "$made"
        "$program" samples --bundled --out trees
        "$program" vary --library trees --count 2 --size 64 --out new
        PYTHONPATH=$scripts/reliability python3 -c 'import inputs; inputs.photo_and_mask(".", 64)'
        "$program" crown photo.png --mask mask.png --size 32 --out crown
    ) >/dev/null
    seed library "$made/new/library.json"
    seed crown_record "$made/crown/crown.json"
    seed mesh "$made"/crown/*.ply
    seed grey16 "$made"/crown/*.png
    rm -r "$made"
fi
mkdir -p fuzz/corpus/{expression,polygons,regions,library,profile,crown_record,mesh,grey16}
printf '2+sin(pi*j)-min(i,3)^-2' >fuzz/corpus/expression/formula
printf '{"points":[[0,1],[2.5,3],[4,-5e1]]}' >fuzz/corpus/polygons/points
printf '{"polygons":[[[0,1],[2,3],[4,5]],[[1,1]]]}' >fuzz/corpus/polygons/polygons
printf '{"regions":[{"label":100,"k":2},{"label":200,"k":"1+j","depth_px":20}]}' >fuzz/corpus/regions/two
printf '{"components":[[[0,2],[0.5,3.5]]]}' >fuzz/corpus/profile/one
if [[ -n $folder ]]; then
    while IFS= read -r -d '' file; do
        case ${file,,} in
        *.png) seed image "$file" && seed grey16 "$file" ;;
        *.jpg | *.jpeg | *.webp | *.tif | *.tiff | *.tga | *.bmp | *.dds) seed image "$file" ;;
        *.json | *.txt)
            for target in polygons regions library profile crown_record; do seed "$target" "$file"; done
            ;;
        *.onnx) seed model "$file" ;;
        *expressions*) seed expression "$file" ;;
        esac
    done < <(find "$folder" -type f -print0)
fi

# The pinned versions, and what only fuzzing needs beside them.
[[ -f fuzz/Cargo.lock ]] || cp Cargo.lock fuzz/Cargo.lock
RUSTC_WRAPPER=$PWD/scripts/instrumented.sh cargo build --quiet --release --manifest-path fuzz/Cargo.toml

((${#targets[@]})) || mapfile -t targets < <(basename -s .rs fuzz/targets/*.rs)
mkdir -p fuzz/artifacts
failed=0
for target in "${targets[@]}"; do
    log=$(mktemp)
    # Without the address sanitizer: there is no unsafe code of ours for it to watch.
    if "fuzz/target/release/fuzz_$target" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 \
        -max_len=65536 -print_final_stats=1 -artifact_prefix="fuzz/artifacts/$target-" \
        "fuzz/corpus/$target" >"$log" 2>&1; then
        outcome='nothing found'
    else
        outcome="FAILED: $(grep -m 1 -e 'panicked at' -e 'ERROR: libFuzzer' "$log" | tr -d '|'), see $log"
        failed=1
    fi
    number() { sed -n "s/^stat::$1: *//p" "$log"; }
    edges=$(sed -n 's/.* cov: \([0-9]*\) .*/\1/p' "$log" | tail -1)
    printf 'fuzz %s: %s executions, %s branches reached, most memory %s MB, %s\n' "$target" \
        "$(number number_of_executed_units)" "${edges:-?}" "$(number peak_rss_mb)" "$outcome"
done
exit "$failed"
