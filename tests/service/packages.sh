#!/usr/bin/env bash
# Installs, runs, upgrades and purges the packages in a fresh Debian, 12 or 13 as they were built for, and asks lintian
# about them. By hand, as root, a few minutes, with the network.
#   tests/service/packages.sh DEBS [ROOT]
#     DEBS  the folder where systemd/packages.sh put them
#     ROOT  a folder to leave the system in, packages installed (for qemu.sh); default: none is left
#     STYLED_BASE in the environment: a folder that debootstrap made, to save its time
#     STYLED_OLD in the environment: a folder of packages of an older version for the same Debian, from which the first
#     upgrade goes out (upgrade.sh upgrades the Debian, too)
# apt: debootstrap lintian
set -euo pipefail
[ $# -ge 1 ] || { sed -n '2,9s/^# \{0,1\}//p' "$0" >&2; exit 2; }
debs=$(realpath "$1")
work=$(mktemp -d)
root=$work/root
mounted=no
cleanup() {
  [ $mounted = no ] || umount "$root/proc"
  rm -rf --one-file-system "$work"
}
trap cleanup EXIT
. "$(dirname "$0")/packages_common.sh"
suite=bookworm
case $(dpkg-deb -f "$debs"/styled_*.deb Version) in *+deb13*) suite=trixie ;; esac
echo "packages for $suite"

echo "lintian:"
lintian --fail-on error --tag-display-limit 0 "$debs"/*.deb && tags=0 || tags=$?
check "lintian finds no errors" $tags 0

# Their dependencies first, so that what is left at the end is theirs alone.
if [ -n "${STYLED_BASE:-}" ]; then
  cp -a "$STYLED_BASE" "$root"
else
  quietly debootstrap --variant=minbase "$suite" "$root"
fi
mount -t proc proc "$root/proc"
mounted=yes
depends=$(for deb in "$debs"/*.deb; do dpkg-deb -f "$deb" Depends; echo; done | grep . | paste -sd, |
  sed -E 's/(^|,) *(lib)?styled[a-z0-9-]* \([^)]*\)//g')
apt satisfy "$depends"
everything() { # and whose it is
  (cd "$root" && find . -xdev \( -path ./proc -o -path ./tmp -o -path ./debs -o -path ./var/cache -o -path ./var/log \
    -o -path ./var/lib/dpkg -o -path ./var/lib/apt \) -prune -o ! -name '*.pyc' ! -name __pycache__ \
    -printf '%p %u %g %m %l\n' | sort)
}
everything >"$work/before"
inside getent group | sort >"$work/groups"

mkdir "$root/debs"
if [ -n "${STYLED_OLD:-}" ]; then
  cp "$STYLED_OLD"/*.deb "$root/debs"
  quietly inside sh -c 'dpkg -i /debs/*.deb'
  old=$(inside dpkg-query -W -f '${Version}' styled)
  cp "$(dirname "$0")/../parity/fixtures/synthetic.bvh" "$root/tmp/pirate.bvh"
  check "$old: a frame's way, and a style" "$(during=$like runs elderly "${library[@]}")" elderly
  check "$old: a style of an example" "$(runs pirate "${library[@]}")" pirate
  allow
  (cd "$root/var/lib/styled" && find . -type f ! -name performers.toml ! -path './styles/*' -exec sha256sum {} + | sort) >"$work/kept"
  rm "$root"/debs/*
  cp "$debs"/styled_*.deb "$debs"/styled-tools_*.deb "$debs"/styled-web_*.deb "$root/debs"
  quietly inside sh -c 'dpkg -i /debs/*.deb'
  check "upgraded from $old without the weights that were in it: it is told where they are" \
    "$(grep -c 'now in the package styled-weights-nc' "$work/log")" 1
  check "it runs with open" "$(runs zombie --weights open)" zombie
  check "and with the style of the example" "$(runs pirate --weights open "${library[@]}")" pirate
  rm -rf "$root/debs"
  mkdir "$root/debs"
  # Once more, as whoever keeps the weights does it.
  quietly inside dpkg --remove --force-depends styled
  cp "$STYLED_OLD"/*.deb "$root/debs"
  quietly inside sh -c 'dpkg -i --force-downgrade /debs/*.deb'
  check "$old again, with its style" "$(runs elderly)" elderly
  rm "$root"/debs/*
fi
cp "$debs"/*.deb "$root/debs"
quietly inside sh -c 'apt-get -q -y --no-install-recommends install /debs/*.deb'
if [ -n "${STYLED_OLD:-}" ]; then
  check "upgraded from $old, styled-weights-nc has the weights" \
    "$(inside dpkg-query -S /usr/share/styled/weights/v2.safetensors)" "styled-weights-nc: /usr/share/styled/weights/v2.safetensors"
  check "the performer's style stayed" "$(runs '')" elderly
  check "so did the style of an example" "$(runs pirate "${library[@]}")" pirate
  runs elderly >/dev/null
  check "keys and recordings stayed" "$(cd "$root/var/lib/styled" && sha256sum --quiet -c "$work/kept" && grep -c 'keys/clients/anna.key' "$work/kept")" 1
fi
count=$(ls "$debs"/*.deb | wc -l)
check "all are installed" "$(inside dpkg-query -W -f '${db:Status-Abbrev}\n' 'styled*' '*-styled' 'libstyled*' | grep -c '^ii')" "$count"
check "the group is there" "$(inside getent group styled | cut -d: -f1)" styled
check "nothing is enabled" "$(find "$root/etc/systemd" -name '*style*' | wc -l)" 0
check "the weights are there, each with its licence" "$(cd "$root/usr/share/styled/weights" && echo *)" \
  "$(for name in graph open st-gcn v2; do echo "$name.safetensors $name.safetensors.license"; done | paste -sd' ')"
check "the weights' licences are told" "$(cd "$root/usr/share/doc" && grep -h '^License: CC' styled/copyright styled-weights-nc/copyright | sort | uniq -c | tr -s ' ' | paste -sd,)" \
  " 2 License: CC-BY-4.0, 3 License: CC-BY-NC-4.0"
check "the configuration is good" "$(inside styled --check-config /etc/styled/styled.toml)" "/etc/styled/styled.toml: ok"
check "the documents are there" "$(cd "$root/usr/share/doc" && ls styled/*.md styled-web/*.md styled-web/prometheus/* | paste -sd' ')" \
  "styled-web/README.md styled-web/WEBSOCKET.md styled-web/prometheus/styled.dashboard.json styled-web/prometheus/styled.rules.yml styled/GLOSSARY.md styled/MODEL-CARD.md styled/OPERATING.md styled/SECURITY.md styled/STANDBY.md styled/TROUBLESHOOTING.md styled/WIRE.md"
check "every program tells its version" "$(cd "$root/usr/bin" && for p in style*; do chroot "$root" "/usr/bin/$p" --version | grep -q "^$p [0-9.]*" || echo "$p"; done)" ""
check "every program has a page" "$(cd "$root/usr/bin" && for p in style*; do [ -f "$root/usr/share/man/man1/$p.1.gz" ] || echo "$p"; done)" ""

check "a frame's way, and a style" "$(runs elderly)" elderly
check "libstyled finds the weights" "$(inside python3 -c 'import styled; print("zombie" in styled.Network("open").styles)')" True
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
check "upgraded" "$(inside dpkg-query -W -f '${Version}\n' 'styled*' '*-styled' 'libstyled*' | grep -c '+next$')" "$count"
check "the changed configuration stayed" "$(tail -n 1 "$root/etc/styled/styled.toml")" "# mine"
check "and so did performers' settings" "$(grep -c elderly "$root/var/lib/styled/performers.toml")" 1
check "it still runs, in the same style" "$(runs '')" elderly

[ -e "$root/var/lib/styled/keys/clients/anna.key" ] || allow
remove() { quietly inside apt-get -q -y remove 'styled*' '*-styled' 'libstyled*'; }
purge() { quietly inside sh -c 'dpkg --purge $(dpkg-query -W -f "\${Package} " "styled*" "*-styled" "libstyled*" 2>/dev/null)'; }
remove
check "removed, configuration and settings stay" "$(ls "$root/etc/styled" "$root/var/lib/styled" | grep -c toml)" 2
ls "$root/var/lib/styled" >"$work/state"
purge
check "purged, it says that keys and recordings are kept" "$(grep -c 'kept in /var/lib/styled;' "$work/log")" 1
check "they are, and the settings are gone" "$(ls "$root/var/lib/styled")" "$(grep -v '^performers.toml$' "$work/state")"
check "keys and a recording are among them" "$(ls "$root/var/lib/styled/keys/clients" | grep -c anna.key), $(find "$root/var/lib/styled" -maxdepth 1 -type f | grep -c .)" \
  "1, $(grep -vc 'performers.toml\|keys\|styles' "$work/state")"
check "the group is kept with them" "$(inside getent group styled | cut -d: -f1)" styled

# Installed again over what was kept, and told to remove that, too.
quietly inside sh -c 'dpkg -i $(ls /debs/*.deb | grep -v +next)'
check "it runs with the keys that were kept" "$(runs elderly)" elderly
touch "$root/etc/styled/purge-all"
remove
purge
rm -rf "$root/debs" "$root/tmp"/*
everything | diff "$work/before" - >"$work/left" || true
check "purged with everything, nothing is left" "$(cat "$work/left")" ""
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
