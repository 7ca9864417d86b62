#!/usr/bin/env bash
# The figures of weights on set 2's test split, which is used once for the same weights: a line of model/weights/TESTED.tsv.
# JUDGES=FILE in the environment gives the judges of judges.sh; else they are trained first. Add AGAIN=1 to judge
# weights knowingly a second time.
recipe_needs='WEIGHTS '
. "$(dirname "$0")/recipe.sh"

judged=${arguments[0]}
[ -r "$judged" ] || recipe_refuse "$judged cannot be read; expected weights"
ledger=$weights/TESTED.tsv
[ "$smoke" = no ] || ledger=$runs/TESTED.tsv  # shows that the command works, and uses nothing
options=()
[ -z "${JUDGES:-}" ] || options+=(--judges "$JUDGES")
[ -z "${AGAIN:-}" ] || options+=(--again)
evaluate "${options[@]}" --weights "$judged" --manifest "$manifests/bandai-2.toml" --long 0 --split test \
  --ledger "$ledger" --commit "$(git -C "$root" rev-parse --short=12 HEAD)" --json "$runs/test.json"
