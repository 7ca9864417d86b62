// The codec against packets that others made: single messages and a whole session of a Motive 2.1
// server (NatNet 3.0), captured by the authors of mje-nz/python_natnet (BSD-3). The numbers
// expected are those that their own tests checked against OptiTrack's sample client. One rigid
// body and marker sets, no skeleton.
#include "tests/unit/natnet/capture.h"

#include <gtest/gtest.h>

#include <map>

#include "proto/rigs/natnet/dialogue.h"
#include "proto/rigs/natnet/frame.h"

namespace styled::natnet {
namespace {

using testing::Bytes;
using testing::ReadUdp;

constexpr Version k30{3, 0};

std::filesystem::path Folder() { return testing::CaptureFolder(STYLED_DATA_DEFAULT); }
Bytes ReadFile(const std::string& name) { return testing::ReadCaptured(Folder() / name); }

class Capture : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(Folder() / "traffic.pcapng")) {
      GTEST_SKIP() << "skipped, no data in " << Folder() << " (set STYLED_DATA)";
    }
  }
  // The payload of a message in a file of its own.
  std::span<const std::byte> Payload(const std::string& name, MessageId id) {
    bytes_ = ReadFile(name);
    Packet packet;
    EXPECT_EQ(DecodePacket(bytes_, packet), DecodeResult::kOk) << name;
    EXPECT_EQ(packet.id, id) << name;
    return packet.payload;
  }
  Bytes bytes_;
};

TEST_F(Capture, HoldsAConnectThatWeWriteAlike) {
  for (const auto& [name, id] : {std::pair{"connect_packet_v3.bin", MessageId::kConnect},
                                 {"discovery_packet_v3.bin", MessageId::kDiscovery}}) {
    Connect connect;
    DecodeConnect(Payload(name, id), connect);
    EXPECT_EQ(connect.shape, Connect::Shape::kRecord);
    EXPECT_EQ(connect.name, "NatNetLib");
    EXPECT_EQ(connect.application, k30);
    EXPECT_EQ(connect.natnet, k30);
    Bytes again(bytes_.size());
    ASSERT_EQ(EncodeConnect(connect, again), bytes_.size());
    again[0] = bytes_[0];  // DISCOVERY has the same payload
    EXPECT_EQ(again, bytes_);
  }
}

TEST_F(Capture, HoldsAServerInfo) {
  ServerInfo info;
  ASSERT_EQ(DecodeServerInfo(Payload("serverinfo_packet_v3.bin", MessageId::kServerInfo), info),
            DecodeResult::kOk);
  EXPECT_EQ(info.name, "Motive");
  EXPECT_EQ(info.application, (Version{2, 1}));
  EXPECT_EQ(info.natnet, k30);
  ASSERT_TRUE(info.connection);
  EXPECT_EQ(info.connection->clock_hz, 3312787U);
  EXPECT_EQ(info.connection->data_port, kDataPort);
  EXPECT_TRUE(info.connection->multicast);
  EXPECT_EQ(info.connection->group, (std::array<std::uint8_t, 4>{239, 255, 42, 99}));
  // Ours is as long, and the same behind the name, after whose end Motive leaves garbage.
  Bytes again(bytes_.size());
  ASSERT_EQ(EncodeServerInfo(info, again), bytes_.size());
  EXPECT_TRUE(std::equal(again.begin() + 260, again.end(), bytes_.begin() + 260));
}

TEST_F(Capture, HoldsEchoes) {
  Echo echo;
  ASSERT_EQ(DecodeEchoRequest(Payload("echorequest_packet_v3.bin", MessageId::kEchoRequest), echo),
            DecodeResult::kOk);
  EXPECT_EQ(echo.client, 278554190U);
  ASSERT_EQ(Payload("echoresponse_packet_v3.bin", MessageId::kEchoResponse).size(), 16U);
  Bytes again(bytes_.size());
  ASSERT_EQ(EncodeEchoResponse({278554190, 1416498545924}, again), again.size());
  EXPECT_EQ(again, bytes_);
}

TEST_F(Capture, HoldsAModelWithoutSkeletons) {
  EXPECT_TRUE(Payload("requestmodeldef_packet_v3.bin", MessageId::kRequestModelDef).empty());
  static Model model;
  ASSERT_EQ(DecodeModel(Payload("modeldef_packet_v3.bin", MessageId::kModelDef), k30, model),
            DecodeResult::kOk);
  EXPECT_TRUE(model.complete);
  EXPECT_EQ(model.rigid_body_count, 1U);
  ASSERT_EQ(model.rigid_bodies_read, 1U);
  EXPECT_EQ(model.rigid_bodies[0].name, "RaceQuad");
  EXPECT_EQ(model.rigid_bodies[0].id, 2);
  EXPECT_EQ(model.rigid_bodies[0].parent, -1);
  EXPECT_EQ(model.skeleton_count, 0U);
}

TEST_F(Capture, HoldsAFrame) {
  static Frame frame;
  ASSERT_EQ(DecodeFrame(Payload("mocapframe_packet_v3.bin", MessageId::kFrameOfData), k30, frame),
            DecodeResult::kOk);
  EXPECT_EQ(frame.number, 162734);
  EXPECT_EQ(frame.rigid_body_count, 1U);
  ASSERT_EQ(frame.rigid_bodies_read, 1U);
  const Bone& quad = frame.rigid_bodies[0];
  EXPECT_EQ(quad.id, 2);
  EXPECT_TRUE(quad.tracked);
  const std::array<float, 7> pose{0.1744466F, 1.4471314F, -0.7343040F, -0.0545942F,
                                  0.5099482F, 0.0437036F, -0.8573577F};
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_NEAR(i < 3 ? quad.position_m[i] : quad.rotation[i - 3], pose[i], 1e-6F) << i;
  }
  EXPECT_EQ(frame.skeleton_count, 0U);
  EXPECT_EQ(frame.timecode, 0U);
  EXPECT_NEAR(frame.timestamp_s, 1356.1166666666666, 1e-9);
  EXPECT_EQ(frame.exposure_ticks, 1416497730518U);
  EXPECT_EQ(frame.received_ticks, 1416497745808U);
  EXPECT_EQ(frame.transmit_ticks, 1416497748722U);
  EXPECT_EQ(frame.params, 0);
}

TEST_F(Capture, HoldsAFrameWithMarkerSets) {
  static Frame frame;
  ASSERT_EQ(DecodeFrame(Payload("mocapframe_packet_occluded_v3.bin", MessageId::kFrameOfData), k30,
                        frame),
            DecodeResult::kOk);
  EXPECT_EQ(frame.rigid_body_count, 1U);
  // In no other bitstream could the same bytes be a frame.
  for (const Version v : {Version{2, 7}, {2, 9}, {4, 1}, {4, 2}}) {
    EXPECT_NE(DecodeFrame(std::span(bytes_).subspan(kHeaderSize), v, frame), DecodeResult::kOk);
  }
}

TEST_F(Capture, HoldsASessionOfWhichEveryFrameEndsWhereItsPacketDoes) {
  static Frame frame;
  std::map<MessageId, int> seen;
  std::int32_t number = 0;
  double time_s = 0;
  for (const Bytes& bytes : ReadUdp(ReadFile("traffic.pcapng"))) {
    Packet packet;
    ASSERT_EQ(DecodePacket(bytes, packet), DecodeResult::kOk);
    ++seen[packet.id];
    if (packet.id != MessageId::kFrameOfData) continue;
    ASSERT_EQ(DecodeFrame(packet.payload, k30, frame), DecodeResult::kOk);
    if (number != 0) {
      EXPECT_EQ(frame.number, number + 1);
      EXPECT_NEAR(frame.timestamp_s - time_s, 1.0 / 120, 1e-6);
    }
    number = frame.number;
    time_s = frame.timestamp_s;
    EXPECT_EQ(frame.rigid_body_count, 1U);
    EXPECT_EQ(frame.skeleton_count, 0U);
  }
  EXPECT_EQ(seen[MessageId::kFrameOfData], 518);
  EXPECT_EQ(seen[MessageId::kServerInfo], 2);
  EXPECT_EQ(seen[MessageId::kEchoResponse], 9);
  EXPECT_EQ(seen[MessageId::kUnrecognized], 1);
}

TEST_F(Capture, HoldsTheAnswerToAQuestionForTheFrameRate) {
  bool asked = false;
  for (const Bytes& bytes : ReadUdp(ReadFile("traffic.pcapng"))) {
    Packet packet;
    ASSERT_EQ(DecodePacket(bytes, packet), DecodeResult::kOk);
    if (packet.id == MessageId::kRequest) asked = DecodeRequest(packet.payload) == "FrameRate";
    if (!asked || packet.id != MessageId::kResponse) continue;
    Bytes again(bytes.size());
    ASSERT_EQ(EncodeNumber(120, again), bytes.size());
    EXPECT_EQ(again, bytes);
    return;
  }
  FAIL() << "no answer";
}

}  // namespace
}  // namespace styled::natnet
