// Writes the datagrams of tests/unit/mvn/packets.h, each to a file, as seeds of mvn_fuzz.
#include "tests/fuzz/write_seeds.h"
#include "tests/unit/mvn/packets.h"

int main(int argc, char** argv) {
  return styled::fuzz::WriteSeeds(argc, argv, styled::mvn::testing::Seeds());
}
