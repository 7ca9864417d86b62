#!/bin/sh
# run.sh FOLDER: the witness over the files of FOLDER. Its programs are fetched from npm once, into the
# current folder; where they cannot be, the test is skipped (77).
[ -d node_modules/@pixiv/three-vrm-animation ] || npm ci --no-audit --no-fund >npm.log 2>&1 || {
  echo "skipped, npm cannot fetch the witnesses: $(tail -n 1 npm.log)"
  rm -rf node_modules
  exit 77
}
exec node witness.mjs "$1"
