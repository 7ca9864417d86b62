#!/usr/bin/env bash
# The weights st-gcn.safetensors: the spatio-temporal graph network of Bandai-Namco's set 2, seven
# domains, from random weights. Seventy minutes on one core; wall time ends the run, so that another
# machine gets other weights of the same kind. Then its figures on set 2.
. "$(dirname "$0")/recipe.sh"

run=(--minutes 70 --family st-gcn --manifest "$manifests/bandai-2.toml" --seed 1 --warm-up 3000
  --w-posture 10 --w-read 1.5)
# The weights were made with these losses up to here.
train st-gcn "${run[@]}" --stop-at 12000 --w-penalty 5 --w-smooth 0.1
# Noises no further apart than they need to be, a calmer critic that counts for more, calmer motion.
train st-gcn "${run[@]}" --resume --w-penalty 20 --w-smooth 0.7 --w-adversarial 2.5 --diversity-target 3
evaluate --weights "$runs/st-gcn/weights.safetensors" --manifest "$manifests/bandai-2.toml" --long 0 \
  --json "$runs/st-gcn.json" --report "$runs/st-gcn.html"
