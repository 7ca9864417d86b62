#include "model/stylist/grounding.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "model/stylist/tuning.h"

namespace styled::stylist {
namespace {

constexpr int kFeet[] = {body::kLeftFoot, body::kLeftToes, body::kRightFoot, body::kRightToes};

rig::Vec3 WorldPosition(const rig::Skeleton& skeleton, const rig::RigPose& pose, int joint) {
  rig::Vec3 position = pose.translations[static_cast<std::size_t>(joint)];
  for (int above = skeleton.parents[static_cast<std::size_t>(joint)]; above >= 0;
       above = skeleton.parents[static_cast<std::size_t>(above)]) {
    const auto a = static_cast<std::size_t>(above);
    position = pose.translations[a] + pose.rotations[a].normalized() * position;
  }
  return position;
}

// -w log(sum exp(-h/w)): never above the lowest height, and smooth where two heights meet.
class SoftMinimum {
 public:
  explicit SoftMinimum(float width) : width_(width) {}
  void Add(float height) {
    if (count_ < heights_.size()) heights_[count_++] = height;
  }
  float Value() const {
    const auto end = heights_.begin() + static_cast<std::ptrdiff_t>(count_);
    const float lowest = *std::min_element(heights_.begin(), end);
    float sum = 0;
    for (auto height = heights_.begin(); height != end; ++height) {
      sum += std::exp((lowest - *height) / width_);
    }
    return lowest - width_ * std::log(sum);
  }

 private:
  float width_;
  std::array<float, 4> heights_{};
  std::size_t count_ = 0;
};

float SoftLowest_m(const body::Pose& pose) {
  body::WorldPose world;
  body::ForwardKinematics(pose, world);
  SoftMinimum lowest(tuning::kSoftLowest_m);
  for (int foot : kFeet) lowest.Add(world.positions_m[static_cast<std::size_t>(foot)].y());
  return lowest.Value();
}

float SoftLowest(const rig::Binding& binding, const rig::RigPose& pose, const rig::Vec3& up) {
  SoftMinimum lowest(tuning::kSoftLowest_m / binding.scale());
  for (int foot : kFeet) {
    const int joint = binding.spec().source_joint[static_cast<std::size_t>(foot)];
    if (joint >= 0) lowest.Add(WorldPosition(binding.skeleton(), pose, joint).dot(up));
  }
  return lowest.Value();  // a binding has at least one foot
}

rig::Vec3 Up(const rig::Binding& binding) {
  return binding.spec().canonical_from_source.conjugate() * rig::Vec3::UnitY();
}

}  // namespace

float GroundShift_m(const body::Pose& input, const body::Pose& styled) noexcept {
  return SoftLowest_m(input) - SoftLowest_m(styled);
}

float GroundShift(const rig::Binding& binding, const rig::RigPose& input,
                  const rig::RigPose& styled) noexcept {
  const rig::Vec3 up = Up(binding);
  return SoftLowest(binding, input, up) - SoftLowest(binding, styled, up);
}

float GroundShift_m(const rig::Binding& input_binding, const rig::RigPose& input,
                    const rig::Binding& binding, const rig::RigPose& styled) noexcept {
  return input_binding.scale() * SoftLowest(input_binding, input, Up(input_binding)) -
         binding.scale() * SoftLowest(binding, styled, Up(binding));
}

namespace {

// `by`: source units, in the world's source axes. The result is in the frame of the hips' parent.
rig::Vec3 InHipsParent(const rig::Binding& binding, const rig::Vec3& by,
                       const rig::RigPose& pose) noexcept {
  const rig::Skeleton& skeleton = binding.skeleton();
  const auto hips = static_cast<std::size_t>(binding.spec().source_joint[body::kHips]);
  rig::Quat world_from_parent = rig::Quat::Identity();
  for (int above = skeleton.parents[hips]; above >= 0;
       above = skeleton.parents[static_cast<std::size_t>(above)]) {
    world_from_parent =
        pose.rotations[static_cast<std::size_t>(above)].normalized() * world_from_parent;
  }
  return world_from_parent.conjugate() * by;
}

rig::Vec3& HipsOf(const rig::Binding& binding, rig::RigPose& pose) noexcept {
  return pose.translations[static_cast<std::size_t>(binding.spec().source_joint[body::kHips])];
}

}  // namespace

void ShiftUp(const rig::Binding& binding, float shift, rig::RigPose& styled) noexcept {
  HipsOf(binding, styled) += InHipsParent(binding, shift * Up(binding), styled);
}

rig::Vec3 HipsShift(const rig::Binding& binding, const body::Vec3& by_m,
                    const rig::RigPose& pose) noexcept {
  return InHipsParent(
      binding, binding.spec().canonical_from_source.conjugate() * (by_m / binding.scale()), pose);
}

void Shift(const rig::Binding& binding, const body::Vec3& by_m, rig::RigPose& styled) noexcept {
  HipsOf(binding, styled) += HipsShift(binding, by_m, styled);
}

}  // namespace styled::stylist
