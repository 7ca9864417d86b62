#!/bin/sh
# build_page.sh CLIENTS ROOT BUILD OUT: builds the client library and the page in BUILD from a copy
# of the sources in CLIENTS (ROOT/proto contains the messages), and copies the page to OUT. Packages
# are fetched from npm when package-lock.json has changed; if that fails, a message is printed and
# no page is built.
set -eu
clients=$1 root=$2 build=$3 out=$4
mkdir -p "$build"
rm -rf "$build/js/src" "$build/js/test" "$build/js/test-support" "$build/web/page/src" "$build/web/page/public" \
  "$build/web/page/test"
(cd "$clients" && find package.json package-lock.json js web/page -type f \
  ! -path '*/node_modules/*' ! -path '*/dist/*' ! -path '*/gen/*' -print0 |
  tar -cf - --null -T -) | tar -xf - -C "$build"
cd "$build"
if ! cmp -s package-lock.json node_modules/.installed; then
  rm -rf node_modules
  if ! npm ci --no-audit --no-fund >npm.log 2>&1; then
    echo "styleweb will have no page: npm cannot fetch its packages: $(tail -n 1 npm.log)"
    rm -rf node_modules "$out"
    exit 0
  fi
  cp package-lock.json node_modules/.installed
fi
if ! STYLED_PROTO=$root npm run build >build.log 2>&1; then
  cat build.log >&2
  exit 1
fi
mv web/page/dist/packages.json web/page/packages.json  # of systemd/finish_packages.py, not of browsers
rm -rf "$out"
cp -r web/page/dist "$out"
touch page.stamp
