#!/usr/bin/env bash
# The spatio-temporal graph network of both Bandai-Namco sets: sixteen domains, from random weights.
# 75 minutes on one core; wall time ends the run, so that another machine gets other weights of the same
# kind. Then its figures on set 2.
. "$(dirname "$0")/recipe.sh"

train st-gcn --minutes 75 --family st-gcn --manifest "$manifests/bandai.toml" --seed 1 --warm-up 3000 \
  --w-identity 2 --w-cycle 2 --w-penalty 5 --w-smooth 0.5 --log-every 100 --monitor-every 500
evaluate --weights "$runs/st-gcn/weights.safetensors" --manifest "$manifests/bandai-2.toml" --long 0 \
  --json "$runs/st-gcn.json"
