#!/usr/bin/env bash
# Checks the files that git tracks: format, self-contained headers, layer rules, words, and the longest and
# the repeated pieces. Needs build/release configured, with the tests and its generated headers built.
#   tests/lint.sh             all of that
#   tests/lint.sh --tidy      clang-tidy over the product (libtorch's users excepted: minutes each)
#   tests/lint.sh --changed   clang-tidy over at most 20 sources that changed since origin/main, or where
#                             there is none since the commit before
set -uo pipefail
cd "$(dirname "$0")/.."
build=build/release

tidy() {  # tidy < sources
  command -v clang-tidy-16 >/dev/null || {
    cat >/dev/null  # else the writer dies of a broken pipe
    echo "clang-tidy: skipped, there is no clang-tidy-16"
    return 0
  }
  xargs -r -P 2 -n 4 clang-tidy-16 -p build/sources --quiet >build/tidy.log 2>/dev/null
  ! grep -E '(error|warning):' build/tidy.log | sort -u | head -40 | grep .
}

sources() {  # of stdin: what has a compile command here
  grep '\.cpp$' | grep '^model/\|^daemon/\|^clients/\|^sim/\|^proto/rigs/' |
    grep -v '^model/train/\|styletrain\|styleeval\|stylebaseline' | while read -r file; do
    ! grep -qF "\"$PWD/$file\"" build/sources/compile_commands.json || echo "$file"
  done
}

case "${1:-}" in
  --tidy | --changed) tests/source_commands.sh || exit ;;
esac
case "${1:-}" in
  --tidy)
    git ls-files '*.cpp' | sources | tidy
    exit
    ;;
  --changed)
    base=$(git merge-base HEAD origin/main 2>/dev/null || git rev-parse HEAD~1) || exit 0
    changed=$(git diff --name-only --diff-filter=d "$base" | sources)
    echo "clang-tidy: ${changed:+$(wc -l <<<"$changed") }sources changed since $(git rev-parse --short "$base")"
    head -n 20 <<<"$changed" | tidy
    exit
    ;;
esac

bad=0
if command -v clang-format-16 >/dev/null; then
  git ls-files -z '*.h' '*.cpp' | xargs -0 clang-format-16 --dry-run -Werror || bad=1
else
  echo "format: skipped, there is no clang-format-16, and other versions format differently"
fi
python3 -B tests/headers.py "$build" || bad=1
printf 'layers: '
python3 -B tests/layers.py || bad=1
printf 'types of a frame: '
python3 -B tests/frame_types.py | tail -1
[ "${PIPESTATUS[0]}" = 0 ] || bad=1
echo 'words:'
python3 -B tests/words.py || bad=1
python3 -B tests/sizes.py
exit $bad
