#!/usr/bin/env bash
# Breaks the source in one place at a time and looks whether the tests notice. Options:
#   NAME...      these breaks of tests/mutants.txt only; names may be shell patterns ('erd-*')
#   --list       prints names, files and tests
#   --help       prints this
# A break is in the tree while its test binary is built and run, then its file is restored, also
# after Ctrl-C; after a power cut the next call restores it. Needs a configured build/release.
# tests/documents/test_mutants.py checks in CI that every break still applies. Not for CI itself: a
# break takes half a minute to two.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
cd "$root"
table=tests/mutants.txt
build=build/release
work=build/mutants
usage() { sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "$0"; }

names=() files=() olds=() news=() tests=()
read_table() {  # five lines each: name, file, "- " old text, "+ " new text, test binary and filter
  local lines i=0
  mapfile -t lines < <(grep -v '^#' "$table" | grep -v '^$')
  while [ "$i" -lt "${#lines[@]}" ]; do
    if [[ "${lines[i + 2]:-}" != "  - "* || "${lines[i + 3]:-}" != "  +"* || -z "${lines[i + 4]:-}" ]]; then
      echo "$table: '${lines[i]}' has not five lines: name, file, '  - ', '  + ', test" >&2
      exit 2
    fi
    names+=("${lines[i]}")
    files+=("${lines[i + 1]#  }")
    olds+=("${lines[i + 2]#  - }")
    local new=${lines[i + 3]#  +}
    news+=("${new# }")
    tests+=("${lines[i + 4]#  }")
    i=$((i + 5))
  done
}

# How often the text $2 is in the file $1.
count_in() {
  local text rest
  text=$(<"$1")
  rest=${text//"$2"/}
  echo $(((${#text} - ${#rest}) / ${#2}))
}

restore() {  # puts back the file that is broken now
  if [ -e "$work/path" ]; then
    cp "$work/original" "$(<"$work/path")"  # its time is now, so that the next build compiles it
    rm -f "$work/path" "$work/original"
  fi
}

running=
stop() {  # no binary of broken source stays behind
  [ -z "$running" ] || rm -f "$build/bin/$running"
  restore
}

build_target() { nice ninja -C "$build" "$1" >"$work/build.log" 2>&1; }

# Runs a test binary by "BINARY FILTER"; its output is in $work/test.log. 0: all passed; 1: failed.
run_test() {
  local binary=${1%% *} filter=${1#* }
  timeout 300 nice "$build/bin/$binary" --gtest_filter="$filter" >"$work/test.log" 2>&1
}

read_table
if [ "${1:-}" = --help ]; then
  usage
  exit
fi
if [ "${1:-}" = --list ]; then
  for i in "${!names[@]}"; do printf '%-36s %-44s %s\n' "${names[i]}" "${files[i]}" "${tests[i]}"; done
  exit
fi
chosen=()
for i in "${!names[@]}"; do
  if [ $# = 0 ]; then chosen+=("$i"); fi
  for pattern in "$@"; do
    # shellcheck disable=SC2053
    if [[ ${names[i]} == $pattern ]]; then chosen+=("$i") && break; fi
  done
done
for pattern in "$@"; do
  # shellcheck disable=SC2053
  for i in "${!names[@]}"; do [[ ${names[i]} == $pattern ]] && continue 2; done
  echo "no mutant '$pattern', expected names of --list" >&2
  exit 2
done

mkdir -p "$work"
if [ -e "$work/path" ]; then
  echo "restoring $(<"$work/path"), which an interrupted run left broken"
  restore
fi
trap stop EXIT
trap 'exit 130' INT TERM

# 1. Every break applies.
for i in "${chosen[@]}"; do
  times=$(count_in "${files[i]}" "${olds[i]}")
  if [ "$times" != 1 ]; then
    echo "mutant ${names[i]} no longer applies: ${files[i]} has its text $times times, expected once:" >&2
    echo "  ${olds[i]}" >&2
    exit 1
  fi
done

# 2. Without a break every test passes and runs something.
declare -A without_data=()
for test in $(for i in "${chosen[@]}"; do echo "${tests[i]// /@}"; done | sort -u); do
  test=${test//@/ }
  if ! build_target "${test%% *}"; then
    tail -n 20 "$work/build.log" >&2
    echo "${test%% *} does not build without a break" >&2
    exit 1
  fi
  if ! run_test "$test" || grep -q '^\[==========\] 0 tests' "$work/test.log"; then
    tail -n 20 "$work/test.log" >&2
    echo "$test: expected tests that pass without a break" >&2
    exit 1
  fi
  if ! grep -q '^\[       OK \]' "$work/test.log"; then without_data[$test]=1; fi
done

# 3. Each break.
caught=0 survived=() unbuilt=() skipped=0
begun=$SECONDS
for i in "${chosen[@]}"; do
  test=${tests[i]}
  from=$SECONDS
  if [ -n "${without_data[$test]:-}" ]; then
    result='skipped, no data'
    skipped=$((skipped + 1))
  else
    text=$(<"${files[i]}")
    running=${test%% *}
    cp "${files[i]}" "$work/original"
    echo "${files[i]}" >"$work/path"
    printf '%s\n' "${text/"${olds[i]}"/"${news[i]}"}" >"${files[i]}"
    if ! build_target "$running"; then
      result='DID NOT BUILD'
      unbuilt+=("${names[i]}")
    elif run_test "$test"; then
      result=SURVIVED
      survived+=("${names[i]}")
    else
      result=caught
      caught=$((caught + 1))
    fi
    restore
  fi
  printf '%-36s %-16s %4d s\n' "${names[i]}" "$result" $((SECONDS - from))
done
# The binaries without a break, so that ctest does not run a broken one.
for binary in $(for i in "${chosen[@]}"; do echo "${tests[i]%% *}"; done | sort -u); do
  build_target "$binary"
done
running=
tried=$((${#chosen[@]} - skipped))
echo "$caught of $tried mutants caught, ${#survived[@]} survived, ${#unbuilt[@]} did not build," \
  "$skipped skipped, $(((SECONDS - begun + 30) / 60)) min"
[ ${#survived[@]} = 0 ] || echo "survived: ${survived[*]}"
[ ${#unbuilt[@]} = 0 ] || echo "did not build: ${unbuilt[*]}"
[ ${#survived[@]} = 0 ] && [ ${#unbuilt[@]} = 0 ]
