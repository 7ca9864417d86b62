// Ten thousand damaged datagrams of every rig through the running daemon: each is counted, and no
// other performer is disturbed. The datagrams come from simulated rigs, and from captures of real
// ones where available.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <random>

#include "proto/rigs/natnet/packet.h"
#include "sim/player/link.h"
#include "sim/rigs/rig.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"
#include "tests/unit/mocopi/recording.h"
#include "tests/unit/natnet/capture.h"

namespace styled::support {
namespace {

constexpr std::uint64_t kDatagrams = 10000;

using Random = std::mt19937;

// Flips a few bits, truncates, extends, or overwrites a run of bytes.
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

// The sender: a simulated rig, or a capture of a real one.
class Sender {
 public:
  virtual ~Sender() = default;
  virtual bool is_server() const = 0;
  // The datagrams of one instant.
  virtual std::vector<Bytes> Next(std::uint64_t index) = 0;
  virtual std::vector<Bytes> Answers(std::span<const std::byte> datagram) = 0;
};

class StandIn final : public Sender {
 public:
  explicit StandIn(const std::string& type)
      : rig_(std::move(rigs::Make(type, {{"sim"}, 60, 1, {}}).value())) {}
  bool is_server() const override { return rig_->is_server(); }
  std::vector<Bytes> Next(std::uint64_t index) override {
    const body::Pose pose;
    std::vector<Bytes> out;
    rig_->Encode({index, static_cast<double>(index) / 60, {&pose, 1}},
                 [&](std::span<const std::byte> b) { out.emplace_back(b.begin(), b.end()); });
    return out;
  }
  std::vector<Bytes> Answers(std::span<const std::byte> datagram) override {
    std::vector<Bytes> out;
    rig_->Receive(datagram,
                  [&](std::span<const std::byte> b) { out.emplace_back(b.begin(), b.end()); });
    return out;
  }

 private:
  std::unique_ptr<rigs::Rig> rig_;
};

// Repeats randomly chosen captured packets.
class Captured : public Sender {
 public:
  explicit Captured(std::vector<Bytes> packets) : packets_(std::move(packets)) {}
  bool is_server() const override { return false; }
  std::vector<Bytes> Next(std::uint64_t /*index*/) override {
    return {packets_[random_() % packets_.size()]};
  }
  std::vector<Bytes> Answers(std::span<const std::byte> /*datagram*/) override { return {}; }
  std::size_t size() const { return packets_.size(); }

 private:
  std::vector<Bytes> packets_;
  Random random_{11};
};

// Motive's captured replies, sent to the corresponding requests.
class CapturedMotive final : public Captured {
 public:
  // The first packet of each kind is the reply.
  explicit CapturedMotive(const std::vector<Bytes>& packets) : Captured(packets) {
    for (const Bytes& bytes : packets) answers_.emplace(IdOf(bytes), bytes);
  }
  bool is_server() const override { return true; }
  std::vector<Bytes> Answers(std::span<const std::byte> datagram) override {
    using natnet::MessageId;
    static const std::map<MessageId, MessageId> kAnswer{
        {MessageId::kConnect, MessageId::kServerInfo},
        {MessageId::kDiscovery, MessageId::kServerInfo},
        {MessageId::kRequest, MessageId::kResponse},
        {MessageId::kRequestModelDef, MessageId::kModelDef},
        {MessageId::kEchoRequest, MessageId::kEchoResponse}};
    const auto answer = kAnswer.find(IdOf(datagram));
    if (answer == kAnswer.end()) return {};
    return {answers_.at(answer->second)};
  }

  static natnet::MessageId IdOf(std::span<const std::byte> bytes) {
    natnet::Packet packet;
    EXPECT_EQ(natnet::DecodePacket(bytes, packet), natnet::DecodeResult::kOk);
    return packet.id;
  }

 private:
  std::map<natnet::MessageId, Bytes> answers_;
};

// Sends ten thousand datagrams to a source "suit", beside another performer that must not be
// affected.
class MutatedTest : public testing::TestWithParam<std::string> {
 protected:
  void Run(const std::string& type, Sender& sender) {
    std::string keys;
    if (sender.is_server()) {
      std::string bound;
      link_ = std::move(player::Listen("udp://127.0.0.1:0", &bound).value());
      keys = "server = \"" + bound.substr(6) + "\"\nmulticast = false\ninterface = \"127.0.0.1\"\n";
    }
    daemon_ = std::make_unique<Daemon>(
        std::vector<std::string>{},
        "[[source]]\nname = \"suit\"\ntype = \"" + type + "\"\nlisten = \"127.0.0.1:0\"\n" + keys);
    control_ = std::make_unique<ControlClient>(daemon_->control);
    if (!sender.is_server()) {
      link_ = std::move(player::Connect("udp://" + daemon_->listens.at(2), 1000).value());
    }
    Subscriber subscriber(daemon_->publish, {"body/rig.a/", "styled/rig.a/"});
    const UdpLink other(daemon_->udp);
    styled::support::Rig undisturbed("a");
    other.Send(undisturbed.Body());
    ASSERT_TRUE(subscriber.WaitForBody());
    // A server sends only to clients that have connected.
    for (int i = 0; sender.is_server() && heard_ == 0 && i < 1000; ++i) {
      Answer(sender);
      Sleep(0.01);
    }

    Random random(7);
    std::uint64_t frames = 0;
    for (std::uint64_t index = 0; sent_ < kDatagrams; ++index) {
      Answer(sender);
      // Every tenth is undamaged, so that there is a performer to disturb.
      const bool whole = index % 10 == 0;
      for (const Bytes& bytes : sender.Next(index)) {
        EXPECT_TRUE(link_->Send(whole ? bytes : Mutated(bytes, random)).ok());
        ++sent_;
      }
      if (index % 20 != 0) continue;
      other.Send(undisturbed.Frame());
      ++frames;
      Sleep(0.002);
      // Not faster than the daemon empties its socket's buffer.
      if (index % 400 == 0) WaitUntilAllAreCounted(sender);
    }
    WaitUntilAllAreCounted(sender);
    ASSERT_TRUE(subscriber.WaitForFrames(frames, "styled/rig.a/rig/")) << daemon_->Log();
    EXPECT_EQ(subscriber.Count("styled/rig.a/rig/"), frames);
    EXPECT_EQ(control_->Performer("rig.a").received(), frames);
    EXPECT_EQ(control_->Performer("rig.a").lost(), 0U);
    EXPECT_EQ(Counted(), sent_ + answered_) << "not one more, not one less";
    EXPECT_EQ(control_->Counter("source.rate_limited"), 0U) << "each is looked at";
    EXPECT_GT(control_->Counter("source.malformed"), 1000U);
    suit_ = control_->Performer("suit.suit");
    // The log names the source, once per second.
    for (int i = 0; i < 200 && daemon_->Log().find("source.malformed: ") == std::string::npos; ++i)
      Sleep(0.05);
    EXPECT_EQ(daemon_->Stop(), 0) << daemon_->Log();
    const std::string log = daemon_->Log();
    const std::size_t line = log.find("source.malformed: ");
    ASSERT_NE(line, std::string::npos) << log;
    EXPECT_TRUE(log.substr(line, log.find('\n', line) - line).ends_with(" in all; source suit"))
        << log.substr(line, 100);
  }

  v1::PerformerStats suit_;

 private:
  void Answer(Sender& sender) {
    for (std::size_t size = 0; (size = link_->Receive(received_)) > 0;) {
      ++heard_;
      for (const Bytes& bytes : sender.Answers(std::span(received_).first(size))) {
        EXPECT_TRUE(link_->Answer(bytes).ok());
        ++answered_;
      }
    }
  }
  std::uint64_t Counted() {
    return control_->Status().sources(2).received() + control_->Counter("source.kernel_dropped");
  }
  void WaitUntilAllAreCounted(Sender& sender) {
    for (int i = 0; i < 1000 && Counted() != sent_ + answered_; ++i) {
      Answer(sender);
      Sleep(0.01);
    }
  }

  std::unique_ptr<Daemon> daemon_;
  std::unique_ptr<ControlClient> control_;
  std::unique_ptr<player::Link> link_;
  Bytes received_ = Bytes(65536);
  std::uint64_t sent_ = 0, answered_ = 0, heard_ = 0;
};

TEST_P(MutatedTest, TenThousandDamagedDatagramsAreCountedAndDisturbNobodyElse) {
  StandIn sender(GetParam());
  Run(GetParam(), sender);
}

INSTANTIATE_TEST_SUITE_P(EveryRig, MutatedTest,
                         testing::Values("mocopi", "mvn", "natnet", "rokoko", "slimevr", "vmc",
                                         "vrchat"),
                         [](const auto& info) { return info.param; });

using CapturedTest = MutatedTest;

// There are only two packets, so all undamaged frames are the same: one is accepted, the others are
// duplicates.
TEST_F(CapturedTest, TenThousandDamagedPacketsOfARealMocopiAreCountedAndDisturbNobodyElse) {
  const Bytes skeleton =
      mocopi::testing::ReadRecording("mocopi_sample_skdf.bin", STYLED_DATA_DEFAULT);
  const Bytes frame = mocopi::testing::ReadRecording("mocopi_sample_fram.bin", STYLED_DATA_DEFAULT);
  if (skeleton.empty() || frame.empty()) GTEST_SKIP() << "skipped, no data (set STYLED_DATA)";
  Captured sender({skeleton, frame});
  Run("mocopi", sender);
  EXPECT_GT(suit_.received(), 0U) << "there was a performer to disturb";
}

// A session with one rigid body and no skeleton: it exercises the decoder and the dialogue.
TEST_F(CapturedTest, TenThousandDamagedPacketsOfARealMotiveAreCountedAndDisturbNobodyElse) {
  const auto folder = natnet::testing::CaptureFolder(STYLED_DATA_DEFAULT);
  if (!std::filesystem::exists(folder / "traffic.pcapng")) {
    GTEST_SKIP() << "skipped, no data (set STYLED_DATA)";
  }
  std::vector<Bytes> packets;
  for (const char* name : {"serverinfo_packet_v3.bin", "modeldef_packet_v3.bin",
                           "mocapframe_packet_v3.bin", "mocapframe_packet_occluded_v3.bin"}) {
    packets.push_back(natnet::testing::ReadCaptured(folder / name));
  }
  using natnet::MessageId;
  const auto session =
      natnet::testing::ReadUdp(natnet::testing::ReadCaptured(folder / "traffic.pcapng"));
  for (const Bytes& bytes : session) {
    const MessageId id = CapturedMotive::IdOf(bytes);
    for (const MessageId of_server :
         {MessageId::kServerInfo, MessageId::kFrameOfData, MessageId::kResponse,
          MessageId::kEchoResponse, MessageId::kUnrecognized}) {
      if (id == of_server) packets.push_back(bytes);
    }
  }
  ASSERT_GT(packets.size(), 500U);
  CapturedMotive sender(packets);
  Run("natnet", sender);
}

}  // namespace
}  // namespace styled::support
