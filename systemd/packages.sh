#!/usr/bin/env bash
# Builds the Debian packages: styled, styled-tools, styled-web, libstyled-client-dev, python3-styled. And
# a signed apt repository of them in build/apt (systemd/repository.sh).
#   systemd/packages.sh [--key ID] [--url URL] [BUILD [CMAKE OPTIONS...]]
#     --key, --url  as of systemd/repository.sh
#     BUILD         the build folder, new or existing; default build/package. The packages are written there.
# Installs what is missing (sim/setup.sh). DEBFULLNAME and DEBEMAIL, if set, name the maintainer.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/sim/setup.sh"
repository=()
while [[ "${1:-}" == --* ]]; do
  case $1 in
    --key | --url) repository+=("$1" "${2:?$1: expected a value}"); shift 2 ;;
    *) echo "packages.sh: expected --key ID or --url URL, found $1" >&2; exit 2 ;;
  esac
done
styled_install package
build=$(realpath -m "${1:-$root/build/package}")
mkdir -p "$(dirname "$build")"
[ $# -gt 0 ] && shift
if [ -n "${DEBEMAIL:-}" ]; then
  set -- "-DSTYLED_PACKAGE_MAINTAINER=${DEBFULLNAME:-Styled maintainers} <$DEBEMAIL>" "$@"
fi
cmake -S "$root" --preset release -B "$build" -DCMAKE_INSTALL_PREFIX=/usr \
  -DSTYLED_UNITY=ON -DSTYLED_TRAIN=OFF -DSTYLED_TESTS=OFF "$@" >"$build-cmake.log" 2>&1 || { tail -n 40 "$build-cmake.log" >&2; exit 1; }
targets=(styled stylectl stylemon stylesim stylerec stylevmc stylenats styleweb stylize styled_client styled_python styled_blender styled_man)
[ -n "$(command -v npm)" ] && targets+=(styleweb_page)
cmake --build "$build" --target "${targets[@]}"
rm -f "$build"/*.deb
(cd "$build" && cpack -G DEB --config CPackConfig.cmake >cpack.log 2>&1) || { tail -n 40 "$build/cpack.log" >&2; exit 1; }
ls "$build"/*.deb
"$root/systemd/repository.sh" "${repository[@]}" "$build"
