#!/bin/sh
# Makes models/segmenter.onnx and segmenter.json from nothing:
#   BOSCAGE_DATA=DIR models/train/run.sh WORK_FOLDER
# BOSCAGE names the program that grows the trees (default: the release build). Everything that is
# made on the way stays in WORK_FOLDER and is not made again. Stages end after so many examples, those
# of the shipped model: one and a half hours on two idle cores; PATIENCE=4 takes four times as many.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
work=${1:?"usage: BOSCAGE_DATA=DIR $0 WORK_FOLDER"}
data=${BOSCAGE_DATA:?"BOSCAGE_DATA names the folder of real images"}
boscage=${BOSCAGE:-$here/../../target/release/boscage}
patience=${PATIENCE:-1}
mkdir -p "$work"
work=$(cd "$work" && pwd)
[ -d "$work/venv" ] || { python3 -m venv "$work/venv" && "$work/venv/bin/pip" install -q -r "$here/requirements.txt"; }
python="$work/venv/bin/python"
export OMP_NUM_THREADS=1

# Trees of our own: sketches by the hundred, and the grown ones.
[ -d "$work/sketches" ] || "$python" "$here/sketches.py" --count 500 --out "$work/sketches"
[ -d "$work/grown" ] || "$boscage" samples --species all --first 101 --individuals 8 --height 448 --out "$work/grown"

fit() { # name, examples, flags...
    name=$1 examples=$2
    shift 2
    [ -e "$work/$name.done" ] && return
    "$python" "$here/fit.py" --out "$work/$name.pt" --examples "$((examples * patience))" \
        --data "$data" --grown "$work/sketches" "$work/grown" --size 256 --batch 8 "$@"
    touch "$work/$name.done"
}

# From the features of ImageNet: our own trees, then permissive real images too, then the feet of trees
# from near, and last everything larger than the program looks at it.
real="--real permissive --real-share 0.4 --billboards 0.3"
fit own 2144 --rate 2e-3 --billboards 0.35 --close-ups 0
fit first 5600 $real --rate 1.5e-3 --close-ups 0 --seed 3 --weights "$work/own.pt"
fit near 2400 $real --rate 1.3e-3 --seed 7 --weights "$work/first.pt"
fit shipped 9600 --size 320 --real permissive --real-share 0.35 --billboards 0.25 --rate 1e-3 --seed 11 --weights "$work/near.pt"

"$python" "$here/evaluate.py" --data "$data" --size 256 --net "$work/shipped.pt:open" \
    --calibration "$work/calibration.json" --json "$work/shipped.json" --draw "$work/shipped"
"$python" "$here/package.py" "$work/shipped.pt" --size 256 --calibration "$work/calibration.json" --out "$here/.."

# The same without some of the real images, for a table of pictures that the shipped weights have seen;
# only when asked for: TABLES=1.
[ -n "${TABLES:-}" ] || exit 0
fit without_2 1416 $real --rate 1.5e-3 --close-ups 0 --fold 2 --weights "$work/own.pt"
fit without_2_near 728 $real --rate 1.3e-3 --seed 5 --fold 2 --weights "$work/without_2.pt"
fit without_01 1616 $real --rate 1.5e-3 --close-ups 0 --fold 0 1 --weights "$work/own.pt"
fit without_34 1232 $real --rate 1.5e-3 --close-ups 0 --fold 3 4 --weights "$work/own.pt"
"$python" "$here/evaluate.py" --data "$data" --size 256 --net "$work/near.pt:open" \
    --net "$work/without_2_near.pt:2" --net "$work/without_01.pt:0+1" --net "$work/without_34.pt:3+4"
