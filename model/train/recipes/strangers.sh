#!/usr/bin/env bash
# The effect of weights on people who are in no training data, and on those of set 2's validation: the table "Strangers" of
# RESULTS.md, in Markdown. Beside each figure, that of the simplest methods: a constant offset per style, and the
# posture alone, which is what is left where the network is shut out. Minutes on one core.
recipe_needs='WEIGHTS '
recipe_sets="bandai-2-train bandai-2-val"
recipe_folders="accad xia"
. "$(dirname "$0")/recipe.sh"

judged=${arguments[0]}
[ -r "$judged" ] || recipe_refuse "$judged cannot be read; expected weights"
recipe_run "$bin/styleeval" --write-offset "$runs/offset.safetensors" --manifest "$manifests/bandai-2.toml" \
  --data "$data"
# A gate that is always shut: no limb is ever reconstructed to a tenth of a millimetre.
recipe_run cp "$judged" "$runs/posture.safetensors"
recipe_run "$bin/styletrain" --write-gate "$runs/posture.safetensors" 0.0001:0.0002 0.0001:0.0002 0.0001:0.0002
recipe_run "$root/model/train/recipes/strangers.py" --styleacts "$bin/styleacts" --data "$data" \
  --manifest "$manifests/bandai-2.toml" --out "$runs" "$judged" "posture alone=$runs/posture.safetensors" \
  "constant offset=$runs/offset.safetensors"
recipe_run "$root/model/train/recipes/strangers_time.py" "$bin/stylize" "$data" "$judged" "$runs"
