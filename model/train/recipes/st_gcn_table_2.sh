#!/usr/bin/env bash
# Table 2 of Park et al. 2021 here: st-gcn's WEIGHTS, the designs that it is compared with, trained on
# set 2, Style-ERD's v2, a constant offset, and real clips; all before the same judges. STYLED_SEEDS
# (default "1 2 3"): trainings of each design; STYLED_MINUTES (default 10): of each, processor time.
recipe_needs='WEIGHTS '
recipe_action_classifiers=3
. "$(dirname "$0")/recipe.sh"

judged=${arguments[0]}
[ -r "$judged" ] || recipe_refuse "$judged cannot be read; expected weights"
set_2=(--manifest "$manifests/bandai-2.toml")
minutes=${STYLED_MINUTES:-10}
read -ra seeds <<<"${STYLED_SEEDS:-1 2 3}"
for seed in "${seeds[@]}"; do
  [[ $seed =~ ^[0-9]+$ ]] || recipe_refuse "STYLED_SEEDS: found '$seed', expected whole numbers, like \"1 2 3\""
done
[[ $minutes =~ ^[0-9]+(\.[0-9]+)?$ ]] || recipe_refuse "STYLED_MINUTES: found '$minutes', expected a number"

evaluate "${set_2[@]}" --weights "$judged" --long 0 --json "$runs/st-gcn.json"
evaluate "${set_2[@]}" --weights "$weights/v2.safetensors" --long 0 --json "$runs/style-erd.json"
for design in aberman holden; do
  for seed in "${seeds[@]}"; do
    baseline "$design-$seed" --design "$design" "${set_2[@]}" --seed "$seed" --minutes "$minutes" \
      --json "$runs/$design-$seed.json"
  done
done
of_design() { printf ",$runs/$1-%s.json" "${seeds[@]}" | cut -c 2-; }
tabulate "st-gcn, examples=styled@$runs/st-gcn.json" "st-gcn, noise=noise@$runs/st-gcn.json" \
  "st-gcn, mean codes=mean@$runs/st-gcn.json" \
  "Aberman, examples=styled@$(of_design aberman)" "Aberman, mean codes=mean@$(of_design aberman)" \
  "Holden, examples=styled@$(of_design holden)" "Holden, mean codes=mean@$(of_design holden)" \
  "Style-ERD v2=styled@$runs/style-erd.json" "offset per content=offset_per_content@$runs/st-gcn.json" \
  "neutral input=neutral@$runs/st-gcn.json" "real clips=real@$runs/st-gcn.json"
