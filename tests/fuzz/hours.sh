#!/usr/bin/env bash
# Fuzzes every parser with libFuzzer under ASan and UBSan, for as long as you like:
#   tests/fuzz/hours.sh [MINUTES=10 [JOBS=1 [TARGET...]]]
# MINUTES per target, JOBS at once. Interesting inputs stay in build/fuzz/corpus, from where the
# next run continues; build/fuzz/hours.tsv lists every run: time, target, seconds, inputs, coverage,
# exit code. It ends with a table of all runs so far. Exit code 1 if a failing input was found: it
# is stored in build/fuzz/found/TARGET, with a log beside it. STYLED_CMAKE: more options for CMake.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
minutes=${1:-10} jobs=${2:-1}
[ $# -gt 2 ] && targets=("${@:3}") || targets=()

. "$root/sim/setup.sh"
# The first that the system has: Debian 12 has no 19, Debian 13 no 16.
styled_packages_fuzz=("${styled_packages_test[@]}" "clang-16|clang-19|clang-18" "libclang-rt-16-dev|libclang-rt-19-dev|libclang-rt-18-dev")
styled_install fuzz
clang=$(type -P clang++-16 clang++-19 clang++-18 | head -n 1)
build=$root/build/fuzz
mkdir -p "$build"
cmake -S "$root" -B "$build" -G Ninja "-DCMAKE_CXX_COMPILER=$clang" -DCMAKE_BUILD_TYPE=RelWithDebInfo \
  -DSTYLED_UNITY=ON -DSTYLED_TESTS=ON -DSTYLED_TRAIN=OFF -DSTYLED_LIBFUZZER=ON \
  -DSTYLED_SANITIZE=address,undefined,fuzzer-no-link \
  -DCMAKE_CXX_FLAGS=-fno-sanitize-recover=undefined ${STYLED_CMAKE:-} >"$build.log" 2>&1 || {
  tail -n 20 "$build.log" >&2
  exit 1
}
# The targets from ctest: the command line of each ends with its seeds.
list=$build/targets.json
look() { (cd "$build" && ctest -N --show-only=json-v1 -L fuzz) >"$list"; }
look
ask() { # EXPRESSION, a list of words, over `name` and `command` of each target
  python3 - "$list" "$1" <<'PY'
import json, sys
for test in json.load(open(sys.argv[1]))['tests']:
    name, command = test['name'], test.get('command', [])
    for word in eval(sys.argv[2]):
        print(word)
PY
}
known=$(ask '[name] if name.endswith("_fuzz") else []')
seeds='_seeds$'
[ ${#targets[@]} -gt 0 ] && seeds="^($(IFS='|' && echo "${targets[*]/%_fuzz/_seeds}"))\$"
[ ${#targets[@]} -gt 0 ] || mapfile -t targets <<<"$known"
for target in "${targets[@]}"; do
  grep -qx -- "$target" <<<"$known" || {
    echo "$target: no such target; expected one of" $known >&2
    exit 2
  }
done
# A target also builds the program that writes its seeds.
if ! { ninja -C "$build" "${targets[@]}" && (cd "$build" && ctest -R "$seeds"); } >>"$build.log" 2>&1; then
  tail -n 20 "$build.log" >&2
  exit 1
fi
look  # built targets now have a command line

fuzz() {
  local target=$1 corpus=$build/corpus/$1 found=$build/found/$1 code=0 begin=$SECONDS
  mkdir -p "$corpus" "$found"
  local places
  mapfile -t places < <(ask "[word for word in command[1:] if name == '$target' and \
    not word.startswith('-') and '/corpus/' not in word]")
  local log=$found/$(date -u +%Y%m%dT%H%M%S).log
  "$build/bin/$target" -max_total_time=$((minutes * 60)) -rss_limit_mb=4096 -timeout=25 \
    -print_final_stats=1 -artifact_prefix="$found/" "$corpus" "${places[@]}" >"$log" 2>&1 || code=$?
  local runs cover
  runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
  cover=$(grep -o 'cov: [0-9]*' "$log" | tail -n 1 | cut -d' ' -f2)
  printf '%s\t%s\t%s\t%s\t%s\t%s\n' "$(date -u +%FT%TZ)" "$target" $((SECONDS - begin)) "${runs:-0}" \
    "${cover:-0}" "$code" >>"$build/hours.tsv"
  echo "$target: ${runs:-0} inputs, coverage ${cover:-0}, exit code $code"
  [ "$code" = 0 ] && rm "$log"
  return 0
}
for target in "${targets[@]}"; do
  while [ "$(jobs -rp | wc -l)" -ge "$jobs" ]; do wait -n; done
  fuzz "$target" &
done
wait

printf '\n%-18s %9s %14s %9s %s\n' target minutes inputs coverage failed
awk -F'\t' '{ s[$2] += $3; n[$2] += $4; if ($5 > c[$2]) c[$2] = $5; if ($6) f[$2]++; all += $3 }
  END { for (t in s) printf "%-18s %9.1f %14d %9d %d\n", t, s[t] / 60, n[t], c[t], f[t]
        printf "%-18s %9.1f\n", "together", all / 60 }' "$build/hours.tsv" | sort
[ -z "$(find "$build/found" -type f ! -name '*.log' -print -quit 2>/dev/null)" ]
