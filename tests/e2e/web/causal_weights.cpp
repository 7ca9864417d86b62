// causal_weights FILE: writes small random weights of family st-gcn-causal, which have a style
// encoder: styles "style1" to "style3".
#include <fstream>
#include <vector>

#include "tests/unit/net/stgcn_causal/random_weights.h"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::vector<std::byte> bytes = styled::stgcn_causal::RandomWeights(4, 16, 1).Bytes();
  std::ofstream file(argv[1], std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  return file.good() ? 0 : 1;
}
