#!/bin/sh
# Fetches oscquery and bonjour-service from npm once, into the current folder; without them the test is
# skipped (77).
[ -d node_modules/oscquery ] || npm ci --no-audit --no-fund >npm.log 2>&1 || {
  echo "skipped, npm cannot fetch oscquery: $(tail -n 1 npm.log)"
  rm -rf node_modules
  exit 77
}
