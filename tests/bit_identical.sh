#!/usr/bin/env bash
# Compares the motion that this tree computes with the motion of an older commit, byte by byte.
#   tests/bit_identical.sh COMMIT     builds COMMIT below build/before and compares build/release
#   tests/bit_identical.sh --control  negative control: compares this tree with itself at another
#                                     strength and fails unless every styled output differs
# Compared are the replay of each golden recording through the daemon, and the BVH that `stylize`
# makes of up to four clips of $STYLED_DATA with each style of the shipped weights, with a mix, with
# parts of the body, and with the paper's output. Without the data only the replays are compared.
# A change of structure must leave all of them as they are.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
cd "$root"
data=${STYLED_DATA:-$root/../shared/data}
new=$root/build/release/bin
case "${1:-}" in
  "" | -h | --help) sed -n '2,10s/^# \{0,1\}//p' "$0"; exit 2 ;;
esac
for program in styled stylize; do
  [ -x "$new/$program" ] || { echo "$new/$program is missing: build first" >&2; exit 1; }
done

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
old_strength=1
if [ "$1" = --control ]; then
  old=$new
  old_strength=0.9
else
  commit=$(git rev-parse --verify "$1^{commit}")
  before=$root/build/before
  if [ ! -e "$before/.git" ]; then
    git worktree prune
    git worktree add --quiet --detach "$before" "$commit"
  fi
  git -C "$before" checkout --quiet --detach "$commit"
  echo "building $(git log -1 --format='%h %s' "$commit")"
  (cd "$before" && cmake --preset release -DSTYLED_UNITY=ON -DSTYLED_TESTS=OFF -DSTYLED_TRAIN=OFF &&
    cmake --build --preset release --target styled stylize) >build/before.log 2>&1 ||
    { tail -n 20 build/before.log >&2; exit 1; }
  old=$before/build/release/bin
fi

same=0
differs=()
compare() {  # compare NAME: $work/old and $work/new
  if cmp -s "$work/old" "$work/new"; then same=$((same + 1)); else differs+=("$1"); fi
}

if [ "$1" != --control ]; then  # a recording holds its own commands: nothing to change there
  for recording in tests/golden/recordings/*.styrec; do
    rm -f "$work/old" "$work/new"
    for side in old new; do
      "${!side}/styled" --replay "$recording" --replay-to "$work/$side" >"$work/log" 2>&1 ||
        { echo "$side: replay of $recording failed:" >&2; cat "$work/log" >&2; exit 1; }
    done
    compare "replay of $(basename "$recording")"
  done
fi

mapfile -t styles < <("$new/stylize" --list | tr ',' '\n' | tr -d ' ' | grep -v '^neutral$')
clips=()
for clip in samples/dataset-1_walk_normal_001 samples/dataset-1_kick_normal_001 \
  samples/dataset-2_run_normal_001 xia/neutral_01_000; do
  [ -e "$data/$clip.bvh" ] && clips+=("$data/$clip.bvh")
done
[ ${#clips[@]} -gt 0 ] || echo "stylize: skipped, no data"
stylize_both() {  # stylize_both CLIP OPTIONS...
  local clip=$1 side strength
  shift
  for side in old new; do
    strength=1
    [ "$side" = new ] || strength=$old_strength
    "${!side}/stylize" --weights model/weights/v2.safetensors --strength "$strength" "$@" "$clip" \
      "$work/$side.bvh" >"$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }
    mv "$work/$side.bvh" "$work/$side"
  done
  compare "stylize $* $(basename "$clip")"
}
for clip in "${clips[@]}"; do
  for style in "${styles[@]}"; do stylize_both "$clip" --style "$style"; done
  stylize_both "$clip" --mix "${styles[0]}=0.5" --mix "${styles[3]}=0.7"
  stylize_both "$clip" --style "${styles[1]}" --only arms
  stylize_both "$clip" --style "${styles[2]}" --absolute
  stylize_both "$clip" --style "${styles[4]}" --no-feet
done

if [ "$1" = --control ]; then
  echo "control: $same outputs the same, ${#differs[@]} differ"
  [ "$same" = 0 ] && [ ${#differs[@]} -gt 0 ]
  exit
fi
for name in "${differs[@]}"; do echo "differs: $name"; done
echo "$((same + ${#differs[@]})) outputs compared, $same the same, ${#differs[@]} differ"
[ ${#differs[@]} = 0 ]
