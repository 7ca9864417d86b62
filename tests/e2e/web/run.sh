#!/bin/sh
# run.sh TEST CHROMIUM CAUSAL_WEIGHTS: runs a test of the page. Its driver is fetched from npm once,
# into the current folder; if that fails, the test is skipped (77). CAUSAL_WEIGHTS: the program that
# writes weights with a style encoder.
[ -f "$STYLED_BIN/../web/index.html" ] || {
  echo "skipped, the page was not built"
  exit 77
}
if ! cmp -s package-lock.json node_modules/.installed; then
  npm ci --no-audit --no-fund >npm.log 2>&1 || {
    echo "skipped, npm cannot fetch its packages: $(tail -n 1 npm.log)"
    rm -rf node_modules
    exit 77
  }
  cp package-lock.json node_modules/.installed
fi
"$3" causal.safetensors || exit 1
CAUSAL_WEIGHTS=$PWD/causal.safetensors CHROMIUM=$2 exec node --test "$1"
