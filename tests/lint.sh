#!/usr/bin/env bash
# Format and self-contained headers over what git tracks; with --tidy, clang-tidy instead (the
# trainer's sources excepted: libtorch's headers take minutes each). Needs build/release configured.
set -uo pipefail
cd "$(dirname "$0")/.."
build=build/release

if [ "${1:-}" = --tidy ]; then
  git ls-files 'model/*.cpp' 'daemon/*.cpp' 'clients/*.cpp' 'sim/*.cpp' 'proto/rigs/*.cpp' |
    grep -v '^model/train/\|styletrain\|styleeval' |
    xargs -P 2 -n 4 clang-tidy-16 -p "$build" --quiet >build/tidy.log 2>/dev/null
  ! grep -E '(error|warning):' build/tidy.log | sort -u | head -40 | grep .
  exit $?
fi

bad=0
git ls-files -z '*.h' '*.cpp' | xargs -0 clang-format-16 --dry-run -Werror || bad=1
check_header() {
  echo "#include \"$2\"" |
    g++ -std=c++20 -march=x86-64-v3 -fsyntax-only -I. -I"$1/generated" -isystem /usr/include/eigen3 \
      -x c++ - || { echo "header is not self-contained: $2"; return 1; }
}
export -f check_header
git ls-files '*.h' | grep -v '^model/train/' |
  xargs -P 2 -I{} bash -c 'check_header "$0" {}' "$build" || bad=1
exit $bad
