#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "model/net/clip_stylizer.h"

namespace styled::judge {

inline body::Quat Arm(float angle_rad) { return body::Exp(body::Vec3(0, 0, angle_rad)); }

// Turns the left upper arm of every pose to an angle about z.
inline void SetArm(std::vector<body::Pose>& poses, float angle_rad) {
  for (body::Pose& pose : poses) pose.rotations[body::kLeftUpperArm] = Arm(angle_rad);
}

inline float ArmOf(const body::Pose& pose) {
  return body::Log(pose.rotations[body::kLeftUpperArm]).z();
}

// How the fake network below answers.
struct ArmHabits {
  static constexpr float kDeaf_rad = 0.5F;

  // Of the way from kDeaf_rad to the code's angle: 1 follows the code, 0 is deaf to it.
  float share = 1;
  // Of a stream; those after them stay as they came.
  std::size_t frames = std::numeric_limits<std::size_t>::max();
};

// Sets the left upper arm to an angle, and leaves everything else as it came.
class ArmStream final : public net::ClipStream {
 public:
  ArmStream(float angle_rad, std::size_t frames) : angle_rad_(angle_rad), frames_(frames) {}
  void Add(const body::Pose& pose) override { poses_.push_back(pose); }
  void End() override { ended_ = true; }
  bool Pop(net::Prediction& out) override {
    if (!ended_ || taken_ == poses_.size()) return false;
    const body::Pose& pose = poses_[taken_++];
    out.heading_rad = 0;
    out.reconstruction.rotations = pose.rotations;
    out.reconstruction.velocities_m_s.fill(0);
    out.reconstruction.hips_height_m = pose.hips_position_m.y();
    out.styled = out.reconstruction;
    if (taken_ <= frames_) out.styled.rotations[body::kLeftUpperArm] = Arm(angle_rad_);
    return true;
  }

 private:
  float angle_rad_;
  std::size_t frames_;
  bool ended_ = false;
  std::size_t taken_ = 0;
  std::vector<body::Pose> poses_;
};

// A network of whole clips whose code is one number, the angle of the left upper arm in rad: half
// of the style's number, more by a seed, or the mean angle of the examples.
class ArmNetwork : public net::ClipStylizer {
 public:
  explicit ArmNetwork(const ArmHabits& habits) : habits_(habits) {
    model_.styles = {{"neutral", {}}, {"low", {}}, {"high", {}}};
  }
  static float StyleAngle_rad(int style) { return 0.5F * static_cast<float>(style); }
  static float SeedAngle_rad(std::uint64_t seed) { return 0.05F * static_cast<float>(seed % 5); }

  const net::Model& model() const noexcept override { return model_; }
  int least_frames() const noexcept override { return 4; }
  net::StyleCode MakeCode(const net::StyleRequest& request) const override {
    float angle_rad = 0;
    for (const net::StyleSource& source : request.sources) {
      float of_source = StyleAngle_rad(source.style) + SeedAngle_rad(source.seed.value_or(0));
      if (!source.reference.empty()) of_source = 0;
      for (const body::Pose& pose : source.reference) {
        of_source += ArmOf(pose) / static_cast<float>(source.reference.size());
      }
      angle_rad += source.weight * of_source;
    }
    return {angle_rad};
  }
  // The nearest of its styles; distances are over that of two neighbours.
  net::NearestStyle Nearest(const net::StyleCode& code) const override {
    net::NearestStyle nearest{0, std::numeric_limits<float>::infinity()};
    for (int style = 0; style < static_cast<int>(model_.styles.size()); ++style) {
      const float distance = std::abs(code[0] - StyleAngle_rad(style)) / StyleAngle_rad(1);
      if (distance < nearest.distance) nearest = {style, distance};
    }
    return nearest;
  }
  std::unique_ptr<net::ClipStream> MakeStream(const net::StyleCode& code, int,
                                              net::Extent) const override {
    const float deaf_rad = ArmHabits::kDeaf_rad;
    return std::make_unique<ArmStream>(deaf_rad + habits_.share * (code[0] - deaf_rad),
                                       habits_.frames);
  }

 private:
  ArmHabits habits_;
  net::Model model_;
};

}  // namespace styled::judge
