#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "daemon/source/source_frame.h"
#include "model/rig/hands.h"

namespace styled::pipeline {

// A sender of fingers alone, as frames for the pipeline: a root, hands, and the fingers of
// `joints`.
class Glove {
 public:
  explicit Glove(const rig::TailSet& joints = rig::FingersOf(body::kLeftHand) |
                                              rig::FingersOf(body::kRightHand)) {
    auto body = std::make_shared<v1::Body>();
    const auto add = [&](std::string_view name, int parent, const rig::Vec3& offset_m) {
      body->add_names(std::string(name));
      body->add_parents(parent);
      for (const float value : offset_m) body->add_offsets(value);
      return body->names_size() - 1;
    };
    const int root = add("gloves", -1, rig::Vec3::Zero());
    left_hand = add("leftHand", root, {0.7F, 0, 0});
    right_hand = add("rightHand", root, {-0.7F, 0, 0});
    for (int t = 0; t < rig::kTailLeftEye; ++t) {
      if (!joints[static_cast<std::size_t>(t)]) continue;
      const int before = rig::TailBefore(t);
      const int hand = t < rig::kTailRightThumb ? left_hand : right_hand;
      const int parent = before >= 0 ? joint_of[static_cast<std::size_t>(before)] : hand;
      joint_of[static_cast<std::size_t>(t)] =
          add(rig::kTailNames[static_cast<std::size_t>(t)], parent, rig::FingerOffset_m(t));
    }
    body->set_metres_per_unit(1);
    turns.assign(static_cast<std::size_t>(body->names_size()), rig::Quat::Identity());
    message = std::move(body);
  }

  source::SourceFrame Body() {
    source::SourceFrame frame = Next();
    frame.is_body = true;
    frame.body = message;
    return frame;
  }
  // Its views are of this object, until the next call.
  source::SourceFrame Frame() {
    source::SourceFrame frame = Next();
    frame.source_time_ns = time_ns += 10'000'000;
    frame.root_position = std::as_bytes(std::span(root.data(), 3));
    frame.rotations = std::as_bytes(std::span(turns));
    return frame;
  }
  rig::Quat& Of(int tail_joint) {
    return turns[static_cast<std::size_t>(joint_of[static_cast<std::size_t>(tail_joint)])];
  }

  int left_hand = 0, right_hand = 0;
  std::array<int, rig::kTailCount> joint_of = rig::NoTail();
  std::vector<rig::Quat> turns;
  std::shared_ptr<const v1::Body> message;
  std::string performer = "gloves";
  std::uint64_t session = 5, sequence = 0, time_ns = 1'000'000'000;
  std::uint32_t crc = 77;
  rig::Vec3 root = rig::Vec3::Zero();

 private:
  source::SourceFrame Next() {
    source::SourceFrame frame;
    frame.performer = performer;
    frame.session = session;
    frame.sequence = sequence++;
    frame.body_crc = crc;
    return frame;
  }
};

inline rig::Quat Bent(float degrees) {
  return rig::Quat(Eigen::AngleAxisf(degrees / 57.29578F, rig::Vec3::UnitZ()));
}

}  // namespace styled::pipeline
