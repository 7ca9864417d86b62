#!/bin/sh
# Fetches Qualisys' package from npm once, into the current folder; without it the test is skipped (77),
# and the tests that need it report it.
[ -d node_modules/qualisys-rt ] || npm ci --no-audit --no-fund >npm.log 2>&1 || {
  echo "skipped, npm cannot fetch qualisys-rt: $(tail -n 1 npm.log)"
  rm -rf node_modules
  exit 77
}
