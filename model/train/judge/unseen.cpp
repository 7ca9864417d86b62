#include "model/train/judge/unseen.h"

#include <Eigen/Eigenvalues>
#include <array>

#include "model/body/heading.h"
#include "model/clip/clip.h"
#include "model/train/judge/mixed.h"
#include "model/train/judge/variety.h"

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

ByCode ByCodeOf(const ClipRestyler& restyler) {
  return {restyler.network(), [&restyler](const Poses& clip, const net::StyleCode& code) {
            return RestyleRecorded(restyler, clip, code);
          }};
}

ByCode ByCodeOf(const LiveRestyler& restyler, const net::StyleSpace& space) {
  return {space, [&restyler](const Poses& clip, const net::StyleCode& code) {
            Poses out = Thin(
                restyler.RestyleBy(clip::ResamplePoses(clip, kJudgeRate_hz, kStreamRate_hz), code));
            out.resize(clip.size(), out.empty() ? body::Pose() : out.back());
            return out;
          }};
}

UnseenFigures MeasureUnseen(const ByCode& network, const Poses& source, const Poses& normal,
                            const Poses& example) {
  net::StyleRequest request;
  request.sources.push_back({.style = -1, .seed = {}, .reference = example, .weight = 1});
  const net::StyleCode code = network.space.MakeCode(request);
  const ConstantOffset offset = OffsetBetween(normal, example);
  Poses by_offset;
  for (const body::Pose& pose : source) by_offset.push_back(offset.Apply(pose));
  const Eigen::VectorXd wanted = MeanPose(example) - MeanPose(normal);
  const Eigen::VectorXd before = MeanPose(source);
  return {MeasureExpression(MeanPose(network.restyle(source, code)) - before, wanted),
          MeasureExpression(MeanPose(by_offset) - before, wanted), network.space.Nearest(code)};
}

}  // namespace styled::judge
