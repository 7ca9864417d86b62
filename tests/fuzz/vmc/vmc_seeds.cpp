// Writes the cases of tests/unit/vmc, each to a file, as seeds of vmc_fuzz; then all valid ones as
// one sequence of datagrams, and a few frames as each kind of sender sends them.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "tests/unit/vmc/message_cases.h"
#include "tests/unit/vmc/osc_cases.h"

namespace {

using namespace styled::vmc::testing;

void Append(Bytes& sequence, unsigned wait_ms, const Bytes& datagram) {
  if (datagram.size() > 4 * 255) return;
  sequence = sequence + Bytes{std::byte(wait_ms), std::byte(datagram.size() / 4)} + datagram;
}

Bytes Frames(bool time_first) {
  Bytes sequence;
  for (int i = 0; i < 4; ++i) {
    const auto value = static_cast<float>(i);
    const Bytes time = TimeMessage(value / 60);
    const Bytes thru = S("/VMC/Thru/a/b") + S(",s") + S("x");
    if (time_first) Append(sequence, 16, time);
    Append(sequence, time_first ? 0 : 16,
           Bundle({RootMessage(value), BoneMessage("Hips", value), BoneMessage("Head", value)}));
    Append(sequence, 0, Bundle({BlendMessage("Joy", value), ApplyMessage(), thru}));
    if (!time_first) Append(sequence, 0, Bundle({OkMessage(), time}));
  }
  return sequence;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: vmc_seeds FOLDER\n");
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  std::vector<Bytes> seeds{Frames(false), Frames(true)};
  Bytes sequence;
  for (const auto& c : OscCases()) {
    if (c.bytes.size() < 8192) seeds.push_back(c.bytes);
  }
  for (const auto& c : MessageCases()) {
    seeds.push_back(c.bytes);
    Append(sequence, 5, c.bytes);
  }
  seeds.push_back(sequence);
  for (const char* kind : {"Hmd", "Con", "Tra"}) {
    seeds.push_back(S("/VMC/Ext/" + std::string(kind) + "/Pos") + S(",sfffffff") + S("LHR-1") +
                    Floats({0, 1, 2, 0, 0, 0, 1}));
  }
  int index = 0;
  for (const Bytes& seed : seeds) {
    std::ofstream file(folder / std::to_string(index++), std::ios::binary);
    file.write(reinterpret_cast<const char*>(seed.data()),
               static_cast<std::streamsize>(seed.size()));
    if (!file) return 1;
  }
  return 0;
}
