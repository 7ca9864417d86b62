#!/usr/bin/env bash
# The weights v2: fifteen styles of both Bandai-Namco sets, a wide network, from random weights. Three and
# a half hours on one core. Two graph networks are trained first, one on each set, and teach what they do
# to whole clips. Wall time ends the runs, so that another machine gets other weights of the same kind.
# Then their figures on both sets.
recipe_folders="100style cmu idle other"
. "$(dirname "$0")/recipe.sh"

train_st_gcn
train st-gcn-1 --minutes 38 --family st-gcn --manifest "$manifests/bandai-1.toml" --seed 1 --warm-up 1500 \
  --w-posture 10 --w-read 1.5 --w-penalty 20 --w-smooth 0.7 --w-adversarial 2.5 --diversity-target 3

# 1 All styles. The teachers do everything: no critic, no classifier. Acts that no style was recorded in
# stay as they are. The gains make up for what the stylist's low-pass and a student's caution take of a
# change, and the student is taught what a teacher does 80 ms later: about the delay of the stylist.
run=(--minutes 92 --manifest "$manifests/v2.toml" --seed 1 --wide 1 --per-style 2
  --w-adversarial 0 --w-perceptual 0 --classifier-iterations 1 --unpaired 0.3
  --teacher-lead 0.08 --idle 0.2 --idle-content idle
  --keep-content fight --keep-content dance --keep-content acrobatics --keep-content act
  --w-rotation 0.2 --w-teacher 1 --w-teacher-position 1000 --w-teacher-velocity 3
  --smooth-from 0 --smooth-full 0.1 --offset 0.2 --noise 0.05 --miscalibrated 0.1
  --generator-rate 1e-3 --decay-from 0.4 --decay-to 0.03 --ema 0.9995)
# teach GAIN FILE STYLE...: the value of --teacher: FILE for these styles, with this gain or, where it is
# written STYLE*GAIN, with that one.
teach() {
  local gain=$1 file=$2 style lessons=()
  shift 2
  for style in "$@"; do
    [[ $style = *"*"* ]] || style+="*$gain"
    lessons+=("$style")
  done
  printf '%s:%s' "$file" "$(IFS=,; echo "${lessons[*]}")"
}
set_1=(angry childish giant happy musical not-confident proud sad swagger)
set_2=(active elderly exhausted feminine masculine youthful)
first=$runs/st-gcn/weights.safetensors second=$runs/st-gcn-1/weights.safetensors
second_teaches=$(teach 1.3 "$second" "${set_1[@]}")
# The shipped weights were made in three parts. The second teacher was not ready when part one began. After
# part two the styles were too strong and jerked: part three has lower gains and more smoothness.
train v2 "${run[@]}" --stop-at 16400 --w-smooth 1 --teacher "$(teach 1.4 "$first" "${set_2[@]}")"
train v2 "${run[@]}" --resume --stop-at 28500 --w-smooth 1 --w-moments 30 \
  --teacher "$(teach 1.2 "$first" "active*1.5" elderly "exhausted*1.45" feminine "masculine*1.25" youthful)" \
  --teacher "$second_teaches"
train v2 "${run[@]}" --resume --w-smooth 4 --w-moments 15 \
  --teacher "$(teach 1.2 "$first" active "elderly*1.15" exhausted "feminine*1.15" "masculine*1.15" youthful)" \
  --teacher "$second_teaches"

# 2 Set 1's styles once more, by themselves, nearer to the clips' mean poses; the rest is frozen.
# shellcheck disable=SC2046
add_style v2-set-1 --minutes 16 --replace $(printf -- '--name %s ' "${set_1[@]}") --seed 1 --per-style 3 \
  --init "$runs/v2/weights.safetensors" --manifest "$manifests/add-style/set-1.toml" \
  --w-adversarial 0 --w-perceptual 0 --classifier-iterations 1 --teacher-lead 0.08 --idle 0.2 \
  --w-teacher 0.2 --w-teacher-position 200 --w-teacher-velocity 3 --w-moments 100 \
  --w-smooth 4 --smooth-from 0 --smooth-full 0.1 --offset 0.2 --noise 0.05 --miscalibrated 0.1 \
  --generator-rate 1e-3 --decay-from 0.3 --decay-to 0.03 --teacher "$(teach 1.5 "$second" "${set_1[@]}")"
evaluate --weights "$runs/v2-set-1/weights.safetensors" --manifest "$manifests/bandai-2.toml" --long 0 \
  --json "$runs/set-2.json"
evaluate --weights "$runs/v2-set-1/weights.safetensors" --manifest "$manifests/bandai-1.toml" \
  --inputs "$manifests/bandai-2.toml" --long 0 --json "$runs/set-1-of-set-2.json"
