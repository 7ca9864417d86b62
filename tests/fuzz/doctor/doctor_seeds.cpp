// Writes datagrams of every format, bare and within IP packets, and a ruleset of nft as seeds of
// doctor_fuzz.
#include "tests/fuzz/write_seeds.h"
#include "tests/unit/mocopi/decode_cases.h"
#include "tests/unit/mvn/packets.h"
#include "tests/unit/native/decode_cases.h"
#include "tests/unit/natnet/decode_cases.h"
#include "tests/unit/rokoko/texts.h"
#include "tests/unit/slimevr/decode_cases.h"
#include "tests/unit/vmc/bytes.h"

namespace {

using Bytes = std::vector<std::byte>;

Bytes ToBytes(std::string_view text) {
  Bytes out;
  for (const char c : text) out.push_back(static_cast<std::byte>(c));
  return out;
}

// Wraps a datagram in IPv4 and UDP.
Bytes Packet(const Bytes& payload) {
  using namespace styled::slimevr::testing;
  const auto u16 = [](std::size_t value) {
    return Bytes{std::byte(value >> 8U & 0xFFU), std::byte(value & 0xFFU)};
  };
  return Join({Hex("45 00"), u16(28 + payload.size()),
               Hex("12 34 00 00 40 11 00 00 C0 00 02 09 C0 00 02 01 C3 50 26 23"),
               u16(8 + payload.size()), Hex("00 00"), payload});
}

constexpr std::string_view kRules =
    R"({"nftables":[{"chain":{"family":"inet","table":"t","name":"c","hook":"input","type":"filter",
"policy":"drop"}},{"chain":{"family":"inet","table":"t","name":"d"}},{"set":{"family":"inet",
"table":"t","name":"s","elem":[1,{"range":[2,3]}]}},{"rule":{"family":"inet","table":"t","chain":"c",
"expr":[{"match":{"op":"==","left":{"payload":{"protocol":"udp","field":"dport"}},"right":"@s"}},
{"accept":null}]}},{"rule":{"family":"inet","table":"t","chain":"c","expr":[{"vmap":{"key":
{"payload":{"protocol":"udp","field":"dport"}},"data":{"set":[[4,{"drop":null}],[5,{"jump":
{"target":"d"}}]]}}}]}},{"rule":{"family":"inet","table":"t","chain":"d","expr":[{"match":{"op":"!=",
"left":{"meta":{"key":"iifname"}},"right":"lo"}},{"goto":{"target":"c"}}]}}]})";

}  // namespace

int main(int argc, char** argv) {
  std::vector<Bytes> seeds = styled::mvn::testing::Seeds();
  using namespace styled;
  using natnet::testing::I16;
  using natnet::testing::Part;
  const Bytes frame = natnet::testing::FullFrame({3, 0});
  seeds.push_back(native::testing::MakeDatagram(native::Kind::kBody, 7, 0,
                                                ToBytes("\x0A\x04"
                                                        "anna")));
  seeds.push_back(mocopi::testing::GoodFrame());
  seeds.push_back(mocopi::testing::GoodSkeleton());
  seeds.push_back(vmc::testing::Bundle({vmc::testing::BoneMessage("Hips"),
                                        vmc::testing::OkMessage(), vmc::testing::TimeMessage(1)}));
  seeds.push_back(natnet::testing::Join(I16{7}, I16{static_cast<int>(frame.size())}, Part{frame}));
  seeds.push_back(ToBytes(rokoko::testing::kLayout3));
  seeds.push_back(slimevr::testing::kHandshake);
  seeds.push_back(slimevr::testing::kBundle);
  for (std::size_t i = 0, count = seeds.size(); i < count; ++i) seeds.push_back(Packet(seeds[i]));
  seeds.push_back(ToBytes(kRules));
  return fuzz::WriteSeeds(argc, argv, seeds);
}
