#!/bin/sh
# Makes models/segmenter.onnx and segmenter.json from nothing:
#   BOSCAGE_DATA=DIR models/train/run.sh WORK_FOLDER
# BOSCAGE names the program that grows the trees (default: the release build). Everything that is
# made on the way stays in WORK_FOLDER and is not made again.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
work=${1:?"usage: BOSCAGE_DATA=DIR $0 WORK_FOLDER"}
data=${BOSCAGE_DATA:?"BOSCAGE_DATA names the folder of real images"}
boscage=${BOSCAGE:-$here/../../target/release/boscage}
minutes=${MINUTES:-1}
mkdir -p "$work"
work=$(cd "$work" && pwd)
[ -d "$work/venv" ] || { python3 -m venv "$work/venv" && "$work/venv/bin/pip" install -q -r "$here/requirements.txt"; }
python="$work/venv/bin/python"
export OMP_NUM_THREADS=1

# Trees of our own: sketches by the hundred, and the grown ones.
[ -d "$work/sketches" ] || "$python" "$here/sketches.py" --count 500 --out "$work/sketches"
[ -d "$work/grown" ] || "$boscage" samples --height 512 --out "$work/grown"
own="$work/sketches $work/grown"

fit() { # name, seconds, flags...
    name=$1 seconds=$2
    shift 2
    [ -e "$work/$name.done" ] && return
    "$python" "$here/fit.py" --out "$work/$name.pt" --seconds "$((seconds * minutes))" --data "$data" --grown $own "$@"
    touch "$work/$name.done"
}

# Our own trees only, small pictures first.
fit coarse 420 --size 128 --batch 16 --rate 3e-3
fit own 900 --size 192 --batch 12 --rate 2e-3 --weights "$work/coarse.pt"

# The model that ships: permissive real images too. Then the same without some of them, and with
# real images of every licence, a fold of sources held out at a time: for the tables only.
tune="--size 256 --batch 8 --rate 1e-3 --weights $work/own.pt"
fit shipped 480 $tune --real permissive
fit permissive_2 240 $tune --real permissive --fold 2
fit permissive_01 180 $tune --real permissive --fold 0 1
fit permissive_34 180 $tune --real permissive --fold 3 4
for fold in 0 1 2 3 4; do
    fit all_$fold 240 $tune --real all --fold $fold
done

held_out="--net $work/permissive_2.pt:2 --net $work/permissive_01.pt:0+1 --net $work/permissive_34.pt:3+4"
"$python" "$here/evaluate.py" --data "$data" --net "$work/own.pt:none" --json "$work/own.json" --draw "$work/own"
"$python" "$here/evaluate.py" --data "$data" --net "$work/shipped.pt:open" $held_out --json "$work/shipped.json" --draw "$work/shipped"
"$python" "$here/evaluate.py" --data "$data" $(for f in 0 1 2 3 4; do echo "--net $work/all_$f.pt:$f"; done) --json "$work/all.json" --draw "$work/all"
"$python" "$here/calibrate.py" --data "$data" --net "$work/shipped.pt:open" $held_out --out "$work/calibration.json"
"$python" "$here/package.py" "$work/shipped.pt" --calibration "$work/calibration.json" --out "$here/.."
