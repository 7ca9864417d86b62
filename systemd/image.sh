#!/usr/bin/env bash
# Makes a container image of packages, as one file (an OCI archive), with programs that Debian has.
#   systemd/image.sh APT FOLDER
#     APT     the apt repository of systemd/repository.sh
#     FOLDER  gets styled-VERSION-image.oci.tar: podman load -i, skopeo copy oci-archive:...
# It has this machine's Debian, daemon, tools, web page and the weights open. systemd/Containerfile builds the same
# from the sources, with docker or podman. As root.
# apt: mmdebstrap umoci
set -euo pipefail
[ $# -eq 2 ] || { sed -n '2,7s/^# \{0,1\}//p' "$0" >&2; exit 2; }
fail() { echo "image.sh: $*" >&2; exit 1; }
[ "$(id -u)" = 0 ] || fail "expected root: mmdebstrap makes a system with its users"
for program in mmdebstrap umoci; do
  [ -n "$(type -P $program)" ] || fail "$program is missing: apt-get install mmdebstrap umoci"
done
apt=$(realpath "$1")
mkdir -p "$2"
folder=$(realpath "$2")
suite=$(. /etc/os-release && echo "${VERSION_CODENAME:?}")
architecture=$(dpkg --print-architecture)
sources=$apt/styled-$suite.sources  # of a repository with the packages of several Debians
[ -e "$sources" ] || sources=$apt/styled.sources
[ -e "$sources" ] || fail "$apt: expected an apt repository; systemd/packages.sh makes it"
deb=$(echo "$apt/pool/$suite"/main/styled_*_"$architecture".deb)
[ -e "$deb" ] || fail "$apt: expected one package styled for $suite and $architecture"
version=$(dpkg-deb -f "$deb" Version)
version=${version%%+*}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
chmod 755 "$work"
# The repository is in the chroot while its packages are installed, and only then. User and group have the numbers
# of the Containerfile, so that volumes and host agree about them.
mmdebstrap --quiet --variant=essential --include=systemd-standalone-sysusers,styled,styled-tools,styled-web \
  --aptopt='APT::Install-Recommends "false"' --dpkgopt='path-exclude=/usr/share/man/*' \
  --dpkgopt='path-exclude=/usr/share/locale/*' \
  --setup-hook="mkdir -p \"\$1/styled-apt\" && cp -r '$apt/.' \"\$1/styled-apt\"" \
  --setup-hook="sed 's|^URIs: .*|URIs: copy:'\"\$1\"'/styled-apt|' '$sources' >\"\$1/etc/apt/sources.list.d/styled.sources\"" \
  --essential-hook='echo styled:x:7000: >>"$1/etc/group"' \
  --essential-hook='echo styled-run:x:7000:7000::/var/lib/styled:/usr/sbin/nologin >>"$1/etc/passwd"' \
  --customize-hook='rm -r "$1/styled-apt" "$1/etc/apt/sources.list.d/styled.sources"' \
  --customize-hook='chroot "$1" install -d -o 7000 -g 7000 -m 0750 /var/lib/styled' \
  "$suite" "$work/root.tar" || fail "mmdebstrap could not make the system"
image=$work/oci:styled  # podman load calls it localhost/styled
umoci init --layout "$work/oci"
umoci new --image "$image"
umoci raw add-layer --image "$image" "$work/root.tar"
ports=(7000/udp 7000/tcp 7001/tcp 7002/tcp 39540/udp 9763/udp 9763/tcp 12351/udp 14043/udp 6969/udp 9000/udp 11111/udp 49983/udp)
umoci config --image "$image" --config.user 7000:7000 --config.env STYLED_STATE_DIR=/var/lib/styled \
  --config.env PATH=/usr/bin:/bin --config.entrypoint styled --config.cmd --config --config.cmd /etc/styled/styled.toml \
  --config.volume /etc/styled --config.volume /var/lib/styled --config.stopsignal SIGTERM --os linux \
  --architecture "$architecture" --config.label "org.opencontainers.image.version=$version" \
  --config.label org.opencontainers.image.licenses=Apache-2.0 "${ports[@]/#/--config.exposedports=}"
umoci gc --layout "$work/oci"
tar --sort=name --owner=0 --group=0 --numeric-owner -cf "$folder/styled-$version-image.oci.tar" -C "$work/oci" .
echo "$folder/styled-$version-image.oci.tar"
