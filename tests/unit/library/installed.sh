#!/bin/sh
# The C++ example against an installed libstyled: by pkg-config, and by CMake.
# installed.sh CMAKE CXX SOURCE BUILD
set -eu
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for component in library library_dev; do
  "$1" --install "$4" --prefix "$work/usr" --component "$component" >/dev/null
done
pc=$(find "$work/usr" -name libstyled.pc)
libraries=$(dirname "$(dirname "$pc")")
clip=$3/tests/parity/fixtures/synthetic.bvh
export STYLED_WEIGHTS="$3/model/weights/open.safetensors" LD_LIBRARY_PATH="$libraries"
if command -v pkg-config >/dev/null; then
  flags=$(PKG_CONFIG_PATH=$(dirname "$pc") pkg-config --cflags --libs libstyled)
  # shellcheck disable=SC2086  # several words
  "$2" -std=c++20 "$3/model/library/example.cpp" $flags -o "$work/by-pkg-config"
  "$work/by-pkg-config" "$clip" zombie "$work/one.bvh"
fi
mkdir "$work/by-cmake"
cat >"$work/by-cmake/CMakeLists.txt" <<TEXT
cmake_minimum_required(VERSION 3.21)
project(by_cmake LANGUAGES CXX)
set(CMAKE_CXX_STANDARD 20)
find_package(libstyled 0.1 REQUIRED)
add_executable(clips $3/model/library/example.cpp)
target_link_libraries(clips PRIVATE libstyled::libstyled)
TEXT
"$1" -G Ninja -S "$work/by-cmake" -B "$work/by-cmake/build" -DCMAKE_PREFIX_PATH="$work/usr" -DCMAKE_CXX_COMPILER="$2" >/dev/null
"$1" --build "$work/by-cmake/build" >/dev/null
"$work/by-cmake/build/clips" "$clip" zombie "$work/two.bvh"
[ ! -f "$work/one.bvh" ] || cmp "$work/one.bvh" "$work/two.bvh"
