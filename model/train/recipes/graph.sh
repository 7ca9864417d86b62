#!/usr/bin/env bash
# The weights graph.safetensors: the causal spatio-temporal graph network of Bandai-Namco's set 2,
# from random weights, by way of st-gcn.safetensors: 70 and 45 minutes on one core. Wall time ends
# both runs, so that another machine gets other weights of the same kind. Then its figures on set 2.
. "$(dirname "$0")/recipe.sh"

train_st_gcn
train graph --minutes 45 --family st-gcn-causal --init "$runs/st-gcn/weights.safetensors" \
  --manifest "$manifests/bandai-2.toml" --seed 1
evaluate --weights "$runs/graph/weights.safetensors" --manifest "$manifests/bandai-2.toml" --long 60 \
  --rates --json "$runs/graph.json" --report "$runs/graph.html"
