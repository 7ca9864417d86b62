#!/usr/bin/env bash
# Makes a signed apt repository of .deb files: a folder that any web server can serve, or file: can read.
#   systemd/repository.sh [--key ID] [--url URL] DEBS [FOLDER]
#     DEBS      the folder of the packages. Their versions tell for which Debian each was built (0.2.0+deb12), so that
#               those of several Debians and architectures may lie in it; one without is for this machine's
#     FOLDER    the repository; default build/apt. It is replaced when the new one is complete
#     --key ID  the key of your gpg keyring that signs (fingerprint, key id or address). Default: a key of
#               its own, made at the first call and kept, without a passphrase, in FOLDER-key
#     --url URL where clients will find FOLDER, for styled.sources; default: the folder itself (file:)
# In FOLDER then: dists/ and pool/, the public key styled.asc, and styled.sources, which has the key in it and
# is all that a client needs; with several Debians styled-trixie.sources and so on, one for each.
# daemon/OPERATING.md says how to serve it and how to install from it.
# apt: apt-utils gnupg
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
usage() { sed -n '3,10s/^# \{0,1\}//p' "$0" >&2; exit 2; }
fail() { echo "repository.sh: $*" >&2; exit 1; }
gpg() { command gpg --batch --quiet --no-auto-check-trustdb "$@"; }

key=
url=
while [ $# -gt 0 ]; do
  case $1 in
    --key | --url) [ -n "${2:-}" ] || usage; declare "${1#--}=$2"; shift 2 ;;
    -h | --help) sed -n '2,14s/^# \{0,1\}//p' "$0"; exit 0 ;;
    -*) usage ;;
    *) break ;;
  esac
done
[ $# -ge 1 ] && [ $# -le 2 ] || usage
for program in apt-ftparchive gpg; do
  [ -n "$(type -P $program)" ] || fail "$program is missing: apt-get install apt-utils gnupg"
done
compgen -G "$1/*.deb" >/dev/null || fail "$1: expected .deb files, found none; systemd/packages.sh builds them"
debs=$(realpath "$1")
folder=$(realpath -m "${2:-$root/build/apt}")
case $url in *[[:space:]]*) fail "--url '$url': expected an address without spaces" ;; esac
url=${url:-file:${folder// /%20}}
# A folder that is not a repository is not changed.
[ ! -e "$folder" ] || [ -e "$folder/dists" ] || [ -z "$(ls -A "$folder" 2>/dev/null || echo file)" ] ||
  fail "$folder: exists and is not an apt repository; name another folder"

mkdir -p "$(dirname "$folder")"
new=$(mktemp -d "$folder.new-XXXXXX")
chmod 755 "$new"  # apt reads it as its own user
own_home=no
cleanup() {
  [ $own_home = no ] || gpgconf --kill all || true  # the agent of a keyring that is used only here
  rm -rf "$new"
}
trap cleanup EXIT

if [ -z "$key" ]; then
  export GNUPGHOME=$folder-key
  own_home=yes
  mkdir -p -m 700 "$GNUPGHOME"
  gpg --list-secret-keys | grep -q . ||
    gpg --passphrase '' --quick-generate-key "Styled packages of $(hostname)" ed25519 sign never ||
    fail "$GNUPGHOME: gpg could not make a key"
  key=$(gpg --with-colons --list-secret-keys | awk -F: '$1 == "fpr" { print $10; exit }')
fi
gpg --list-secret-keys "$key" >/dev/null 2>&1 ||
  fail "--key $key: expected a secret key of ${GNUPGHOME:-$HOME/.gnupg}; gpg --list-secret-keys lists them"

here=$(. /etc/os-release && echo "${VERSION_CODENAME:-bookworm}")
suite_of() {  # suite_of VERSION: the codename of the system that a package is for
  case $1 in
    *+deb12*) echo bookworm ;;
    *+deb13*) echo trixie ;;
    *+ubuntu22.04*) echo jammy ;;
    *+ubuntu24.04*) echo noble ;;
    *) echo "$here" ;;
  esac
}
# apt-ftparchive only finds NAME_VERSION_ARCHITECTURE.deb, so a package gets the name from its own
# data.
for deb in "$debs"/*.deb; do
  named=$(dpkg-deb --show --showformat='${Package}_${Version}_${Architecture}' "$deb" 2>/dev/null) ||
    fail "$deb: is not a package: dpkg-deb cannot read it"
  # A client that must stay free of it leaves the component non-free out of styled.sources.
  component=main
  case $(dpkg-deb -f "$deb" Section) in non-free/*) component=non-free ;; esac
  pool=$new/pool/$(suite_of "$(dpkg-deb -f "$deb" Version)")/$component
  mkdir -p "$pool"
  cp "$deb" "$pool/${named//:/%3a}.deb"
done
cd "$new"
gpg --armor --export "$key" >styled.asc
suites=$(ls pool)
for suite in $suites; do
  components=$(ls "pool/$suite")
  architectures=$(for deb in pool/"$suite"/*/*.deb; do dpkg-deb -f "$deb" Architecture; done | sort -u | grep -vx all || true)
  architectures=${architectures:-$(dpkg --print-architecture)}
  for component in $components; do
    for architecture in $architectures; do
      packages=dists/$suite/$component/binary-$architecture/Packages
      mkdir -p "$(dirname "$packages")"
      apt-ftparchive --arch "$architecture" packages "pool/$suite/$component" >"$packages"
      gzip -9nk "$packages"
    done
  done
  # Written outside of the folder that it lists.
  release=$(apt-ftparchive -o APT::FTPArchive::Release::Origin=Styled -o APT::FTPArchive::Release::Label=Styled \
    -o APT::FTPArchive::Release::Suite="$suite" -o APT::FTPArchive::Release::Codename="$suite" \
    -o "APT::FTPArchive::Release::Components=${components//$'\n'/ }" \
    -o "APT::FTPArchive::Release::Architectures=${architectures//$'\n'/ }" \
    -o APT::FTPArchive::Release::MD5=no -o APT::FTPArchive::Release::SHA1=no release "dists/$suite")
  echo "$release" >"dists/$suite/Release"
  sign() { gpg --yes --local-user "$key" --digest-algo SHA512 "$@" "dists/$suite/Release"; }
  sign --clearsign --output "dists/$suite/InRelease"
  sign --armor --detach-sign --output "dists/$suite/Release.gpg"
  sources=styled-$suite.sources
  [ "$suite" != "$suites" ] || sources=styled.sources
  {
    printf '%s\n' 'Types: deb' "URIs: $url" "Suites: $suite" "Components: ${components//$'\n'/ }"
    # A client of one architecture need not read the lists of the others.
    case $architectures in *$'\n'*) ;; *) echo "Architectures: $architectures" ;; esac
    echo 'Signed-By:'
    sed 's/^$/./;s/^/ /' styled.asc
  } >"$sources"
done
count=$(cat dists/*/*/*/Packages | sed -n 's/^Filename: //p' | sort -u | wc -l)
all=$(find pool -name '*.deb' | wc -l)
[ "$count" = "$all" ] ||
  fail "$debs: $all packages, of which $count could be listed; nothing was replaced"
chmod -R u=rwX,go=rX .

cd /
if [ -e "$folder" ]; then mv -T "$folder" "$new.old"; fi
mv -T "$new" "$folder"
rm -rf "$new.old"
fingerprint=$(gpg --with-colons --list-secret-keys "$key" | awk -F: '$1 == "fpr" { print $10; exit }')
echo "$folder: $count packages, signed by $fingerprint"
echo "a client copies $(cd "$folder" && echo *.sources) of $folder to /etc/apt/sources.list.d"
