// The C++ client reads the goldens to the same numbers (README.md).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "clients/cpp/transforms.h"

namespace styled::client {
namespace {

using nlohmann::json;

json Golden(const std::string& name) {
  std::ifstream file(std::string(GOLDENS) + "/" + name + ".json");
  EXPECT_TRUE(file.good()) << name;
  return json::parse(file);
}

std::string Bytes(const json& hex) {
  const std::string text = hex;
  std::string bytes;
  for (std::size_t i = 0; i + 1 < text.size(); i += 2) {
    bytes.push_back(static_cast<char>(std::stoi(text.substr(i, 2), nullptr, 16)));
  }
  return bytes;
}

template <typename Repeated>
json List(const Repeated& values) {
  json list = json::array();
  for (const auto& value : values) list.push_back(value);
  return list;
}

std::string Base64(std::string_view bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (; !bytes.empty(); bytes.remove_prefix(std::min<std::size_t>(3, bytes.size()))) {
    unsigned three = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      three = three << 8 | (i < bytes.size() ? static_cast<unsigned char>(bytes[i]) : 0U);
    }
    for (std::size_t i = 0; i < 4; ++i) {
      text += i <= bytes.size() ? kDigits[three >> (18 - 6 * i) & 63] : '=';
    }
  }
  return text;
}

json Fields(const v1::Body& body) {
  return {{"performer", body.performer()},
          {"names", List(body.names())},
          {"parents", List(body.parents())},
          {"offsets", List(body.offsets())},
          {"rest", List(body.rest())},
          {"metres_per_unit", body.metres_per_unit()},
          {"dialect", body.dialect()},
          {"hash", std::to_string(body.hash())},
          {"output", static_cast<int>(body.output())},
          {"output_name", body.output_name()}};
}

json Fields(const v1::Frame& frame) {
  json styles = json::array(), expressions = json::array(), thru = json::array(),
       props = json::array(), timecode;
  for (const auto& style : frame.styles()) {
    styles.push_back({{"style", style.style()}, {"weight", style.weight()}});
  }
  for (const auto& expression : frame.expressions()) {
    expressions.push_back({{"name", expression.name()}, {"value", expression.value()}});
  }
  for (const auto& prop : frame.props()) {
    props.push_back({{"name", prop.name()},
                     {"position", List(prop.position())},
                     {"rotation", List(prop.rotation())}});
  }
  for (const std::string& bytes : frame.thru()) thru.push_back(Base64(bytes));
  if (frame.has_timecode()) {
    const v1::Timecode& code = frame.timecode();
    timecode = {{"hours", code.hours()},     {"minutes", code.minutes()},
                {"seconds", code.seconds()}, {"frames", code.frames()},
                {"rate", code.rate()},       {"drop_frame", code.drop_frame() ? 1 : 0}};
  }
  return {{"performer", frame.performer()},
          {"epoch", std::to_string(frame.epoch())},
          {"sequence", std::to_string(frame.sequence())},
          {"source_time_ns", std::to_string(frame.source_time_ns())},
          {"receive_time_ns", std::to_string(frame.receive_time_ns())},
          {"publish_time_ns", std::to_string(frame.publish_time_ns())},
          {"wall_time_ns", std::to_string(frame.wall_time_ns())},
          {"body_hash", std::to_string(frame.body_hash())},
          {"output", static_cast<int>(frame.output())},
          {"held_joints", List(frame.held_joints())},
          {"contacts", frame.contacts()},
          {"flags", frame.flags()},
          {"styles", styles},
          {"timecode", timecode},
          {"source_sequence", std::to_string(frame.source_sequence())},
          {"expressions", expressions},
          {"thru", thru},
          {"props", props}};
}

float Largest(const json& positions) {
  float largest = 1;
  for (const auto& position : positions) {
    for (const float value : position) largest = std::max(largest, std::abs(value));
  }
  return largest;
}

void ExpectNear(const Transform& got, const json& position, const json& rotation, float scale) {
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(got.position[k], position[k].get<float>(), 1e-5F * scale);
  Eigen::Vector4f expected(rotation[0], rotation[1], rotation[2], rotation[3]);
  if (expected.dot(got.rotation.coeffs()) < 0) expected = -expected;
  EXPECT_LT((got.rotation.coeffs() - expected).cwiseAbs().maxCoeff(), 1e-5F);
}

class ConformanceTest : public testing::TestWithParam<const char*> {};

TEST_P(ConformanceTest, ReadsTheSameNumbers) {
  const json golden = Golden(GetParam());
  v1::Body body;
  ASSERT_TRUE(body.ParseFromString(Bytes(golden["body"])));
  ASSERT_EQ(Validate(body), BodyError::kNone);
  EXPECT_EQ(Fields(body), golden["body_fields"]);
  ASSERT_EQ(golden["frames"].size(), 3U);
  for (const json& expected : golden["frames"]) {
    v1::Frame frame;
    ASSERT_TRUE(frame.ParseFromString(Bytes(expected["frame"])));
    EXPECT_EQ(Fields(frame), expected["fields"]);
    std::vector<Transform> world;
    ASSERT_EQ(WorldTransforms(body, frame, world), FrameError::kNone);
    ASSERT_EQ(world.size(), expected["positions"].size());
    for (std::size_t j = 0; j < world.size(); ++j) {
      SCOPED_TRACE(body.names(static_cast<int>(j)));
      ExpectNear(world[j], expected["positions"][j], expected["rotations"][j],
                 Largest(expected["positions"]));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Goldens, ConformanceTest,
                         testing::Values("canonical", "fifty-five-joints", "centimetres", "hand"),
                         [](const auto& info) {
                           std::string name = info.param;
                           std::erase(name, '-');
                           return name;
                         });

TEST(Conformance, RefusesWhatIsToBeRefused) {
  const json golden = Golden("refused");
  v1::Body body;
  ASSERT_TRUE(body.ParseFromString(Bytes(golden["body"])));
  ASSERT_EQ(Validate(body), BodyError::kNone);
  EXPECT_GE(golden["bodies"].size(), 10U);
  EXPECT_GE(golden["frames"].size(), 10U);
  for (const json& entry : golden["bodies"]) {
    v1::Body bad;
    EXPECT_FALSE(bad.ParseFromString(Bytes(entry["body"])) && Validate(bad) == BodyError::kNone)
        << entry["why"];
  }
  for (const json& entry : golden["frames"]) {
    v1::Frame bad;
    EXPECT_FALSE(bad.ParseFromString(Bytes(entry["frame"])) &&
                 Validate(bad, body) == FrameError::kNone)
        << entry["why"];
  }
}

}  // namespace
}  // namespace styled::client
