#!/usr/bin/env bash
# Over what git tracks: format, layer rules, and the longest and the repeated pieces. Needs
# build/release configured, with the tests and its generated headers built.
#   tests/lint.sh             all of that, and that each header that changed stands alone
#   tests/lint.sh --headers   that every header stands alone (ten minutes)
#   tests/lint.sh --tidy      clang-tidy over the product (libtorch's users excepted: minutes each)
#   tests/lint.sh --changed   clang-tidy over at most 20 sources that changed
# Changed is: since origin/main, or where there is none since the commit before.
set -uo pipefail
cd "$(dirname "$0")/.."
build=build/release

tidy() {  # tidy < sources
  xargs -r -P 2 -n 4 clang-tidy-16 -p build/sources --quiet >build/tidy.log 2>/dev/null
  ! grep -E '(error|warning):' build/tidy.log | sort -u | head -40 | grep .
}

sources() {  # of stdin: what has a compile command here
  grep '\.cpp$' | grep '^model/\|^daemon/\|^clients/\|^sim/\|^proto/rigs/' |
    grep -v '^model/train/\|styletrain\|styleeval\|stylebaseline' | while read -r file; do
    ! grep -qF "\"$PWD/$file\"" build/sources/compile_commands.json || echo "$file"
  done
}

changed() {  # changed PATTERN...: files of these patterns that changed
  local base
  base=$(git merge-base HEAD origin/main 2>/dev/null || git rev-parse HEAD~1) || return 0
  git diff --name-only --diff-filter=d "$base" -- "$@"
}

check_header() {
  echo "#include \"$2\"" |
    g++ -std=c++20 -march=x86-64-v3 -fsyntax-only -I. -I"$1/generated" -isystem /usr/include/eigen3 \
      -x c++ - || { echo "header is not self-contained: $2"; return 1; }
}
export -f check_header
check_headers() {  # check_headers < headers
  { grep -v '^model/train/\|_torch\.h$' || true; } | xargs -r -P 2 -I{} bash -c 'check_header "$0" {}' "$build"
}

case "${1:-}" in
  --tidy)
    tests/source_commands.sh || exit
    git ls-files '*.cpp' | sources | tidy
    exit
    ;;
  --changed)
    tests/source_commands.sh || exit
    changed=$(changed '*.cpp' | sources)
    echo "clang-tidy: ${changed:+$(wc -l <<<"$changed") }sources changed"
    head -n 20 <<<"$changed" | tidy
    exit
    ;;
  --headers)
    git ls-files '*.h' | check_headers
    exit
    ;;
esac

bad=0
git ls-files -z '*.h' '*.cpp' | xargs -0 clang-format-16 --dry-run -Werror || bad=1
changed '*.h' | check_headers || bad=1
printf 'layers: '
python3 -B tests/layers.py || bad=1
python3 -B tests/sizes.py
exit $bad
