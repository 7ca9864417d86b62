#!/usr/bin/env bash
# Makes a release in one folder: packages for this machine's Debian and architecture, and what was built elsewhere.
#   systemd/release.sh [--train] [--key ID] [--url URL] [--packages FOLDER]... [FOLDER]
#     --train, --key, --url  as of systemd/packages.sh
#     --packages FOLDER  takes in the .debs and bills of materials that systemd/packages.sh made on another Debian, or for
#             ARM64 (tests/arm64.sh --packages)
#     FOLDER  default build/release-VERSION; it must not exist, or be empty
# In it then: the packages, apt/ (a signed repository of them), the tarballs (systemd/tarball.sh), a container image
# (systemd/image.sh; as root), sbom-VERSION-ARCHITECTURE.spdx.json (systemd/sbom.py), CHANGELOG.md, and SHA256SUMS of all
# files, signed as the repository is. The build is build/package; the commit should have the tag that is named at the end.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/sim/setup.sh"
options=()
signing=()
elsewhere=()
while [[ "${1:-}" == --* ]]; do
  case $1 in
    --train) options+=("$1"); shift ;;
    --key | --url) signing+=("$1" "${2:?$1: expected a value}"); shift 2 ;;
    --packages)
      compgen -G "${2:?--packages: expected a folder}/*.deb" >/dev/null || { echo "release.sh: --packages $2: expected .deb files, found none" >&2; exit 2; }
      elsewhere+=("$(realpath "$2")")
      shift 2
      ;;
    *) sed -n '2,11s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
  esac
done
[ $# -le 1 ] || { echo "release.sh: expected one FOLDER, found $*" >&2; exit 2; }
version=$(sed -n 's/^project(styled VERSION \([0-9.]*\) .*/\1/p' "$root/CMakeLists.txt")
folder=$(realpath -m "${1:-$root/build/release-$version}")
[ -z "$(ls -A "$folder" 2>/dev/null)" ] || { echo "release.sh: $folder is not empty; name another folder, or remove it" >&2; exit 1; }
[ "$(id -u)" = 0 ] || { echo "release.sh: expected root: systemd/image.sh makes a system with its users" >&2; exit 1; }
styled_install release

"$root/systemd/packages.sh" "${options[@]}" "${signing[@]}" "$root/build/package"
[ -d "$root/build/package/web" ] || { echo "release.sh: the page could not be built; see build/package/npm/npm.log" >&2; exit 1; }
mkdir -p "$folder"
for packages in "$root/build/package" "${elsewhere[@]}"; do
  cp -n "$packages"/*.deb "$folder"
  cp "$packages"/*.spdx.json "$folder" || { echo "release.sh: $packages: has no bill of materials; systemd/packages.sh makes it" >&2; exit 1; }
done
if [ ${#elsewhere[@]} -gt 0 ]; then "$root/systemd/repository.sh" "${signing[@]}" "$folder"; fi
cp -r "$root/build/apt" "$folder/apt"
"$root/systemd/tarball.sh" "$root/build/package" "$folder"
"$root/systemd/image.sh" "$folder/apt" "$folder"
cp "$root/systemd/CHANGELOG.md" "$folder"
(cd "$folder" && find . -type f ! -name 'SHA256SUMS*' -printf '%P\0' | sort -z | xargs -0 sha256sum >SHA256SUMS)
key=()
for ((i = 0; i < ${#signing[@]}; i++)); do [ "${signing[i]}" != --key ] || key=(--local-user "${signing[i + 1]}"); done
[ ${#key[@]} -gt 0 ] || export GNUPGHOME=$root/build/apt-key
gpg --batch --quiet --yes "${key[@]}" --armor --detach-sign --output "$folder/SHA256SUMS.asc" "$folder/SHA256SUMS"
du -sh "$folder" | cut -f 1 | sed "s|^|$folder: |"
tag=$(git -C "$root" tag --points-at HEAD 2>/dev/null | grep -x "v$version" || true)
[ -n "$tag" ] || echo "the commit has no tag v$version; before it is handed out: git tag -s v$version"
