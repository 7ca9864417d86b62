#pragma once

#include <array>
#include <string_view>

#include "model/body/pose.h"
#include "proto/rigs/qtm/frame.h"
#include "proto/rigs/qtm/parameters.h"

// The skeleton of the simulated QTM: the canonical humanoid with segments named as QTM's.
namespace styled::rigs {

inline constexpr std::size_t kQtmSegments = 24;
inline constexpr std::uint32_t kQtmFirstId = 752;  // of the first skeleton; QTM numbers all objects

// In the T-pose. `z_up`: +Z up and facing -Y, otherwise like the canonical humanoid. `flat`: in the
// capture volume, otherwise relative to the parents.
qtm::SkeletonDescription DescribeQtmSkeleton(std::string_view name, std::uint32_t first_id,
                                             bool z_up, bool flat);
// Local rotations and positions; a joint that is NaN makes its segment NaN.
void PlaceQtmSkeleton(const body::Pose& pose, std::uint32_t first_id, bool z_up,
                      qtm::SkeletonPose& out);
// A canonical point in QTM's volume, millimetres.
std::array<float, 3> ToQtm(const body::Vec3& point_m, bool z_up);

}  // namespace styled::rigs
