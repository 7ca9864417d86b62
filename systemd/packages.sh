#!/usr/bin/env bash
# Builds the Debian packages (daemon/OPERATING.md lists them), their bill of materials (systemd/sbom.py), and a signed apt
# repository of them in build/apt (systemd/repository.sh).
#   systemd/packages.sh [--train | --arm64] [--key ID] [--url URL] [BUILD [CMAKE OPTIONS...]]
#     --train       styled-train, too: installs libtorch (0.9 GB)
#     --arm64       for ARM64, in a chroot with Debian's cross compiler and libraries (tests/arm64.sh --packages)
#     --key, --url  as of systemd/repository.sh
#     BUILD         the build folder, new or existing; default build/package. The packages are written there.
# Installs what is missing (sim/setup.sh). DEBFULLNAME and DEBEMAIL, if set, name the maintainer.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/sim/setup.sh"
repository=()
train=OFF
preset=release
while [[ "${1:-}" == --* ]]; do
  case $1 in
    --key | --url) repository+=("$1" "${2:?$1: expected a value}"); shift 2 ;;
    --train) train=ON; shift ;;
    --arm64) preset=arm64; shift ;;
    *) echo "packages.sh: expected --train, --arm64, --key ID or --url URL, found $1" >&2; exit 2 ;;
  esac
done
if [ $preset = arm64 ]; then
  [ $train = OFF ] || { echo "packages.sh: --train: not with --arm64: libtorch is not among the cross compiler's libraries" >&2; exit 2; }
  command -v aarch64-linux-gnu-g++ >/dev/null || { echo "packages.sh: --arm64: no aarch64-linux-gnu-g++; tests/arm64.sh --packages makes a chroot that has it" >&2; exit 1; }
  export DEB_HOST_ARCH=arm64  # for dpkg-shlibdeps
  set -- "${1:-$root/build/package-arm64}" -DCMAKE_INSTALL_LIBDIR=lib/aarch64-linux-gnu "${@:2}"
elif [ $train = ON ]; then
  styled_install package_train
else
  styled_install package
fi
build=$(realpath -m "${1:-$root/build/package}")
mkdir -p "$(dirname "$build")"
[ $# -gt 0 ] && shift
if [ -n "${DEBEMAIL:-}" ]; then
  set -- "-DSTYLED_PACKAGE_MAINTAINER=${DEBFULLNAME:-Styled maintainers} <$DEBEMAIL>" "$@"
fi
cmake -S "$root" --preset $preset -B "$build" -DCMAKE_INSTALL_PREFIX=/usr \
  -DSTYLED_UNITY=ON -DSTYLED_TRAIN=$train -DSTYLED_TESTS=OFF "$@" >"$build-cmake.log" 2>&1 || { tail -n 40 "$build-cmake.log" >&2; exit 1; }
targets=(styled stylectl stylemon stylesim stylerec stylevmc stylenats styleoscquery styleweb stylize styled_client styled_python styled_blender styled_man)
[ $train = OFF ] || targets+=(styletrain styleeval styleunseen stylerefine styleacts stylestrip)
if grep -q '^set(CPACK_COMPONENTS_ALL.*library' "$build/CPackConfig.cmake"; then targets+=(styled_library); fi
[ -n "$(command -v npm)" ] && targets+=(styleweb_page)
cmake --build "$build" --target "${targets[@]}"
rm -f "$build"/*.deb "$build"/*.spdx.json
(cd "$build" && cpack -G DEB --config CPackConfig.cmake >cpack.log 2>&1) || { tail -n 40 "$build/cpack.log" >&2; exit 1; }
deb=$(echo "$build"/styled_*.deb)
python3 -B "$root/systemd/sbom.py" "$build" "$build" >"$build/sbom-$(dpkg-deb -f "$deb" Version)-$(dpkg-deb -f "$deb" Architecture).spdx.json"
ls "$build"/*.deb "$build"/*.spdx.json
"$root/systemd/repository.sh" "${repository[@]}" "$build"
