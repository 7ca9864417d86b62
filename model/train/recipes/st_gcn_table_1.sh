#!/usr/bin/env bash
# Table 1 of Park et al. 2021 here: what the losses of st-gcn are worth. Six styles of set 2 from random
# weights, three rows of equal length: adversarial, cycle and identity losses; style reconstruction added;
# diversity added, whose weight this trainer steers. STYLED_SEEDS (default "1 2 3"): runs of each row;
# STYLED_ITERATIONS (default 2500, 1,000 of them identity alone): of each run, some 5 minutes on one core.
recipe_action_classifiers=3
. "$(dirname "$0")/recipe.sh"

common=(--w-penalty 20 --w-smooth 0.5 --w-adversarial 2.5)
# Weight 0 and no target: a target would raise the weight.
no_diversity=(--w-diversity 0 --diversity-target 0)
read -ra seeds <<<"${STYLED_SEEDS:-1 2 3}"
rows=()
row() {  # row NAME TITLE [OPTIONS...]
  local run=$1 title=$2 seed files=
  shift 2
  for seed in "${seeds[@]}"; do
    train "$run-$seed" --iterations "${STYLED_ITERATIONS:-2500}" --family st-gcn --manifest "$manifests/bandai-2.toml" \
      --seed "$seed" "${common[@]}" "$@"
    evaluate --weights "$runs/$run-$seed/weights.safetensors" --manifest "$manifests/bandai-2.toml" --long 0 \
      --json "$runs/$run-$seed.json"
    files+=,$runs/$run-$seed.json
  done
  rows+=("$title=noise@${files#,}")
}
row adversarial 'adversarial, cycle, identity' --w-style 0 "${no_diversity[@]}"
row style '+ style reconstruction' "${no_diversity[@]}"
row diversity '+ diversity' --diversity-target 2.6
tabulate "${rows[@]}"
