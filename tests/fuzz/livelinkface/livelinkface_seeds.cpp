// Writes the cases of tests/unit/livelinkface/decode_cases.h, each to a file, as seeds.
#include "tests/fuzz/write_seeds.h"
#include "tests/unit/livelinkface/decode_cases.h"

int main(int argc, char** argv) {
  std::vector<styled::live_link_face::testing::Bytes> seeds;
  for (const auto& c : styled::live_link_face::testing::DecodeCases()) seeds.push_back(c.bytes);
  return styled::fuzz::WriteSeeds(argc, argv, seeds);
}
