#!/bin/sh
# Builds and runs the examples of libstyled in a folder of their own: example.sh CC CXX SOURCE LIBRARIES
set -eu
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/include" "$work/lib"
library=$3/model/library
cp "$library/styled.h" "$library/styled.hpp" "$work/include/"
cp -P "$4"/libstyled.so* "$work/lib/"
cd "$work"
export LD_LIBRARY_PATH="$work/lib" STYLED_WEIGHTS="$3/model/weights/open.safetensors"

"$1" -Wall -Wextra -Werror -I include "$library/example.c" -L lib -lstyled -lm -o example
./example zombie >out
cat out
[ "$(wc -l <out)" = 15 ]
grep -q '^leftUpperArm  *turned by  *[1-9]' out
! ./example nosuch 2>error
grep -q 'no such style as nosuch; expected one of neutral angry' error
! STYLED_WEIGHTS=/nowhere ./example 2>error
grep -q /nowhere error

"$2" -std=c++20 -Wall -Wextra -Werror -I include "$library/example.cpp" -L lib -lstyled -o clips
clip=$3/tests/parity/fixtures/synthetic.bvh
./clips "$clip" zombie out.bvh >out
cat out
# The clip and the live performer, who knows the clip's neutral, end in the same place.
hips=$(sed -n 's/^live: .* at //p' out)
[ -n "$hips" ]
tail -n 1 out.bvh | awk -v hips="$hips" '{
  split(hips, h)
  for (i = 1; i <= 3; ++i) if (($i - h[i]) ^ 2 > 1e-5) { print "found", $1, $2, $3, "expected", hips; exit 1 }
}'
if cmp -s "$clip" out.bvh; then exit 1; fi
! ./clips "$clip" elderly out.bvh 2>error
grep -q "unknown style 'elderly', expected one of neutral, angry" error
! ./clips nosuch.bvh zombie out.bvh 2>error
grep -q nosuch.bvh error
