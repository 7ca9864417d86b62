#!/usr/bin/env bash
# Configures what systemd/Containerfile copies, as systemd/packages.sh does inside: without tests, trainer
# and every folder that is not copied.
#   tests/service/container_tree.sh ROOT
set -euo pipefail
root=$1
tree=$(mktemp -d)
trap 'rm -rf "$tree"' EXIT
mkdir "$tree/source"
# COPY FROM... TO of the first stage; the second copies --from it.
grep -E '^COPY [^-]' "$root/systemd/Containerfile" | while read -r _ words; do
  for from in ${words% *}; do
    mkdir -p "$(dirname "$tree/source/$from")"
    cp -r "$root/$from" "$(dirname "$tree/source/$from")"
  done
done
cmake -S "$tree/source" --preset release -B "$tree/build" -DCMAKE_INSTALL_PREFIX=/usr \
  -DSTYLED_TRAIN=OFF -DSTYLED_TESTS=OFF >"$tree/log" 2>&1 || { tail -n 40 "$tree/log" >&2; exit 1; }
