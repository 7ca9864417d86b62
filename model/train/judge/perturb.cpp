#include "model/train/judge/perturb.h"

#include <cmath>
#include <random>

#include "model/body/heading.h"

namespace styled::judge {
namespace {

constexpr float kDegree = 0.017453293F;

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(seed) {}
  float Normal() { return normal_(random_); }
  float Between(float low, float high) {
    return std::uniform_real_distribution<float>(low, high)(random_);
  }
  bool Coin() { return (random_() & 1) != 0; }
  body::Vec3 Direction() {
    const body::Vec3 v(Normal(), Normal(), Normal());
    return v.normalized();
  }

 private:
  std::mt19937_64 random_;
  std::normal_distribution<float> normal_;
};

}  // namespace

Poses Perturb(Perturbation kind, const Poses& poses, double rate_hz, std::uint64_t seed) {
  Draw draw(seed * 8 + static_cast<std::uint64_t>(kind));
  Poses out = poses;
  switch (kind) {
    case Perturbation::kRest:
      for (int joint = 1; joint < body::kJointCount; ++joint) {
        const body::Quat off =
            body::Exp(draw.Direction() * draw.Between(5 * kDegree, 15 * kDegree));
        for (body::Pose& pose : out) pose.rotations[joint] = pose.rotations[joint] * off;
      }
      break;
    case Perturbation::kNoise:
      for (body::Pose& pose : out) {
        const float per_axis = 0.5F * kDegree / std::sqrt(3.0F);
        for (body::Quat& rotation : pose.rotations) {
          rotation = rotation *
                     body::Exp(body::Vec3(draw.Normal(), draw.Normal(), draw.Normal()) * per_axis);
        }
        pose.hips_position_m +=
            body::Vec3(draw.Normal(), draw.Normal(), draw.Normal()) * (0.002F / std::sqrt(3.0F));
      }
      break;
    case Perturbation::kDrift: {
      const float turn_rad_s = (draw.Coin() ? 20.0F : -20.0F) * kDegree / 60.0F;
      const body::Vec3 velocity_m_s =
          body::Yaw(draw.Between(-3.14F, 3.14F)) * body::Vec3(0.05F, 0, 0);
      for (std::size_t i = 0; i < out.size(); ++i) {
        const auto time_s = static_cast<float>(static_cast<double>(i) / rate_hz);
        const body::Quat turn = body::Yaw(turn_rad_s * time_s);
        out[i].hips_position_m = turn * out[i].hips_position_m + velocity_m_s * time_s;
        out[i].rotations[body::kHips] = turn * out[i].rotations[body::kHips];
      }
      break;
    }
    case Perturbation::kFloor: {
      const float height_m = draw.Coin() ? 0.1F : -0.1F;
      for (body::Pose& pose : out) pose.hips_position_m.y() += height_m;
      break;
    }
    case Perturbation::kFrozen: {
      constexpr std::array kJoints{body::kLeftLowerArm, body::kRightLowerArm,
                                   body::kLeftUpperArm, body::kRightUpperArm,
                                   body::kLeftLowerLeg, body::kRightLowerLeg};
      const auto joint = kJoints[static_cast<std::size_t>(draw.Between(0, kJoints.size() - 0.01F))];
      for (body::Pose& pose : out) pose.rotations[joint] = poses.front().rotations[joint];
      break;
    }
    case Perturbation::kLegs: {
      const float stride = draw.Coin() ? 1.15F : 0.85F;
      for (body::Pose& pose : out) {
        pose.hips_position_m.x() *= stride;
        pose.hips_position_m.z() *= stride;
      }
      break;
    }
    case Perturbation::kCount:
      break;
  }
  return out;
}

}  // namespace styled::judge
