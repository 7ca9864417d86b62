// Ten thousand damaged datagrams of every rig through the running daemon: each counted, nobody else
// disturbed.
#include <gtest/gtest.h>

#include <random>

#include "sim/player/link.h"
#include "sim/rigs/rig.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"

namespace styled::support {
namespace {

constexpr int kDatagrams = 10000;

using Random = std::mt19937;

// A few bits flipped, cut short, made longer, or a run of bytes written over.
Bytes Mutated(std::span<const std::byte> datagram, Random& random) {
  Bytes bytes(datagram.begin(), datagram.end());
  const auto below = [&random](std::size_t limit) {
    return random() % std::max<std::size_t>(limit, 1);
  };
  const auto any = [&random] { return static_cast<std::byte>(random() & 0xFFU); };
  switch (below(4)) {
    case 0:
      for (std::size_t i = 0; i < 1 + below(8); ++i) {
        bytes[below(bytes.size())] ^= static_cast<std::byte>(1U << below(8));
      }
      break;
    case 1:
      bytes.resize(below(bytes.size()));
      break;
    case 2:
      for (std::size_t i = 0; i < 1 + below(64); ++i) bytes.push_back(any());
      break;
    default: {
      const std::size_t at = below(bytes.size());
      for (std::size_t i = at; i < std::min(bytes.size(), at + 1 + below(16)); ++i)
        bytes[i] = any();
    }
  }
  return bytes;
}

class MutatedTest : public testing::TestWithParam<std::string> {};

TEST_P(MutatedTest, TenThousandDamagedDatagramsAreCountedAndDisturbNobodyElse) {
  auto rig = rigs::Make(GetParam(), {{"sim"}, 60, 1, {}});
  ASSERT_TRUE(rig.ok()) << rig.status().message();
  const bool server = rig.value()->is_server();
  std::string keys;
  std::unique_ptr<player::Link> link;
  if (server) {
    std::string bound;
    link = std::move(player::Listen("udp://127.0.0.1:0", &bound).value());
    keys = "server = \"" + bound.substr(6) + "\"\nmulticast = false\n";
  }
  Daemon daemon({}, "[[source]]\nname = \"suit\"\ntype = \"" + GetParam() +
                        "\"\nlisten = \"127.0.0.1:0\"\n" + keys);
  if (!server) link = std::move(player::Connect("udp://" + daemon.listens.at(2), 1000).value());
  Subscriber subscriber(daemon.publish, {"body/rig.a/", "styled/rig.a/"});
  ControlClient control(daemon.control);
  const UdpLink other(daemon.udp);
  Rig undisturbed("a");
  other.Send(undisturbed.Body());
  ASSERT_TRUE(subscriber.WaitForBody());

  Random random(7);
  Bytes received(65536);
  const auto answer = [&](std::span<const std::byte> bytes) { (void)link->Answer(bytes); };
  const body::Pose pose;
  int sent = 0, frames = 0;
  for (std::uint64_t index = 0; sent < kDatagrams; ++index) {
    if (server && control.Status().sources(2).received() == 0) sent = 0;  // nobody asked yet
    for (std::size_t size = 0; (size = link->Receive(received)) > 0;) {
      rig.value()->Receive(std::span(received).first(size), answer);
    }
    rig.value()->Encode(
        {index, static_cast<double>(index) / 60, {&pose, 1}},
        [&](std::span<const std::byte> bytes) {
          // Now and then a whole one, so that there is a performer to disturb.
          const bool whole = index % 10 == 0;
          EXPECT_TRUE(
              link->Send(whole ? Bytes(bytes.begin(), bytes.end()) : Mutated(bytes, random)).ok());
          ++sent;
        });
    if (index % 20 == 0) {
      other.Send(undisturbed.Frame());
      ++frames;
      Sleep(0.002);  // no faster than a socket's buffer is emptied
    }
  }
  ASSERT_TRUE(subscriber.WaitForFrames(static_cast<std::size_t>(frames), "styled/rig.a/rig/"))
      << daemon.Log();
  EXPECT_EQ(control.Performer("rig.a").lost(), 0U);
  const std::uint64_t dropped = control.Counter("source.kernel_dropped");
  EXPECT_GE(control.Status().sources(2).received() + dropped, static_cast<std::uint64_t>(sent))
      << "a server's first ones, before the daemon asked, reach nobody";
  EXPECT_GT(control.Counter("source.malformed"), 100U);
  EXPECT_EQ(daemon.Stop(), 0) << daemon.Log();
}

INSTANTIATE_TEST_SUITE_P(EveryRig, MutatedTest,
                         testing::Values("mocopi", "mvn", "natnet", "rokoko", "slimevr", "vmc"),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace styled::support
