#!/usr/bin/env bash
# The weights open: eight styles from clips that may be used commercially, a wide network, from random
# weights. An hour and a half on one core. A graph network is trained first and teaches what it does to whole
# clips. Wall time ends the runs, so that another machine gets other weights of the same kind. Then
# their figures, by the later part of each take.
recipe_sets=
recipe_folders="100style cmu idle other"
. "$(dirname "$0")/recipe.sh"

train st-gcn-open --minutes 35 --family st-gcn --manifest "$manifests/open.toml" --seed 1 --warm-up 1500 \
  --w-posture 10 --w-read 1.5 --w-penalty 20 --w-smooth 0.7 --w-adversarial 2.5 --diversity-target 3

# As v2 in its last part: no critic, no classifier; acts that no style was recorded in stay as they are.
styles=(angry elated graceful limping mummy rushed sultry zombie)
names() { printf -- '--name %s ' "$@"; }
common=(--seed 1 --w-adversarial 0 --w-perceptual 0 --classifier-iterations 1 --teacher-lead 0.08
  --idle 0.2 --idle-as stand
  --keep-content fight --keep-content dance --keep-content acrobatics --keep-content act
  --w-teacher 1 --w-teacher-position 1000 --w-teacher-velocity 3 --smooth-from 0 --smooth-full 0.1
  --offset 0.2 --noise 0.05 --miscalibrated 0.1 --generator-rate 1e-3 --decay-to 0.03)
teacher=$runs/st-gcn-open/weights.safetensors
train open --minutes 40 --manifest "$manifests/open.toml" --wide 1 --per-style 2 "${common[@]}" \
  --unpaired 0.3 --w-rotation 0.2 --w-smooth 2 --w-moments 15 --decay-from 0.4 --ema 0.9995 \
  --teacher "$teacher:$(IFS=,; echo "${styles[*]/%/*1.25}")"

# The moments of fast styles had made slow walks step twice: all styles once more without them, calmer,
# and then the fast ones weaker still. The rest is frozen.
# shellcheck disable=SC2046
add_style open-calm --minutes 14 --replace $(names "${styles[@]}") --init "$runs/open/weights.safetensors" \
  --manifest "$manifests/open.toml" --per-style 3 "${common[@]}" --w-moments 0 --w-smooth 6 --decay-from 0.3 \
  --teacher "$teacher:angry,elated*1.15,graceful*1.15,limping,mummy*1.1,rushed,sultry*1.2,zombie*1.1"
add_style open-fast --minutes 7 --replace --name angry --name rushed --init "$runs/open-calm/weights.safetensors" \
  --manifest "$manifests/add-style/open-fast.toml" --per-style 6 "${common[@]}" --w-moments 0 --w-smooth 30 \
  --decay-from 0.3 --teacher "$teacher:angry*0.8,rushed*0.7"
evaluate --weights "$runs/open-fast/weights.safetensors" --manifest "$manifests/open.toml" --long 0 \
  --json "$runs/open.json"
