#!/usr/bin/env bash
# A style added to frozen weights: feminine of set 2, left out of a network of fifteen styles and then
# learned from 158 seconds of it. An hour on one core; RESULTS.md has the figures.
. "$(dirname "$0")/recipe.sh"

train base --minutes 45 --manifest "$manifests/add-style/base.toml" --seed 1 --per-style 2 --w-smooth 4 \
  --w-penalty 40 --penalty-every 4 --w-moments 20 --noise 0.2 --offset 0.7 --decay-from 0.5 --smooth-from 0 \
  --smooth-full 0.1
add_style feminine --minutes 18 --name feminine --init "$runs/base/weights.safetensors" \
  --manifest "$manifests/add-style/feminine.toml" --seed 1 --per-style 12 --penalty-every 4 --w-moments 200 \
  --w-smooth 3 --w-penalty 60 --decay-from 0.5 --smooth-from 0 --smooth-full 0.1
