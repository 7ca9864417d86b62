// Writes the cases of tests/unit/vrchat, each to a file, as seeds of vrchat_fuzz; then all of them
// in one bundle.
#include "tests/fuzz/write_seeds.h"
#include "tests/unit/vrchat/message_cases.h"

int main(int argc, char** argv) {
  std::vector<styled::vrchat::testing::Bytes> messages;
  for (const auto& c : styled::vrchat::testing::MessageCases()) messages.push_back(c.bytes);
  std::vector<std::vector<std::byte>> seeds(messages.begin(), messages.end());
  seeds.push_back(styled::vrchat::testing::Bundle(messages));
  return styled::fuzz::WriteSeeds(argc, argv, seeds);
}
