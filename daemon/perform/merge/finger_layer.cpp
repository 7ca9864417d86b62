#include "daemon/perform/merge/finger_layer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "daemon/perform/performer/body_binding.h"

namespace styled::pipeline {
namespace {

using runtime::Counter;

// A shorter quaternion has no reliable direction.
constexpr float kShortest = 1e-3F;

// The part of a binding that fingers need.
struct HandBinding {
  rig::BindingSpec spec;
  float scale = 1;
};

// Whether the skeleton is more than hands. Only then is an error in it reported.
bool IsBody(const rig::Skeleton& skeleton, const rig::JointNames& names) {
  const auto map = rig::MapJoints(skeleton, names);
  return !map.ok() ||
         std::ranges::all_of(
             std::array{body::kHips, body::kHead, body::kLeftUpperArm, body::kRightUpperArm,
                        body::kLeftUpperLeg, body::kRightUpperLeg},
             [&](body::Joint joint) { return map.value()[joint] >= 0; });
}

Result<HandBinding> BindAsHands(const v1::Body& body, const rig::JointNames& names) {
  auto skeleton = ReadSkeleton(body);
  if (!skeleton.ok()) return skeleton.status();
  if (IsBody(skeleton.value(), names)) {
    const auto bound = BindBody(body, std::nullopt, names);
    if (!bound.ok()) return bound.status();
    const rig::Binding& binding = *bound.value().binding;
    return HandBinding{binding.spec(), binding.scale()};
  }
  std::vector<rig::Quat> rest;
  for (int j = 0; 4 * j < body.rest_size(); ++j) {
    rest.emplace_back(body.rest(4 * j + 3), body.rest(4 * j), body.rest(4 * j + 1),
                      body.rest(4 * j + 2));
    if (!(std::abs(rest.back().norm() - 1.0F) < 1e-3F)) {
      return Status::Error("body: joint " + std::to_string(j) + ": rest is not of unit length");
    }
  }
  auto hands = rig::BindHands(skeleton.value(), rest, names);
  if (!hands.ok()) return hands.status();
  return HandBinding{std::move(hands.value()), 1};
}

}  // namespace

FingerLayer::FingerLayer(const rig::TailSet& wanted, rig::JointNames names,
                         config::Smoothing smoothing)
    : wanted_(wanted), names_(std::move(names)), options_(smoothing) {}

Result<FingerLayer::Body> FingerLayer::AcceptBody(const source::SourceFrame& frame,
                                                  std::int64_t now_ns) {
  why_ = Admit(frame, now_ns);
  if (why_ != kAccepted) return Body::kNotNext;
  admission_.session_has_body = true;
  if (crc_ == frame.body_crc) return Body::kSame;
  if (!admission_.MayChangeBody(now_ns)) {
    return Status::Error(
        "the body changes too often, expected at most twice a second: the last one stays");
  }
  crc_ = frame.body_crc;
  v1::Body body;
  const Status status =
      source::ReadBody(frame, body) ? Bind(body) : Status::Error("body: not a styled.v1.Body");
  if (status.ok()) return Body::kBound;
  bound_.reset();
  return status;
}

Status FingerLayer::Bind(const v1::Body& body) {
  auto made = BindAsHands(body, names_);
  if (!made.ok()) return made.status();
  const HandBinding& hands = made.value();
  rig::TailMap map = rig::FindTail(hands.spec.skeleton, hands.spec.source_joint);
  for (std::size_t t = 0; t < map.size(); ++t) {
    if (!wanted_[t]) map[t] = -1;
  }
  auto bound = std::make_unique<Bound>(hands.spec.skeleton);
  bound->tail = rig::Tail::Make(hands.spec, hands.scale, map);
  if (bound->tail.size() == 0) {
    return Status::Error(
        "body: found no finger that is to be merged, expected e.g. leftIndexProximal below "
        "leftHand; is the glove switched on in the rig's application?");
  }
  bound->turns.assign(bound->tail.size(), rig::Quat::Identity());
  for (std::size_t i = 0; i < bound->turns.size(); ++i) {
    bound->turns[i] = fingers_[static_cast<std::size_t>(bound->tail.joints()[i].joint)].rotation;
  }
  bound->smoothing =
      PoseSmoothing(options_, hands.spec.skeleton.names.size(), body.metres_per_unit());
  bound_ = std::move(bound);
  return Status::Ok();
}

void FingerLayer::HoldBadJoints(Bound& bound) noexcept {
  for (std::size_t joint = 0; joint < bound.sound.size(); ++joint) {
    rig::Quat& rotation = bound.pose.rotations[joint];
    const float length = rotation.norm();  // infinite for absurd values
    bound.held[joint] = !std::isfinite(length) || length < kShortest;
    if (!bound.held[joint]) bound.sound[joint] = rotation.normalized();
    rotation = bound.sound[joint];
  }
}

Counter FingerLayer::Accept(const source::SourceFrame& frame, std::int64_t now_ns) noexcept {
  const Counter why = Admit(frame, now_ns);
  if (why != kAccepted) return why;
  if (!crc_ || (frame.body_crc == 0 && !admission_.session_has_body)) {
    return Counter::kPipelineBeforeBody;
  }
  if (frame.body_crc != 0 && frame.body_crc != *crc_) {
    return admission_.session_has_body ? Counter::kPipelineWrongBody : Counter::kPipelineBeforeBody;
  }
  if (bound_ == nullptr) return Counter::kPipelineUncalibrated;
  const auto time = admission_.session.AdmitTime(frame.source_time_ns, kRules);
  if (time == decide::Session::Time::kOld) return Counter::kPipelineOldTime;
  Bound& bound = *bound_;
  const auto joints = static_cast<int>(bound.pose.rotations.size());
  if (!source::CopyPose(frame, joints, bound.pose)) return Counter::kPipelineWrongSize;
  if (time == decide::Session::Time::kJump) bound.smoothing.Reset();
  HoldBadJoints(bound);
  bound.smoothing.Apply(bound.pose, admission_.session.elapsed_ns());
  bound.tail.Read(bound.pose.rotations, bound.turns);
  for (std::size_t i = 0; i < bound.turns.size(); ++i) {
    const auto t = static_cast<std::size_t>(bound.tail.joints()[i].joint);
    const auto joint = static_cast<std::size_t>(bound.tail.map()[t]);
    if (bound.held[joint]) continue;
    fingers_[t].rotation = bound.turns[i];
    fingers_[t].fresh = true;
  }
  MarkAccepted(now_ns);
  return kAccepted;
}

void FingerLayer::Advance(std::int64_t step_ns) noexcept {
  constexpr std::int64_t kLongest_ns = kHold_ns + kFade_ns + 1;  // every fade has ended by then
  step_ns = std::clamp<std::int64_t>(step_ns, 0, kLongest_ns);
  const float turn = static_cast<float>(step_ns) / static_cast<float>(kFade_ns);
  for (Finger& finger : fingers_) {
    finger.silent_ns =
        std::exchange(finger.fresh, false) ? 0 : std::min(finger.silent_ns + step_ns, kLongest_ns);
    const float by = finger.silent_ns <= kHold_ns ? turn : -turn;
    finger.weight = std::clamp(finger.weight + by, 0.0F, 1.0F);
  }
}

bool FingerLayer::Over(int joint, rig::Quat& rotation) const noexcept {
  const Finger& finger = fingers_[static_cast<std::size_t>(joint)];
  if (finger.weight <= 0) return false;
  // Ease in and out, so that fingers start and stop smoothly.
  const float share = finger.weight * finger.weight * (3 - 2 * finger.weight);
  rotation = finger.weight >= 1 ? finger.rotation : rotation.slerp(share, finger.rotation);
  return true;
}

}  // namespace styled::pipeline
