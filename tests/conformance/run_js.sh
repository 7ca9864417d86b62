#!/bin/sh
# run_js.sh NODE: the JavaScript client's tests in STYLED_JS; skipped (77) where it was not built.
cd "$STYLED_JS" 2>/dev/null && [ -d dist ] || {
  echo "skipped, the JavaScript client was not built"
  exit 77
}
exec "$1" --test
