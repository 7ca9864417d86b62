#!/usr/bin/env bash
# The figures of the model card for any weights: judged as live on set 2, after a minute and after ten
# minutes, disturbed inputs and rigs' rates; then, where the weights have the styles of set 1, on set 1
# from its own neutral and from set 2's.
recipe_needs='WEIGHTS '
. "$(dirname "$0")/recipe.sh"

judged=${arguments[0]}
[ -r "$judged" ] || recipe_refuse "$judged cannot be read; expected weights"
set_2=(--weights "$judged" --manifest "$manifests/bandai-2.toml")
evaluate "${set_2[@]}" --long 60 --synthetic --robust --rates --styled-inputs --foreign --json "$runs/set-2.json" \
  --report "$runs/set-2.html"
evaluate "${set_2[@]}" --long 600 --json "$runs/set-2-long.json"
grep -aq swagger "$judged" || exit 0
set_1=(--weights "$judged" --manifest "$manifests/bandai-1.toml" --long 0)
evaluate "${set_1[@]}" --json "$runs/set-1.json"
evaluate "${set_1[@]}" --inputs "$manifests/bandai-2.toml" --json "$runs/set-1-of-set-2.json"
