// Writes the cases of tests/unit/slimevr/decode_cases.h, each to a file, as seeds of slimevr_fuzz.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "tests/unit/slimevr/decode_cases.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: slimevr_seeds FOLDER\n");
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  int index = 0;
  const auto write = [&](const styled::slimevr::testing::Bytes& bytes) {
    std::ofstream file(folder / std::to_string(index++), std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    return static_cast<bool>(file);
  };
  for (const auto& c : styled::slimevr::testing::ReportCases()) {
    if (!write(c.bytes)) return 1;
  }
  for (const auto& c : styled::slimevr::testing::UdpCases()) {
    if (!write(c.bytes)) return 1;
  }
  return 0;
}
