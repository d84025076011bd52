#!/usr/bin/env bash
# Exports trees and crowns with every preset and reads them with programs that are not ours: the
# Khronos glTF validator (node), Pillow, zstandard and OpenEXR (Python). Both are fetched into
# target/consumers, pinned by tests/consumers; what cannot be fetched is said and left out, except
# under BOSCAGE_REQUIRE_CONSUMERS=1.
#   scripts/consumers.sh [BOSCAGE]      the program; default target/debug/boscage
#   scripts/consumers.sh --fetch        only fetches them, which may go on while the program is compiled
set -euo pipefail
cd "$(dirname "$0")/.."

boscage=${1:-target/debug/boscage}
kept=$PWD/target/consumers
mkdir -p "$kept"
work=$(mktemp -d "$kept/run.XXXXXX")
trap 'rm -rf "$work"' EXIT
# A fetch that still goes on is waited for.
exec 9>"$kept/lock"
if command -v flock >/dev/null; then flock 9; fi

left_out() {
    printf '== %s: exports were not checked by it\n' "$1"
    [[ ${BOSCAGE_REQUIRE_CONSUMERS:-0} != 1 ]] || exit 1
}

validator() {
    command -v npm >/dev/null || return 1
    cp tests/consumers/package.json "$kept/"
    [[ -d $kept/node_modules/gltf-validator ]] ||
        timeout 120 npm install --prefix "$kept" --no-audit --no-fund --silent >/dev/null
}

readers() {
    command -v python3 >/dev/null || return 1
    [[ -e $kept/python/done ]] && return
    python3 -m venv "$kept/python" &&
        timeout 180 "$kept/python/bin/pip" install --quiet --requirement tests/consumers/requirements.txt &&
        touch "$kept/python/done"
}

if [[ ${1:-} == --fetch ]]; then
    validator || true
    readers || true
    exit
fi

# A tree with its crown, of the pictures built in.
mkdir "$work/pictures"
cp assets/samples/{oak_01,pine_02,apple_01}.webp "$work/pictures/"
"$boscage" vary --library "$work/pictures" --count 1 --size 256 --seed 1 --any-pair \
    --crowns --crown-size 64 --out "$work/trees"

# Model textures as PNG or JPEG: the validator knows no Basis Universal.
for preset in blender godot unity unreal web flightgear; do
    "$boscage" export "$work/trees" --preset $preset --maps normal,depth,ao,translucency \
        --out "$work/exports/$preset"
done
"$boscage" export "$work/trees" --preset unreal --textures dds,ktx2 --out "$work/textures"
for preset in blender godot unity unreal web; do
    "$boscage" export "$work/trees/crowns" --preset $preset --exr --out "$work/exports/$preset-crowns"
done

if validator; then
    NODE_PATH=$kept/node_modules node tests/consumers/validate.mjs "$work/exports"
else
    left_out "no glTF validator"
fi
if readers; then
    "$kept/python/bin/python" tests/consumers/textures.py "$work/textures"
    "$kept/python/bin/python" tests/consumers/textures.py "$work/exports/blender-crowns"
else
    left_out "no readers of textures"
fi
