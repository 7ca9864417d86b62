#!/usr/bin/env bash
# Installs what is missing on Debian 12 or 13, or Ubuntu 24.04, through apt-get, then configures and builds a preset.
#   sim/setup.sh run            what the daemon, the simulator and the clients need
#   sim/setup.sh test           the same, and the tests
#   sim/setup.sh train          the same, and libtorch for styletrain and styleeval
# Without apt-get or root it only prints what is missing. It can also be sourced: it defines
# styled_install LEVEL (there are more: package and package_train, for systemd/packages.sh, release, for
# systemd/release.sh, and sites, for sim/demo-sites.sh) and
# styled_build PRESET [CMAKE OPTIONS...], which builds $styled_targets (default: everything).

styled_root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

# Alternatives are separated by |, the best first; >= gives the least version that will do; a package with a ? is
# left out, with a line, where there is none: Ubuntu has chromium only as a snap, and no libtorch; the tree's format is
# clang-format 16's, and tests/lint.sh reports where it is missing.
styled_packages_run=(g++ cmake ninja-build pkg-config libeigen3-dev "libboost-dev>=1.81|libboost1.81-dev" libzmq3-dev
  cppzmq-dev libprotobuf-dev protobuf-compiler libspdlog-dev libtomlplusplus-dev libcli11-dev
  nlohmann-json3-dev libsimdjson-dev libhwy-dev libncurses-dev libpng-dev liblz4-dev libzstd-dev
  libusb-1.0-0-dev libsodium-dev libmeshoptimizer-dev libpugixml-dev libnats-dev libavahi-client-dev scdoc)
styled_packages_test=("${styled_packages_run[@]}" git libgtest-dev libgmock-dev libbenchmark-dev
  "clang-format-16?" "clang-tidy-16?" xz-utils procps liblo-dev liblo-tools liboscpack-dev lz4 zstd zlib1g-dev
  python3 python3-zmq python3-protobuf python3-numpy python3-setuptools python3-wheel python3-venv mono-mcs
  "python3-nbclient?" "python3-ipykernel?" "python3-matplotlib?" mono-runtime libumockdev-dev umockdev "chromium?"
  libfaketime apt-utils gnupg nats-server openssl
  linuxptp iproute2 qemu-user avahi-daemon dbus-daemon "mold?")
styled_packages_sites=("${styled_packages_run[@]}" nats-server)
styled_packages_package=("${styled_packages_run[@]}" dpkg-dev file apt-utils gnupg python3)
styled_packages_release=("${styled_packages_package[@]}" zstd mmdebstrap umoci)
styled_packages_package_train=("${styled_packages_package[@]}" libtorch-dev libopenblas0-pthread)
styled_packages_effects=(clang-22)  # Debian 12 has it among its security updates
styled_packages_train=("${styled_packages_test[@]}" "libtorch-dev?" libopenblas0-pthread)

styled_install() {
  local list="styled_packages_$1[@]" missing=() package
  for package in "${!list}"; do
    styled_has "${package%\?}" || missing+=("$package")
  done
  # For styleweb's page. Checks for the command, not the package: node from another source has its
  # own npm.
  command -v npm >/dev/null || missing+=(nodejs npm)
  # What may be left out is no reason to ask for a password, or for the network.
  local needed=0
  for package in "${missing[@]}"; do [[ "$package" = *\? ]] && ! styled_choose "${package%\?}" || needed=1; done
  [ "$needed" = 1 ] || return 0
  local sudo=()
  if [ "$(id -u)" != 0 ]; then
    if ! command -v sudo >/dev/null; then
      echo "missing packages, and neither root nor sudo to install them: ${missing[*]}" >&2
      return 1
    fi
    sudo=(sudo)
  fi
  if ! command -v apt-get >/dev/null; then
    echo "missing packages, and no apt-get to install them: ${missing[*]}" >&2
    return 1
  fi
  "${sudo[@]}" apt-get update -q >/dev/null || return 1
  local chosen=() absent=()
  for package in "${missing[@]}"; do
    if styled_choose "${package%\?}"; then
      chosen+=("$styled_chosen")
    elif [[ "$package" = *\? ]]; then
      echo "left out, there is no such package here: ${package%\?}"
    else
      absent+=("${package//|/ or }")
    fi
  done
  if [ ${#absent[@]} -gt 0 ]; then
    local name
    name=$(. /etc/os-release 2>/dev/null && echo "${PRETTY_NAME:-}") || true
    echo "${name:-this system} has no package ${absent[*]}; expected Debian 12 or 13, or Ubuntu 24.04" >&2
    return 1
  fi
  [ ${#chosen[@]} -gt 0 ] || return 0
  echo "installing ${#chosen[@]} packages: ${chosen[*]}"
  "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get install -q -y --no-install-recommends "${chosen[@]}" >/dev/null
}

# Whether one of a package's alternatives is installed, in a version that is new enough.
styled_has() {
  local one status version
  for one in ${1//|/ }; do
    read -r status version < <(dpkg-query -W -f='${db:Status-Status} ${Version}\n' "${one%%>=*}" 2>/dev/null) || true
    if [ "$status" = installed ] && styled_new_enough "$one" "$version"; then return 0; fi
  done
  return 1
}

# The first alternative that apt-get can install, in styled_chosen.
styled_choose() {
  local one version
  for one in ${1//|/ }; do
    version=$(LC_ALL=C apt-cache policy "${one%%>=*}" 2>/dev/null | sed -n 's/^ *Candidate: \([0-9]\)/\1/p')
    styled_chosen=${one%%>=*}
    [ -z "$version" ] || ! styled_new_enough "$one" "$version" || return 0
  done
  return 1
}

styled_new_enough() {  # styled_new_enough NAME[>=VERSION] FOUND
  [ "${1%%>=*}" = "$1" ] || dpkg --compare-versions "$2" ge "${1##*>=}"
}

# Reads Ninja's output and prints the progress: on a terminal one line that is rewritten, else a
# line per tenth of the steps.
styled_progress() {
  local line step steps percent shown=-1
  while IFS= read -r line; do
    [[ "$line" =~ ^\[([0-9]+)/([0-9]+)\] ]] || continue
    step=${BASH_REMATCH[1]} steps=${BASH_REMATCH[2]}
    percent=$((100 * step / steps))
    [ "$step" != 1 ] || shown=-1
    if [ -t 1 ]; then
      printf '\r  step %d of %d, %d %% ' "$step" "$steps" "$percent"
    elif [ $((percent / 10)) -gt "$shown" ]; then
      printf '  step %d of %d, %d %%\n' "$step" "$steps" "$percent"
    fi
    shown=$((percent / 10))
  done
  [ "$shown" = -1 ] || [ ! -t 1 ] || echo
}

styled_build() {
  local preset=$1
  shift
  local log="$styled_root/build/$preset.log" targets=()
  [ -z "${styled_targets:-}" ] || read -ra targets <<<"--target $styled_targets"
  mkdir -p "$styled_root/build"
  (set -o pipefail && cd "$styled_root" && cmake --preset "$preset" -DSTYLED_UNITY=ON "$@" >"$log" 2>&1 &&
    cmake --build --preset "$preset" "${targets[@]}" 2>&1 | tee -a "$log" | styled_progress) &&
    return 0
  echo "the build of preset '$preset' failed; the end of $log:" >&2
  tail -n 40 "$log" >&2
  return 1
}

if [ "${BASH_SOURCE[0]}" = "$0" ]; then
  set -eu
  case "${1:-}" in
    run) styled_install run && styled_build release -DSTYLED_TESTS=OFF -DSTYLED_TRAIN=OFF ;;
    test) styled_install test && styled_build release -DSTYLED_TESTS=ON ;;
    train) styled_install train && styled_build release -DSTYLED_TRAIN=ON ;;
    *)
      echo "usage: sim/setup.sh run|test|train" >&2
      exit 2
      ;;
  esac
fi
