#include "model/net/phase/tables.h"

#include "model/body/parts.h"
#include "model/net/phase/design.h"
#include "model/net/styles.h"

namespace styled::phase {
namespace {

using gait::Curve;
using gait::Lane;
using gait::LanesAt;
using gait::Rotations;
using gait::ToLanes;
using gait::TurnLanes;
using gait::VectorLanes;

// mean_j exp(vectors_j)
TurnLanes About(const Rotations& mean, const gait::Vectors& vectors) noexcept {
  return ToLanes(mean) * ExpOf(ToLanes(vectors));
}

// The identity.
TurnLanes Still() noexcept { return {Lane::Zero(), Lane::Zero(), Lane::Zero(), Lane::Ones()}; }

}  // namespace

LaneCurve::LaneCurve(const Curve& curve)
    : mean(ToLanes(curve.mean)), series(ToLanes(curve.series)) {}

TurnLanes LaneCurve::At(const gait::Terms& terms) const noexcept {
  return mean * ExpOf(LanesAt(series, terms));
}

Table::Table(const Style& style) : difference(style.difference) {
  constexpr float kDegree = 0.017453293F;
  dynamics = {style.sliders[kEnergy], style.sliders[kLag], kDegree * style.sliders[kTremor],
              kDegree * style.sliders[kWander], style.sliders[kHold]};
  has_walk = style.walk.has_value();
  has_run = style.run.has_value();
  if (has_walk) walk = LaneCurve(style.walk->curve);
  if (has_run) run = LaneCurve(style.run->curve);
  rest_share.setOnes();
  if (style.standing) {
    rest = ToLanes(*style.standing);
  } else if (style.has_gait()) {
    const Curve& gait = has_walk ? style.walk->curve : style.run->curve;
    rest = About(gait.mean, gait.series.col(0));
    rest_of_gait = true;
  } else {
    rest = ToLanes(style.posture);
    if (style.is_pose()) return;
    rest_share.setZero();
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

TurnLanes Own::Walk() const noexcept {
  if (neutral_ == nullptr) return WalkMean();
  return About(reference_.gaits->walking.mean, neutral_->walk().series() * terms_);
}

TurnLanes Own::Run() const noexcept {
  if (neutral_ == nullptr) return RunMean();
  return About(reference_.gaits->running.mean, neutral_->run().series() * terms_);
}

TurnLanes Own::WalkMean() const noexcept {
  if (neutral_ == nullptr) return ToLanes(reference_.walking.rotations);
  return About(reference_.gaits->walking.mean, neutral_->walk().series().col(0));
}

TurnLanes Own::RunMean() const noexcept {
  if (neutral_ == nullptr) return ToLanes(reference_.running.rotations);
  return About(reference_.gaits->running.mean, neutral_->run().series().col(0));
}

TurnLanes Own::Standing() const noexcept {
  TurnLanes standing = ToLanes(reference_.standing.rotations);
  if (neutral_ == nullptr) return standing;
  return ToLanes(neutral_->turns().rotations).Inverse() * standing;
}

TurnLanes Own::Mean() const noexcept {
  if (neutral_ == nullptr || running_ <= 0) return WalkMean();
  if (running_ >= 1) return RunMean();
  const TurnLanes walk = WalkMean();
  return walk * ExpOf(running_ * LogOf(walk.Inverse() * RunMean()));
}

Lane Own::Spread_rad() const noexcept {
  if (neutral_ == nullptr) return Lane::Zero();
  const auto spread = [](const neutral::OwnGait& own) -> Lane {
    const gait::Vectors squares =
        own.series().rightCols<gait::kTerms - 1>().rowwise().squaredNorm() / 2;
    const VectorLanes lanes = ToLanes(squares);
    return (lanes.x + lanes.y + lanes.z).sqrt();
  };
  Lane walk_rad = spread(neutral_->walk());
  if (running_ <= 0) return walk_rad;
  return walk_rad + running_ * (spread(neutral_->run()) - walk_rad);
}

namespace {

VectorLanes InGait(const Table& style, const Own& own) noexcept {
  const auto turn = [&](const LaneCurve& curve, const auto& neutral) {
    return style.difference ? LanesAt(curve.series, own.terms())
                            : LogOf(neutral().Inverse() * curve.At(own.terms()));
  };
  const auto walk = [&] { return turn(style.walk, [&] { return own.Walk(); }); };
  const auto run = [&] { return turn(style.run, [&] { return own.Run(); }); };
  // Of a style with one gait, the difference of that gait serves the other, too.
  if (!style.has_run || (style.has_walk && own.running() <= 0)) return walk();
  if (!style.has_walk || own.running() >= 1) return run();
  const VectorLanes walking = walk();
  return walking + own.running() * (run() - walking);
}

TurnLanes Replaced(const Table& style, const Own& own) noexcept {
  if (style.difference) return Still();
  if (!style.rest_of_gait) return own.Standing();
  return style.has_walk ? own.WalkMean() : own.RunMean();
}

VectorLanes AtRest(const Table& style, const Own& own) noexcept {
  VectorLanes turn = LogOf(Replaced(style, own).Inverse() * style.rest);
  return turn *= style.rest_share;
}

}  // namespace

VectorLanes TurnOf(const Table& style, const Own& own) noexcept {
  const float confidence = style.has_walk || style.has_run ? own.confidence() : 0;
  if (confidence <= 0) return AtRest(style, own);
  if (confidence >= 1) return InGait(style, own);
  const VectorLanes rest = AtRest(style, own);
  return rest + confidence * (InGait(style, own) - rest);
}

}  // namespace styled::phase
