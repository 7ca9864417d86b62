// Writes the cases of tests/unit/rokoko/texts.h and two LZ4 frames, each to a file, as seeds of
// rokoko_fuzz.
#include "tests/fuzz/write_seeds.h"
#include "tests/unit/rokoko/lz4_frames.h"
#include "tests/unit/rokoko/texts.h"

namespace {

std::vector<std::byte> ToBytes(std::span<const std::byte> bytes) {
  return {bytes.begin(), bytes.end()};
}

}  // namespace

int main(int argc, char** argv) {
  using namespace styled::rokoko;
  std::vector<std::vector<std::byte>> seeds;
  for (const auto& c : styled::rokoko::testing::DecodeCases()) {
    if (c.text.size() < 65536) seeds.push_back(ToBytes(std::as_bytes(std::span(c.text))));
  }
  seeds.push_back(ToBytes(std::as_bytes(std::span(styled::rokoko::testing::kLz4Default))));
  seeds.push_back(ToBytes(std::as_bytes(std::span(styled::rokoko::testing::kLz4BlockChecksums))));
  return styled::fuzz::WriteSeeds(argc, argv, seeds);
}
