#!/bin/sh
# Fetches SlimeVR's packages from npm once, into the current folder; without them the test is skipped (77),
# and the tests that need them report it.
[ -d node_modules/@slimevr/tracker-emulation ] || npm ci --no-audit --no-fund >npm.log 2>&1 || {
  echo "skipped, npm cannot fetch @slimevr/tracker-emulation: $(tail -n 1 npm.log)"
  rm -rf node_modules
  exit 77
}
