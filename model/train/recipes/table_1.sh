#!/usr/bin/env bash
# The paper's Table 1 here: what each part of the training is worth. Six styles of set 2 from random
# weights, 4,000 iterations each, five minutes on one core; RESULTS.md has the figures.
. "$(dirname "$0")/recipe.sh"

row() {  # row NAME [OPTIONS...]
  local run=$1
  shift
  train "$run" --iterations 4000 --manifest "$manifests/bandai-2.toml" --seed 1 --penalty-every 4 "$@"
  evaluate --weights "$runs/$run/weights.safetensors" --manifest "$manifests/bandai-2.toml" --long 0 --absolute \
    --json "$runs/$run.json"
}
row full
row no-perceptual --w-perceptual 0
row no-attention --attention 0
row zero-states --learned-states 0
row reconstruction --w-perceptual 0 --w-adversarial 0
row no-adversarial --w-adversarial 0
row v1-losses --w-moments 20 --noise 0.2 --offset 0.7
