#!/usr/bin/env bash
# Makes the pictures of clients/guides and the film of README.md again, from the programs of build/release and in
# Chromium, in two minutes: tests/pictures.sh. By hand, when what they show has changed. On a machine that does nothing
# else: the film is in real time.
# apt: chromium python3-pil
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
build=$root/build/release
chromium=$(type -P chromium || type -P chromium-headless-shell)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$build/tests/e2e/web"
[ -d node_modules/playwright-core ] || npm ci --no-audit --no-fund >/dev/null
cp "$root"/tests/e2e/web/{house,doll,pictures}.mjs .
STYLED_BIN=$build/bin CHROMIUM=$chromium node pictures.mjs "$work" 2>"$work/log" || { tail "$work/log" >&2; exit 1; }
/usr/bin/python3 -B "$root/tests/pictures.py" "$work" "$root/clients/guides"
ls -l "$root"/clients/guides/*.webp
