#!/usr/bin/env bash
# The spatio-temporal graph network of both Bandai-Namco sets: sixteen domains, from random weights.
# 82 minutes on one core; wall time ends the run, so that another machine gets other weights of the same
# kind. Then its figures on set 2. The stages are those in which the weights were made, each with what
# had been found to help by then.
. "$(dirname "$0")/recipe.sh"

all=(--family st-gcn --manifest "$manifests/bandai.toml" --seed 1 --warm-up 3000 --w-identity 2 --w-cycle 2
  --log-every 100 --monitor-every 500)
train st-gcn --minutes 75 --stop-at 14000 "${all[@]}" --w-penalty 5 --w-smooth 0.5
# Style no longer rose. (A thousand of these iterations were in float32, without an effect.)
later=(--resume --w-adversarial 2.5 --w-smooth 0.3 --diversity-target 2.7)
train st-gcn --minutes 75 --stop-at 17600 "${all[@]}" "${later[@]}" --w-penalty 5
# The critic won whatever the generator did (its loss 0.56 of 1.39): a stronger penalty calms it.
train st-gcn --minutes 75 --stop-at 20300 "${all[@]}" "${later[@]}" --w-penalty 50
# Then its gradient can count for more, and what moves fast may.
last=(--resume --w-penalty 50 --w-adversarial 4 --diversity-target 2.7)
train st-gcn --minutes 82 --stop-at 22900 "${all[@]}" "${last[@]}" --w-smooth 0.3
train st-gcn --minutes 82 "${all[@]}" "${last[@]}" --w-smooth 0.05
evaluate --weights "$runs/st-gcn/weights.safetensors" --manifest "$manifests/bandai-2.toml" --long 0 \
  --json "$runs/st-gcn.json"
