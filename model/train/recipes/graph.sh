#!/usr/bin/env bash
# The weights graph.safetensors: the causal spatio-temporal graph network of Bandai-Namco's set 2,
# from random weights, by way of st-gcn.safetensors: 70 and 110 minutes on one core. Wall time ends
# both runs, so that another machine gets other weights of the same kind. Then its figures on set 2.
. "$(dirname "$0")/recipe.sh"

train_st_gcn
# The shipped weights were made in three parts: first the teacher's output; then its change of style
# as much later as the stylist's low-pass is late, and larger; then more smoothly.
run=(--family st-gcn-causal --init "$runs/st-gcn/weights.safetensors"
  --manifest "$manifests/bandai-2.toml" --seed 1)
late=(--lead 0.08 --gain 1.2)
train graph --minutes 45 "${run[@]}"
train graph --minutes 110 "${run[@]}" --resume --stop-at 21069 "${late[@]}" --w-smooth 10
train graph --minutes 110 "${run[@]}" --resume "${late[@]}" --w-smooth 20
evaluate --weights "$runs/graph/weights.safetensors" --manifest "$manifests/bandai-2.toml" --long 600 \
  --rates --json "$runs/graph.json" --report "$runs/graph.html"
