#include "model/net/phase/tables.h"

#include <algorithm>
#include <cmath>

#include "model/body/parts.h"
#include "model/net/phase/design.h"
#include "model/net/styles.h"

namespace styled::phase {
namespace {

using body::kJointCount;
using body::Quat;
using gait::Curve;
using gait::Rotations;
using gait::Vectors;

// mean_j exp(vectors_j)
Rotations About(const Rotations& mean, const Vectors& vectors) noexcept {
  Rotations at;
  for (int joint = 0; joint < kJointCount; ++joint) {
    const auto j = static_cast<std::size_t>(joint);
    at[j] = mean[j] * body::Exp(gait::VectorOf(vectors, joint));
  }
  return at;
}

}  // namespace

Table::Table(const Style& style) : difference(style.difference) {
  constexpr float kDegree = 0.017453293F;
  dynamics = {style.sliders[kEnergy], style.sliders[kLag], kDegree * style.sliders[kTremor],
              kDegree * style.sliders[kWander], style.sliders[kHold]};
  has_walk = style.walk.has_value();
  has_run = style.run.has_value();
  if (has_walk) walk = style.walk->curve;
  if (has_run) run = style.run->curve;
  rest_share.fill(1);
  if (style.standing) {
    rest = *style.standing;
  } else if (style.has_gait()) {
    const Curve& gait = has_walk ? walk : run;
    rest = About(gait.mean, gait.series.col(0));
    rest_of_gait = true;
  } else {
    rest = style.posture;
    if (style.is_pose()) return;
    rest_share.fill(0);
    for (const body::Joint joint : net::kPostureJoints) rest_share[joint] = 1;
  }
}

Own::Own(const net::Performer* performer, const neutral::Reference& reference) noexcept
    : reference_(performer == nullptr ? reference : *performer->reference) {
  if (performer == nullptr) {
    terms_ = gait::TermsAt(0);
    return;
  }
  neutral_ = performer->neutral;
  terms_ = gait::TermsAt(neutral_->phase().After(performer->delay_s));
  confidence_ = neutral_->phase().confidence;
  running_ = neutral_->running();
}

Rotations Own::Walk() const noexcept {
  if (neutral_ == nullptr) return WalkMean();
  return About(reference_.gaits->walking.mean, neutral_->walk().series() * terms_);
}

Rotations Own::Run() const noexcept {
  if (neutral_ == nullptr) return RunMean();
  return About(reference_.gaits->running.mean, neutral_->run().series() * terms_);
}

Rotations Own::WalkMean() const noexcept {
  if (neutral_ == nullptr) return reference_.walking.rotations;
  return About(reference_.gaits->walking.mean, neutral_->walk().series().col(0));
}

Rotations Own::RunMean() const noexcept {
  if (neutral_ == nullptr) return reference_.running.rotations;
  return About(reference_.gaits->running.mean, neutral_->run().series().col(0));
}

Rotations Own::Standing() const noexcept {
  Rotations standing = reference_.standing.rotations;
  for (std::size_t j = 0; neutral_ != nullptr && j < standing.size(); ++j) {
    standing[j] = neutral_->turns().rotations[j].conjugate() * standing[j];
  }
  return standing;
}

Quat Own::Mean(int joint) const noexcept {
  const auto j = static_cast<std::size_t>(joint);
  if (neutral_ == nullptr) return reference_.walking.rotations[j];
  const auto mean = [&](const gait::Curve& usual, const neutral::OwnGait& own) -> Quat {
    return usual.mean[j] * body::Exp(own.series().col(0).segment<3>(3 * joint));
  };
  const Quat walk = mean(reference_.gaits->walking, neutral_->walk());
  if (running_ <= 0) return walk;
  return walk.slerp(running_, mean(reference_.gaits->running, neutral_->run()));
}

float Own::Spread_rad(int joint) const noexcept {
  if (neutral_ == nullptr) return 0;
  const auto spread = [joint](const neutral::OwnGait& own) {
    return std::sqrt(own.series().block<3, gait::kTerms - 1>(3 * joint, 1).squaredNorm() / 2);
  };
  const float walk_rad = spread(neutral_->walk());
  return walk_rad + running_ * (spread(neutral_->run()) - walk_rad);
}

namespace {

// log(from^-1 to), per joint.
Vectors Between(const Rotations& from, const Rotations& to) noexcept {
  return gait::VectorsAbout(from, to);
}

Vectors InGait(const Table& style, const Own& own) noexcept {
  const auto walk = [&]() -> Vectors {
    return style.difference ? style.walk.VectorsAt(own.terms())
                            : Between(own.Walk(), style.walk.At(own.terms()));
  };
  const auto run = [&]() -> Vectors {
    return style.difference ? style.run.VectorsAt(own.terms())
                            : Between(own.Run(), style.run.At(own.terms()));
  };
  // Of a style with one gait, the difference of that gait serves the other, too.
  if (!style.has_run || (style.has_walk && own.running() <= 0)) return walk();
  if (!style.has_walk || own.running() >= 1) return run();
  const Vectors walking = walk();
  return walking + own.running() * (run() - walking);
}

Rotations Replaced(const Table& style, const Own& own) noexcept {
  if (style.difference) return Curve().mean;
  if (!style.rest_of_gait) return own.Standing();
  return style.has_walk ? own.WalkMean() : own.RunMean();
}

Vectors AtRest(const Table& style, const Own& own) noexcept {
  Vectors turn = Between(Replaced(style, own), style.rest);
  for (int joint = 0; joint < kJointCount; ++joint) {
    turn.segment<3>(3 * joint) *= style.rest_share[static_cast<std::size_t>(joint)];
  }
  return turn;
}

}  // namespace

Vectors TurnOf(const Table& style, const Own& own) noexcept {
  const float confidence = style.has_walk || style.has_run ? own.confidence() : 0;
  if (confidence <= 0) return AtRest(style, own);
  if (confidence >= 1) return InGait(style, own);
  const Vectors rest = AtRest(style, own);
  return rest + confidence * (InGait(style, own) - rest);
}

}  // namespace styled::phase
