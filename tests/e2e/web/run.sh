#!/bin/sh
# run.sh CHROMIUM: runs the page's test. Its driver is fetched from npm once, into the current
# folder; if that fails, the test is skipped (77).
[ -f "$STYLED_BIN/../web/index.html" ] || {
  echo "skipped, the page was not built"
  exit 77
}
[ -d node_modules/playwright-core ] && [ -d node_modules/three ] || npm ci --no-audit --no-fund >npm.log 2>&1 || {
  echo "skipped, npm cannot fetch its packages: $(tail -n 1 npm.log)"
  rm -rf node_modules
  exit 77
}
CHROMIUM=$1 exec node --test page.test.mjs
