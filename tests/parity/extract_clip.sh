#!/usr/bin/env bash
# extract_clip.sh FOLDER: unpacks the real clip of the parity tests into FOLDER, from the archives
# in $STYLED_DATA (default: shared/data beside the checkout). Without them it prints a message and
# succeeds.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
data=${STYLED_DATA:-$root/../shared/data}
clip=dataset-1_dance-short_normal_001.bvh
[ ! -s "$1/$clip" ] || exit 0
if [ ! -f "$data/bandai-1.tar.xz" ]; then
  echo "skipped, no data (set STYLED_DATA)"
  exit 0
fi
mkdir -p "$1"
scratch=$(mktemp -d "$1/unpack-XXXXXX")
trap 'rm -rf "$scratch"' EXIT
tar -xJf "$data/bandai-1.tar.xz" -C "$scratch" "bandai-1/$clip"
mv "$scratch/bandai-1/$clip" "$1/$clip"
