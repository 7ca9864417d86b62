#!/usr/bin/env bash
# The spatio-temporal graph network of both Bandai-Namco sets: sixteen domains, from random weights, 50
# minutes on one core. Not shipped: at width 32 its styles are weaker than those of set 2 alone
# (model/weights/RESULTS.md). Then its figures on set 2.
. "$(dirname "$0")/recipe.sh"

train st-gcn-both --minutes 50 --family st-gcn --manifest "$manifests/bandai.toml" --seed 1 --warm-up 2500 \
  --w-penalty 20 --w-smooth 0.5 --w-adversarial 2.5 --diversity-target 2.6
evaluate --weights "$runs/st-gcn-both/weights.safetensors" --manifest "$manifests/bandai-2.toml" --long 0 \
  --json "$runs/st-gcn-both.json"
