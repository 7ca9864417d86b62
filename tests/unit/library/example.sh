#!/bin/sh
# Builds and runs the example of libstyled in a folder of its own: example.sh COMPILER MODEL LIBRARIES
set -eu
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/include" "$work/lib"
cp "$2/library/styled.h" "$work/include/"
cp -P "$3"/libstyled.so* "$work/lib/"
cd "$work"
"$1" -Wall -Wextra -Werror -I include "$2/library/example.c" -L lib -lstyled -lm -o example
export LD_LIBRARY_PATH="$work/lib"
STYLED_WEIGHTS="$2/weights/open.safetensors" ./example zombie >out
cat out
[ "$(wc -l <out)" = 15 ]
grep -q '^leftUpperArm  *turned by  *[1-9]' out
! STYLED_WEIGHTS="$2/weights/open.safetensors" ./example nosuch 2>error
grep -q 'no such style' error
! STYLED_WEIGHTS=/nowhere ./example 2>error
grep -q /nowhere error
