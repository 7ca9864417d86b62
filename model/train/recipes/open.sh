#!/usr/bin/env bash
# The weights open: eight styles from clips that may be used commercially, a wide network, from random
# weights. 75 minutes on one core. A graph network is trained first and teaches what it does to whole
# clips. Wall time ends the runs, so that another machine gets other weights of the same kind. Then
# their figures, by the later part of each take.
recipe_sets=
recipe_folders="100style cmu idle other"
. "$(dirname "$0")/recipe.sh"

train st-gcn-open --minutes 35 --family st-gcn --manifest "$manifests/open.toml" --seed 1 --warm-up 1500 \
  --w-posture 10 --w-read 1.5 --w-penalty 20 --w-smooth 0.7 --w-adversarial 2.5 --diversity-target 3

# As v2 in its last part: no critic, no classifier; acts that no style was recorded in stay as they are.
styles=(angry elated graceful limping mummy rushed sultry zombie)
lessons=$(IFS=,; echo "${styles[*]/%/*1.25}")
train open --minutes 40 --manifest "$manifests/open.toml" --seed 1 --wide 1 --per-style 2 \
  --w-adversarial 0 --w-perceptual 0 --classifier-iterations 1 --unpaired 0.3 \
  --teacher-lead 0.08 --idle 0.2 --idle-as stand \
  --keep-content fight --keep-content dance --keep-content acrobatics --keep-content act \
  --w-rotation 0.2 --w-teacher 1 --w-teacher-position 1000 --w-teacher-velocity 3 \
  --w-smooth 2 --w-moments 15 --smooth-from 0 --smooth-full 0.1 --offset 0.2 --noise 0.05 --miscalibrated 0.1 \
  --generator-rate 1e-3 --decay-from 0.4 --decay-to 0.03 --ema 0.9995 \
  --teacher "$runs/st-gcn-open/weights.safetensors:$lessons"
evaluate --weights "$runs/open/weights.safetensors" --manifest "$manifests/open.toml" --long 0 \
  --json "$runs/open.json"
