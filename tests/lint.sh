#!/usr/bin/env bash
# Format, self-contained headers and clang-tidy over what git tracks.
set -uo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
cd "$root"
build=build/release
bad=0

mapfile -t files < <(git ls-files '*.h' '*.cpp')
clang-format-16 --dry-run -Werror "${files[@]}" || bad=1

# Every header compiles on its own. Headers of the trainer need libtorch and take 20 s each: they are
# compiled by their own sources, which include them first.
check_header() {
  g++ -std=c++20 -fsyntax-only -x c++ -I. -I"$1/generated" -isystem /usr/include/eigen3 "$2" ||
    { echo "header is not self-contained: $2"; return 1; }
}
export -f check_header
git ls-files '*.h' | grep -v '^model/train/' |
  xargs -P 2 -I{} bash -c 'check_header "$0" {}' "$build" || bad=1

mapfile -t tidy < <(git ls-files 'model/*.cpp' 'daemon/*.cpp' 'clients/*.cpp' 'sim/*.cpp' \
  'proto/rigs/*.cpp' | grep -v '^model/train/\|styletrain\|styleeval')
printf '%s\n' "${tidy[@]}" |
  xargs -P 2 -n 4 clang-tidy-16 -p "$build" --quiet 2>/dev/null >build/tidy.log
if grep -q 'error:\|warning:' build/tidy.log; then
  grep -E 'error:|warning:' build/tidy.log | sort -u | head -40
  bad=1
fi
exit $bad
