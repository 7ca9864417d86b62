#!/usr/bin/env bash
# All styles of The 100STYLE Dataset (Ian Mason, CC BY 4.0, doi 10.1145/3522618, zenodo 8127870) as a library of the
# daemon, from its unpacked archive: measured by gait phase, from each style's walk, run and idle, within the set's own
# frame cuts. Missing takes are named and skipped. Minutes on one core; nothing is trained.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../../.." && pwd)
bin=${STYLED_BIN:-$root/build/release/bin}
recipe_needs='DIR '
dry_run=no
if [ "${1:-}" = --dry-run ]; then
  dry_run=yes
  shift
fi
if [ $# != 2 ] || [ "${1:0:1}" = - ]; then
  cat >&2 <<USAGE
usage: model/train/recipes/100style.sh [--dry-run] ${recipe_needs}LIBRARY
  DIR        the unpacked archive: STYLE/STYLE_FW.bvh ..., Frame_Cuts.csv
  LIBRARY    folder for the styles, to be named by [style] library of styled.toml
  --dry-run  print the command
STYLED_BIN   the folder of stylephase; default build/release/bin
USAGE
  exit 2
fi
command=(stylephase --manifest 100style.toml --data "$1" --library "$2" --prefix 100style-)
echo "${command[*]}"
[ "$dry_run" = no ] || exit 0
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$root/model/train/recipes/100style.py" "$1" >"$folder/100style.toml"
command[0]=$bin/stylephase
command[2]=$folder/100style.toml
"${command[@]}"
