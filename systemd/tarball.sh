#!/usr/bin/env bash
# Makes tarballs of packages: programs that run on any Linux of this architecture, from any folder.
#   systemd/tarball.sh DEBS FOLDER
#     DEBS    the folder of styled, styled-tools, styled-web and styled-weights-nc, built on this machine
#     FOLDER  gets styled-VERSION-linux-x86_64.tar.zst, and styled-weights-nc-VERSION.tar.zst to unpack beside it
# The libraries that the programs need are taken from this machine, the C library among them: programs of Debian 12
# ask for glibc 2.36, and Debian 11, which has 2.31, cannot build them.
# apt: zstd
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
[ $# -eq 2 ] || { sed -n '2,5s/^# \{0,1\}//p' "$0" >&2; exit 2; }
fail() { echo "tarball.sh: $*" >&2; exit 1; }
debs=$(realpath "$1")
mkdir -p "$2"
folder=$(realpath "$2")
[ "$(uname -m)" = x86_64 ] || fail "expected an x86-64 machine, found $(uname -m)"
[ -n "$(type -P zstd)" ] || fail "zstd is missing: apt-get install zstd"
for name in styled styled-tools styled-web styled-weights-nc; do
  [ "$(compgen -G "$debs/${name}_*.deb" | wc -l)" = 1 ] || fail "$debs: expected one ${name}_*.deb; systemd/packages.sh builds it"
done
version=$(dpkg-deb -f "$debs"/styled_*.deb Version)
version=${version%%+*}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
name=styled-$version-linux-x86_64
top=$work/$name
nc=$work/nc/$name
mkdir -p "$work/deb" "$work/nc-deb" "$top"/{bin,lib,libexec,etc,share/units,share/doc/libraries} "$nc/share/doc" "$nc/share/styled"
for deb in styled styled-tools styled-web; do dpkg-deb -x "$debs/${deb}"_*.deb "$work/deb"; done
dpkg-deb -x "$debs"/styled-weights-nc_*.deb "$work/nc-deb"

files=$work/deb
units=$(dirname "$(find "$files" -name styled.service)")
sed -i 's|/usr/bin/sty|/opt/styled/bin/sty|' "$units"/*.service
! grep -l '/usr/bin/sty' "$units"/*.service || fail "a unit still starts a program of /usr/bin"
mv "$units"/*.service "$(find "$files" -name styled.conf)" "$(find "$files" -name 70-styled.rules)" "$top/share/units"
mv "$files/etc/styled/styled.toml" "$top/etc/styled.toml"
mv "$files"/usr/bin/* "$top/libexec"
for part in man bash-completion styled; do mv "$files/usr/share/$part" "$top/share/$part"; done
mv "$files"/usr/share/doc/* "$top/share/doc"
left=$(find "$files" -type f)
[ -z "$left" ] || fail "files of the packages that have no place in the tarball: $left"
mv "$work/nc-deb/usr/share/doc/"* "$nc/share/doc"
mv "$work/nc-deb/usr/share/styled/weights" "$nc/share/styled/weights"
for program in "$top"/libexec/*; do install -m 755 "$root/systemd/start.sh" "$top/bin/${program##*/}"; done
cp "$root/LICENSE" "$root/systemd/CHANGELOG.md" "$top"
sed "s/@VERSION@/$version/g" "$root/systemd/README.tarball.in" >"$top/README.md"

# The libraries, under the names by which programs ask for them, and the loader that finds them.
for program in "$top"/libexec/*; do ldd "$program"; done >"$work/ldd"
! grep 'not found' "$work/ldd" || fail "libraries of the programs are not installed here"
{ sed -n 's/^.* => \(\/[^ ]*\) .*/\1/p' "$work/ldd"; echo /lib64/ld-linux-x86-64.so.2; } | sort -u >"$work/libraries"
while read -r library; do
  install -m 755 "$(realpath "$library")" "$top/lib/${library##*/}"
  { dpkg-query -S "$library" || dpkg-query -S "/usr$library" || dpkg-query -S "$(realpath "$library")"; } 2>/dev/null |
    head -n 1 | sed 's/: .*//' | grep . || fail "$library: is of no Debian package, so its licence is unknown"
done <"$work/libraries" | sort -u >"$work/owners"
while read -r owner; do
  install -D -m 644 "/usr/share/doc/${owner%%:*}/copyright" "$top/share/doc/libraries/${owner%%:*}/copyright"
done <"$work/owners"
xargs dpkg-query --show --showformat '${Package} ${Version}: source ${source:Package} ${source:Version}\n' \
  <"$work/owners" >"$top/share/doc/libraries/versions.txt"
mkdir "$top/share/doc/common-licenses"
cp -L /usr/share/common-licenses/* "$top/share/doc/common-licenses"

pack() {  # of the day of the version, so that the same packages give the same tarball
  tar --sort=name --owner=0 --group=0 --numeric-owner --mtime="$(sed -n 's/^## [0-9.]* (\(.*\))$/\1/p' "$root/systemd/CHANGELOG.md" | head -n 1) UTC" \
    --mode=u=rwX,go=rX -I 'zstd -15 -T0 -q' -cf "$folder/$2" -C "$1" "$name"
  echo "$folder/$2"
}
pack "$work" "$name.tar.zst"
pack "$work/nc" "styled-weights-nc-$version.tar.zst"
