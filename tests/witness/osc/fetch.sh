#!/bin/sh
# Fetches osc-min from npm once, into the current folder; without it the test is skipped (77), and the
# tests that need it report it.
[ -d node_modules/osc-min ] || npm ci --no-audit --no-fund >npm.log 2>&1 || {
  echo "skipped, npm cannot fetch osc-min: $(tail -n 1 npm.log)"
  rm -rf node_modules
  exit 77
}
