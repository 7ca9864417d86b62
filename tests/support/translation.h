#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include "daemon/perform/performer/body_binding.h"
#include "model/body/pose.h"
#include "tests/support/count_new.h"
#include "tests/support/translated.h"

// Helpers for tests of translators.
namespace styled::support {

// The output for one datagram.
inline std::vector<Translated::Item> Said(Translated& translated,
                                          std::span<const std::byte> datagram,
                                          std::uint64_t peer = 1) {
  translated.items.clear();
  translated.Handle(datagram, peer);
  return std::exchange(translated.items, {});
}

// The number of allocations while the translator processes a datagram. The binary needs
// count_new.cpp.
inline int Allocations(source::Translator& translator, std::span<const std::byte> datagram,
                       std::int64_t now_ns) {
  struct Nobody final : source::Receiver {
    void OnFrames(int, std::span<const source::SourceFrame>, bool) override {}
    void OnNote(int, const std::string&) override {}
  };
  static runtime::Counters counters;
  static source::Outbox outbox(0, counters);
  Nobody nobody;
  const CountNew count;
  outbox.Open(nobody, -1);
  translator.Handle(datagram, source::Peer(), now_ns, outbox);
  translator.Tick(now_ns, outbox);
  outbox.Close();
  return count.calls();
}

// The canonical pose that the pipeline computes from a frame on its body; empty if it refuses the
// body or the frame.
inline std::optional<body::Pose> CanonicalPose(const v1::Body& body, const v1::SourceFrame& frame) {
  const auto bound = pipeline::BindBody(body, {});
  const int joints = body.names_size();
  if (!bound.ok() || frame.rotations_size() != 4 * joints || frame.root_position_size() != 3) {
    return {};
  }
  rig::RigPose source(bound.value().binding->skeleton());
  std::memcpy(source.translations.front().data(), frame.root_position().data(), 3 * sizeof(float));
  std::memcpy(source.rotations.front().coeffs().data(), frame.rotations().data(),
              static_cast<std::size_t>(4 * joints) * sizeof(float));
  body::Pose pose;
  bound.value().binding->Bind(source, pose);
  return pose;
}

// The difference between two poses: the hips' distance in metres, and the largest rotation
// difference of a joint in degrees.
struct Distance {
  float hips_m = 0, joint_deg = 0;
};
inline Distance Between(const body::Pose& a, const body::Pose& b) {
  Distance distance;
  distance.hips_m = (a.hips_position_m - b.hips_position_m).norm();
  for (std::size_t j = 0; j < body::kJointCount; ++j) {
    const Eigen::Quaterniond turn =
        a.rotations[j].cast<double>().conjugate() * b.rotations[j].cast<double>();
    const double angle_rad = 2 * std::atan2(turn.vec().norm(), std::abs(turn.w()));
    distance.joint_deg = std::max(distance.joint_deg, static_cast<float>(angle_rad * 57.29578));
  }
  return distance;
}

}  // namespace styled::support
