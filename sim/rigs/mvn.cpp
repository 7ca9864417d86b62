#include "sim/rigs/mvn.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "proto/rigs/mvn/mvn.h"

namespace styled::rigs {
namespace {

using body::Joint;
using body::Quat;
using body::Vec3;

// The canonical joint of each segment. Where two segments share a joint, the first is at the joint,
// and the second lies between it and the next one with the same rotation.
constexpr std::array<int, mvn::kBodySegments> kJointOfSegment{
    body::kHips,          body::kSpine,         body::kSpine,     body::kChest,
    body::kChest,         body::kNeck,          body::kHead,      body::kRightShoulder,
    body::kRightUpperArm, body::kRightLowerArm, body::kRightHand, body::kLeftShoulder,
    body::kLeftUpperArm,  body::kLeftLowerArm,  body::kLeftHand,  body::kRightUpperLeg,
    body::kRightLowerLeg, body::kRightFoot,     body::kRightToes, body::kLeftUpperLeg,
    body::kLeftLowerLeg,  body::kLeftFoot,      body::kLeftToes};
constexpr std::size_t kL3 = 2, kT8 = 4;

// +Y up, +Z forward, +X left -> +Z up, +X forward, +Y left.
std::array<float, 3> ToMvn(const Vec3& v) { return {v.z(), v.x(), v.y()}; }
std::array<float, 4> ToMvn(const Quat& q) { return {q.z(), q.x(), q.y(), q.w()}; }

// Type 01 uses the canonical axes, and centimetres.
mvn::Segment AsOfType01(std::uint32_t id, const Vec3& p, const Quat& q) {
  return {id, {100 * p.x(), 100 * p.y(), 100 * p.z()}, {q.x(), q.y(), q.z(), q.w()}};
}

// Global positions and rotations of the segments, in canonical axes.
void Place(const body::Pose& pose, std::array<Vec3, mvn::kBodySegments>& positions,
           std::array<Quat, mvn::kBodySegments>& rotations) {
  body::WorldPose world;
  body::ForwardKinematics(pose, world);
  for (std::size_t s = 0; s < mvn::kBodySegments; ++s) {
    const int joint = kJointOfSegment[s];
    positions[s] = world.positions_m[static_cast<std::size_t>(joint)];
    rotations[s] = world.rotations[static_cast<std::size_t>(joint)];
  }
  positions[kL3] += rotations[kL3] * Vec3(body::Offset(body::kChest) / 2);
  positions[kT8] += rotations[kT8] * Vec3(body::Offset(body::kNeck) / 3);
}

class Mvn final : public Rig {
 public:
  explicit Mvn(const Options& options) : options_(options), buffer_(2048) {
    split_ = HasQuirk(options_, "split");
    old_ = HasQuirk(options_, "old");
    timecode_ = HasQuirk(options_, "timecode");
    euler_ = HasQuirk(options_, "euler");
  }

  void Encode(const Frame& frame, const Send& send) override {
    const auto second = static_cast<std::uint64_t>(std::max(1.0, std::round(options_.rate_hz)));
    for (std::size_t k = 0; k < frame.poses.size(); ++k) {
      mvn::Header header;
      header.sample = 1000 + static_cast<std::uint32_t>(frame.index);
      header.time_ms = static_cast<std::uint32_t>(std::llround(frame.time_s * 1000));
      header.character = static_cast<std::uint8_t>(k);
      if (old_) header.body_segments = 0;
      const auto props = k == 0 ? frame.props : std::span<const std::optional<rig::Placed>>();
      header.props = static_cast<std::uint8_t>(props.size());
      if (frame.index % second == 0) SendBody(header, options_.performers[k], send);
      if (timecode_) SendTimecode(header, send);
      SendPose(header, frame.poses[k], props, send);
    }
  }

  std::string default_address() const override { return "udp://127.0.0.1:9763"; }

 private:
  void SendFirst(std::size_t size, const Send& send) {
    if (old_) std::fill_n(buffer_.begin() + 22, 2, std::byte{0});
    send(std::span(buffer_).first(size));
  }

  void SendBody(const mvn::Header& header, const std::string& name, const Send& send) {
    // Like a real sender: types 12 and 13 contain no time, and 13 is not marked as the last.
    mvn::Header bare = header;
    bare.sample = bare.time_ms = 0;
    SendFirst(mvn::EncodeName(bare, name, buffer_), send);
    std::array<Vec3, mvn::kBodySegments> positions;
    std::array<Quat, mvn::kBodySegments> rotations;
    Place(body::Pose(), positions, rotations);
    std::vector<mvn::Scale::Row> rows;
    for (std::size_t s = 0; s < positions.size(); ++s) {
      rows.push_back({mvn::kSegments[s].name, ToMvn(positions[s])});
    }
    for (std::size_t k = 0; k < header.props; ++k) rows.push_back({options_.props[k].name, {}});
    bare.last = false;
    SendFirst(mvn::EncodeScale(bare, rows, buffer_), send);
  }

  void SendTimecode(const mvn::Header& header, const Send& send) {
    const std::uint32_t ms = header.time_ms;
    const mvn::Timecode timecode{10 + ms / 3'600'000, ms / 60'000 % 60, ms / 1000 % 60, ms % 1000};
    SendFirst(mvn::EncodeTimecode(header, timecode, buffer_), send);
  }

  void SendPose(mvn::Header header, const body::Pose& pose,
                std::span<const std::optional<rig::Placed>> props, const Send& send) {
    std::array<Vec3, mvn::kBodySegments> positions;
    std::array<Quat, mvn::kBodySegments> rotations;
    Place(pose, positions, rotations);
    std::vector<mvn::Segment> segments;
    const auto add = [&](const Vec3& position, const Quat& rotation) {
      const auto id = static_cast<std::uint32_t>(segments.size() + 1);
      segments.push_back(euler_ ? AsOfType01(id, position, rotation)
                                : mvn::Segment{id, ToMvn(position), ToMvn(rotation)});
    };
    for (std::size_t s = 0; s < positions.size(); ++s) add(positions[s], rotations[s]);
    for (const auto& prop : props) {
      const rig::Placed placed = prop.value_or(rig::Placed());
      add(placed.position_m, placed.rotation);
    }
    if (euler_) header.type = mvn::Type::kEuler;
    std::span<const mvn::Segment> rest(segments);
    if (split_) {
      header.last = false;
      SendFirst(mvn::EncodePose(header, rest.first(12), buffer_), send);
      rest = rest.subspan(12);
      header.datagram = 1;
      header.last = true;
    }
    SendFirst(mvn::EncodePose(header, rest, buffer_), send);
  }

  Options options_;
  std::vector<std::byte> buffer_;
  bool split_ = false, old_ = false, timecode_ = false, euler_ = false;
};

}  // namespace

Result<std::unique_ptr<Rig>> MakeMvn(const Options& options) {
  const Status status =
      CheckOptions("mvn", options, 255, {"euler", "split", "old", "timecode"}, mvn::kMaxProps);
  if (!status.ok()) return status;
  return std::unique_ptr<Rig>(std::make_unique<Mvn>(options));
}

}  // namespace styled::rigs
