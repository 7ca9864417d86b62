#!/bin/sh
# Fetches the NATS project's package from npm once, into the current folder; without it the test is
# skipped (77), and the tests that need it report it.
[ -d node_modules/nats ] || npm ci --no-audit --no-fund >npm.log 2>&1 || {
  echo "skipped, npm cannot fetch nats: $(tail -n 1 npm.log)"
  rm -rf node_modules
  exit 77
}
