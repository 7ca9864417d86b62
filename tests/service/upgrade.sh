#!/usr/bin/env bash
# Upgrades a Debian 12 that has older packages to Debian 13 and its packages by a repository, as an administrator does it:
# settings, learnt styles, keys and recordings must stay. By hand, as root, a quarter of an hour, with the network.
#   tests/service/upgrade.sh OLD DEBS
#     OLD   the folder of packages of an older version, built for Debian 12
#     DEBS  the folder of packages for Debian 13
#     STYLED_BASE in the environment: a folder that debootstrap made of bookworm, to save its time
# apt: debootstrap apt-utils gnupg
set -euo pipefail
[ $# -eq 2 ] || { sed -n '2,7s/^# \{0,1\}//p' "$0" >&2; exit 2; }
old=$(realpath "$1")
debs=$(realpath "$2")
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
root=$work/root
mounted=no
cleanup() {
  [ $mounted = no ] || umount "$root/proc"
  rm -rf --one-file-system "$work"
}
trap cleanup EXIT
. "$here/packages_common.sh"
case $(dpkg-deb -f "$debs"/styled_*.deb Version) in
  *+deb13*) ;;
  *) echo "upgrade.sh: $debs: expected packages for Debian 13" >&2; exit 1 ;;
esac
quietly "$here/../../systemd/repository.sh" --url file:/styled-apt "$debs" "$work/apt"

if [ -n "${STYLED_BASE:-}" ]; then cp -a "$STYLED_BASE" "$root"; else quietly debootstrap --variant=minbase bookworm "$root"; fi
mount -t proc proc "$root/proc"
mounted=yes
apt install ca-certificates
mkdir "$root/debs"
cp "$old"/styled_*.deb "$old"/styled-tools_*.deb "$old"/styled-web_*.deb "$root/debs"
quietly inside sh -c 'apt-get -q -y --no-install-recommends install /debs/*.deb'
rm -r "$root/debs"
version=$(inside dpkg-query -W -f '${Version}' styled)
cp "$here/../parity/fixtures/synthetic.bvh" "$root/tmp/pirate.bvh"
check "$version on Debian $(cut -d. -f1 "$root/etc/debian_version"): a frame's way, and a style" "$(during=$like runs elderly "${library[@]}")" elderly
check "the style of an example is there" "$(runs pirate "${library[@]}")" pirate
allow
echo '# mine' >>"$root/etc/styled/styled.toml"
(cd "$root/var/lib/styled" && find . -type f ! -name performers.toml ! -path './styles/*' -exec sha256sum {} + | sort) >"$work/kept"

cp -r "$work/apt" "$root/styled-apt"
cp "$work/apt/styled.sources" "$root/etc/apt/sources.list.d"
sed -i 's/bookworm/trixie/g' "$root"/etc/apt/sources.list
apt update
apt -o Dpkg::Options::=--force-confold full-upgrade
new=$(inside dpkg-query -W -f '${Version}' styled)
check "upgraded, to $new on Debian $(cut -d. -f1 "$root/etc/debian_version")" "${new##*+}" deb13
check "it tells where the weights are that were in it" "$(grep -c 'now in the package styled-weights-nc' "$work/log")" 1
check "tools and page came with it" "$(inside dpkg-query -W -f '${Version} ' styled-tools styled-web)" "$new $new "
check "it runs with open, and the style of the example is there" "$(runs pirate --weights open "${library[@]}")" pirate
apt install styled-weights-nc
check "it runs with the weights that it had, and the performer's style" "$(runs '' "${library[@]}")" pirate
check "so does another style" "$(runs elderly)" elderly
check "the changed configuration stayed" "$(tail -n 1 "$root/etc/styled/styled.toml")" "# mine"
check "keys and recordings stayed" \
  "$(cd "$root/var/lib/styled" && sha256sum --quiet -c "$work/kept" && grep -c 'keys/clients/anna.key' "$work/kept")" 1
[ $failed = 0 ] && echo "upgrade: all passed" || { echo "upgrade: FAILED"; exit 1; }
