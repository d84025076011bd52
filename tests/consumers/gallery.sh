#!/bin/sh
# Opens an exported web gallery from disk in headless Chromium and takes pictures of one tree from
# three sides, to be looked at. Needs chromium.
#   sh gallery.sh FOLDER TREE OUT
set -eu
folder=$(cd "$1" && pwd)
mkdir -p "$3"
for yaw in 0 0.8 1.57; do
  chromium --headless=new --no-sandbox --use-gl=angle --use-angle=swiftshader \
    --enable-unsafe-swiftshader --window-size=900,700 --virtual-time-budget=15000 \
    --screenshot="$3/$2_$yaw.png" "file://$folder/index.html#$2&yaw=$yaw" 2>/dev/null
done
