// Writes the cases of tests/unit/mocopi/decode_cases.h, each to a file, as seeds of mocopi_fuzz.
#include "tests/fuzz/write_seeds.h"
#include "tests/unit/mocopi/decode_cases.h"

int main(int argc, char** argv) {
  std::vector<styled::mocopi::testing::Bytes> seeds;
  for (const auto& c : styled::mocopi::testing::DecodeCases()) seeds.push_back(c.bytes);
  return styled::fuzz::WriteSeeds(argc, argv, seeds);
}
