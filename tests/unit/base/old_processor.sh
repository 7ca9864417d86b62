#!/usr/bin/env bash
# A program on a processor without AVX2, emulated by QEMU: old_processor.sh BUILD ARCH COMPILER SOURCE. It
# ends with a sentence and code 1, where it would end by SIGILL; libstyled says the same and lets its program
# go on. On a processor that has all of it nothing is refused. Code 77: skipped.
set -euo pipefail
build=$1 arch=$2 compiler=$3 source=$4
[ "$arch" = x86-64-v3 ] || { echo "skipped: built for '$arch', not for x86-64-v3"; exit 77; }
command -v qemu-x86_64 >/dev/null || { echo "skipped: there is no qemu-x86_64 (package qemu-user)"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
sentence="this processor has no AVX2, which this build needs; expected x86-64-v3, or a build with -DSTYLED_ARCH=x86-64-v2"

programs=0
for program in "$build"/bin/styl*; do
  case "$(basename "$program")" in *_test | *_bench | *_fuzz | styled_*) continue ;; esac
  [ -x "$program" ] || continue
  code=0
  qemu-x86_64 -cpu Nehalem "$program" --version >"$work/out" 2>"$work/error" || code=$?
  grep -v '^qemu-x86_64: warning:' "$work/error" >"$work/said" || true
  if [ "$code" != 1 ] || [ "$(cat "$work/said")" != "$(basename "$program"): $sentence" ]; then
    echo "$program: code $code, expected 1; it said:" >&2
    cat "$work/error" >&2
    exit 1
  fi
  programs=$((programs + 1))
done
[ "$programs" -gt 0 ] || { echo "no programs in $build/bin" >&2; exit 1; }

# The library's static objects are made, or the program would not come as far as its answer.
"$compiler" -x c -I "$source/model/library" "$source/model/library/example.c" -x none -L "$build/bin" -L "$build/model/library" \
  -lstyled -lm -o "$work/example"
code=0
LD_LIBRARY_PATH="$build/bin:$build/model/library" qemu-x86_64 -cpu Nehalem "$work/example" zombie \
  >"$work/out" 2>"$work/error" || code=$?
if [ "$code" -ge 126 ] || ! grep -qF "$sentence" "$work/error"; then
  echo "libstyled: code $code; it said:" >&2
  cat "$work/error" >&2
  exit 1
fi
# Control: with all instructions there is no refusal.
stylectl=$build/bin/stylectl
[ ! -x "$stylectl" ] || "$stylectl" --version
echo "$programs programs and libstyled refuse a processor without AVX2"
