#include "model/net/phase/style.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "model/gait/tuning.h"

namespace styled::phase {
namespace {

using body::kJointCount;
using body::Quat;
using body::Vec3;
using gait::Curve;
using gait::Gait;
using gait::Rotations;
using gait::Series;
using gait::Vectors;

// Curves are combined at this many phases of a stride, and a curve is fitted to the result. More
// than twice the harmonics, so the fit is an average.
constexpr int kPhases = 32;

// The curve through rotations given at kPhases equal steps of a stride, about `mean`.
template <typename RotationsAt>
Curve Fitted(const Rotations& mean, const RotationsAt& at) {
  Curve curve;
  curve.mean = mean;
  for (int i = 0; i < kPhases; ++i) {
    const gait::Terms terms =
        gait::TermsAt(gait::tuning::kTurn_rad * static_cast<float>(i) / kPhases);
    gait::Terms weights = terms * (2.0F / kPhases);  // the terms are orthogonal
    weights[0] /= 2;
    curve.series += gait::VectorsAbout(mean, at(terms)) * weights.transpose();
  }
  return curve;
}

// The mean of rotations about the first one, by rotation vectors.
class RotationMean {
 public:
  void Add(const Rotations& rotations, float weight) {
    if (weight_ == 0) first_ = rotations;
    sum_ += weight * gait::VectorsAbout(first_, rotations);
    weight_ += weight;
  }
  bool any() const { return weight_ > 0; }
  Rotations Value() const {
    Rotations mean = first_;
    for (int joint = 0; joint < kJointCount; ++joint) {
      const Vec3 turn = gait::VectorOf(sum_, joint) / weight_;
      Quat& rotation = mean[static_cast<std::size_t>(joint)];
      rotation = (rotation * body::Exp(turn)).normalized();
    }
    return mean;
  }

 private:
  Rotations first_;
  Vectors sum_ = Vectors::Zero();
  float weight_ = 0;
};

using GaitOf = std::optional<Gait> Style::*;

std::optional<Gait> MeanGait(std::span<const Weighted> styles, GaitOf of) {
  RotationMean means;
  Gait mean;
  float weights = 0;
  const auto gait_of = [of](const Weighted& one) -> const std::optional<Gait>& {
    return one.style.*of;
  };
  for (const Weighted& one : styles) {
    const std::optional<Gait>& gait = gait_of(one);
    if (!gait) continue;
    means.Add(gait->curve.mean, one.weight);
    weights += one.weight;
    mean.rate_rad_s += one.weight * gait->rate_rad_s;
    mean.speed_mps += one.weight * gait->speed_mps;
    mean.explained += one.weight * gait->explained;
    mean.seconds += gait->seconds;
    mean.strides += gait->strides;
  }
  if (!means.any()) return {};
  mean.rate_rad_s /= weights;
  mean.speed_mps /= weights;
  mean.explained /= weights;
  mean.curve = Fitted(means.Value(), [&](const gait::Terms& terms) {
    RotationMean at;
    for (const Weighted& one : styles) {
      if (gait_of(one)) at.Add(gait_of(one)->curve.At(terms), one.weight);
    }
    return at.Value();
  });
  return mean;
}

Rotations Between(const Rotations& from, const Rotations& to) {
  Rotations between;
  for (std::size_t j = 0; j < between.size(); ++j) between[j] = from[j].conjugate() * to[j];
  return between;
}

std::optional<Gait> GaitDifference(const std::optional<Gait>& style,
                                   const std::optional<Gait>& neutral) {
  if (!style || !neutral) return {};
  Gait difference = *style;
  difference.curve = Fitted(Rotations(Curve().mean), [&](const gait::Terms& terms) {
    return Between(neutral->curve.At(terms), style->curve.At(terms));
  });
  return difference;
}

// The numbers of a code, one after the other.
class Writer {
 public:
  void Number(float number) { code_.push_back(number); }
  void Put(const Vectors& vectors) {
    code_.insert(code_.end(), vectors.data(), vectors.data() + 3 * kJointCount);
  }
  void Put(const Rotations& rotations) { Put(gait::VectorsAbout(Curve().mean, rotations)); }
  void Put(const std::optional<Gait>& gait) {
    const Gait one = gait.value_or(Gait());
    Put(one.curve.mean);
    for (int term = 0; term < gait::kTerms; ++term) Put(Vectors(one.curve.series.col(term)));
    for (const float number :
         {one.rate_rad_s, one.speed_mps, one.seconds, one.strides, one.explained}) {
      Number(number);
    }
  }
  net::StyleCode code_;
};

class Reader {
 public:
  explicit Reader(const net::StyleCode& code) : next_(code.data()) {}
  float Number() { return *next_++; }
  Vectors ReadVectors() {
    Vectors vectors = Vectors::Zero();
    vectors.head<3 * kJointCount>() =
        Eigen::Map<const Eigen::Matrix<float, 3 * kJointCount, 1>>(next_);
    next_ += 3 * kJointCount;
    return vectors;
  }
  Rotations ReadRotations() {
    const Vectors vectors = ReadVectors();
    Rotations rotations;
    for (int joint = 0; joint < kJointCount; ++joint) {
      rotations[static_cast<std::size_t>(joint)] =
          body::Exp(gait::VectorOf(vectors, joint)).normalized();
    }
    return rotations;
  }
  Gait ReadGait() {
    Gait gait;
    gait.curve.mean = ReadRotations();
    for (int term = 0; term < gait::kTerms; ++term) gait.curve.series.col(term) = ReadVectors();
    for (float* const number :
         {&gait.rate_rad_s, &gait.speed_mps, &gait.seconds, &gait.strides, &gait.explained}) {
      *number = Number();
    }
    return gait;
  }

 private:
  const float* next_;
};

// The largest difference of a slider from its usual value, in any unit.
constexpr float kMostSlider = 360;

// The first numbers of a code.
enum Head : std::size_t { kKind, kHasWalk, kHasRun, kHasStanding, kSeconds, kSpread, kUnused = 8 };

}  // namespace

bool Style::is_pose() const { return !has_gait() && spread_rad < gait::tuning::kPose_rad; }

Style StyleOf(const gait::Analysis& example) {
  Style style;
  style.walk = example.walk;
  style.run = example.run;
  style.standing = example.standing;
  style.posture = example.posture;
  style.seconds = example.seconds;
  style.spread_rad = example.spread_rad;
  return style;
}

Style MeanOf(std::span<const Weighted> styles) {
  assert(!styles.empty());
  Style mean;
  mean.difference = styles.front().style.difference;
  mean.walk = MeanGait(styles, &Style::walk);
  mean.run = MeanGait(styles, &Style::run);
  RotationMean standing, posture;
  float weights = 0;
  for (const auto& [style, weight] : styles) {
    if (style.standing) standing.Add(*style.standing, weight);
    // The posture of a gait counts before that of an act.
    if (style.has_gait() == mean.has_gait()) posture.Add(style.posture, weight);
    mean.seconds += style.seconds;
    mean.spread_rad = std::max(mean.spread_rad, style.spread_rad);
    weights += weight;
    for (std::size_t i = 0; i < kSliderNumbers; ++i) mean.sliders[i] += weight * style.sliders[i];
  }
  for (float& slider : mean.sliders) slider /= weights;
  if (standing.any()) mean.standing = standing.Value();
  mean.posture = posture.Value();
  return mean;
}

Style DifferenceOf(const Style& style, const Style& neutral) {
  Style difference;
  difference.difference = true;
  difference.walk = GaitDifference(style.walk, neutral.walk);
  difference.run = GaitDifference(style.run, neutral.run);
  if (style.standing && neutral.standing) {
    difference.standing = Between(*neutral.standing, *style.standing);
  }
  difference.posture = Between(neutral.posture, style.posture);
  difference.seconds = style.seconds;
  difference.spread_rad = style.spread_rad;
  difference.sliders = style.sliders;
  return difference;
}

namespace {

// The rotations of a difference, or their inverses, after others.
Rotations Turned(const Rotations& rotations, const Rotations& turns, bool back) {
  Rotations turned;
  for (std::size_t j = 0; j < turned.size(); ++j) {
    turned[j] = (rotations[j] * (back ? turns[j].conjugate() : turns[j])).normalized();
  }
  return turned;
}

Style TurnedBy(const Style& style, const Style& difference, bool back) {
  Style turned = style;
  const auto turn = [&](std::optional<Gait>& gait, const std::optional<Gait>& by) {
    if (!gait || !by) return;
    const Curve curve = gait->curve;
    gait->curve = Fitted(curve.mean, [&](const gait::Terms& terms) {
      return Turned(curve.At(terms), by->curve.At(terms), back);
    });
  };
  turn(turned.walk, difference.walk);
  turn(turned.run, difference.run ? difference.run : difference.walk);
  const Rotations& standing = difference.standing ? *difference.standing : difference.posture;
  if (turned.standing) turned.standing = Turned(*turned.standing, standing, back);
  turned.posture = Turned(turned.posture, difference.posture, back);
  return turned;
}

}  // namespace

Style WithDifference(const Style& style, const Style& difference) {
  return TurnedBy(style, difference, false);
}

Style WithoutDifference(const Style& style, const Style& difference) {
  return TurnedBy(style, difference, true);
}

net::StyleCode ToCode(const Style& style) {
  Writer writer;
  for (const bool flag : {style.difference, style.walk.has_value(), style.run.has_value(),
                          style.standing.has_value()}) {
    writer.Number(flag ? 1 : 0);
  }
  for (const float number : {style.seconds, style.spread_rad, 0.0F, 0.0F}) writer.Number(number);
  writer.Put(style.walk);
  writer.Put(style.run);
  writer.Put(style.standing.value_or(Curve().mean));
  writer.Put(style.posture);
  for (const float slider : style.sliders) writer.Number(slider);
  assert(writer.code_.size() == kCodeSize);
  return writer.code_;
}

Style FromCode(const net::StyleCode& code) {
  assert(IsCode(code));
  Style style;
  style.difference = code[kKind] != 0;
  style.seconds = code[kSeconds];
  style.spread_rad = code[kSpread];
  Reader reader(code);
  for (std::size_t i = 0; i < kUnused; ++i) reader.Number();
  const Gait walk = reader.ReadGait(), run = reader.ReadGait();
  const Rotations standing = reader.ReadRotations();
  if (code[kHasWalk] != 0) style.walk = walk;
  if (code[kHasRun] != 0) style.run = run;
  if (code[kHasStanding] != 0) style.standing = standing;
  style.posture = reader.ReadRotations();
  for (float& slider : style.sliders) slider = reader.Number();
  return style;
}

bool IsCode(const net::StyleCode& code) {
  if (code.size() != kCodeSize) return false;
  for (const std::size_t flag : {kKind, kHasWalk, kHasRun, kHasStanding}) {
    if (code[flag] != 0 && code[flag] != 1) return false;
  }
  // Rotation vectors are at most some turns, and all else seconds, metres and degrees. Larger
  // numbers would overflow in a step.
  constexpr float kMost = 1e6F, kMost_rad = 4 * gait::tuning::kTurn_rad;
  constexpr std::size_t kGait = 8 * 3 * kJointCount + 5, kPostures = kUnused + 2 * kGait;
  const auto within = [&code](std::size_t from, std::size_t count, float most) {
    return std::all_of(code.begin() + static_cast<std::ptrdiff_t>(from),
                       code.begin() + static_cast<std::ptrdiff_t>(from + count),
                       [most](float number) { return std::abs(number) <= most; });  // no NaN
  };
  return within(0, kCodeSize, kMost) && within(kUnused, kGait - 5, kMost_rad) &&
         within(kUnused + kGait, kGait - 5, kMost_rad) &&
         within(kPostures, 2 * 3 * kJointCount, kMost_rad) &&
         within(kCodeSize - kSliderNumbers, kSliderNumbers, kMostSlider);
}

}  // namespace styled::phase
