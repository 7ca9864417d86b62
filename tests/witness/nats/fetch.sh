#!/bin/sh
# Fetches the NATS project's package from npm once, into the current folder; where it cannot be, the
# test is skipped (77), and those that need it say so.
[ -d node_modules/nats ] || npm ci --no-audit --no-fund >npm.log 2>&1 || {
  echo "skipped, npm cannot fetch nats: $(tail -n 1 npm.log)"
  rm -rf node_modules
  exit 77
}
