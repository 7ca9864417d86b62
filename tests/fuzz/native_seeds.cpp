// Writes the cases of tests/unit/native/decode_cases.h, each to a file, as seeds of native_fuzz.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "tests/unit/native/decode_cases.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: native_seeds FOLDER\n");
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  int index = 0;
  for (const auto& c : styled::native::testing::DecodeCases()) {
    std::ofstream file(folder / std::to_string(index++), std::ios::binary);
    file.write(reinterpret_cast<const char*>(c.bytes.data()),
               static_cast<std::streamsize>(c.bytes.size()));
    if (!file) return 1;
  }
  return 0;
}
