#pragma once

#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace styled::fuzz {

// The main function of a program that writes each entry of a case table to a file of a folder.
// Returns the exit code.
inline int WriteSeeds(int argc, char** argv, const std::vector<std::vector<std::byte>>& seeds) {
  if (argc != 2) {
    std::fprintf(stderr, "expected one argument, the folder\n");
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  int index = 0;
  for (const auto& bytes : seeds) {
    std::ofstream file(folder / std::to_string(index++), std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    if (!file) return 1;
  }
  return 0;
}

}  // namespace styled::fuzz
