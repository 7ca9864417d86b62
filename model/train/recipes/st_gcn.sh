#!/usr/bin/env bash
# The weights st-gcn.safetensors: the spatio-temporal graph network of Bandai-Namco's set 2, seven
# domains, from random weights. Seventy minutes on one core; wall time ends the run, so that another
# machine gets other weights of the same kind. Then its figures on set 2.
. "$(dirname "$0")/recipe.sh"

train_st_gcn
evaluate --weights "$runs/st-gcn/weights.safetensors" --manifest "$manifests/bandai-2.toml" --long 0 \
  --json "$runs/st-gcn.json" --report "$runs/st-gcn.html"
