#include "model/net/stgcn/graph.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace styled::stgcn {
namespace {

using body::kHips;
using Eigen::MatrixXf;
using Eigen::RowVectorXf;

// Bones between a node and the centre.
int Distance(int level, int node) {
  int bones = 0;
  for (; ParentsOf(level)[static_cast<std::size_t>(node)] >= 0; ++bones) {
    node = ParentsOf(level)[static_cast<std::size_t>(node)];
  }
  return bones;
}

TEST(Graph, LevelsAreTreesAroundHipsAbdomenAndTrunk) {
  const std::array<int, kLevels> centres{kHips, 4, 2};
  for (int level = 0; level < kLevels; ++level) {
    const auto parents = ParentsOf(level);
    ASSERT_EQ(static_cast<int>(parents.size()), kNodes[static_cast<std::size_t>(level)]);
    for (int node = 0; node < kNodes[static_cast<std::size_t>(level)]; ++node) {
      EXPECT_EQ(parents[static_cast<std::size_t>(node)] < 0,
                node == centres[static_cast<std::size_t>(level)]);
      EXPECT_LT(Distance(level, node), 8);
    }
  }
  EXPECT_EQ(Distance(1, 1), 2) << "foot, thigh, abdomen";
  EXPECT_EQ(Distance(1, 9), 3) << "forearm, arm, upper trunk, abdomen";
}

TEST(Graph, ABoneJoinsTwoClustersOnlyWhereTheyAreNeighbours) {
  for (int level = 0; level + 1 < kLevels; ++level) {
    const auto parents = ParentsOf(level), clusters = ClustersOf(level),
               above = ParentsOf(level + 1);
    for (std::size_t node = 0; node < parents.size(); ++node) {
      if (parents[node] < 0) continue;
      const int here = clusters[node];
      const int there = clusters[static_cast<std::size_t>(parents[node])];
      EXPECT_TRUE(here == there || above[static_cast<std::size_t>(here)] == there)
          << "level " << level << ", node " << node;
    }
  }
}

TEST(Graph, LeftAndRightAreClusteredAlike) {
  const std::vector<int> regions{2, 3, 0, 1, 4, 5, 8, 9, 6, 7}, limbs{1, 0, 2, 4, 3};
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    EXPECT_EQ(ClustersOf(0)[static_cast<std::size_t>(body::MirrorJoint(joint))],
              regions[static_cast<std::size_t>(ClustersOf(0)[static_cast<std::size_t>(joint)])]);
  }
  for (std::size_t region = 0; region < regions.size(); ++region) {
    EXPECT_EQ(ClustersOf(1)[static_cast<std::size_t>(regions[region])],
              limbs[static_cast<std::size_t>(ClustersOf(1)[region])]);
  }
}

TEST(Graph, NeighboursAreLabelledByTheirDistanceToTheCentreEverywhere) {
  for (int level = 0; level < kLevels; ++level) {
    const auto labels = Adjacency(level);
    const int nodes = kNodes[static_cast<std::size_t>(level)];
    int nearer = 0, farther = 0;
    for (int i = 0; i < nodes; ++i) {
      for (int j = 0; j < nodes; ++j) {
        const int difference = Distance(level, j) - Distance(level, i);
        EXPECT_EQ(labels[kSelf](j, i) > 0, i == j);
        if (labels[kNearer](j, i) > 0) {
          EXPECT_EQ(difference, -1);
          ++nearer;
        }
        if (labels[kFarther](j, i) > 0) {
          EXPECT_EQ(difference, 1);
          ++farther;
        }
      }
    }
    EXPECT_EQ(nearer, nodes - 1) << "each bone once inward";
    EXPECT_EQ(farther, nodes - 1) << "and once outward, not only near the hips";
  }
}

// Equation (1): each neighbour counts one over the size of its subset.
TEST(Graph, BySubsetsEachSubsetSumsToOne) {
  for (int level = 0; level < kLevels; ++level) {
    const auto labels = Adjacency(level, Normalization::kSubset);
    const auto entries = Adjacency(level);
    for (int label = 0; label < kLabelCount; ++label) {
      for (int node = 0; node < kNodes[static_cast<std::size_t>(level)]; ++node) {
        const bool any = (entries[label].col(node).array() > 0).any();
        EXPECT_FLOAT_EQ(labels[label].col(node).sum(), any ? 1.0F : 0.0F);
        for (Eigen::Index from = 0; from < labels[label].rows(); ++from) {
          EXPECT_EQ(labels[label](from, node) > 0, entries[label](from, node) > 0);
        }
      }
    }
  }
  // The chest's three outward neighbours are the neck and both shoulders.
  const auto labels = Adjacency(0, Normalization::kSubset);
  EXPECT_FLOAT_EQ(labels[kSelf](body::kChest, body::kChest), 1);
  EXPECT_FLOAT_EQ(labels[kNearer](body::kSpine, body::kChest), 1);
  EXPECT_FLOAT_EQ(labels[kFarther](body::kNeck, body::kChest), 1.0F / 3);
}

TEST(Graph, ColumnsOfTheAdjacencySumToOne) {
  for (int level = 0; level < kLevels; ++level) {
    const auto labels = Adjacency(level);
    const RowVectorXf sums = (labels[kSelf] + labels[kNearer] + labels[kFarther]).colwise().sum();
    EXPECT_LT((sums.array() - 1).abs().maxCoeff(), 1e-6F);
  }
  // The chest has five entries: itself, the spine, the neck and both shoulders.
  EXPECT_FLOAT_EQ(Adjacency(0)[kFarther](body::kNeck, body::kChest), 0.2F);
  EXPECT_FLOAT_EQ(Adjacency(0)[kNearer](body::kSpine, body::kChest), 0.2F);
  EXPECT_FLOAT_EQ(Adjacency(0)[kNearer](body::kLeftLowerArm, body::kLeftHand), 0.5F);
}

TEST(Graph, PoolingIsTheMeanOfAClusterAndUnpoolingItsCopy) {
  for (int level = 0; level + 1 < kLevels; ++level) {
    const MatrixXf pooling = Pooling(level), unpooling = Unpooling(level);
    ASSERT_EQ(pooling.rows(), kNodes[static_cast<std::size_t>(level)]);
    ASSERT_EQ(pooling.cols(), kNodes[static_cast<std::size_t>(level) + 1]);
    EXPECT_LT((pooling.colwise().sum().array() - 1).abs().maxCoeff(), 1e-6F);
    const MatrixXf both = unpooling * pooling;
    EXPECT_LT((both - MatrixXf::Identity(both.rows(), both.cols())).cwiseAbs().maxCoeff(), 1e-6F);
  }
  RowVectorXf x = RowVectorXf::Zero(body::kJointCount);
  x[body::kChest] = 3;
  const RowVectorXf pooled = x * Pooling(0);
  EXPECT_FLOAT_EQ(pooled[5], 1) << "upper trunk: chest, neck, head";
  EXPECT_FLOAT_EQ((pooled * Unpooling(0))[body::kHead], 1);
}

}  // namespace
}  // namespace styled::stgcn
