#!/usr/bin/env bash
# Breaks the source in one place at a time and checks that the tests notice. Options:
#   NAME...      these breaks of tests/mutants.txt only; names may be shell patterns ('erd-*')
#   --list       prints names, files and tests
#   --help       prints this
# All breaks that a test binary is to notice are built at once, each behind a question for the
# environment variable STYLED_MUTANT; without it the tests must pass, with it they must fail. The
# broken files are restored then, also after Ctrl-C; after a power cut the next call restores them.
# Needs a configured build/release. CI does not run it; tests/documents/test_mutants.py checks there
# that every break still applies.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
cd "$root"
table=tests/mutants.txt
build=build/release
work=build/mutants
usage() { sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "$0"; }

ulimit -c 0  # a failure ends a test binary by a signal

names=() files=() kinds=() olds=() news=() tests=()
read_table() {
  local lines i
  mapfile -t lines < <(grep -v '^#' "$table" | grep -v '^$')
  for ((i = 0; i < ${#lines[@]}; i += 5)); do
    if [[ "${lines[i + 2]:-}" != "  "[-=]" "* || "${lines[i + 3]:-}" != "  + "* || -z "${lines[i + 4]:-}" ]]; then
      echo "$table: '${lines[i]}' has not five lines: name, file, '  - ' or '  = ', '  + ', test" >&2
      exit 2
    fi
    names+=("${lines[i]}")
    files+=("${lines[i + 1]#  }")
    kinds+=("${lines[i + 2]:2:1}")
    olds+=("${lines[i + 2]:4}")
    news+=("${lines[i + 3]:4}")
    tests+=("${lines[i + 4]#  }")
  done
}

# How often the text $2 is in the text $1.
count() {
  local rest=${1//"$2"/}
  echo $(((${#1} - ${#rest}) / ${#2}))
}

# The first lines of every file with a break.
question='#ifndef STYLED_MUTANT
#define STYLED_MUTANT
#include <cstdlib>
#include <cstring>
static inline bool StyledMutant(const char* name) {
  static const char* const on = std::getenv("STYLED_MUTANT");
  return on != nullptr && std::strcmp(on, name) == 0;
}
#endif
'

# Puts break $1 into its file; 1 if its text is not there once, because of another break.
apply() {
  local i=$1 file=${files[$1]} text new
  text=$(<"$file")
  [ "$(count "$text" "${olds[i]}")" = 1 ] || return 1
  if [ ! -e "$work/originals/$file" ]; then
    mkdir -p "$work/originals/$(dirname "$file")"
    cp "$file" "$work/originals/$file"
    [ "${kinds[i]}" = = ] || text=$question$text
  fi
  new="(StyledMutant(\"${names[i]}\") ? (${news[i]}) : (${olds[i]}))"
  [ "${kinds[i]}" = - ] || new=${news[i]}
  printf '%s\n' "${text/"${olds[i]}"/"$new"}" >"$file"
}

restore() {  # puts back what is broken now; its time is now, so that the next build compiles it
  [ -d "$work/originals" ] || return 0
  local file
  (cd "$work/originals" && find . -type f) | while read -r file; do cp "$work/originals/$file" "$file"; done
  rm -rf "$work/originals"
}

running=
stop() {  # no binary of broken source stays behind
  [ -z "$running" ] || rm -f "$build/bin/$running"
  restore
}

build_target() { nice ninja -C "$build" "$1" >"$work/build.log" 2>&1; }

# Runs the test of break $1 with STYLED_MUTANT=$2, up to the first failure. Bash's own line about
# the signal is left out.
run_test() {
  STYLED_MUTANT=$2 timeout 300 nice "$build/bin/${tests[$1]%% *}" --gtest_filter="${tests[$1]#* }" \
    --gtest_break_on_failure >"$work/test.log" 2>&1
} 2>/dev/null

caught=0 survived=() unbuilt=() skipped=0
say() {  # say BREAK RESULT SECONDS
  printf '%-40s %-16s %4d s\n' "${names[$1]}" "$2" "$3"
}

# Tries the breaks $@, which are in the tree and have one binary.
try() {
  local i from result
  declare -A clean=()
  running=${tests[$1]%% *}
  from=$SECONDS
  if ! build_target "$running"; then
    for i in "$@"; do
      say "$i" 'DID NOT BUILD' $((SECONDS - from))
      unbuilt+=("${names[i]}")
    done
    grep -m 3 'error:' "$work/build.log" || true
    restore
    return
  fi
  echo "$running built in $((SECONDS - from)) s"
  for i in "$@"; do
    from=$SECONDS
    # Without a break the same tests pass and are some; a "=" break is always on.
    if [ "${kinds[i]}" = - ] && [ -z "${clean[${tests[i]}]:-}" ]; then
      if ! run_test "$i" '' || grep -q '^\[==========\] Running 0 tests' "$work/test.log"; then
        tail -n 20 "$work/test.log" >&2
        echo "${tests[i]}: expected tests that pass without a break" >&2
        exit 1
      fi
      clean[${tests[i]}]=passed
      grep -q '^\[       OK \]' "$work/test.log" || clean[${tests[i]}]=skipped
    fi
    if [ "${clean[${tests[i]}]:-}" = skipped ]; then
      result='skipped, no data'
      skipped=$((skipped + 1))
    elif run_test "$i" "${names[i]}"; then
      result=SURVIVED
      survived+=("${names[i]}")
    else
      result=caught
      caught=$((caught + 1))
    fi
    say "$i" "$result" $((SECONDS - from))
  done
  restore
}

read_table
if [ "${1:-}" = --help ]; then
  usage
  exit
fi
if [ "${1:-}" = --list ]; then
  for i in "${!names[@]}"; do printf '%-40s %-38s %s\n' "${names[i]}" "${files[i]}" "${tests[i]}"; done
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
exec 9>"$work/lock"
if ! flock -n 9; then
  echo "another tests/mutants.sh runs in this tree" >&2
  exit 1
fi
if [ -d "$work/originals" ]; then
  echo 'restoring what an interrupted run left broken:'
  (cd "$work/originals" && find . -type f)
  restore
fi
trap stop EXIT
trap 'exit 130' INT TERM

# 1. Every break applies.
for i in "${chosen[@]}"; do
  times=$(count "$(<"${files[i]}")" "${olds[i]}")
  if [ "$times" != 1 ]; then
    echo "mutant ${names[i]} no longer applies: ${files[i]} has its text $times times, expected once:" >&2
    echo "  ${olds[i]}" >&2
    exit 1
  fi
done

# 2. By binary: as many breaks at once as do not touch the same text, then those of any text.
begun=$SECONDS
for binary in $(for i in "${chosen[@]}"; do echo "${tests[i]%% *}"; done | awk '!seen[$0]++'); do
  waiting=() alone=()
  for i in "${chosen[@]}"; do
    [ "${tests[i]%% *}" = "$binary" ] || continue
    if [ "${kinds[i]}" = - ]; then waiting+=("$i"); else alone+=("$i"); fi
  done
  while [ ${#waiting[@]} -gt 0 ]; do
    together=() later=()
    for i in "${waiting[@]}"; do
      if apply "$i"; then together+=("$i"); else later+=("$i"); fi
    done
    try "${together[@]}"
    waiting=("${later[@]}")
  done
  for i in "${alone[@]}"; do
    apply "$i"
    try "$i"
  done
done

# 3. The binaries without a break, so that ctest does not run a broken one.
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
