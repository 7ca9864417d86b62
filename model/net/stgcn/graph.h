#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

#include "model/body/humanoid.h"

// The graph of the spatio-temporal network (Park et al. 2021, section 3.1): the humanoid's joints,
// and two coarser levels whose nodes are clusters of nodes of the level below. Level 0 has the 21
// joints in the order of body::Joint. Level 1: left thigh, left foot, right thigh, right foot,
// abdomen, upper trunk, left arm, left forearm, right arm, right forearm. Level 2: left leg, right
// leg, trunk, left arm, right arm. Start-up code: it allocates. Training and runtime use the same.
// Pinned by tests/unit/net/stgcn/graph_test.cpp.
namespace styled::stgcn {

inline constexpr int kLevels = 3;
inline constexpr std::array<int, kLevels> kNodes{body::kJointCount, 10, 5};

// The position of a neighbour relative to a node, by their distances to the centre (hips, abdomen,
// trunk): the node itself, nearer, farther. The index of an adjacency matrix.
enum Label : int { kSelf, kNearer, kFarther, kLabelCount };

// The neighbour of each node that is nearer to the centre, -1 for the centre: a level is a tree.
std::span<const int> ParentsOf(int level);
// The node of level + 1 that each node of `level` belongs to; level 0 or 1.
std::span<const int> ClustersOf(int level);

// The divisor of a neighbour j of i: the size of i's neighbourhood, itself counted, as in the
// authors' code; or of those with j's label, as in the paper's equation (1).
enum class Normalization { kNeighbours, kSubset };

// One [nodes, nodes] matrix per label. Element (j, i) is one over the divisor where j is a
// neighbour of i with that label, else 0; so the columns of the sum over the labels sum to 1, or
// each column of a label that a node has. A graph convolution is y = sum over k of (W_k x + b_k 1')
// A_k, with a node's channels as a column of x.
std::array<Eigen::MatrixXf, kLabelCount> Adjacency(
    int level, Normalization normalization = Normalization::kNeighbours);

// [nodes of level, nodes of level + 1], from the right: the mean over each cluster. Level 0 or 1.
Eigen::MatrixXf Pooling(int level);
// [nodes of level + 1, nodes of level], from the right: each node gets its cluster's value.
Eigen::MatrixXf Unpooling(int level);

}  // namespace styled::stgcn
