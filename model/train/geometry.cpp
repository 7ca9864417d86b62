#include "model/train/geometry.h"

#include <vector>

#include "model/body/humanoid.h"

namespace styled::train {
namespace {

using torch::Tensor;

// v turned by q: v + 2 w (u × v) + 2 u × (u × v), u the vector part.
Tensor Rotate(const Tensor& q, const Tensor& v) {
  const Tensor u = q.narrow(-1, 0, 3);
  const Tensor twice = 2.0 * torch::cross(u, v.expand_as(u), -1);
  return v + q.narrow(-1, 3, 1) * twice + torch::cross(u, twice, -1);
}

// The humanoid's joints by depth, so that a whole level is computed at once. Order of results: the
// joints level by level, which `inverse` undoes.
struct Levels {
  struct Level {
    Tensor joints, parents;  // parents: as places within the level above
    Tensor offsets_m;        // [joints, 3]
  };
  std::vector<Level> levels;
  Tensor inverse, feet;

  explicit Levels(const torch::Device& device) {
    std::vector<std::vector<int64_t>> joints, parents;
    std::vector<int64_t> depth(body::kJointCount, 0), place(body::kJointCount, 0), order;
    for (int joint = 0; joint < body::kJointCount; ++joint) {
      const int parent = body::kHumanoid[joint].parent;
      depth[joint] = parent < 0 ? 0 : depth[parent] + 1;
      const auto level = static_cast<std::size_t>(depth[joint]);
      if (joints.size() <= level) {
        joints.emplace_back();
        parents.emplace_back();
      }
      place[joint] = static_cast<int64_t>(joints[level].size());
      joints[level].push_back(joint);
      parents[level].push_back(parent < 0 ? 0 : place[parent]);
    }
    const auto indices = [&device](const std::vector<int64_t>& values) {
      return torch::tensor(values, torch::kInt64).to(device);
    };
    for (std::size_t level = 0; level < joints.size(); ++level) {
      std::vector<float> offsets;
      for (const int64_t joint : joints[level]) {
        const body::JointRow& row = body::kHumanoid[joint];
        offsets.insert(offsets.end(), {row.x_m, row.y_m, row.z_m});
        order.push_back(joint);
      }
      levels.push_back({indices(joints[level]), indices(parents[level]),
                        torch::tensor(offsets).view({-1, 3}).to(device)});
    }
    std::vector<int64_t> undone(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) undone[order[i]] = static_cast<int64_t>(i);
    inverse = indices(undone);
    feet = indices({body::kLeftFoot, body::kLeftToes, body::kRightFoot, body::kRightToes});
  }

  // Of a device they are made once, so that recorded work finds them where they were. They are
  // never destroyed: a device's memory must not be freed after libtorch has ended.
  static const Levels& Of(const torch::Device& device) {
    static const Levels* const on_cpu = new Levels(torch::kCPU);
    if (device.is_cpu()) return *on_cpu;
    static const Levels* const elsewhere = new Levels(device);
    return *elsewhere;
  }
};

}  // namespace

Tensor Multiply(const Tensor& a, const Tensor& b) {
  const Tensor av = a.narrow(-1, 0, 3), aw = a.narrow(-1, 3, 1);
  const Tensor bv = b.narrow(-1, 0, 3), bw = b.narrow(-1, 3, 1);
  return torch::cat(
      {aw * bv + bw * av + torch::cross(av, bv, -1), aw * bw - (av * bv).sum(-1, true)}, -1);
}

Tensor Conjugate(const Tensor& q) {
  return torch::cat({-q.narrow(-1, 0, 3), q.narrow(-1, 3, 1)}, -1);
}

Tensor LogQuaternion(const Tensor& q) {
  const Tensor w = q.narrow(-1, 3, 1);
  const Tensor sign = torch::where(w.detach() < 0, -torch::ones_like(w), torch::ones_like(w));
  const Tensor v = sign * q.narrow(-1, 0, 3);
  const Tensor sine = (v.square().sum(-1, true) + 1e-12).sqrt();
  return v * (2.0 * torch::atan2(sine, sign * w) / sine);
}

Tensor ExpQuaternion(const Tensor& rotation_rad) {
  const Tensor half = 0.5 * rotation_rad;
  const Tensor angle = half.norm(2, -1, true);
  return torch::cat({half * torch::sinc(angle / M_PI), angle.cos()}, -1);
}

Tensor ScaleRotation(const Tensor& q, const Tensor& factor) {
  return ExpQuaternion(factor * LogQuaternion(q));
}

Tensor SquaredHalfAngle(const Tensor& a, const Tensor& b) {
  const Tensor e = 1.0 - (a * b).sum(-1).abs();
  return e * (2.0 + e * (1.0 / 3.0 + e * (4.0 / 45.0)));
}

Tensor ToHemisphere(const Tensor& q, const Tensor& reference) {
  const Tensor dot = (q.detach() * reference).sum(-1, true);
  return torch::where(dot < 0, -q, q);
}

Tensor HipsRelativePositions(const Tensor& rotations) {
  const Levels& all = Levels::Of(rotations.device());
  Tensor world_rotation;  // of the level above
  Tensor position;
  std::vector<Tensor> positions;
  for (std::size_t i = 0; i < all.levels.size(); ++i) {
    const Levels::Level& level = all.levels[i];
    const Tensor local = rotations.index_select(-2, level.joints);
    if (i == 0) {
      world_rotation = local;
      position = torch::zeros_like(local.narrow(-1, 0, 3));
    } else {
      const Tensor parent_rotation = world_rotation.index_select(-2, level.parents);
      position =
          position.index_select(-2, level.parents) + Rotate(parent_rotation, level.offsets_m);
      if (i + 1 < all.levels.size()) world_rotation = Multiply(parent_rotation, local);
    }
    positions.push_back(position);
  }
  return torch::cat(positions, -2).index_select(-2, all.inverse);
}

Tensor WorldVelocities(const Tensor& positions, const Tensor& yaw_change_rad,
                       const Tensor& hips_step_m, const Tensor& lift_m, double rate_hz) {
  const int64_t last = positions.size(0) - 1;
  const Tensor before = positions.narrow(0, 0, last);
  const Tensor now = positions.narrow(0, 1, last);
  // The frame before, seen from the heading of now: turned by -yaw_change about +Y.
  const Tensor cosine = yaw_change_rad.narrow(0, 1, last).cos().unsqueeze(-1);
  const Tensor sine = yaw_change_rad.narrow(0, 1, last).sin().unsqueeze(-1);
  const Tensor x = before.select(-1, 0), y = before.select(-1, 1), z = before.select(-1, 2);
  const Tensor turned = torch::stack({x * cosine - z * sine, y, x * sine + z * cosine}, -1);
  const Tensor rise = lift_m.narrow(0, 1, last) - lift_m.narrow(0, 0, last);
  const Tensor none = torch::zeros_like(rise);
  const Tensor step = hips_step_m.narrow(0, 1, last) + torch::stack({none, rise, none}, -1);
  return (now - turned + step.unsqueeze(-2)) * rate_hz;
}

Tensor LowestFoot(const Tensor& positions) {
  return positions.select(-1, 1).index_select(-1, Levels::Of(positions.device()).feet).amin(-1);
}

}  // namespace styled::train
