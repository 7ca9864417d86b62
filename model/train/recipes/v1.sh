#!/usr/bin/env bash
# The weights v1: fifteen styles of both Bandai-Namco sets, from v0. Six hours on one core. The stages
# are those in which the shipped file was made, each with what had been found to help by then;
# RESULTS.md has the figures. Stages that wall time ends come out different on another machine.
. "$(dirname "$0")/recipe.sh"

set_2=(active elderly exhausted feminine masculine youthful)
set_1=(angry childish giant happy musical not-confident proud sad swagger)
v0=$weights/v0.safetensors
names() { printf -- '--name %s ' "$@"; }

# 1 Sixteen styles, neutral included, from v0's six.
first=(--manifest "$manifests/bandai.toml" --init "$v0" --seed 1 --per-style 2 --smooth-from 0 --smooth-full 0.01
  --penalty-every 4 --critic-first 500 --decay-to 0.1)
train v1 --minutes 95 "${first[@]}" --w-smooth 5 --w-penalty 40 --miscalibrated 0.4 --decay-from 0.6
train v1 --minutes 117 "${first[@]}" --resume --w-smooth 2 --w-penalty 15 --decay-from 0.6
# Stopped after 22 minutes, the next after 60: here at as many iterations. The moments were of
# positions alone until the last.
train v1 --minutes 215 --stop-at 65800 "${first[@]}" --resume --w-smooth 2 --w-penalty 15 --decay-from 0.6 --w-moments 30
later=(--resume --w-smooth 3 --w-penalty 15 --decay-from 0.72 --noise 0.2 --offset 0.7)
train v1 --minutes 232 --stop-at 94300 "${first[@]}" "${later[@]}" --w-moments 20
train v1 --minutes 240 "${first[@]}" "${later[@]}" --w-moments 40

# 2 Branches learned anew, the rest frozen.
critic=(--seed 1 --penalty-every 4 --w-penalty 40 --smooth-from 0 --smooth-full 0.01 --critic-first 800)
# shellcheck disable=SC2046
add_style v1e --iterations 5164 --replace $(names elderly feminine) --init "$runs/v1/weights.safetensors" \
  --manifest "$manifests/add-style/elderly-feminine.toml" "${critic[@]}" \
  --per-style 8 --w-moments 100 --w-smooth 4 --noise 0.2 --offset 0.7 --decay-from 1
# shellcheck disable=SC2046
add_style v1k --iterations 9000 --replace $(names "${set_1[@]}") --init "$runs/v1e/weights.safetensors" \
  --manifest "$manifests/add-style/set-1.toml" "${critic[@]}" \
  --per-style 2 --w-moments 60 --w-smooth 12 --noise 0.3 --offset 1.5 --decay-from 0.5
old=$runs/v1k/weights.safetensors

# 3 What v0 does better, taught by v0; then everything, taught by both.
by_teacher=(--w-adversarial 0 --w-perceptual 0 --smooth-from 0 --smooth-full 0.01)
# shellcheck disable=SC2046
add_style v1t --iterations 4000 --replace $(names exhausted masculine youthful) --init "$old" --teacher "$v0" \
  --manifest "$manifests/add-style/exhausted-masculine-youthful.toml" "${by_teacher[@]}" --seed 1 --per-style 6 \
  --penalty-every 4 --w-penalty 40 --critic-first 800 --decay-from 0.5 --w-teacher 2 --w-smooth 2 --noise 0.3 --offset 1
teachers=(--teacher "$old" --teacher "$v0:exhausted,masculine,youthful")
all=(--manifest "$manifests/bandai.toml" "${teachers[@]}" "${by_teacher[@]}" --per-style 2 --classifier-iterations 1
  --decay-to 0.05)
# The schedule is of 88 minutes; it was stopped after 23,519 iterations, 35 minutes.
train v1u --minutes 88 --stop-at 23519 --init "$runs/v1t/weights.safetensors" "${all[@]}" --seed 1 \
  --generator-rate 6e-4 --decay-from 0.5 --w-teacher 1 --w-smooth 6 --noise 0.3 --offset 1.0 --miscalibrated 0.3
train v1w --minutes 48 --init "$runs/v1u/weights.safetensors" "${all[@]}" --seed 3 \
  --generator-rate 4e-4 --decay-from 0.3 --w-teacher 3 --w-smooth 4 --noise 0.2 --offset 0.7 --miscalibrated 0.2

# 4 Branches once more, each content taught by the network that does it best, and idle postures.
fine=("${by_teacher[@]}" --seed 1 --classifier-iterations 1 --decay-from 0.3 --decay-to 0.03 --w-teacher 5 --w-smooth 2
  --noise 0.1 --offset 0.4)
# shellcheck disable=SC2046
add_style v1p --iterations 9000 --replace $(names "${set_2[@]}") --init "$runs/v1w/weights.safetensors" \
  "${teachers[@]}" --manifest "$manifests/bandai-2.toml" "${fine[@]}" --per-style 4
better="$v0:exhausted*1.2,exhausted/walk*0.9,youthful*1.08,youthful/run,elderly/raise,elderly/wave,elderly/stand"
# shellcheck disable=SC2046
add_style v1q --iterations 12000 --replace $(names active elderly exhausted youthful) \
  --init "$runs/v1p/weights.safetensors" --teacher "$runs/v1p/weights.safetensors:elderly,elderly/walk*1.15" \
  --teacher "$old:active,active/run*1.1" --teacher "$better" \
  --manifest "$manifests/add-style/active-elderly-exhausted-youthful.toml" "${fine[@]}" --per-style 6
# shellcheck disable=SC2046
add_style v1s --iterations 9000 --replace $(names "${set_2[@]}" "${set_1[@]}") \
  --init "$runs/v1q/weights.safetensors" --teacher "$runs/v1q/weights.safetensors" --idle 0.3 \
  --manifest "$manifests/bandai.toml" "${fine[@]}" --per-style 2
echo "the weights: $runs/v1s/weights.safetensors"
