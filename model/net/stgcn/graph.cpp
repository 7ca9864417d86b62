#include "model/net/stgcn/graph.h"

#include <cassert>

namespace styled::stgcn {
namespace {

// Nodes of level 1 (kAbdomen is its centre) and of level 2 (kTrunk is its centre).
enum Region : int {
  kLeftThigh,
  kLeftSole,
  kRightThigh,
  kRightSole,
  kAbdomen,
  kUpperTrunk,
  kLeftArm,
  kLeftForearm,
  kRightArm,
  kRightForearm
};
enum Limb : int { kLimbLeftLeg, kLimbRightLeg, kTrunk, kLimbLeftArm, kLimbRightArm };

constexpr auto kJointParents = [] {
  std::array<int, kNodes[0]> parents{};
  for (std::size_t joint = 0; joint < parents.size(); ++joint) {
    parents[joint] = body::kHumanoid[joint].parent;
  }
  return parents;
}();
constexpr std::array<int, kNodes[1]> kRegionParents{
    kAbdomen, kLeftThigh,  kAbdomen, kRightThigh, -1,
    kAbdomen, kUpperTrunk, kLeftArm, kUpperTrunk, kRightArm};
constexpr std::array<int, kNodes[2]> kLimbParents{kTrunk, kTrunk, -1, kTrunk, kTrunk};

// In the order of body::Joint.
constexpr std::array<int, kNodes[0]> kRegions{
    kAbdomen,     kAbdomen,     kUpperTrunk, kUpperTrunk, kUpperTrunk,   kLeftArm,      kLeftArm,
    kLeftForearm, kLeftForearm, kRightArm,   kRightArm,   kRightForearm, kRightForearm, kLeftThigh,
    kLeftThigh,   kLeftSole,    kLeftSole,   kRightThigh, kRightThigh,   kRightSole,    kRightSole};
constexpr std::array<int, kNodes[1]> kLimbs{
    kLimbLeftLeg, kLimbLeftLeg, kLimbRightLeg, kLimbRightLeg, kTrunk,
    kTrunk,       kLimbLeftArm, kLimbLeftArm,  kLimbRightArm, kLimbRightArm};

}  // namespace

std::span<const int> ParentsOf(int level) {
  assert(level >= 0 && level < kLevels);
  if (level == 0) return kJointParents;
  if (level == 1) return kRegionParents;
  return kLimbParents;
}

std::span<const int> ClustersOf(int level) {
  assert(level == 0 || level == 1);
  if (level == 0) return kRegions;
  return kLimbs;
}

std::array<Eigen::MatrixXf, kLabelCount> Adjacency(int level, Normalization normalization) {
  const std::span<const int> parents = ParentsOf(level);
  const auto nodes = static_cast<Eigen::Index>(parents.size());
  std::array<Eigen::MatrixXf, kLabelCount> labels;
  labels.fill(Eigen::MatrixXf::Zero(nodes, nodes));
  for (Eigen::Index node = 0; node < nodes; ++node) {
    labels[kSelf](node, node) = 1;
    const int parent = parents[static_cast<std::size_t>(node)];
    if (parent < 0) continue;
    labels[kNearer](parent, node) = 1;
    labels[kFarther](node, parent) = 1;
  }
  const Eigen::RowVectorXf entries =
      (labels[kSelf] + labels[kNearer] + labels[kFarther]).colwise().sum();
  for (Eigen::MatrixXf& label : labels) {
    const Eigen::RowVectorXf divisors = normalization == Normalization::kSubset
                                            ? label.colwise().sum().cwiseMax(1).eval()
                                            : entries;
    label.array().rowwise() /= divisors.array();
  }
  return labels;
}

Eigen::MatrixXf Unpooling(int level) {
  const std::span<const int> clusters = ClustersOf(level);
  const auto nodes = static_cast<Eigen::Index>(clusters.size());
  Eigen::MatrixXf unpooling =
      Eigen::MatrixXf::Zero(kNodes[static_cast<std::size_t>(level) + 1], nodes);
  for (Eigen::Index node = 0; node < nodes; ++node) {
    unpooling(clusters[static_cast<std::size_t>(node)], node) = 1;
  }
  return unpooling;
}

Eigen::MatrixXf Pooling(int level) {
  Eigen::MatrixXf pooling = Unpooling(level).transpose();
  const Eigen::RowVectorXf members = pooling.colwise().sum();
  pooling.array().rowwise() /= members.array();
  return pooling;
}

}  // namespace styled::stgcn
