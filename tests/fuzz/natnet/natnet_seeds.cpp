// Writes the cases of tests/unit/natnet/decode_cases.h, each to a file, as seeds of natnet_fuzz:
// the bitstream's major and minor number, then the packet.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "proto/rigs/natnet/dialogue.h"
#include "tests/unit/natnet/decode_cases.h"

namespace {

using namespace styled::natnet;
using namespace styled::natnet::testing;

bool Write(const std::filesystem::path& file, Version version, Packet packet) {
  Bytes bytes(2 + kMaxPacketSize);
  bytes[0] = std::byte{version.major};
  bytes[1] = std::byte{version.minor};
  bytes.resize(2 + EncodePacket(packet, std::span(bytes).subspan(2)));
  std::ofstream stream(file, std::ios::binary);
  stream.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  return static_cast<bool>(stream);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: natnet_seeds FOLDER\n");
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  int index = 0;
  for (const DecodeCase& c : DecodeCases()) {
    if (!Write(folder / std::to_string(index++), c.version, {c.id, c.payload})) return 1;
  }
  const Bytes info = Join(Text{"Motive"}, Any{249}, I32{2}, I32{3}, Any{15});
  const Bytes connect = Join(Text{"Ping"}, Any{265});
  const Bytes echo = Join(U64{1}, U64{2});
  const Bytes request = Join(Text{"FrameRate"});
  const Bytes number = Join(F32{120});
  for (const auto& [id, payload] : {std::pair{MessageId::kServerInfo, info},
                                    {MessageId::kConnect, connect},
                                    {MessageId::kEchoResponse, echo},
                                    {MessageId::kRequest, request},
                                    {MessageId::kResponse, number}}) {
    if (!Write(folder / std::to_string(index++), k30, {id, payload})) return 1;
  }
  return 0;
}
