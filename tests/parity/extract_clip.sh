#!/usr/bin/env bash
# extract_clip.sh FOLDER: unpacks two real clips into FOLDER, that of the parity tests, a dance, and that
# of the rigs' tests, a walk, which every style changes. From the archives in $STYLED_DATA (default:
# shared/data beside the checkout). Without them it prints a message and succeeds.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
data=${STYLED_DATA:-$root/../shared/data}
clips=(dataset-1_dance-short_normal_001.bvh dataset-1_walk_normal_001.bvh)
[ ! -s "$1/${clips[0]}" ] || [ ! -s "$1/${clips[1]}" ] || exit 0
if [ ! -f "$data/bandai-1.tar.xz" ]; then
  echo "skipped, no data (set STYLED_DATA)"
  exit 0
fi
mkdir -p "$1"
scratch=$(mktemp -d "$1/unpack-XXXXXX")
trap 'rm -rf "$scratch"' EXIT
tar -xJf "$data/bandai-1.tar.xz" -C "$scratch" "${clips[@]/#/bandai-1/}"
mv "$scratch"/bandai-1/*.bvh "$1/"
