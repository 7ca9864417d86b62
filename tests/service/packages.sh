#!/usr/bin/env bash
# Installs, runs, upgrades and purges the packages in a fresh Debian 12, and asks lintian about them. By
# hand, as root, a few minutes, with the network.
#   tests/service/packages.sh DEBS [ROOT]
#     DEBS  the folder where systemd/packages.sh put them
#     ROOT  a folder to leave the system in, packages installed (for qemu.sh); default: none is left
#     STYLED_BASE in the environment: a folder that debootstrap made, to save its time
# apt: debootstrap lintian
set -euo pipefail
[ $# -ge 1 ] || { sed -n '2,8s/^# \{0,1\}//p' "$0" >&2; exit 2; }
debs=$(realpath "$1")
work=$(mktemp -d)
root=$work/root
mounted=no
cleanup() {
  [ $mounted = no ] || umount "$root/proc"
  rm -rf --one-file-system "$work"
}
trap cleanup EXIT
failed=0
check() { if [ "$2" = "$3" ]; then echo "ok: $1"; else echo "FAILED: $1: $2, expected $3"; failed=1; fi; }
inside() {
  chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"
}
quietly() { "$@" >"$work/log" 2>&1 || { tail -n 30 "$work/log"; echo "FAILED: $*"; exit 1; }; }
apt() { quietly inside apt-get -q -y --no-install-recommends "$@"; }

echo "lintian:"
lintian --fail-on error --tag-display-limit 0 "$debs"/*.deb && tags=0 || tags=$?
check "lintian finds no errors" $tags 0

# Their dependencies first, so that what is left at the end is theirs alone.
if [ -n "${STYLED_BASE:-}" ]; then
  cp -a "$STYLED_BASE" "$root"
else
  quietly debootstrap --variant=minbase bookworm "$root"
fi
mount -t proc proc "$root/proc"
mounted=yes
depends=$(for deb in "$debs"/*.deb; do dpkg-deb -f "$deb" Depends; echo; done | grep . | paste -sd, |
  sed 's/, *styled[a-z-]* ([^)]*)//g')
apt satisfy "$depends"
everything() { # and whose it is
  (cd "$root" && find . -xdev \( -path ./proc -o -path ./tmp -o -path ./debs -o -path ./var/cache -o -path ./var/log \
    -o -path ./var/lib/dpkg -o -path ./var/lib/apt \) -prune -o ! -name '*.pyc' ! -name __pycache__ \
    -printf '%p %u %g %m %l\n' | sort)
}
everything >"$work/before"
inside getent group | sort >"$work/groups"

mkdir "$root/debs"
cp "$debs"/*.deb "$root/debs"
quietly inside sh -c 'dpkg -i /debs/*.deb'
check "all are installed" "$(inside dpkg-query -W -f '${db:Status-Abbrev}\n' 'styled*' '*-styled' '*styled-client*' | grep -c '^ii')" 5
check "the group is there" "$(inside getent group styled | cut -d: -f1)" styled
check "nothing is enabled" "$(find "$root/etc/systemd" -name '*style*' | wc -l)" 0
check "the weights are there" "$(cd "$root/usr/share/styled/weights" && echo *)" \
  "graph.safetensors open.safetensors st-gcn.safetensors v2.safetensors"
check "the weights' licences are told" "$(grep '^License: CC' "$root/usr/share/doc/styled/copyright" | sort | uniq -c | tr -s ' ' | paste -sd,)" \
  " 2 License: CC-BY-4.0, 3 License: CC-BY-NC-4.0"
check "the configuration is good" "$(inside styled --check-config /etc/styled/styled.toml)" "/etc/styled/styled.toml: ok"
check "every program has a page" "$(cd "$root/usr/bin" && for p in style*; do [ -f "$root/usr/share/man/man1/$p.1.gz" ] || echo "$p"; done)" ""

# As it is started by hand: ports of the system's choice, the shipped weights.
setting() { sed -n "s/.*\"$1\": \"\(.*\)\".*/\1/p" "$root/tmp/ready.json" | head -n 1; }
runs() {
  rm -f "$root/tmp/ready.json"
  chroot "$root" /usr/bin/styled --config /etc/styled/styled.toml --set source.0.listen=127.0.0.1:0 --set source.1.listen=127.0.0.1:0 \
    --set publish.address=tcp://127.0.0.1:0 --set control.address=tcp://127.0.0.1:0 \
    --set state.dir=/var/lib/styled --ready-file /tmp/ready.json 2>"$work/styled.log" &
  local daemon=$! i
  for i in $(seq 300); do [ -s "$root/tmp/ready.json" ] && break; sleep 0.1; done
  inside stylesim --to "udp://$(setting listen)" --seconds 2 >/dev/null
  inside stylectl --endpoint "$(setting control)" set rig.sim --style elderly >/dev/null
  inside stylectl --endpoint "$(setting control)" status | grep -c 'rig.sim.*elderly' || true
  kill "$daemon"
  wait "$daemon" || { cat "$work/styled.log" >&2; return 1; }
}
check "a frame's way, and a style" "$(runs)" 1
check "Python's client is there" "$(inside python3 -c 'import styled; print(styled.__name__)')" styled

# The same as the next version; a configuration that the administrator changed stays as it is.
echo '# mine' >>"$root/etc/styled/styled.toml"
for deb in "$debs"/*.deb; do
  dpkg-deb -R "$deb" "$work/unpacked"
  sed -i 's/^Version: .*/&+next/;s/(= \([^)]*\))/(= \1+next)/' "$work/unpacked/DEBIAN/control"
  dpkg-deb --root-owner-group -b "$work/unpacked" "$root/debs" >/dev/null
  rm -rf "$work/unpacked"
done
quietly inside sh -c 'dpkg -i /debs/*+next*.deb'
check "upgraded" "$(inside dpkg-query -W -f '${Version}\n' 'styled*' '*-styled' '*styled-client*' | grep -c '+next$')" 5
check "the changed configuration stayed" "$(tail -n 1 "$root/etc/styled/styled.toml")" "# mine"
check "and so did performers' settings" "$(grep -c elderly "$root/var/lib/styled/performers.toml")" 1
check "it still runs" "$(runs)" 1

quietly inside apt-get -q -y remove 'styled*' '*-styled' '*styled-client*'
check "removed, configuration and settings stay" "$(ls "$root/etc/styled" "$root/var/lib/styled" | grep -c toml)" 2
quietly inside sh -c 'dpkg --purge $(dpkg-query -W -f "\${Package} " "styled*" "*-styled" "*styled-client*" 2>/dev/null)'
rm -rf "$root/debs" "$root/tmp"/*
everything | diff "$work/before" - >"$work/left" || true
check "purged, nothing is left" "$(cat "$work/left")" ""
check "nor the group" "$(inside getent group | sort | diff "$work/groups" -)" ""

if [ $# -gt 1 ]; then
  apt install udev  # which is not in every Debian, and gives the service its USB devices
  mkdir "$root/debs"
  cp "$debs"/*.deb "$root/debs"
  quietly inside sh -c 'dpkg -i /debs/*.deb'
  umount "$root/proc"
  mounted=no
  mv "$root" "$2"
fi
[ $failed = 0 ] && echo "packages: all passed" || { echo "packages: FAILED"; exit 1; }
