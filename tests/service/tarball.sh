#!/usr/bin/env bash
# Runs the tarball's programs on other distributions, from a folder with a space in its name, as a user who is not
# root. By hand, as root, minutes, with the network.
#   tests/service/tarball.sh FOLDER [SUITE...]
#     FOLDER  where systemd/tarball.sh put the two tarballs
#     SUITE   Debian's; default: bullseye (glibc 2.31), bookworm, trixie
#     STYLED_CHROOTS in the environment: a folder with a chroot that debootstrap made for each SUITE, to save its time
# apt: debootstrap zstd
set -euo pipefail
[ $# -ge 1 ] || { sed -n '2,8s/^# \{0,1\}//p' "$0" >&2; exit 2; }
tarballs=$(realpath "$1")
shift
[ $# -gt 0 ] || set -- bullseye bookworm trixie
work=$(mktemp -d)
root=
cleanup() {
  [ -z "$root" ] || umount "$root/proc" 2>/dev/null || true
  rm -rf --one-file-system "$work"
}
trap cleanup EXIT
failed=0
check() { if [ "$2" = "$3" ]; then echo "ok: $suite: $1"; else echo "FAILED: $suite: $1: $2, expected $3"; failed=1; fi; }
inside() {
  chroot --userspec=65534:65534 "$root" env -i PATH=/usr/bin:/bin LC_ALL=C.UTF-8 HOME=/tmp "$@"
}
setting() { sed -n "s/.*\"$2\": \"\([^\"]*\)\".*/\1/p" "$root/tmp/$1.json" | head -n 1; }
started() { # NAME COMMAND...: starts it, and waits for its ready file
  local name=$1 i
  shift
  rm -f "$root/tmp/$name.json"
  chroot --userspec=65534:65534 "$root" env -i PATH=/usr/bin:/bin "$@" --ready-file "/tmp/$name.json" 2>"$work/$name.log" &
  eval "$name=$!"
  for i in $(seq 300); do [ -s "$root/tmp/$name.json" ] && return; sleep 0.1; done
  cat "$work/$name.log" >&2
  echo "FAILED: $suite: $name does not start"
  exit 1
}

for suite in "$@"; do
  root=$work/$suite
  mkdir "$root"
  if [ -d "${STYLED_CHROOTS:-/nonexistent}/$suite" ]; then
    cp -a "$STYLED_CHROOTS/$suite/." "$root"
  else
    debootstrap --variant=minbase "$suite" "$root" >"$work/log" 2>&1 || { tail -n 5 "$work/log"; exit 1; }
  fi
  mount -t proc proc "$root/proc"
  mkdir "$root/srv/any where"
  tar -xf "$tarballs"/styled-[0-9]*.tar.zst -C "$root/srv/any where"
  top=$(cd "$root" && echo "srv/any where"/styled-*)
  echo "$suite: glibc $(chroot "$root" ldd --version | sed -n '1s/.* //p'), packages of ours: $(chroot "$root" dpkg-query -W 'libzmq*' 'libprotobuf*' 2>/dev/null | wc -l)"
  bin="/$top/bin"
  check "every program starts" "$(for p in "$root$bin"/*; do inside "$bin/${p##*/}" --help >/dev/null 2>&1 || echo "${p##*/}"; done)" ""
  inside ln -s "$bin/stylize" /tmp/linked
  inside "$bin/stylesim" --seconds 3 --write /tmp/walk.bvh >/dev/null
  inside /tmp/linked --weights open --style zombie /tmp/walk.bvh /tmp/zombie.bvh >/dev/null
  check "a clip is restyled, by a link to the program" "$(cmp -s "$root/tmp/walk.bvh" "$root/tmp/zombie.bvh" && echo same; head -n 1 "$root/tmp/zombie.bvh")" HIERARCHY
  started styled "$bin/styled" --weights open --set source.0.listen=127.0.0.1:0 --set source.1.listen=127.0.0.1:0 \
    --set publish.address=tcp://127.0.0.1:0 --set control.address=tcp://127.0.0.1:0
  inside "$bin/stylesim" --to "udp://$(setting styled listen)" --seconds 8 >/dev/null 2>&1 &
  simulated=$!
  sleep 1
  inside "$bin/stylectl" --endpoint "$(setting styled control)" set rig.sim --style zombie >/dev/null
  check "a styled performer" "$(inside "$bin/stylectl" --endpoint "$(setting styled control)" status | grep -c 'rig.sim.*zombie')" 1
  check "and their frames" "$(inside "$bin/stylemon" --endpoint "$(setting styled publish)" --plain --seconds 2 | grep -q 'rig.sim' && echo seen)" seen
  started styleweb "$bin/styleweb" --listen 127.0.0.1:0 --publish "$(setting styled publish)" --control "$(setting styled control)"
  address=$(grep -o '127.0.0.1:[0-9]*' "$root/tmp/styleweb.json" | head -n 1)
  check "the page, and its notices" "$(for path in / /notices.txt; do
    inside bash -c "exec 3<>/dev/tcp/${address/://}; printf 'GET $path HTTP/1.1\r\nHost: $address\r\nConnection: close\r\n\r\n' >&3; cat <&3" |
      grep -a -c -m 1 -e '<title>Styled' -e '^mediabunny'; done | paste -sd+)" 1+1
  wait "$simulated"
  kill "$styled" "$styleweb"
  wait "$styled" && code=0 || code=$?
  check "the daemon ends by SIGTERM" "$code" 0
  wait "$styleweb" || true
  tar -xf "$tarballs"/styled-weights-nc-*.tar.zst -C "$root/srv/any where"
  inside "$bin/stylize" --style elderly /tmp/walk.bvh /tmp/old.bvh >/dev/null
  check "with the weights beside it, v2 is the default" "$(cmp -s "$root/tmp/walk.bvh" "$root/tmp/old.bvh" && echo same; head -n 1 "$root/tmp/old.bvh")" HIERARCHY
  umount "$root/proc"
  rm -rf --one-file-system "$root"
  root=
done
[ $failed = 0 ] && echo "tarball: all passed" || { echo "tarball: FAILED"; exit 1; }
