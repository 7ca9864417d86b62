#pragma once

#include <cstdint>
#include <vector>

#include "clients/cpp/transforms.h"
#include "clients/stylemon/canvas.h"
#include "model/body/humanoid.h"

namespace styled::stylemon {

// The data of a skeleton that drawing needs, found once per body from the joint names. A
// canonical joint that no name matches is -1; the body's joints are drawn as lines in any case.
struct Anatomy {
  std::vector<int> parents;                  // per joint of the body
  std::vector<Ink> inks;                     // per joint: the bone from its parent
  std::array<int, body::kJointCount> joint;  // the body's joint for each canonical one, or -1
  float height = 0;           // standing, body units, from bone lengths; 0 = unknown from the names
  float metres_per_unit = 0;  // 0 = unknown
};

// `body` must have passed client::Validate.
Anatomy Analyse(const v1::Body& body);

// The yaw (rad, about +Y; 0 = facing +Z) that the hips and shoulders face. False if the names do
// not identify them. Assumes +Y up.
bool Facing(const Anatomy& anatomy, const std::vector<client::Transform>& joints, float& yaw_rad);

// The lowest joint's height, body units.
float Lowest(const std::vector<client::Transform>& joints);

enum class Side : std::uint8_t {
  kSide,   // seen from the figure's right: it faces to the right of the picture
  kFront,  // seen from the front: the figure's left is on the right of the picture
};

// The figure and the view on it. The hips stay in the middle of the picture and the floor at its
// lower edge; the floor marks move instead.
struct Pose {
  const Anatomy* anatomy = nullptr;                        // not null
  const std::vector<client::Transform>* joints = nullptr;  // not null; the anatomy's joint count
  Side side = Side::kSide;
  float yaw_rad = 0;  // the figure's front; usually a smoothed Facing
  float height = 0;   // body units; > 0; the extent that fills most of the picture
  float floor = 0;    // height of the floor, body units
  float travel = 0;  // body units, along the picture's x: the distance that the hips have travelled
  std::uint32_t contacts = 0;  // bits as in Frame.contacts
};

// The height to pass in Pose: 1.75 m if the unit is known and the figure is of human size, so that
// performers are comparable; else the figure's own height; else `seen`, the largest extent so far
// (may be 0).
float PictureHeight(const Anatomy& anatomy, float seen);

// Unit vector of the picture's x axis in the world.
Eigen::Vector3f PictureX(Side side, float yaw_rad);

// Draws the stick figure and its floor into `area`. Pure: the same arguments give the same cells.
void Draw(const Pose& pose, const DotRect& area, Canvas& canvas);

}  // namespace styled::stylemon
