# shellcheck shell=bash disable=SC2034
# Sourced by the recipes: reads their arguments and runs styletrain and styleeval. A recipe says
# first what it makes, in its own comment, and then calls
#   train NAME LENGTH [OPTIONS...]       a run of styletrain in the folder $runs/NAME, or its resumption
#   add_style NAME LENGTH [OPTIONS...]   the same of styletrain add-style
#   evaluate [OPTIONS...]                styleeval
#   write_judges [OPTIONS...]            the same, which only trains judges
#   baseline NAME [OPTIONS...]           stylebaseline in the folder $runs/NAME
#   tabulate ROW...                      table.py
#   train_st_gcn                         the graph network of set 2, in $runs/st-gcn
# LENGTH is styletrain's: "--minutes 95" or "--iterations 9000".
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../../.." && pwd)
name=$(basename "$0" .sh)
recipe_sets=${recipe_sets-bandai-1 bandai-2-train bandai-2-val}  # of Bandai-Namco
recipe_folders=${recipe_folders:-}                                # of other clips
weights=$root/model/weights
manifests=$weights/manifests

# All folders of clips: "a, b, c".
recipe_all() {
  local all=(${recipe_sets} ${recipe_folders})
  local IFS=,
  echo "${all[*]}" | sed 's/,/, /g'
}
recipe_usage() {
  cat <<USAGE
usage: model/train/recipes/$name.sh [--dry-run] [--smoke] ${recipe_needs:-}RUNS
  RUNS       folder for the runs, made where there is none
  --dry-run  print the commands
  --smoke    two iterations of each run, on and before a few clips of each kind: shows that the
             commands work, and nothing else
STYLED_DATA  the folder of the unpacked clips: $(recipe_all)
STYLED_BIN   the folder of styletrain, styleeval and stylebaseline; default build/release/bin
USAGE
}
recipe_refuse() {
  echo "$name: $*" >&2
  exit 2
}

dry_run=no
smoke=no
arguments=()
for argument in "$@"; do
  case "$argument" in
    --dry-run) dry_run=yes ;;
    --smoke) smoke=yes ;;
    -h | --help)
      recipe_usage
      exit 0
      ;;
    -*) recipe_refuse "unknown option '$argument'; see --help" ;;
    *) arguments+=("$argument") ;;
  esac
done
wanted=$([ -n "${recipe_needs:-}" ] && echo 2 || echo 1)
[ ${#arguments[@]} = "$wanted" ] ||
  recipe_refuse "expected $wanted arguments, found ${#arguments[@]}; see --help"
runs=${arguments[-1]}
# Of evaluations by the figures of Park et al. 2021.
recipe_actions=()
[ -z "${recipe_action_classifiers:-}" ] || recipe_actions=(--action-classifiers "$recipe_action_classifiers")
[ -z "${recipe_action_classifiers:-}" ] || [ "$smoke" = no ] || recipe_actions=(--action-classifiers 1)
data=${STYLED_DATA:-}
[ "$dry_run" = no ] || data=${data:-DIR}
bin=${STYLED_BIN:-$root/build/release/bin}
if [ "$dry_run" = no ]; then
  [ -n "$data" ] || recipe_refuse "STYLED_DATA is not set; expected the folder of the unpacked clips"
  # shellcheck disable=SC2086
  for folder in $recipe_sets $recipe_folders; do
    [ -d "$data/$folder" ] || recipe_refuse "STYLED_DATA: $data has no folder $folder; unpack the archives"
  done
  for program in styletrain styleeval stylebaseline; do
    [ -x "$bin/$program" ] || recipe_refuse "$bin/$program is missing; sim/setup.sh train builds it"
  done
  mkdir -p "$runs"
fi
# recipe_few_clips FROM TO: a folder of data with links to at most 5 takes of each act and style, the
# fewest of which the judges' share is one.
recipe_few_clips() {
  local folder file kind last='' count=0
  mkdir -p "$2"
  for folder in $recipe_sets; do
    mkdir -p "$2/$folder"
    for file in "$1/$folder"/*.bvh; do
      kind=${file%_*}
      [ "$kind" = "$last" ] || count=0
      last=$kind count=$((count + 1))
      [ $count -gt 5 ] || ln -sf "$(realpath "$file")" "$2/$folder/"
    done
  done
  for folder in $recipe_folders; do
    ln -sfn "$(realpath "$1/$folder")" "$2/$folder"
  done
}
if [ "$smoke" = yes ] && [ "$dry_run" = no ]; then
  recipe_few_clips "$data" "$runs/few"
  data=$runs/few
fi
export OMP_NUM_THREADS=${OMP_NUM_THREADS:-1} OMP_WAIT_POLICY=passive

recipe_run() {
  printf '%s' "${1##*/}"
  printf ' %q' "${@:2}"
  echo
  [ "$dry_run" = yes ] || "$@"
}

declare -A recipe_sessions=()  # of each run in this recipe: a resumed one continues
recipe_train() {  # recipe_train COMMAND... -- NAME LENGTH_OPTION LENGTH OPTIONS...
  local command=() length
  while [ "$1" != -- ]; do
    command+=("$1")
    shift
  done
  local run=$2
  length=("$3" "$4")
  shift 4
  if [ "$smoke" = yes ]; then
    recipe_sessions[$run]=$((${recipe_sessions[$run]:-0} + 2))
    length=(--iterations "${recipe_sessions[$run]}")
    set -- "$@" --log-every 1
    case " $* " in *" --classifier-iterations "* | *" --family "*) ;; *) set -- "$@" --classifier-iterations 2 ;; esac
  fi
  recipe_run "${command[@]}" --data "$data" --out "$runs/$run" "${length[@]}" "$@"
}
train() { recipe_train "$bin/styletrain" -- "$@"; }
add_style() { recipe_train "$bin/styletrain" add-style -- "$@"; }
evaluate() {
  if [ "$smoke" = yes ]; then
    local option options=() long=no
    for option in "$@"; do  # all but --long and its value
      if [ "$option" = --long ]; then
        long=yes
      elif [ "$long" = yes ]; then
        long=no
      else
        options+=("$option")
      fi
    done
    set -- "${options[@]}" --judge-iterations 2 --judge-seeds 2 --long 0
  fi
  recipe_run "$bin/styleeval" --data "$data" --cache "$runs/judges" "${recipe_actions[@]}" "$@"
}
write_judges() {
  [ "$smoke" = no ] || set -- "$@" --judge-iterations 2 --judge-seeds 2
  recipe_run "$bin/styleeval" --data "$data" --cache "$runs/judges" "$@"
}
baseline() {
  local run=$1
  shift
  [ "$smoke" = no ] || set -- "$@" --iterations 2 --judge-iterations 2 --judge-seeds 2
  recipe_run "$bin/stylebaseline" --data "$data" --cache "$runs/judges" --out "$runs/$run" \
    "${recipe_actions[@]}" "$@"
}
tabulate() { recipe_run "$root/model/train/recipes/table.py" "$@"; }

# The graph network of set 2, seven domains. The shipped weights were made with the first losses up to
# iteration 12,000.
train_st_gcn() {
  local run=(--minutes 70 --family st-gcn --manifest "$manifests/bandai-2.toml" --seed 1 --warm-up 3000
    --w-posture 10 --w-read 1.5)
  train st-gcn "${run[@]}" --stop-at 12000 --w-penalty 5 --w-smooth 0.1
  # Noises no further apart than they need to be, a calmer critic that counts for more, calmer motion.
  train st-gcn "${run[@]}" --resume --w-penalty 20 --w-smooth 0.7 --w-adversarial 2.5 --diversity-target 3
}
