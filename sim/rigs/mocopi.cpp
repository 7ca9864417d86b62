#include "sim/rigs/mocopi.h"

#include <algorithm>
#include <cmath>

#include "proto/rigs/mocopi/mocopi.h"

namespace styled::rigs {
namespace {

using body::Quat;
using body::Vec3;

constexpr double kSkeletonPeriod_s = 3.5;
constexpr double kWallStart_s = 1.7e9;  // arbitrary start of `uttm`
constexpr std::size_t kRoot = 0, kTorso7 = 7;

// Placement of a bone: it ends at `joint` and shares that joint's offset and rotation with the
// previous bones of the chain, `parts` in all.
struct Piece {
  int joint;
  int parts;
};
constexpr std::array<Piece, mocopi::kBones> kPieces{{
    {body::kHips, 1},          {body::kSpine, 2},         {body::kSpine, 2},
    {body::kChest, 2},         {body::kChest, 2},         {body::kNeck, 4},
    {body::kNeck, 4},          {body::kNeck, 4},          {body::kNeck, 4},
    {body::kHead, 2},          {body::kHead, 2},          {body::kLeftShoulder, 1},
    {body::kLeftUpperArm, 1},  {body::kLeftLowerArm, 1},  {body::kLeftHand, 1},
    {body::kRightShoulder, 1}, {body::kRightUpperArm, 1}, {body::kRightLowerArm, 1},
    {body::kRightHand, 1},     {body::kLeftUpperLeg, 1},  {body::kLeftLowerLeg, 1},
    {body::kLeftFoot, 1},      {body::kLeftToes, 1},      {body::kRightUpperLeg, 1},
    {body::kRightLowerLeg, 1}, {body::kRightFoot, 1},     {body::kRightToes, 1},
}};

mocopi::Skeleton MakeSkeleton() {
  mocopi::Skeleton skeleton = mocopi::UsualSkeleton();
  for (std::size_t id = 0; id < mocopi::kBones; ++id) {
    Vec3 offset = body::Offset(kPieces[id].joint) / static_cast<float>(kPieces[id].parts);
    // The shoulders are attached to torso_7, three quarters of the way to the neck.
    if (id != kTorso7 + 1 && skeleton[id].parent == kTorso7) {
      offset -= body::Offset(body::kNeck) * 0.75F;
    }
    skeleton[id].rest.position_m = {offset.x(), offset.y(), offset.z()};
    skeleton[id].rest.rotation = {-0.0F, 0.0F, -0.0F, -1.0F};
  }
  return skeleton;
}

// The real application writes w <= 0, and y as +0 if it is 0.
std::array<float, 4> ToMocopi(const Quat& q) {
  const Quat p = q.w() > 0 ? q : Quat(-q.coeffs());
  return {-p.x(), 0.0F - p.y(), -p.z(), -p.w()};
}

class Mocopi final : public Rig {
 public:
  explicit Mocopi(const Options& options)
      : timecode_(HasQuirk(options, "tmcd")),
        early_(HasQuirk(options, "early")),
        skeleton_period_(static_cast<std::uint64_t>(
            std::max(1.0, std::round(kSkeletonPeriod_s * options.rate_hz)))),
        skeleton_(MakeSkeleton()) {
    // The phone's address, in the first four bytes.
    sender_.address = {std::byte{192}, std::byte{168}, std::byte{0}, std::byte{23}};
  }

  void Encode(const Frame& frame, const Send& send) override {
    std::array<std::byte, mocopi::kSkeletonSize> buffer;
    const auto put = [&](std::size_t size) { send(std::span(buffer).first(size)); };
    if (frame.index % skeleton_period_ == 0) put(mocopi::Encode(sender_, skeleton_, buffer));
    mocopi::Frame out;
    out.number = static_cast<std::uint32_t>(frame.index + 1);
    out.time_s = static_cast<float>(frame.time_s);
    if (!early_) out.unix_time_s = kWallStart_s + frame.time_s;
    if (timecode_) out.timecode.emplace();
    Place(frame.poses.front(), out);
    put(mocopi::Encode(sender_, out, buffer));
  }

  std::string default_address() const override { return "udp://127.0.0.1:12351"; }

 private:
  void Place(const body::Pose& pose, mocopi::Frame& out) const {
    for (std::size_t id = 0; id < mocopi::kBones; ++id) {
      const auto [joint, parts] = kPieces[id];
      const Quat& turn = pose.rotations[static_cast<std::size_t>(joint)];
      Quat share = parts == 1 ? turn : body::Exp(body::Log(turn) / static_cast<float>(parts));
      // torso_5 to torso_7 also carry the shoulders, so they do not bend with the neck.
      if (joint == body::kNeck) share = id == kTorso7 + 1 ? turn : Quat::Identity();
      out.bones[id].rotation = ToMocopi(share);
      out.bones[id].position_m = skeleton_[id].rest.position_m;
    }
    const Vec3& hips = pose.hips_position_m;
    out.bones[kRoot].position_m = {hips.x(), hips.y(), hips.z()};
  }

  bool timecode_, early_;
  std::uint64_t skeleton_period_;
  mocopi::Skeleton skeleton_;
  mocopi::Sender sender_;
};

}  // namespace

Result<std::unique_ptr<Rig>> MakeMocopi(const Options& options) {
  const Status status = CheckOptions("mocopi", options, 1, {"tmcd", "early"});
  if (!status.ok()) return status;
  return std::unique_ptr<Rig>(std::make_unique<Mocopi>(options));
}

}  // namespace styled::rigs
