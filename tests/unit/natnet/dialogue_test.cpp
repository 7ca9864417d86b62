#include "proto/rigs/natnet/dialogue.h"

#include <gtest/gtest.h>

#include "tests/unit/natnet/bytes.h"

namespace styled::natnet {
namespace {

using namespace testing;

TEST(Packet, IsRefusedWithItsReason) {
  const std::pair<Bytes, DecodeResult> cases[] = {
      {{}, DecodeResult::kTooShort},
      {Join(I16{7}, Any{1}), DecodeResult::kTooShort},
      {Join(I16{7}, I16{1}), DecodeResult::kLengthMismatch},
      {Join(I16{7}, I16{3}, Any{4}), DecodeResult::kLengthMismatch},
      {Join(I16{7}, I16{5}, Any{4}), DecodeResult::kLengthMismatch},
      {Join(I16{7}, I16{4}, Any{4}), DecodeResult::kOk},
      {Join(I16{4}, I16{0}), DecodeResult::kOk},
  };
  for (const auto& [bytes, expected] : cases) {
    Packet packet{MessageId{12345}, {}};
    EXPECT_EQ(Name(DecodePacket(bytes, packet)), Name(expected)) << bytes.size();
    EXPECT_EQ(packet.id == MessageId{12345}, expected != DecodeResult::kOk);
  }
}

TEST(Packet, IsWrittenWithItsHeaderWhereItFits) {
  const Bytes payload = Join(Any{3});
  Bytes out(7);
  EXPECT_EQ(EncodePacket({MessageId::kKeepAlive, payload}, out), 7U);
  EXPECT_EQ(out, Join(I16{10}, I16{3}, Any{3}));
  Bytes small(6);
  EXPECT_EQ(EncodePacket({MessageId::kKeepAlive, payload}, small), 0U);
  EXPECT_EQ(EncodePacket({MessageId::kKeepAlive, {}}, std::span(out).first(3)), 0U);
  Bytes huge(70000);
  EXPECT_EQ(EncodePacket({MessageId::kResponse, Bytes(kMaxPacketSize - 3)}, huge), 0U);
}

TEST(ServerInfo, IsRefusedWhereItIsCutShort) {
  const Bytes whole = Join(Text{"Motive"}, Any{249}, Any{4}, I32{3}, Any{15});
  ServerInfo info;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const bool right = size == 264;  // 3.0 that says nothing of its connection
    EXPECT_EQ(DecodeServerInfo(std::span(whole).first(size), info),
              right ? DecodeResult::kOk : DecodeResult::kTruncated)
        << size;
  }
  EXPECT_EQ(DecodeServerInfo(whole, info), DecodeResult::kOk);
}

TEST(ServerInfo, OfA2xServerHasNoConnection) {
  const Bytes payload = Join(Text{"Motive"}, Any{249}, I32{9 << 8 | 1}, I32{9 << 8 | 2});
  ServerInfo info;
  ASSERT_EQ(DecodeServerInfo(payload, info), DecodeResult::kOk);
  EXPECT_EQ(info.name, "Motive");
  EXPECT_EQ(info.application, (Version{1, 9}));
  EXPECT_EQ(info.natnet, (Version{2, 9}));
  EXPECT_FALSE(info.connection);
}

TEST(ServerInfo, ComesBackAsItWasSent) {
  ServerInfo sent{.name = std::string_view("Motive"),
                  .application = {3, 1, 4, 0},
                  .natnet = {4, 1},
                  .connection = {}};
  sent.connection = ServerInfo::Connection{10'000'000, 1511, true, {239, 255, 42, 99}};
  Bytes out(300);
  out.resize(EncodeServerInfo(sent, out));
  EXPECT_EQ(out.size(), 283U);
  Packet packet;
  ServerInfo info;
  ASSERT_EQ(DecodePacket(out, packet), DecodeResult::kOk);
  EXPECT_EQ(packet.id, MessageId::kServerInfo);
  ASSERT_EQ(DecodeServerInfo(packet.payload, info), DecodeResult::kOk);
  EXPECT_EQ(info.name, "Motive");
  EXPECT_EQ(info.application, sent.application);
  EXPECT_EQ(info.natnet, sent.natnet);
  ASSERT_TRUE(info.connection);
  EXPECT_EQ(info.connection->clock_hz, 10'000'000U);
  EXPECT_EQ(info.connection->data_port, 1511);
  EXPECT_TRUE(info.connection->multicast);
  EXPECT_EQ(info.connection->group, (std::array<std::uint8_t, 4>{239, 255, 42, 99}));
}

TEST(ServerInfo, WithANameTooLongIsCutAndEnded) {
  const std::string name(400, 'x');
  Bytes out(300);
  ASSERT_EQ(EncodeServerInfo({name, {}, {2, 7}, {}}, out), 268U);
  ServerInfo info;
  ASSERT_EQ(DecodeServerInfo(std::span(out).subspan(4, 264), info), DecodeResult::kOk);
  EXPECT_EQ(info.name, name.substr(0, 255));
}

TEST(Connect, IsReadInEachOfItsShapes) {
  Connect connect;
  Bytes payload;
  const auto read = [&](Bytes bytes) {
    payload = std::move(bytes);
    DecodeConnect(payload, connect);
  };
  read({});
  EXPECT_EQ(connect.shape, Connect::Shape::kText);
  EXPECT_EQ(connect.name, "");
  read(Join(Text{"Ping"}));
  EXPECT_EQ(connect.shape, Connect::Shape::kText);
  EXPECT_EQ(connect.name, "Ping");
  read(Join(Text{"Ping"}, Any{251}, I32{3}, I32{4}));
  EXPECT_EQ(connect.shape, Connect::Shape::kRecord);
  EXPECT_EQ(connect.application, (Version{3}));
  EXPECT_EQ(connect.natnet, (Version{4}));
  read(Join(Text{"Ping"}, Any{259}, I16{4 << 8 | 1}, I16{1}, Any{2}));
  EXPECT_EQ(connect.shape, Connect::Shape::kBitstream);
  EXPECT_TRUE(connect.subscribed_only);
  EXPECT_EQ(connect.bitstream, (Version{4, 1, 0, 0x5A}));
}

TEST(Connect, IsWrittenAsClientsOf3And4Do) {
  Bytes out(300);
  const std::size_t record =
      EncodeConnect({Connect::Shape::kRecord, "NatNetLib", {3}, {3}, false, {}}, out);
  Bytes expected = Join(I16{0}, I16{264}, Text{"NatNetLib"});
  expected.resize(4 + 256);
  Part{Join(I32{3}, I32{3})}.AppendTo(expected);
  EXPECT_EQ(Bytes(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(record)), expected);

  const std::size_t size =
      EncodeConnect({Connect::Shape::kBitstream, {}, {}, {}, true, {4, 1}}, out);
  expected = Join(I16{0}, I16{270}, Text{"Ping"});
  expected.resize(4 + 264);
  Part{Join(I16{4 << 8 | 1}, I16{1}, I16{0})}.AppendTo(expected);
  EXPECT_EQ(Bytes(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(size)), expected);

  EXPECT_EQ(EncodeConnect({Connect::Shape::kText, "Ping", {}, {}, false, {}}, out), 9U);
}

TEST(Request, IsATextWithOrWithoutItsEnd) {
  const Bytes ended = Join(Text{"FrameRate"}, Any{5});
  EXPECT_EQ(DecodeRequest(ended), "FrameRate");
  EXPECT_EQ(DecodeRequest(std::as_bytes(std::span(std::string_view("FrameRate")))), "FrameRate");
  EXPECT_EQ(DecodeRequest({}), "");
}

TEST(Number, HasFourBytes) {
  Bytes out(8);
  EXPECT_EQ(EncodeNumber(120, out), 8U);
  EXPECT_EQ(out, Join(I16{3}, I16{4}, I32{0x42F00000}));
}

TEST(Echo, HasEightAndSixteenBytes) {
  Echo echo{1, 2};
  EXPECT_EQ(DecodeEchoRequest(Join(Any{7}), echo), DecodeResult::kTruncated);
  EXPECT_EQ(DecodeEchoRequest(Join(Any{9}), echo), DecodeResult::kTrailing);
  EXPECT_EQ(echo.client, 1U);
  EXPECT_EQ(echo.server, 2U);
  Bytes out(20);
  EXPECT_EQ(EncodeEchoResponse({5, 6}, out), 20U);
  ASSERT_EQ(DecodeEchoRequest(std::span(out).subspan(4, 8), echo), DecodeResult::kOk);
  EXPECT_EQ(echo.client, 5U);
  EXPECT_EQ(out, Join(I16{13}, I16{16}, I32{5}, I32{0}, I32{6}, I32{0}));
}

}  // namespace
}  // namespace styled::natnet
