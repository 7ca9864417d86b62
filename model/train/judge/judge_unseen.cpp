#include "model/train/judge/judge_unseen.h"

#include <Eigen/Eigenvalues>
#include <array>

#include "model/body/heading.h"
#include "model/train/judge/judge_mixed.h"
#include "model/train/judge/judge_variety.h"

namespace styled::judge {
namespace {

using Rotations = std::array<body::Quat, body::kJointCount>;

// The rotation with the least squared chordal distance to a joint's, for every joint.
Rotations MeanRotations(std::span<const body::Pose> poses) {
  std::array<Eigen::Matrix4d, body::kJointCount> sums;
  sums.fill(Eigen::Matrix4d::Zero());
  body::WorldPose world;
  for (const body::Pose& pose : poses) {
    body::ForwardKinematics(pose, world);
    for (std::size_t joint = 0; joint < sums.size(); ++joint) {
      body::Quat q = pose.rotations[joint];
      if (joint == body::kHips) q = body::Yaw(-body::Heading_rad(world)) * q;
      const Eigen::Vector4d v = q.coeffs().cast<double>();
      sums[joint] += v * v.transpose();  // the same for q and -q
    }
  }
  Rotations means;
  for (std::size_t joint = 0; joint < sums.size(); ++joint) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(sums[joint]);
    means[joint] = body::Quat(Eigen::Vector4f(solver.eigenvectors().col(3).cast<float>()));
  }
  return means;
}

Eigen::VectorXd MeanPose(const Poses& poses) {
  return MeanPoseOf(LocalPositions(poses, kJudgeRate_hz));
}

}  // namespace

ConstantOffset OffsetBetween(std::span<const body::Pose> from, std::span<const body::Pose> to) {
  const Rotations a = MeanRotations(from);
  const Rotations b = MeanRotations(to);
  ConstantOffset offset;
  for (std::size_t joint = 0; joint < a.size(); ++joint) {
    offset.offset[joint] = a[joint].conjugate() * b[joint];
  }
  return offset;
}

UnseenFigures MeasureUnseen(const ClipRestyler& restyler, const Poses& source, const Poses& normal,
                            const Poses& example) {
  net::StyleRequest request;
  request.sources.push_back({.style = -1, .seed = {}, .reference = example, .weight = 1});
  const net::StyleCode code = restyler.network().MakeCode(request);
  const ConstantOffset offset = OffsetBetween(normal, example);
  Poses by_offset;
  for (const body::Pose& pose : source) by_offset.push_back(offset.Apply(pose));
  const Eigen::VectorXd wanted = MeanPose(example) - MeanPose(normal);
  const Eigen::VectorXd before = MeanPose(source);
  return {MeasureExpression(MeanPose(RestyleRecorded(restyler, source, code)) - before, wanted),
          MeasureExpression(MeanPose(by_offset) - before, wanted),
          restyler.network().Nearest(code)};
}

}  // namespace styled::judge
