#!/usr/bin/env bash
# The weights open: styles from clips that may be used commercially, and styles that are designed by hand. Nothing is
# trained: each style is measured by gait phase. Seconds on one core.
recipe_sets="bandai-2-train bandai-2-val"
recipe_folders="100style cmu idle other"
. "$(dirname "$0")/recipe.sh"

recipe_run "$bin/stylephase" --designs --split train --manifest "$manifests/open.toml" --data "$data" \
  --out "$runs/open.safetensors"
# How often each style is recognized on people whom neither the file nor the judges know. Minutes, for the judges.
evaluate --weights "$runs/open.safetensors" --manifest "$manifests/open.toml" --inputs "$manifests/bandai-2.toml" \
  --long 0 --write-evidence
