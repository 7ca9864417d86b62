#!/usr/bin/env bash
# make_fixtures.sh [BUILD]: makes tests/parity/fixtures again from the shipped weights, with the
# programs in BUILD/bin (default build/release, configured with libtorch). Run it whenever
# model/weights/v2.safetensors changes. The synthetic performer's clip is written only if it is
# missing: delete it to follow a change of the performer.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
cd "$root"
build=${1:-build/release}
weights=model/weights/v2.safetensors
[ -f "$weights" ] || weights=${STYLED_WEIGHTS:?no $weights; set STYLED_WEIGHTS}
fixtures=tests/parity/fixtures
reference=$build/bin/styled_parity_reference
[ -x "$reference" ] || { echo "$reference is missing: build it where libtorch is" >&2; exit 1; }

mkdir -p "$fixtures"
if [ ! -s "$fixtures/synthetic.bvh" ]; then
  "$build/bin/stylesim" --write "$fixtures/synthetic.bvh" --seconds 33.4 --rate 30 --seed 7
fi
"$reference" "$fixtures/synthetic.bvh" "$weights" "$fixtures/synthetic.safetensors" \
  --features-every 10

tests/parity/extract_clip.sh "$build/parity-data"
real=$build/parity-data/dataset-1_dance-short_normal_001.bvh
[ -f "$real" ] || { echo "the real clip is missing: its fixture is left as it was" >&2; exit 1; }
# Outputs only, of every fourth frame: small, and nothing of the clip itself.
"$reference" "$real" "$weights" "$fixtures/real.safetensors" --every 4 --features-every 0
ls -l "$fixtures"
