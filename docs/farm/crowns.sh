#!/usr/bin/env bash
# Crowns of many photographs on a farm, where `boscage crown` makes one:
#
#   crowns.sh PHOTOS OUT [flags of boscage crown] --shard I/N --resume
#
# Each NAME.jpg (or .png, .webp) in the folder PHOTOS with a NAME.mask.png beside it becomes the folder
# OUT/NAME. Photographs that cannot be used are told of and the others go on, as in all commands of
# many items. With `BOSCAGE=crowns.sh` it stands in for boscage in array.sbatch.
set -uo pipefail
photos=$1 out=$2
shift 2
flags=() shard=0/1
while (($#)); do
    case $1 in
    --shard)
        shard=$2
        shift
        ;;
    *) flags+=("$1") ;;
    esac
    shift
done
mine=${shard%/*} of=${shard#*/}

index=0 made=0 refused=0
for photo in "$photos"/*.{jpg,jpeg,png,webp}; do
    mask=${photo%.*}.mask.png
    [[ -f $photo && -f $mask ]] || continue
    if ((index++ % of == mine)); then
        name=$(basename "${photo%.*}")
        # In the background, so that a signal can be passed on at once.
        "${BOSCAGE_PROGRAM:-boscage}" crown "$photo" --mask "$mask" --out "$out/$name" "${flags[@]}" &
        child=$!
        trap 'kill -TERM "$child" 2>/dev/null' TERM INT
        wait "$child"
        code=$?
        if kill -0 "$child" 2>/dev/null; then
            wait "$child"
            code=$?
        fi
        case $code in
        0) ((made++)) ;;
        2) ((refused++)) ;;
        *) exit "$code" ;; # cancelled, killed, or the machine failed: worth another try
        esac
    fi
done
if ((refused && !made)); then
    exit 2
fi
exit 0
