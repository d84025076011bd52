#!/usr/bin/env bash
# Fuzzes every reader: scripts/fuzz.sh SECONDS [FOLDER OF FILES THAT OTHERS WROTE]
# Needs a nightly compiler, a C++ compiler and `cargo install cargo-fuzz`; CI needs none of them. Seeds
# are our own samples and fixtures and the files in the folder, by their endings. Prints a line a target.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:?"usage: scripts/fuzz.sh SECONDS [FOLDER]"}
folder=${2:-}

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
        *expressions*) seed expression "$file" ;;
        esac
    done < <(find "$folder" -type f -print0)
fi

cp Cargo.lock fuzz/Cargo.lock
failed=0
for target in fuzz/targets/*.rs; do
    name=$(basename "$target" .rs)
    log=$(mktemp)
    # Without the address sanitizer: there is no unsafe code of ours for it to watch.
    if cargo +nightly fuzz run --sanitizer none --fuzz-dir fuzz "$name" -- \
        -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -max_len=65536 \
        -print_final_stats=1 >"$log" 2>&1; then
        outcome='nothing found'
    else
        outcome="FAILED, see $log"
        failed=1
    fi
    count=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
    printf 'fuzz %s: %s executions in %s s, %s\n' "$name" "${count:-0}" "$seconds" "$outcome"
done
exit "$failed"
