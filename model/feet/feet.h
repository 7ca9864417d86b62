#pragma once

#include <array>
#include <vector>

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/feet/contacts.h"
#include "model/feet/legs.h"
#include "model/feet/options.h"
#include "model/feet/travel.h"
#include "model/feet/two_bone_ik.h"

namespace styled::feet {

// Step 6 of the stylist, for one output skeleton. The style's step is scaled to the distance that
// the body covers. While the performer's own foot is on the floor, and the style does not swing it,
// the published foot moves over the floor like the performer's. Without this stage a style, or
// another skeleton's proportions, would let it slide. During contact the foot keeps the performer's
// height, and it never sinks below the floor. The hips are moved to the height at which the
// standing legs keep the knees' styled angles, above the performer's own if necessary. The legs
// follow by two-bone IK, which keeps bone lengths and the side of the knee. Every quantity is a
// smooth function of the input or an integral of one, so that nothing pops, and no delay is added.
//
// Spaces: poses are local transforms of their skeleton; inside, all is in canonical metres and axes
// (+Y up), in which all bound skeletons have the same hips height. Memory is sized at construction;
// Process does not allocate. One thread at a time. Mathematics: model/README.md, 6. Constants:
// tuning.h. Pinned by tests/unit/feet/feet_test.cpp.
class Feet {
 public:
  // `input` binds the skeleton of the performer's pose, `output` the one whose feet are held.
  // `options` must pass Validate.
  Feet(const rig::Binding& input, const rig::Binding& output, const Options& options);

  // Processes one frame, `dt_s` after the last (0 for the first). Over a hole of 0.25 s or more the
  // locks keep their state, wherever the performer went. `input`: the performer's own pose.
  // `styled`: the pose to be published, changed in place: the rotations of the leg joints and the
  // hips' translation, nothing else. Both need unit rotations and must not share memory. `weight`,
  // 0 .. 1, is the strength of the stage: at 0 only the contacts are tracked, and `styled` stays as
  // it is, bit for bit. `travel`: the offset of the styled body on the floor from the performer, if
  // any.
  STYLED_REALTIME void Process(float dt_s, float weight, const PoseView& input,
                               const MutablePoseView& styled, const Travel& travel = {}) noexcept;

  // Clears locks, floor and contacts: the next frame counts as the first.
  STYLED_REALTIME void Reset() noexcept;

  const Contacts& contacts() const { return contacts_; }
  // See model/base/checkpoint.h.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept {
    c(contacts_, state_, level_m_, drop_m_, last_across_, own_own_, own_styled_, low_m_);
    c.Within(level_frames_, 0, 2);
  }

 private:
  struct Leg {
    int frames = 0;  // since Reset, at most 2; after the first, only frames with dt_s > 0 count
    Vec3 last_in_toes_m, last_in_heel_m, last_toes_m, last_heel_m;
    Vec3 offset_m = Vec3::Zero();  // horizontal: the published foot minus the styled one
    // Horizontal, world axes: the gait's mean of the styled foot minus the input's.
    Vec3 centre_m = Vec3::Zero();
    Vec3 last_own_m = Vec3::Zero(), last_styled_m = Vec3::Zero();  // the ankle minus the hips
    CriticallyDamped lift_toes, lift_heel;
    CriticallyDamped toes_stand, heel_stands;  // 0 .. 1: the foot is on the floor in the style, too
    CriticallyDamped knee;                     // its turn by the inverse kinematics, rad

    float longer = 1;           // this frame: the scale of the step
    Vec3 fit_m = Vec3::Zero();  // this frame: horizontal, makes the step as long as the travelled
                                // distance
    float yields = 0;           // this frame: 1 if the styled foot is too high to hold
    Quat pitch = Quat::Identity();  // this frame: the foot's rotation, world
    Vec3 ankle_m;                   // the ankle's target
    float carries = 0;              // 0 .. 1: the foot is planted, and held
    float rise_m = 0;               // of the hips, for the leg to keep its styled length
    float beyond_m = 0;             // how far the hips are above the leg's reach

    STYLED_REALTIME void Carry(Checkpoint& c) noexcept {
      c.Within(frames, 0, 2);
      c(last_in_toes_m, last_in_heel_m, last_toes_m, last_heel_m, offset_m, centre_m, last_own_m,
        last_styled_m, lift_toes, lift_heel, toes_stand, heel_stands, knee);
    }
  };
  // The performer's own foot, with heel and toes at the output skeleton's heights above a floor.
  struct Sole {
    Vec3 heel_m, toes_m;
    float heel = 0, toes = 0;  // contact weights
  };
  Sole InputFoot(int side) const noexcept;
  bool Resolved(int side) const { return in_legs_.leg(side).resolved && legs_.leg(side).resolved; }
  void TurnWithPerformer() noexcept;
  void FitSteps(float dt_s, const Travel& travel) noexcept;
  void PlaceFoot(int side, float dt_s, float weight, const Travel& travel) noexcept;
  void Lock(int side, float dt_s, const Sole& input, const Vec3& toes, const Vec3& heel,
            const Travel& travel) noexcept;
  void MeasureLeg(int side, float carries) noexcept;
  void MoveHips(float dt_s, const MutablePoseView& styled) noexcept;
  void Reach(int side, float dt_s, const MutablePoseView& styled) noexcept;

  Legs in_legs_, legs_;
  Options options_;
  Contacts contacts_;
  std::array<Leg, kLegs> state_;
  CriticallyDamped level_m_, drop_m_;
  float low_m_ = 0;       // recent mean of how far the standing legs lowered the hips
  int level_frames_ = 0;  // of level_m_, as Leg::frames
  // Means over the time in which feet stand: of the square of the speed at which the performer's
  // foot moves back under the hips, and of its product with that of the styled foot, m^2/s^2.
  float own_own_ = tuning::kFitBegin_m2_s2, own_styled_ = tuning::kFitBegin_m2_s2;
  Vec3 last_across_ = Vec3::Zero();  // the input's right hip to left hip, horizontal, unit
  std::vector<Placed> in_, out_;
};

}  // namespace styled::feet
