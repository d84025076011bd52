#!/usr/bin/env bash
# A rustc for cargo (RUSTC_WRAPPER) that adds what libFuzzer watches to our own code and to the readers that
# it calls, and to nothing else: windows and graphics would take an hour to compile and no reader calls
# them. Ours also keeps its checks of overflow and its assertions. A stable compiler can do all this.
set -euo pipefail
rustc=$1
shift
name=''
for ((i = 1; i < $#; i++)); do
    if [[ ${!i} == --crate-name ]]; then
        next=$((i + 1))
        name=${!next}
    fi
done
ours=(-C opt-level=1 -C debug-assertions=on -C overflow-checks=on)
watched=(
    -C passes=sancov-module -C codegen-units=16
    -C llvm-args=-sanitizer-coverage-level=4
    -C llvm-args=-sanitizer-coverage-inline-8bit-counters
    -C llvm-args=-sanitizer-coverage-pc-table
    -C llvm-args=-sanitizer-coverage-trace-compares
)
case $name in
boscage | fuzz_*) exec "$rustc" "$@" "${ours[@]}" "${watched[@]}" ;;
image | png | fdeflate | zune_jpeg | image_webp | tiff | weezl | bcdec_rs | serde_json | lz4_flex | exmex)
    exec "$rustc" "$@" "${watched[@]}"
    ;;
*) exec "$rustc" "$@" ;;
esac
