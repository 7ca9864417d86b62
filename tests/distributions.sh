#!/usr/bin/env bash
# On a fresh Debian, in a chroot made by debootstrap, the README's two commands:
# tests/distributions.sh [--demo | --packages] [SUITE...]
#   --demo   only sim/demo.sh; tests/run.sh takes an hour
#   --packages  instead of both: systemd/packages.sh, and what it built is installed in a fresh one (tests/service/packages.sh)
#   SUITE    bookworm, trixie (default: both), or noble (Ubuntu 24.04; needs Ubuntu's keyring)
# Needs root, debootstrap and some 10 GB below $STYLED_CHROOTS (default: a new folder in /var/tmp). The commit that is
# checked out is built, without what is not committed. Prints the seconds of each command. Not part of CI.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
commands=("sim/demo.sh --seconds 5 --plain" tests/run.sh)
packages=no
suites=()
for argument in "$@"; do
  case "$argument" in
    --demo) commands=("${commands[0]}") ;;
    --packages) commands=("systemd/packages.sh --train") packages=yes ;;
    -*)
      echo "unknown option '$argument'; expected --demo or --packages" >&2
      exit 2
      ;;
    *) suites+=("$argument") ;;
  esac
done
[ ${#suites[@]} -gt 0 ] || suites=(bookworm trixie)
[ "$(id -u)" = 0 ] || { echo "distributions: expected root: debootstrap and chroot need it" >&2; exit 1; }
command -v debootstrap >/dev/null || { echo "distributions: debootstrap is missing; apt-get install debootstrap" >&2; exit 1; }
chroots=${STYLED_CHROOTS:-$(mktemp -d /var/tmp/styled-chroots.XXXXXX)}

mounted=()
unmount() {
  local place
  for place in "${mounted[@]}"; do umount -l "$place" || true; done
}
trap unmount EXIT

bad=0
for suite in "${suites[@]}"; do
  chroot=$chroots/$suite
  if [ ! -e "$chroot/etc/debian_version" ]; then
    echo "$suite: debootstrap, in $chroot"
    mkdir -p "$chroot"
    of_suite=("$suite" "$chroot")
    [ "$suite" != noble ] ||
      of_suite=(--components=main,universe --keyring=/usr/share/keyrings/ubuntu-archive-keyring.gpg "$suite" "$chroot"
        http://archive.ubuntu.com/ubuntu /usr/share/debootstrap/scripts/gutsy)
    debootstrap --variant=minbase --include=ca-certificates,git "${of_suite[@]}" >"$chroots/$suite.log" 2>&1 ||
      { tail -n 5 "$chroots/$suite.log" >&2; exit 1; }
  fi
  for place in proc dev; do
    mountpoint -q "$chroot/$place" && continue
    mount --rbind "/$place" "$chroot/$place"
    mounted+=("$chroot/$place")
  done
  cp /etc/resolv.conf "$chroot/etc/resolv.conf"
  rm -rf "$chroot/src"
  git clone -q "$root" "$chroot/src"
  for command in "${commands[@]}"; do
    begun=$SECONDS
    if chroot "$chroot" env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin sh -c "cd /src && $command" \
      >"$chroots/$suite.log" 2>&1; then
      result=ok
    else
      result=FAILED bad=1
      tail -n 20 "$chroots/$suite.log"
    fi
    echo "$suite: $command: $result ($((SECONDS - begun)) s)"
  done
  if [ $packages = yes ] && [ "$result" = ok ]; then "$root/tests/service/packages.sh" "$chroot/src/build/package" || bad=1; fi
done
exit $bad
