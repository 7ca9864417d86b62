#!/usr/bin/env bash
# Makes a release in one folder, for this machine's Debian and architecture.
#   systemd/release.sh [--train] [--key ID] [--url URL] [FOLDER]
#     --train, --key, --url  as of systemd/packages.sh
#     FOLDER  default build/release-VERSION; it must not exist, or be empty
# In it then: the packages, apt/ (a signed repository of them), the tarballs (systemd/tarball.sh), a container image
# (systemd/image.sh; as root), sbom.spdx.json (systemd/sbom.py), CHANGELOG.md, and SHA256SUMS of all files, signed as the
# repository is. The build is build/package; the commit should have the tag that is named at the end.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/sim/setup.sh"
options=()
while [[ "${1:-}" == --* ]]; do
  case $1 in
    --train) options+=("$1"); shift ;;
    --key | --url) options+=("$1" "${2:?$1: expected a value}"); shift 2 ;;
    *) sed -n '2,9s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
  esac
done
[ $# -le 1 ] || { echo "release.sh: expected one FOLDER, found $*" >&2; exit 2; }
version=$(sed -n 's/^project(styled VERSION \([0-9.]*\) .*/\1/p' "$root/CMakeLists.txt")
folder=$(realpath -m "${1:-$root/build/release-$version}")
[ -z "$(ls -A "$folder" 2>/dev/null)" ] || { echo "release.sh: $folder is not empty; name another folder, or remove it" >&2; exit 1; }
[ "$(id -u)" = 0 ] || { echo "release.sh: expected root: systemd/image.sh makes a system with its users" >&2; exit 1; }
styled_install release

"$root/systemd/packages.sh" "${options[@]}" "$root/build/package"
[ -d "$root/build/package/web" ] || { echo "release.sh: the page could not be built; see build/package/npm/npm.log" >&2; exit 1; }
mkdir -p "$folder"
cp "$root/build/package"/*.deb "$folder"
cp -r "$root/build/apt" "$folder/apt"
"$root/systemd/tarball.sh" "$folder" "$folder"
"$root/systemd/image.sh" "$folder/apt" "$folder"
python3 -B "$root/systemd/sbom.py" "$root/build/package" "$folder" >"$folder/sbom.spdx.json"
cp "$root/systemd/CHANGELOG.md" "$folder"
(cd "$folder" && find . -type f ! -name 'SHA256SUMS*' -printf '%P\0' | sort -z | xargs -0 sha256sum >SHA256SUMS)
key=()
for ((i = 0; i < ${#options[@]}; i++)); do [ "${options[i]}" != --key ] || key=(--local-user "${options[i + 1]}"); done
[ ${#key[@]} -gt 0 ] || export GNUPGHOME=$root/build/apt-key
gpg --batch --quiet --yes "${key[@]}" --armor --detach-sign --output "$folder/SHA256SUMS.asc" "$folder/SHA256SUMS"
du -sh "$folder" | cut -f 1 | sed "s|^|$folder: |"
tag=$(git -C "$root" tag --points-at HEAD 2>/dev/null | grep -x "v$version" || true)
[ -n "$tag" ] || echo "the commit has no tag v$version; before it is handed out: git tag -s v$version"
