#!/bin/sh
# run_units.sh NPM: unit tests of the page, if it was built in ./npm; otherwise skipped (77).
[ -d npm/node_modules/three ] || {
  echo "skipped, the page was not built"
  exit 77
}
cd npm && exec "$1" test -w styled-page
