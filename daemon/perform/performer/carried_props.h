#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/perform/performer/body_binding.h"
#include "daemon/source/props.h"
#include "model/base/realtime.h"
#include "model/rig/grip.h"
#include "model/rig/mirror.h"
#include "model/stylist/stylist.h"

namespace styled::pipeline {

// Field 20 of v1::Frame, serialized.
class EncodedProps {
 public:
  STYLED_REALTIME void Set(const source::PropList& props) noexcept {
    size_ = source::EncodeProps(props.all(), bytes_);
  }
  STYLED_REALTIME void Clear() noexcept { size_ = 0; }
  std::span<const std::byte> bytes() const noexcept { return std::span(bytes_).first(size_); }

 private:
  std::array<std::byte, kMaxPropBytes> bytes_;
  std::size_t size_ = 0;
};

// The props of one performer's last frame, the hand that holds each, and their places on each
// output. Made for a body; pipeline thread; only the constructor allocates. Pinned by
// tests/unit/daemon/perform/performer/props_test.cpp.
class CarriedProps {
 public:
  // `hands`: the holding hand by a prop's name; other props are held by the hand near them.
  CarriedProps(const BoundBody& body, const config::PropHands& hands);

  // Accepts a frame's props. Returns how many were left out (source::ReadProps). `mirror`: of the
  // body, for a performer who is mirrored; the props, their configured hands and the pose of
  // AcceptUnfiltered are, too, and it must outlive the frame. Null: nothing is mirrored.
  STYLED_REALTIME std::size_t Accept(std::span<const std::byte> encoded, bool of_the_scene,
                                     const rig::MirrorMap* mirror = nullptr) noexcept;
  // Call after Accept if the pose is filtered afterwards, with the pose as received. A held prop
  // then follows the filtered hand.
  STYLED_REALTIME void AcceptUnfiltered(const rig::RigPose& received) noexcept;
  // Finds the hand that holds each prop. Call after the stylist, with `out` in the binding's axes.
  STYLED_REALTIME void Attach(const stylist::Output& out) noexcept;
  // Leaves out the props that `other`, a performer of the same scene, holds and this one does not.
  STYLED_REALTIME void LeaveTo(const CarriedProps& other) noexcept;

  bool empty() const noexcept { return frame_.count == 0; }
  bool of_the_scene() const noexcept { return of_the_scene_; }

  // Call after Attach, with the same `out`. The props on the rig's own skeleton, as captured and
  // styled. In a bypass frame, and if no hand holds them, their values are unchanged bit for bit.
  STYLED_REALTIME void OnSource(const stylist::Output& out, EncodedProps& to) const noexcept;
  STYLED_REALTIME void OnRig(const stylist::Output& out, EncodedProps& to) const noexcept;
  // The props on the canonical humanoid, in its metres and axes.
  STYLED_REALTIME void OnCanonical(const stylist::Output& out, EncodedProps& to) const noexcept;
  // The props on another skeleton with these wrists. `convert(placed, prop)` writes a canonical
  // pose into `prop`, in that skeleton's units and axes.
  template <typename Convert>
  STYLED_REALTIME void OnWrists(const rig::WristPair& wrists, EncodedProps& to,
                                Convert convert) const noexcept {
    source::PropList list;
    for (std::size_t i = 0; i < frame_.count; ++i) {
      if (carried_[i].elsewhere) continue;
      source::Prop prop = frame_.props[i];
      convert(rig::Carry(carried_[i].captured, carried_[i].grip, from_, wrists), prop);
      list.Add(prop);
    }
    to.Set(list);
  }

 private:
  struct Carried {
    rig::Placed captured;
    rig::Grip grip;
    bool elsewhere = false;  // held by another performer
  };
  STYLED_REALTIME void OnOwn(const rig::Vec3& root, std::span<const rig::Quat> rotations,
                             bool as_it_came, bool all, EncodedProps& to) const noexcept;
  bool HandsMoveNot(const stylist::Output& out) const noexcept;

  std::shared_ptr<const rig::Binding> binding_;
  bool left_handed_;
  const config::PropHands hands_;
  rig::Wrists wrists_;
  std::vector<std::byte> bytes_;  // memory of the names in frame_
  source::PropList frame_;        // as received, or mirrored
  bool of_the_scene_ = false;
  std::array<Carried, kMaxProps> carried_;
  const rig::MirrorMap* mirror_ = nullptr;
  rig::WristPair from_;       // wrists of the pose with which the props were captured
  rig::RigPose unfiltered_;   // the pose before filtering, if it differs from the stylist's input
  rig::RigPose received_;     // the same before it is mirrored
  bool is_filtered_ = false;  // unfiltered_ belongs to this frame
};

}  // namespace styled::pipeline
