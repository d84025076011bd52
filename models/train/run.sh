#!/bin/sh
# Makes models/segmenter.onnx and segmenter.json from nothing:
#   BOSCAGE_DATA=DIR models/train/run.sh WORK_FOLDER
# BOSCAGE names the program that grows the trees (default: the release build). Everything that is
# made on the way stays in WORK_FOLDER and is not made again. Training times are those of the shipped
# model, about 90 minutes in all on one thread; PATIENCE=4 takes four times as long over each step.
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
own="$work/sketches $work/grown"

fit() { # name, seconds, flags...
    name=$1 seconds=$2
    shift 2
    [ -e "$work/$name.done" ] && return
    "$python" "$here/fit.py" --out "$work/$name.pt" --seconds "$((seconds * patience))" --data "$data" --grown $own "$@"
    touch "$work/$name.done"
}

# Our own trees only, small pictures first.
fit small 1200 --size 128 --batch 16 --rate 3e-3
fit own 480 --size 192 --batch 12 --rate 2e-3 --billboards 0.35 --weights "$work/small.pt"

# The model that ships: permissive real images too. Then the same without some of them, and with
# real images of every licence, a fold of sources held out at a time: for the tables only.
tune="--size 192 --batch 8 --billboards 0.35"
fit first 660 $tune --rate 1.2e-3 --real permissive --weights "$work/own.pt"
fit second 720 --size 192 --batch 8 --billboards 0.22 --rate 1.2e-3 --real permissive --seed 2 --weights "$work/first.pt"
fit third 330 $tune --rate 8e-4 --real permissive --seed 3 --weights "$work/second.pt"
"$python" "$here/average.py" "$work/first.pt" "$work/second.pt" "$work/third.pt" --out "$work/shipped.pt"
fit permissive_2 330 $tune --rate 1.2e-3 --real permissive --fold 2 --weights "$work/own.pt"
fit permissive_01 210 $tune --rate 1.2e-3 --real permissive --fold 0 1 --weights "$work/own.pt"
fit permissive_34 210 $tune --rate 1.2e-3 --real permissive --fold 3 4 --weights "$work/own.pt"
for fold in 0 1 2 3 4; do
    fit all_$fold 210 $tune --rate 1.2e-3 --real all --fold $fold --weights "$work/own.pt"
done

score="$python $here/evaluate.py --data $data --size 192"
held_out="--net $work/permissive_2.pt:2 --net $work/permissive_01.pt:0+1 --net $work/permissive_34.pt:3+4"
$score --net "$work/own.pt:none" --json "$work/own.json" --draw "$work/own"
$score --net "$work/shipped.pt:open" $held_out --json "$work/shipped.json" --draw "$work/shipped"
$score $(for f in 0 1 2 3 4; do echo "--net $work/all_$f.pt:$f"; done) --json "$work/all.json" --draw "$work/all"
"$python" "$here/calibrate.py" --data "$data" --size 192 --net "$work/shipped.pt:open" $held_out --out "$work/calibration.json"
"$python" "$here/package.py" "$work/shipped.pt" --size 192 --calibration "$work/calibration.json" --out "$here/.."
