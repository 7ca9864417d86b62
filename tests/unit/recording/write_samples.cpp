// Writes recordings to files: `write_samples FOLDER`. whole.styrec for read_recording.py; and the
// seeds of the fuzzer, each whole one and each kind of damage.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "tests/unit/recording/samples.h"

namespace {

using styled::recording::testing::Bytes;
using styled::recording::testing::MakeSample;

bool Write(const std::filesystem::path& file, const Bytes& bytes) {
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()),
            static_cast<std::streamsize>(bytes.size()));
  return out.good();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: write_samples FOLDER\n");
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  const auto sample = MakeSample(4, 40);
  const auto small = MakeSample(2, 4);
  Bytes damaged = small.bytes, cut = small.bytes, holed = small.bytes;
  damaged[small.blocks[1] + 60] ^= std::byte{1};
  cut.resize(cut.size() - 7);
  holed.erase(holed.begin() + static_cast<std::ptrdiff_t>(small.blocks[1] + 10),
              holed.begin() + static_cast<std::ptrdiff_t>(small.blocks[1] + 30));
  const bool done =
      Write(folder / "whole.styrec", sample.bytes) && Write(folder / "small.styrec", small.bytes) &&
      Write(folder / "damaged.styrec", damaged) && Write(folder / "cut.styrec", cut) &&
      Write(folder / "holed.styrec", holed) && Write(folder / "empty.styrec", MakeSample(0).bytes);
  return done ? 0 : 1;
}
