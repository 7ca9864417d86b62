// Writes walk.styrec, the synthetic performer as a rig in centimetres with Z up, and expected.json,
// where its joints are: `gltf_samples FOLDER`.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "model/body/pose.h"
#include "model/synthetic/performer.h"
#include "model/synthetic/script.h"
#include "proto/recording/writer.h"
#include "proto/styled/v1/body.pb.h"
#include "proto/styled/v1/frame.pb.h"

namespace {

using nlohmann::json;
using styled::body::Pose;
using styled::body::Quat;
using styled::body::Vec3;

constexpr int kFrames = 360, kEvery = 12;
constexpr double kRate_hz = 120;
const Quat kRigFromCanonical(Eigen::AngleAxisf(1.57079633F, Vec3::UnitX()));

styled::v1::Body MakeBody() {
  styled::v1::Body body;
  body.set_performer("rig.walk");
  body.set_output(styled::v1::OUTPUT_RIG);
  body.set_hash(1);
  body.set_metres_per_unit(0.01F);
  for (int joint = 0; joint < styled::body::kJointCount; ++joint) {
    body.add_names(std::string(styled::body::kHumanoid[joint].name));
    body.add_parents(styled::body::kHumanoid[joint].parent);
    const Vec3 offset = kRigFromCanonical * styled::body::Offset(joint) * 100;
    for (const float value : offset) body.add_offsets(value);
    for (const float value : {0.0F, 0.0F, 0.0F, 1.0F}) body.add_rest(value);
  }
  return body;
}

styled::v1::Frame MakeFrame(const Pose& pose, int i) {
  styled::v1::Frame frame;
  frame.set_performer("rig.walk");
  frame.set_output(styled::v1::OUTPUT_RIG);
  frame.set_body_hash(1);
  frame.set_sequence(static_cast<std::uint64_t>(i + 1));
  frame.set_source_time_ns(static_cast<std::uint64_t>(5e9 + i * 1e9 / kRate_hz));
  const Vec3 root = kRigFromCanonical * pose.hips_position_m * 100;
  for (const float value : root) frame.add_root_position(value);
  for (const Quat& rotation : pose.rotations) {
    const Quat in_rig = kRigFromCanonical * rotation * kRigFromCanonical.conjugate();
    for (const float value : in_rig.coeffs()) frame.add_rotations(value);
  }
  return frame;
}

json Triple(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  std::filesystem::remove(folder / "walk.styrec");
  auto writer = styled::recording::FileWriter::Create(folder / "walk.styrec", {});
  if (!writer.ok()) return 1;
  const auto publish = [&](int i, const std::string& topic,
                           const google::protobuf::MessageLite& message) {
    styled::recording::Record record;
    record.set_time_ns(static_cast<std::int64_t>(i * 1e9 / kRate_hz));
    record.mutable_published()->set_topic(topic);
    record.mutable_published()->set_payload(message.SerializeAsString());
    return writer.value()->Add(record, record.time_ns()).ok();
  };
  json expected{{"names", json::array()},
                {"times", json::array()},
                {"metres", json::array()},
                {"units", json::array()}};
  for (const auto& row : styled::body::kHumanoid) expected["names"].push_back(row.name);
  if (!publish(0, "body/rig.walk/", MakeBody())) return 1;
  const auto script = styled::synthetic::ParseScript("walk:2,turn-left:1");
  styled::synthetic::Performer performer(styled::synthetic::Vary(3, 0, script.value()));
  Pose pose;
  for (int i = 0; i < kFrames; ++i) {
    performer.Pose(i / kRate_hz, pose);
    if (!publish(i, "source/rig.walk/", MakeFrame(pose, i))) return 1;
    if (i % kEvery != 0) continue;
    styled::body::WorldPose world;
    styled::body::ForwardKinematics(pose, world);
    json metres = json::array(), units = json::array();
    for (const Vec3& place : world.positions_m) {
      metres.push_back(Triple(place));
      units.push_back(Triple(kRigFromCanonical * place * 100));
    }
    expected["times"].push_back(i / kRate_hz);
    expected["metres"].push_back(metres);
    expected["units"].push_back(units);
  }
  std::ofstream(folder / "expected.json") << expected;
  return writer.value()->Flush().ok() ? 0 : 1;
}
