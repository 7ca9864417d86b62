// Writes the cases of tests/unit/ifacialmocap/texts.h, each to a file, as seeds.
#include <span>

#include "tests/fuzz/write_seeds.h"
#include "tests/unit/ifacialmocap/texts.h"

int main(int argc, char** argv) {
  std::vector<std::vector<std::byte>> seeds;
  for (const auto& c : styled::ifacialmocap::testing::DecodeCases()) {
    const auto bytes = std::as_bytes(std::span(c.text));
    seeds.emplace_back(bytes.begin(), bytes.end());
  }
  return styled::fuzz::WriteSeeds(argc, argv, seeds);
}
