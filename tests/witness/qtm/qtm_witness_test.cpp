// The stand-in for QTM, which is built of the codec that the daemon reads with, by Qualisys' own
// client: it is greeted, agrees on a version, and reads parameters and frames of markers with every
// value. It knows neither skeletons nor timecodes in frames.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "model/body/pose.h"
#include "sim/rigs/qtm.h"
#include "sim/rigs/qtm_skeleton.h"
#include "sim/rigs/stream_server.h"
#include "tests/support/child.h"
#include "tests/support/rig.h"
#include "tests/support/temporary_folder.h"

namespace styled::support {
namespace {

using nlohmann::json;

constexpr int kFrames = 20;
constexpr double kRate_hz = 50;

bool HasClient() {
  return std::system("command -v node >/dev/null 2>&1") == 0 &&
         std::filesystem::exists(CLIENT_FOLDER "/node_modules/qualisys-rt");
}

// A pose that is another one in every frame.
body::Pose PoseAt(std::uint64_t index) {
  body::Pose pose;
  pose.hips_position_m = {0.01F * static_cast<float>(index), 0.9F, -0.5F};
  pose.rotations[body::kLeftUpperArm] =
      body::Quat(Eigen::AngleAxisf(0.02F * static_cast<float>(index), body::Vec3::UnitZ()));
  return pose;
}

// The output of the client, by its first word; the frames one after the other.
struct Printed {
  std::map<std::string, json> answers;
  std::vector<json> frames;
};

Printed RunClient(int minor) {
  auto rig = std::move(rigs::MakeQtm({{"anna"}, kRate_hz, 1, {}}).value());
  std::string url;
  const auto link = std::move(rigs::Listen(*rig, "tcp://127.0.0.1:0", &url).value());
  std::jthread server([&](const std::stop_token& stop) {
    for (std::uint64_t index = 0; !stop.stop_requested(); ++index) {
      link->Receive({});
      const body::Pose pose = PoseAt(index);
      rig->Encode({index, static_cast<double>(index) / kRate_hz, {&pose, 1}},
                  [&](std::span<const std::byte> bytes) { EXPECT_TRUE(link->Send(bytes).ok()); });
      Sleep(1 / kRate_hz);
    }
  });
  TemporaryFolder folder;
  Child node({"/bin/sh", "-c",
              "cd '" CLIENT_FOLDER "' && exec node client.mjs " + url.substr(url.rfind(':') + 1) +
                  " " + std::to_string(minor) + " " + std::to_string(kFrames) + " > '" +
                  std::string(folder / "out.txt") + "'"},
             folder / "stderr.txt");
  EXPECT_EQ(node.Wait(60).value_or(-1), 0) << ReadText(folder / "stderr.txt");
  Printed printed;
  std::istringstream lines(ReadText(folder / "out.txt"));
  for (std::string what, rest; lines >> what && std::getline(lines, rest);) {
    const json value = json::parse(rest, nullptr, false);
    EXPECT_FALSE(value.is_discarded()) << rest;
    what == "frame" ? printed.frames.push_back(value) : void(printed.answers[what] = value);
  }
  return printed;
}

class QtmWitnessTest : public testing::TestWithParam<int> {
 protected:
  void SetUp() override {
    if (!HasClient()) GTEST_SKIP() << "skipped, no qualisys-rt (npm)";
  }
};

TEST_P(QtmWitnessTest, ReadsVersionParametersAndFrames) {
  const Printed printed = RunClient(GetParam());
  const auto& answers = printed.answers;
  ASSERT_TRUE(answers.contains("error")) << "it came to the end of its questions";
  EXPECT_EQ(answers.at("version")["human"], "QTM 2024.3 (build 0)");
  EXPECT_EQ(answers.at("byteOrder"), "little endian");
  EXPECT_EQ(answers.at("state")["name"], "Capture Started");
  EXPECT_EQ(answers.at("general")["general"]["frequency"], kRate_hz);
  EXPECT_EQ(answers.at("space")["the3d"]["labels"].size(), 21U);
  EXPECT_EQ(answers.at("space")["the3d"]["axisUpwards"], "+z") << "it lowers all letters";
  const json& skeleton = answers.at("skeleton")["skeletons"]["skeleton"];
  EXPECT_EQ(skeleton["name"], "anna");
  const bool nested = GetParam() >= qtm::kNestedMinor;
  const json& segments = nested ? skeleton["segments"]["segment"] : skeleton["segment"];
  const json& hips = nested ? segments : segments[0];
  EXPECT_EQ(hips["name"], "hips");
  EXPECT_EQ(hips["id"], std::to_string(rigs::kQtmFirstId));
  EXPECT_EQ(nested ? hips["segment"].size() : segments.size(), nested ? 3U : rigs::kQtmSegments);
  EXPECT_EQ(answers.at("error")["type"], "Error");
  EXPECT_EQ(answers.at("error")["text"], std::string("Parse error\0", 12));
  EXPECT_EQ(answers.at("current")["components"]["3d"]["markerCount"], 21);

  ASSERT_EQ(printed.frames.size(), static_cast<std::size_t>(kFrames));
  for (const json& frame : printed.frames) {
    const auto number = frame["frame"].get<std::uint64_t>();
    EXPECT_EQ(number, printed.frames[0]["frame"].get<std::uint64_t>() +
                          static_cast<std::uint64_t>(&frame - printed.frames.data()));
    // It shifts the time's lower half by eight bits, in 32 bits, and adds the upper half.
    const auto time_us =
        static_cast<std::uint32_t>(std::llround(static_cast<double>(number - 1) / kRate_hz * 1e6));
    EXPECT_EQ(std::stoll(frame["timestamp"].get<std::string>()),
              static_cast<std::int32_t>(time_us << 8U));
    EXPECT_EQ(frame["components"].size(), 1U) << "what it asked for alone";
    body::WorldPose world;
    body::ForwardKinematics(PoseAt(number - 1), world);
    const json& markers = frame["components"]["3d"]["markers"];
    ASSERT_EQ(markers.size(), world.positions_m.size());
    for (std::size_t j = 0; j < markers.size(); ++j) {
      // Millimetres, +Z up, the performer faces -Y.
      const body::Vec3& at = world.positions_m[j];
      EXPECT_NEAR(markers[j]["x"].get<float>(), 1000 * at.x(), 0.01F) << j;
      EXPECT_NEAR(markers[j]["y"].get<float>(), -1000 * at.z(), 0.01F) << j;
      EXPECT_NEAR(markers[j]["z"].get<float>(), 1000 * at.y(), 0.01F) << j;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Versions, QtmWitnessTest, testing::Values(19, 25),
                         [](const auto& minor) { return "V1_" + std::to_string(minor.param); });

}  // namespace
}  // namespace styled::support
