// Writes the cases of tests/unit/qtm/decode_cases.h, and a dialogue, as seeds of qtm_fuzz: streams.
#include "tests/fuzz/write_seeds.h"
#include "tests/unit/qtm/decode_cases.h"

int main(int argc, char** argv) {
  using namespace styled::qtm::testing;
  std::vector<Bytes> seeds;
  for (const DecodeCase& c : DecodeCases()) seeds.push_back(c.packet);
  seeds.push_back(Xml(kNestedXml));
  seeds.push_back(Xml(kFlatXml));
  seeds.push_back(Join(Part{Command("QTM RT Interface connected")}, Part{Error("Parse error")},
                       Part{EventOf(3)}, Part{styled::qtm::testing::Pack(4)},
                       Part{Data(1, 1, TwoSkeletons())}));
  return styled::fuzz::WriteSeeds(argc, argv, seeds);
}
