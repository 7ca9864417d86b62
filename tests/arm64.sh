#!/usr/bin/env bash
# ARM64 without a machine that has it: a Debian 12 in a chroot made by debootstrap gets Debian's cross compiler and
# the libraries of arm64, builds the preset arm64 and runs its tests under qemu-aarch64: tests/arm64.sh [--packages FOLDER] [TARGET...]
#   --packages FOLDER  after the tests the Debian packages are built, installed in the chroot,
#            and a frame of a simulated performer is styled by the emulated daemon; FOLDER gets the packages
#   TARGET   what is built and tested (default: the unit tests of model/, the goldens, the library, stylize)
# Then one clip restyled there and on this machine (build/release/bin/stylize), and the largest difference. A compiler
# for 32 bits and a big-endian one must be refused. Needs root, debootstrap and some 5 GB below $STYLED_CHROOTS
# (default: a new folder in /var/tmp). Builds the working tree, committed or not. Not part of CI. It says
# nothing about speed: an emulator has none.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
packages=
if [ "${1:-}" = --packages ]; then
  packages=$(realpath -m "${2:?--packages: expected a folder}")
  shift 2
fi
targets=("$@")
[ ${#targets[@]} -gt 0 ] || targets=(stylize styled_golden_test styled_library_test styled_base_test styled_body_test
  styled_clip_test styled_devices_test styled_feet_test styled_gait_test styled_rig_test styled_stylist_test
  styled_trial_test styled_neutral_test styled_phase_test styled_find_humanoid_test synthetic_test net_kernel_test
  net_weights_test net_load_test several_test offset_test erd_features_test erd_load_test erd_step_test
  erd_allocation_test stgcn_graph_test stgcn_network_test stgcn_load_test stgcn_stylizer_test stgcn_causal_step_test
  stgcn_causal_points_test stgcn_causal_space_test stgcn_causal_variations_test stgcn_causal_load_test
  stgcn_causal_stylizer_test stgcn_causal_allocation_test)
[ "$(id -u)" = 0 ] || { echo "arm64: expected root: debootstrap and chroot need it" >&2; exit 1; }
command -v debootstrap >/dev/null || { echo "arm64: debootstrap is missing; apt-get install debootstrap" >&2; exit 1; }
chroots=${STYLED_CHROOTS:-$(mktemp -d /var/tmp/styled-chroots.XXXXXX)}
chroot=$chroots/arm64

# Of the machine that compiles, and of arm64.
tools=(ca-certificates crossbuild-essential-arm64 g++-arm-linux-gnueabihf g++-s390x-linux-gnu cmake ninja-build
  pkg-config protobuf-compiler qemu-user python3 scdoc dpkg-dev file apt-utils gnupg nodejs npm libeigen3-dev nlohmann-json3-dev libcli11-dev)
libraries=(libboost1.81-dev libzmq3-dev cppzmq-dev libprotobuf-dev libspdlog-dev libtomlplusplus-dev libsimdjson-dev
  libhwy-dev libncurses-dev libpng-dev liblz4-dev libzstd-dev libusb-1.0-0-dev libmeshoptimizer-dev libpugixml-dev
  libnats-dev libavahi-client-dev libgtest-dev libgmock-dev liblo-dev liboscpack-dev zlib1g-dev libsodium-dev)

if [ ! -e "$chroot/etc/debian_version" ]; then
  echo "debootstrap, in $chroot"
  mkdir -p "$chroot"
  debootstrap --variant=minbase bookworm "$chroot" >"$chroots/arm64.log" 2>&1 ||
    { tail -n 5 "$chroots/arm64.log" >&2; exit 1; }
fi
mkdir -p "$chroot/src"
mount --bind "$root" "$chroot/src"
mount -t proc proc "$chroot/proc"
trap 'umount "$chroot/src" "$chroot/proc"' EXIT
cp /etc/resolv.conf "$chroot/etc/resolv.conf"
inside() {  # inside COMMAND
  chroot "$chroot" env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin DEBIAN_FRONTEND=noninteractive \
    sh -c "cd /src && $1"
}
inside "dpkg --add-architecture arm64 && apt-get update -q && apt-get install -q -y --no-install-recommends \
  ${tools[*]} ${libraries[*]/%/:arm64}" >"$chroots/arm64.log" 2>&1 || { tail -n 5 "$chroots/arm64.log" >&2; exit 1; }

bad=0
refused() {  # refused COMPILER PROCESSOR SENTENCE: configuration ends with it
  if inside "rm -rf /tmp/refused && cmake -S . -B /tmp/refused -G Ninja -DCMAKE_SYSTEM_NAME=Linux \
    -DCMAKE_SYSTEM_PROCESSOR=$2 -DCMAKE_CXX_COMPILER=$1" >"$chroots/refused.log" 2>&1 ||
    ! tr -s ' \n' ' ' <"$chroots/refused.log" | grep -qF "$3"; then
    echo "$2: was not refused by '$3'"
    bad=1
  else
    echo "$2: refused: $3"
  fi
}
refused arm-linux-gnueabihf-g++ armv7l "armv7l: the compiler builds for 32 bits; expected x86-64 or ARM64"
refused s390x-linux-gnu-g++ s390x "s390x: this processor is big-endian; expected x86-64 or ARM64, little-endian"

begun=$SECONDS
inside "cmake --preset arm64 -DSTYLED_UNITY=ON -DSTYLED_TESTS=ON && nice -n 12 ninja -C build/arm64 ${targets[*]}" \
  >"$chroots/build.log" 2>&1 || { tail -n 20 "$chroots/build.log" >&2; exit 1; }
echo "built in $((SECONDS - begun)) s"
# Those of GoogleTest. Of a target that was not built ctest knows only that.
inside "ctest --test-dir build/arm64 -j2 -L '^unit\$' -E _NOT_BUILT --output-on-failure --output-junit arm64.xml" \
  >"$chroots/tests.log" 2>&1 || { bad=1; sed -n '/tests FAILED/,$p' "$chroots/tests.log"; }
grep 'tests passed' "$chroots/tests.log" || bad=1
python3 -B "$root/tests/outcomes.py" "$root/build/arm64/arm64.xml"

clip=tests/parity/fixtures/synthetic.bvh
if [ ! -x "$root/build/release/bin/stylize" ]; then
  echo "a styled clip: skipped, there is no build/release/bin/stylize"
elif [ ! -x "$root/build/arm64/bin/stylize" ]; then
  echo "a styled clip: skipped, stylize is not among the targets"
else
  options=(--overwrite --weights model/weights/v2.safetensors --style elderly)
  (cd "$root" && build/release/bin/stylize "${options[@]}" "$clip" build/arm64/here.bvh >/dev/null)
  inside "qemu-aarch64 build/arm64/bin/stylize ${options[*]} $clip build/arm64/there.bvh >/dev/null"
  printf 'a styled clip, here and on ARM64: '
  python3 -B "$root/tests/arm64_clip.py" "$root/build/arm64/here.bvh" "$root/build/arm64/there.bvh" || bad=1
fi

if [ -n "$packages" ]; then
  inside "nice -n 12 systemd/packages.sh --arm64 build/arm64" >"$chroots/packages.log" 2>&1 || { tail -n 20 "$chroots/packages.log" >&2; exit 1; }
  mkdir -p "$packages"
  cp "$root"/build/arm64/*.deb "$packages"
  inside "apt-get install -q -y --no-install-recommends ./build/arm64/*.deb" >"$chroots/packages.log" 2>&1 ||
    { tail -n 20 "$chroots/packages.log" >&2; exit 1; }
  # Programs of arm64, installed, in a system of amd64.
  (
    . "$root/tests/service/packages_common.sh"
    stylesim=$root/build/release/bin/stylesim  # sim/setup.sh run builds it
    work=$chroots root=$chroot emulator=qemu-aarch64
    check "packages are installed" "$(inside dpkg-query -W -f '${db:Status-Abbrev} ${Architecture}\n' styled styled-tools libstyled0 | sort -u)" "ii  arm64"
    check "libraries that a program lacks" "$(inside sh -c 'for p in /usr/bin/style*; do qemu-aarch64 "$p" --version >/dev/null || echo "$p"; done')" ""
    check "a frame's way, and a style" "$(runs zombie)" zombie
    exit $failed
  ) || bad=1
fi
exit $bad
