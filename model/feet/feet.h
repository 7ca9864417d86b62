#pragma once

#include <array>
#include <vector>

#include "model/base/realtime.h"
#include "model/feet/contacts.h"
#include "model/feet/legs.h"
#include "model/feet/options.h"
#include "model/feet/two_bone_ik.h"

namespace styled::feet {

// Step 6 of the stylist, on one output skeleton: while the performer's own foot is on the floor,
// the published one moves over the floor as that does, where a style, or another skeleton's
// proportions, would let it slide. There it keeps the performer's heights, and it never sinks below
// the floor. Legs follow by two-bone IK, which keeps lengths and the side of the knee; the hips
// come down where a leg would have to stretch. Everything is a smooth function of the input or
// integrates one, so nothing pops, and nothing is delayed.
//
// Spaces: poses are local transforms of their skeleton; inside, canonical metres and axes (+Y up),
// in which all bound skeletons have the same hips height. Sized at construction; Process does not
// allocate. One thread at a time. Mathematics: model/README.md, 6. Constants: tuning.h. Pinned
// by tests/unit/feet/feet_test.cpp.
class Feet {
 public:
  // The performer's pose is given on the skeleton of `input`, the feet of `output` are held.
  // `options` must pass Validate.
  Feet(const rig::Binding& input, const rig::Binding& output, const Options& options);

  // One frame, `dt_s` after the last (0 for the first; over a hole of more than 0.25 s
  // locks stay as they are, wherever the performer went).
  // `input`: the performer's own pose; `styled`: what is published, changed in place:
  // leg joints' rotations and the hips' translation, nothing else. Both must have unit rotations;
  // they may not be the same memory. `weight`, 0 .. 1, is the stage's share: at 0 it only watches
  // the contacts and leaves `styled` bit for bit.
  STYLED_REALTIME void Process(float dt_s, float weight, const PoseView& input,
                               const MutablePoseView& styled) noexcept;

  // Forgets locks, floor and contacts: the next frame is the first.
  STYLED_REALTIME void Reset() noexcept;

  const Contacts& contacts() const { return contacts_; }

 private:
  struct Leg {
    int frames = 0;  // since Reset, at most 2: after the first, those that took time
    Vec3 last_in_toes_m, last_in_heel_m, last_toes_m, last_heel_m;
    Vec3 offset_m = Vec3::Zero();  // horizontal: from where the style puts the foot
    Vec3 centre_m =
        Vec3::Zero();  // horizontal: the gait's mean of styled less input, in world axes
    CriticallyDamped lift_toes, lift_heel, moved;

    float yields = 0;               // this frame's: 1 where the styled foot is too high to hold
    Quat pitch = Quat::Identity();  // this frame's: of the foot, in world
    Vec3 ankle_m;                   // where the ankle is to go
    float as_styled = 1;            // 1 where that is where the style has it, 0 elsewhere
    float need_m = 0;               // by how much the hips must come down for that
  };
  // The performer's own foot, at the heights that the output's ankles and toes have over a floor.
  struct Sole {
    Vec3 heel_m, toes_m;
    float heel = 0, toes = 0;  // contact weights
  };
  Sole InputFoot(int side) const noexcept;
  bool Resolved(int side) const { return in_legs_.leg(side).resolved && legs_.leg(side).resolved; }
  void TurnWithPerformer() noexcept;
  void PlaceFoot(int side, float dt_s, float weight) noexcept;
  void Lock(int side, float dt_s, const Sole& input, const Vec3& toes, const Vec3& heel) noexcept;
  void LowerHips(float dt_s, const MutablePoseView& styled) noexcept;
  void Reach(int side, const MutablePoseView& styled) noexcept;

  Legs in_legs_, legs_;
  Options options_;
  Contacts contacts_;
  std::array<Leg, kLegs> state_;
  CriticallyDamped drop_m_;
  Vec3 last_across_ = Vec3::Zero();  // the input's right hip to left hip, horizontal, unit
  std::vector<Placed> in_, out_;
};

}  // namespace styled::feet
