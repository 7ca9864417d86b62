#!/usr/bin/env bash
# Table 1 of Style-ERD's paper: the method beside others, and what each part of its training is worth; beyond
# the paper, the content input and where the recurrent states start. Every row is trained from random weights
# for equally many minutes (STYLED_MINUTES, 5 by default), once per seed (STYLED_SEEDS, "1 2 3" by default).
# The rows of a constant offset and of real clips are in the table. RESULTS.md has the figures.
. "$(dirname "$0")/recipe.sh"

set_2=(--manifest "$manifests/bandai-2.toml")
minutes=${STYLED_MINUTES:-5}
read -ra seeds <<<"${STYLED_SEEDS:-1 2 3}"
for seed in "${seeds[@]}"; do
  [[ $seed =~ ^[0-9]+$ ]] || recipe_refuse "STYLED_SEEDS: found '$seed', expected whole numbers, like \"1 2 3\""
done
[[ $minutes =~ ^[0-9]+(\.[0-9]+)?$ ]] || recipe_refuse "STYLED_MINUTES: found '$minutes', expected a number"

rows=()
row() {  # row NAME TITLE [OPTIONS...]
  local run=$1 title=$2 seed files=
  shift 2
  for seed in "${seeds[@]}"; do
    train "$run-$seed" --minutes "$minutes" "${set_2[@]}" --seed "$seed" --penalty-every 4 "$@"
    evaluate --weights "$runs/$run-$seed/weights.safetensors" "${set_2[@]}" --long 0 --absolute \
      --json "$runs/$run-$seed.json"
    files+=,$runs/$run-$seed.json
  done
  rows+=("$title=styled@${files#,}")
}
row full 'Style-ERD, no content input'
row content 'Style-ERD, content recognized' --content-input 1
row zero-states 'zero initial states' --learned-states 0
row no-attention 'multi-class critic' --attention 0
row no-perceptual 'no perceptual loss' --w-perceptual 0
row no-adversarial 'no adversarial loss' --w-adversarial 0
row reconstruction 'reconstruction alone' --w-perceptual 0 --w-adversarial 0

# The other methods of the table, by examples.
for seed in "${seeds[@]}"; do
  train "st-gcn-$seed" --minutes "$minutes" --family st-gcn "${set_2[@]}" --seed "$seed" --w-adversarial 2.5 --w-penalty 20 \
    --w-smooth 0.7
  evaluate --weights "$runs/st-gcn-$seed/weights.safetensors" "${set_2[@]}" --long 0 --json "$runs/st-gcn-$seed.json"
  baseline "aberman-$seed" --design aberman "${set_2[@]}" --seed "$seed" --minutes "$minutes" \
    --json "$runs/aberman-$seed.json"
done
of() { printf ",$runs/$1-%s.json" "${seeds[@]}" | cut -c 2-; }
first=$runs/full-${seeds[0]}.json
tabulate "${rows[@]}" "Park=styled@$(of st-gcn)" "Aberman=styled@$(of aberman)" \
  "offset per content=offset_per_content@$first" "constant offset=offset@$first" "neutral input=neutral@$first" \
  "real clips=real@$first"
