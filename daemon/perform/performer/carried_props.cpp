#include "daemon/perform/performer/carried_props.h"

#include <algorithm>

namespace styled::pipeline {
namespace {

bool IsFinite(const rig::WristPair& wrists) noexcept {
  return std::all_of(wrists.begin(), wrists.end(), [](const std::optional<rig::Placed>& wrist) {
    return !wrist || (wrist->position_m.allFinite() && wrist->rotation.coeffs().allFinite());
  });
}

rig::Hand OtherHand(rig::Hand hand) noexcept {
  if (hand == rig::Hand::kLeft) return rig::Hand::kRight;
  return hand == rig::Hand::kRight ? rig::Hand::kLeft : hand;
}

}  // namespace

CarriedProps::CarriedProps(const BoundBody& body, const config::PropHands& hands)
    : binding_(body.binding),
      left_handed_(body.left_handed),
      hands_(hands),
      wrists_(*body.binding),
      unfiltered_(body.binding->skeleton()),
      received_(body.binding->skeleton()) {
  bytes_.reserve(kMaxPropBytes);
}

std::size_t CarriedProps::Accept(std::span<const std::byte> encoded, bool of_the_scene,
                                 const rig::MirrorMap* mirror) noexcept {
  bytes_.assign(encoded.begin(), encoded.end());
  source::ReadProps(bytes_, frame_);
  of_the_scene_ = of_the_scene;
  mirror_ = mirror;
  is_filtered_ = false;
  for (std::size_t i = 0; i < frame_.count; ++i) {
    source::Prop& prop = frame_.props[i];
    rig::Vec3 position = prop.position;
    rig::Quat rotation = prop.rotation;
    if (left_handed_) {
      position = rig::Mirrored(position);
      rotation = rig::Mirrored(rotation);
    }
    if (mirror_ != nullptr) {
      position = mirror_->Reflected(position);
      rotation = mirror_->Reflected(rotation);
      prop.position = left_handed_ ? rig::Mirrored(position) : position;
      prop.rotation = left_handed_ ? rig::Mirrored(rotation) : rotation;
    }
    carried_[i] = {rig::ToCanonical(*binding_, position, rotation), {}, false};
  }
  return frame_.left_out;
}

void CarriedProps::AcceptUnfiltered(const rig::RigPose& received) noexcept {
  if (empty()) return;
  rig::RigPose& pose = mirror_ == nullptr ? unfiltered_ : received_;
  std::copy(received.translations.begin(), received.translations.end(), pose.translations.begin());
  std::copy(received.rotations.begin(), received.rotations.end(), pose.rotations.begin());
  if (left_handed_) rig::Mirror(pose);
  if (mirror_ != nullptr) mirror_->Apply(received_, unfiltered_);
  is_filtered_ = true;
}

void CarriedProps::Attach(const stylist::Output& out) noexcept {
  if (empty()) return;
  // Joints without a valid rotation are held in the stylist's input only.
  if (is_filtered_) {
    from_ = wrists_.Read(unfiltered_.translations.front(), unfiltered_.rotations);
    is_filtered_ = IsFinite(from_);
  }
  if (!is_filtered_) from_ = wrists_.Read(out.source.translations.front(), out.source.rotations);
  for (std::size_t i = 0; i < frame_.count; ++i) {
    const auto named = hands_.find(frame_.props[i].name);
    const rig::Hand hand = named == hands_.end() ? rig::Hand::kAuto : named->second;
    carried_[i].grip =
        rig::GripOf(carried_[i].captured, from_, mirror_ == nullptr ? hand : OtherHand(hand));
  }
}

void CarriedProps::LeaveTo(const CarriedProps& other) noexcept {
  for (std::size_t k = 0; k < other.frame_.count; ++k) {
    if (!(other.carried_[k].grip.held() > 0)) continue;
    for (std::size_t i = 0; i < frame_.count; ++i) {
      const bool same = other.frame_.props[k].name == frame_.props[i].name;
      if (same && !(carried_[i].grip.held() > 0)) carried_[i].elsewhere = true;
    }
  }
}

// Whether the styled pose equals the captured one.
bool CarriedProps::HandsMoveNot(const stylist::Output& out) const noexcept {
  return (out.flags & stylist::kBypass) != 0 && out.travel.moved_m.isZero(0.0F);
}

void CarriedProps::OnOwn(const rig::Vec3& root, std::span<const rig::Quat> rotations,
                         bool as_it_came, bool all, EncodedProps& to) const noexcept {
  const rig::WristPair wrists = as_it_came ? from_ : wrists_.Read(root, rotations);
  source::PropList list;
  for (std::size_t i = 0; i < frame_.count; ++i) {
    if (carried_[i].elsewhere && !all) continue;
    source::Prop prop = frame_.props[i];
    if (!as_it_came && carried_[i].grip.held() > 0) {
      const rig::Placed placed = rig::Carry(carried_[i].captured, carried_[i].grip, from_, wrists);
      rig::FromCanonical(*binding_, placed, prop.position, prop.rotation);
      if (left_handed_) {
        prop.position = rig::Mirrored(prop.position);
        prop.rotation = rig::Mirrored(prop.rotation);
      }
    }
    list.Add(prop);
  }
  to.Set(list);
}

void CarriedProps::OnSource(const stylist::Output& out, EncodedProps& to) const noexcept {
  OnOwn(out.source.translations.front(), out.source.rotations, !is_filtered_, true, to);
}

void CarriedProps::OnRig(const stylist::Output& out, EncodedProps& to) const noexcept {
  OnOwn(binding_->RootPosition(out.rig), out.rig.rotations, !is_filtered_ && HandsMoveNot(out),
        false, to);
}

void CarriedProps::OnCanonical(const stylist::Output& out, EncodedProps& to) const noexcept {
  OnWrists(rig::WristsOf(out.canonical), to, [](const rig::Placed& placed, source::Prop& prop) {
    prop.position = placed.position_m;
    prop.rotation = placed.rotation;
  });
}

}  // namespace styled::pipeline
