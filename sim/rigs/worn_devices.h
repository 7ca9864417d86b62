#pragma once

#include <random>
#include <vector>

#include "sim/rigs/rig.h"

namespace styled::rigs {

// Devices worn by a simulated performer: the measurements of VMC's assistants and VRChat's senders.
// Quirks:
//   hips, head, leftFoot, ...  only the devices on these joints; none named: all devices of the rig
//   mounted                    turned anyhow on their parts, but on the head, and up to 3 cm off
//                              the joints (by seed)
//   t-pose                     for the first second of a session the performer stands in a T-pose,
//                              in which a calibration may be requested
//   vanish                     the last device is gone in every third second
//   shuffled                   in another order in each frame
class WornDevices {
 public:
  struct Place {
    int index;  // the rig's own
    body::Joint joint;
    bool before_eyes = false;  // a display: above and before the head's joint
  };
  struct Reading {
    int index;
    body::Joint joint;
    body::Vec3 position_m;  // Unity's axes
    body::Quat rotation;
  };

  WornDevices(const Options& options, const std::vector<Place>& places);

  // The devices of this frame. A device on a joint that is not tracked is left out.
  const std::vector<Reading>& Read(const Frame& frame);

 private:
  struct Worn {
    Place place;
    body::Quat part_from_device = body::Quat::Identity();
    body::Vec3 offset_m = body::Vec3::Zero();  // in the part's frame
  };

  std::vector<Worn> worn_;
  std::vector<Reading> readings_;
  std::mt19937_64 random_;
  bool t_pose_, vanish_, shuffled_;
};

}  // namespace styled::rigs
