# A project of its own: copy this folder anywhere, then
#   cmake -B build -DCMAKE_PREFIX_PATH=DIR && cmake --build build
# DIR is where Styled was installed; /usr and /usr/local are found without it.
cmake_minimum_required(VERSION 3.25)
project(example LANGUAGES CXX)
find_package(styled @PROJECT_VERSION_MAJOR@.@PROJECT_VERSION_MINOR@ REQUIRED)
add_executable(example example.cpp)
target_link_libraries(example PRIVATE styled::client)
