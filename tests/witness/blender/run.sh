#!/usr/bin/env bash
# run.sh READ_BACK: the BVH texts of texts.py, read by READ_BACK (bvh_read_back) and by Blender.
# 77: skipped.
set -euo pipefail
command -v blender >/dev/null || { echo "skipped, no blender"; exit 77; }
here=$(cd "$(dirname "$0")" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -B "$here/texts.py" "$folder"
"$1" "$folder" >"$folder/ours.json"
blender --background --factory-startup --python-exit-code 3 --python "$here/import_all.py" -- \
  "$folder" >"$folder/blender.log" 2>&1 || {
  echo "Blender ended with an error:"
  tail -n 20 "$folder/blender.log"
  exit 1
}
python3 -B "$here/compare.py" "$folder"
