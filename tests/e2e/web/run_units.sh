#!/bin/sh
# run_units.sh NPM: tests of the page's parts, where the page was built in ./npm; else skipped (77).
[ -d npm/node_modules/three ] || {
  echo "skipped, the page was not built"
  exit 77
}
cd npm && exec "$1" test -w styled-page
