#!/usr/bin/env bash
# Writes build/sources/compile_commands.json: one command per source, as clang-tidy and
# tests/realtime/effects.py need it. In build/release several sources are compiled at a time, with
# g++'s precompiled headers. The generated headers are those of build/release, which must be built.
set -euo pipefail
cd "$(dirname "$0")/.."
cmake --preset release -B build/sources -DSTYLED_UNITY=OFF -DSTYLED_PCH=OFF -DSTYLED_TESTS=ON \
  -DSTYLED_TRAIN=ON >build/sources.log 2>&1 || { tail -n 20 build/sources.log >&2; exit 1; }
sed -i "s|$PWD/build/sources/|$PWD/build/release/|g" build/sources/compile_commands.json
