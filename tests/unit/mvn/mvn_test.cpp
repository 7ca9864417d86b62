#include "proto/rigs/mvn/mvn.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <bit>
#include <cmath>

#include "proto/rigs/mvn/stream.h"
#include "tests/unit/mvn/packets.h"

namespace styled::mvn {
namespace {

using testing::Bytes;

DecodeResult PoseOf(const Bytes& bytes) {
  Header header;
  Pose pose;
  return DecodePose(bytes, header, pose);
}

// About x, then y, then z, all fixed.
Segment Turned(float x_deg, float y_deg, float z_deg) {
  constexpr float kRadians = 3.14159265F / 180;
  using Eigen::AngleAxisf, Eigen::Vector3f;
  const Eigen::Quaternionf q(AngleAxisf(kRadians * z_deg, Vector3f::UnitZ()) *
                             AngleAxisf(kRadians * y_deg, Vector3f::UnitY()) *
                             AngleAxisf(kRadians * x_deg, Vector3f::UnitX()));
  return {1, {}, {q.x(), q.y(), q.z(), q.w()}};
}

TEST(Mvn, RefusesWhatIsNoDatagramOfIts) {
  Header header;
  const Bytes good = testing::Quaternions();
  for (std::size_t size = 0; size < kHeaderSize; ++size) {
    EXPECT_EQ(DecodeHeader(std::span(good).first(size), header), DecodeResult::kTooShort) << size;
  }
  Bytes bad = good;
  bad[0] = std::byte{'N'};
  EXPECT_EQ(DecodeHeader(bad, header), DecodeResult::kBadMagic);
  bad = good;
  bad[5] = std::byte{'x'};
  EXPECT_EQ(DecodeHeader(bad, header), DecodeResult::kBadMagic);
}

TEST(Mvn, RefusesPosesThatAreCutLongOrTooMany) {
  const Bytes good = testing::Quaternions();
  for (std::size_t size = kHeaderSize; size < good.size(); ++size) {
    ASSERT_EQ(PoseOf({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)}),
              DecodeResult::kTooShort)
        << size;
  }
  Bytes longer = good;
  longer.push_back({});
  EXPECT_EQ(PoseOf(longer), DecodeResult::kLengthMismatch);
  EXPECT_EQ(PoseOf(testing::Quaternions(68)), DecodeResult::kTooManyItems);
  EXPECT_EQ(PoseOf(testing::Meta("name:a\n")), DecodeResult::kNotThisType);
}

TEST(Mvn, RefusesTextThatLeavesItsDatagramAndWhatIsNoTimecode) {
  std::string_view name;
  Bytes meta = testing::Meta("name:Anna\n");
  meta[kHeaderSize + 3] = std::byte{200};
  EXPECT_EQ(DecodeName(meta, name), DecodeResult::kBadText);
  meta[kHeaderSize] = std::byte{0xFF};  // a negative length
  EXPECT_EQ(DecodeName(meta, name), DecodeResult::kBadText);

  Scale scale;
  const Bytes good = testing::ScaleOf({"Pelvis", "L5"});
  for (std::size_t size = kHeaderSize; size + 4 < good.size(); ++size) {
    ASSERT_NE(DecodeScale(std::span(good).first(size), scale), DecodeResult::kOk) << size;
  }
  EXPECT_EQ(DecodeScale(testing::ScaleOf(std::vector<std::string>(68)), scale),
            DecodeResult::kTooManyItems);

  Timecode timecode;
  for (const char* text : {"10:20:30", "10:20:30.45x", "10-20-30.456", "10:20:30.4567"}) {
    EXPECT_EQ(DecodeTimecode(testing::TimecodeOf(text, false), timecode), DecodeResult::kBadText)
        << text;
  }
}

// The header and the Pelvis of a packet that MVN sent: the figures are from the project's notes on
// wouterpot/xsens-to-osc's capture, the bytes put together by hand (packets.h).
TEST(Mvn, ReadsTheHeaderAndThePelvisOfARealPacket) {
  const Bytes bytes = testing::Quaternions();
  ASSERT_EQ(bytes.size(), 760U) << "as the real one";
  Header header;
  Pose pose;
  ASSERT_EQ(DecodePose(bytes, header, pose), DecodeResult::kOk);
  EXPECT_EQ(header.type, Type::kQuaternion);
  EXPECT_EQ(header.sample, 0x1A19U);
  EXPECT_EQ(header.datagram, 0);
  EXPECT_TRUE(header.last);
  EXPECT_EQ(header.items, 23);
  EXPECT_EQ(header.time_ms, 0x6CBDU);
  EXPECT_EQ(header.character, 0);
  EXPECT_EQ(header.body_segments, 23);
  EXPECT_EQ(header.payload_size, 736);
  ASSERT_EQ(pose.count, 23);
  const Segment& pelvis = pose.segments[0];
  EXPECT_EQ(pelvis.id, 1U);
  EXPECT_EQ(pelvis.position, (std::array<float, 3>{0.06897729F, 0.41073215F, 1.04834807F}));
  EXPECT_EQ(pelvis.rotation,
            (std::array<float, 4>{-0.00467666F, -0.07288225F, -0.12879553F, 0.98897827F}))
      << "w comes first on the wire";
}

TEST(Mvn, ReadsEulerAnglesAboutXThenYThenZ) {
  Header header;
  Pose pose;
  ASSERT_EQ(DecodePose(testing::Eulers(), header, pose), DecodeResult::kOk);
  // 90 degrees about x, then 90 about the fixed z: y goes to z and stays; z goes to -y, then to x.
  const auto& q = pose.segments[22].rotation;
  const std::array<float, 4> expected{0.5F, 0.5F, 0.5F, 0.5F};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(q[i], expected[i], 1e-6F) << i;
  EXPECT_FLOAT_EQ(pose.segments[22].position[1], 104.834807F) << "centimetres, as they are";
}

// Eigen's rotation of the angles on the wire is the encoded one, upside down, too.
TEST(Mvn, WritesEulerAnglesOfAnyRotation) {
  std::vector<Segment> segments;
  for (const float x : {-170.0F, -90.0F, 0.0F, 31.0F, 180.0F}) {
    for (const float y : {-90.0F, -89.0F, 0.0F, 45.0F, 135.0F}) {
      for (const float z : {-120.0F, 0.0F}) segments.push_back(Turned(x, y, z));
    }
  }
  Header header;
  header.type = Type::kEuler;
  Bytes out(2000);
  const std::size_t size = EncodePose(header, segments, out);
  ASSERT_EQ(size, kHeaderSize + segments.size() * 28);
  out.resize(size);
  ASSERT_EQ(DecodeHeader(out, header), DecodeResult::kOk);
  EXPECT_EQ(header.type, Type::kEuler);
  EXPECT_EQ(header.payload_size, segments.size() * 28);
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const auto angle = [&](std::size_t axis) {
      std::uint32_t bits = 0;
      for (std::size_t k = 0; k < 4; ++k) {
        bits = bits << 8U | std::to_integer<std::uint32_t>(out[40 + 28 * i + 4 * axis + k]);
      }
      return std::bit_cast<float>(bits);
    };
    const auto& q = segments[i].rotation;
    const auto again = Turned(angle(0), angle(1), angle(2)).rotation;
    const float cosine = q[0] * again[0] + q[1] * again[1] + q[2] * again[2] + q[3] * again[3];
    EXPECT_GT(std::abs(cosine), 1 - 1e-6F) << i;
    EXPECT_LE(std::abs(angle(1)), 90.001F) << i;
  }
}

TEST(Mvn, ReadsNamesScaleAndBothKindsOfTimecode) {
  std::string_view name;
  const Bytes meta = testing::Meta("count:1\nname:Anna B\nxmid:7\nname2:no\n");
  ASSERT_EQ(DecodeName(meta, name), DecodeResult::kOk);
  EXPECT_EQ(name, "Anna B");
  const Bytes nameless = testing::Meta("color:FF0080");
  ASSERT_EQ(DecodeName(nameless, name), DecodeResult::kOk);
  EXPECT_EQ(name, "");

  Scale scale;
  const Bytes bytes = testing::ScaleOf({"Pelvis", "L5"});
  ASSERT_EQ(DecodeScale(bytes, scale), DecodeResult::kOk);
  ASSERT_EQ(scale.count, 2);
  EXPECT_EQ(scale.segments[1].name, "L5");
  EXPECT_EQ(scale.segments[1].position_m, (std::array<float, 3>{1, 0.25F, 1.5F}));

  for (const bool with_length : {false, true}) {
    Timecode timecode;
    ASSERT_EQ(DecodeTimecode(testing::TimecodeOf("10:20:30.456", with_length), timecode),
              DecodeResult::kOk);
    EXPECT_EQ(timecode.hours, 10U);
    EXPECT_EQ(timecode.minutes, 20U);
    EXPECT_EQ(timecode.seconds, 30U);
    EXPECT_EQ(timecode.milliseconds, 456U);
  }
}

TEST(Mvn, EncodesByteForByteWhatWasPutTogetherByHand) {
  Header header;
  Pose pose;
  Bytes out(2000);
  const auto written = [&out](std::size_t size) {
    return Bytes(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(size));
  };
  const Bytes quaternions = testing::Quaternions();
  ASSERT_EQ(DecodePose(quaternions, header, pose), DecodeResult::kOk);
  EXPECT_EQ(written(EncodePose(header, std::span(pose.segments).first(23), out)), quaternions);

  EXPECT_EQ(written(EncodeName(header, "Anna", out)), testing::Meta("name:Anna\n"));
  EXPECT_EQ(written(EncodeTimecode(header, {10, 20, 30, 456}, out)),
            testing::TimecodeOf("10:20:30.456", false));
  header.last = false;
  const std::array<Scale::Row, 2> rows{{{"Pelvis", {0, 0.25F, 1.5F}}, {"L5", {1, 0.25F, 1.5F}}}};
  EXPECT_EQ(written(EncodeScale(header, rows, out)), testing::ScaleOf({"Pelvis", "L5"}));
  EXPECT_EQ(EncodeScale(header, rows, std::span(out).first(50)), 0U) << "does not fit";
}

TEST(Mvn, CutsAStreamAtThePayloadsSizeOrWhereOldSendersLeaveItOutAtTheItems) {
  Bytes stream = testing::Quaternions();
  const std::size_t first = stream.size();
  for (const bool old : {false, true}) {
    if (old) stream[22] = stream[23] = std::byte{0};
    std::size_t size = 0;
    for (std::size_t have = 0; have < first; ++have) {
      ASSERT_EQ(CutRecord(std::span(stream).first(have), size), Cut::kNeedMore) << have;
    }
    ASSERT_EQ(CutRecord(stream, size), Cut::kRecord);
    EXPECT_EQ(size, first);
  }
  std::size_t size = 0;
  stream[1] = std::byte{'?'};
  EXPECT_EQ(CutRecord(stream, size), Cut::kBroken);
}

}  // namespace
}  // namespace styled::mvn
