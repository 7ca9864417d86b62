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

Rotations MeanOf(const Curve& curve) noexcept {
  gait::Terms constant = gait::Terms::Zero();
  constant[0] = 1;
  return curve.At(constant);
}

Curve CurveOf(const gait::Curve& reference, const neutral::OwnGait& own) noexcept {
  Curve curve;
  curve.mean = reference.mean;
  curve.series = own.series();
  return curve;
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
    rest = MeanOf(has_walk ? walk : run);
    rest_of_gait = true;
  } else {
    rest = style.posture;
    if (style.is_pose()) return;
    rest_share.fill(0);
    for (const body::Joint joint : net::kPostureJoints) rest_share[joint] = 1;
  }
}

Own::Own(const net::Performer* performer, const neutral::Reference& reference) noexcept {
  if (performer == nullptr) {
    terms = gait::TermsAt(0);
    walk_mean = reference.walking.rotations;
    run_mean = reference.running.rotations;
    standing = reference.standing.rotations;
    walk = walk_mean;
    run = run_mean;
    spread_rad.fill(0);
    return;
  }
  const neutral::Neutral& neutral = *performer->neutral;
  const neutral::Reference& known = *performer->reference;
  terms = gait::TermsAt(neutral.phase().After(performer->delay_s));
  confidence = neutral.phase().confidence;
  running = neutral.running();
  const Curve own_walk = CurveOf(known.gaits->walking, neutral.walk());
  const Curve own_run = CurveOf(known.gaits->running, neutral.run());
  walk = own_walk.At(terms);
  run = own_run.At(terms);
  walk_mean = MeanOf(own_walk);
  run_mean = MeanOf(own_run);
  for (int joint = 0; joint < kJointCount; ++joint) {
    const auto j = static_cast<std::size_t>(joint);
    standing[j] = neutral.turns().rotations[j].conjugate() * known.standing.rotations[j];
    const auto spread = [joint](const Curve& curve) {
      return std::sqrt(curve.series.block<3, gait::kTerms - 1>(3 * joint, 1).squaredNorm() / 2);
    };
    spread_rad[j] = spread(own_walk) + running * (spread(own_run) - spread(own_walk));
  }
}

namespace {

// log(from^-1 to), per joint.
Vectors Between(const Rotations& from, const Rotations& to) noexcept {
  return gait::VectorsAbout(from, to);
}

Vectors InGait(const Table& style, const Own& own) noexcept {
  const auto of = [&](const Curve& curve, const Rotations& neutral) -> Vectors {
    return style.difference ? curve.VectorsAt(own.terms) : Between(neutral, curve.At(own.terms));
  };
  if (!style.has_run || (style.has_walk && own.running <= 0)) return of(style.walk, own.walk);
  if (!style.has_walk || own.running >= 1) return of(style.run, own.run);
  const Vectors walk = of(style.walk, own.walk);
  return walk + own.running * (of(style.run, own.run) - walk);
}

Vectors AtRest(const Table& style, const Own& own) noexcept {
  const Rotations& gait = style.has_walk ? own.walk_mean : own.run_mean;
  Vectors turn = style.difference ? Between(Curve().mean, style.rest)
                                  : Between(style.rest_of_gait ? gait : own.standing, style.rest);
  for (int joint = 0; joint < kJointCount; ++joint) {
    turn.segment<3>(3 * joint) *= style.rest_share[static_cast<std::size_t>(joint)];
  }
  return turn;
}

}  // namespace

Vectors TurnOf(const Table& style, const Own& own) noexcept {
  const float confidence = style.has_walk || style.has_run ? own.confidence : 0;
  if (confidence <= 0) return AtRest(style, own);
  if (confidence >= 1) return InGait(style, own);
  const Vectors rest = AtRest(style, own);
  return rest + confidence * (InGait(style, own) - rest);
}

}  // namespace styled::phase
