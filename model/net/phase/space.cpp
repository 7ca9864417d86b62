#include "model/net/phase/space.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "model/gait/tuning.h"
#include "model/net/phase/design.h"

namespace styled::phase {
namespace {

// Rms angle between the joints of two styles over a stride of a gait that both have, else of their
// postures.
float Distance(const Style& a, const Style& b) {
  constexpr int kPhases = 16;
  const auto& of_a = a.walk && b.walk ? a.walk : a.run;
  const auto& of_b = a.walk && b.walk ? b.walk : b.run;
  double sum = 0;
  for (int i = 0; i < kPhases; ++i) {
    const gait::Terms terms =
        gait::TermsAt(gait::tuning::kTurn_rad * static_cast<float>(i) / kPhases);
    const bool gaits = of_a && of_b;
    const gait::Rotations from = gaits ? of_a->curve.At(terms) : a.posture;
    const gait::Rotations to = gaits ? of_b->curve.At(terms) : b.posture;
    sum += gait::VectorsAbout(from, to).squaredNorm();
  }
  return static_cast<float>(std::sqrt(sum / (kPhases * body::kJointCount)));
}

std::string Text(const char* format, double a, double b = 0, double c = 0, double d = 0) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), format, a, b, c, d);
  return text.data();
}

// The least seconds of a gait that are a measurement, not a sample: with 3 s nine styles' walks are
// as good as with 6, with 2 s they are not.
constexpr float kEnough_s = 3;
// Least share of a gait's movement that its curve should have.
constexpr float kRegular = 0.6F;

void DescribeGait(const char* name, const std::optional<gait::Gait>& gait,
                  net::Findings& findings) {
  if (!gait || gait->seconds <= 0) return;  // none, or made by hand
  const double hz = static_cast<double>(gait->rate_rad_s / gait::tuning::kTurn_rad);
  findings.found.push_back(name +
                           Text(": %.1f strides in %.1f s, %.0f steps a minute",
                                static_cast<double>(gait->strides),
                                static_cast<double>(gait->seconds), 120 * hz) +
                           (gait->speed_mps < gait::tuning::kOnTheSpot_mps
                                ? std::string(", on the spot")
                                : Text(", %.1f m/s", static_cast<double>(gait->speed_mps))));
  if (gait->seconds < kEnough_s) {
    findings.weak.push_back(
        name + Text(": only %.1f s; show 3 s or more", static_cast<double>(gait->seconds)));
  }
  if (gait->explained < kRegular) {
    findings.weak.push_back(
        name + Text(": strides differ from each other; %.0f %% of the movement is the same in each",
                    100 * static_cast<double>(gait->explained)));
  }
}

}  // namespace

Space::Space(Style neutral, std::vector<Style> styles, float rate_hz)
    : neutral_(std::move(neutral)), styles_(std::move(styles)), rate_hz_(rate_hz) {
  double sum = 0, count = 0;
  for (std::size_t a = 1; a < styles_.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      const Style& other = b == 0 ? neutral_ : styles_[b];
      if (styles_[a].difference != other.difference) continue;
      sum += Distance(styles_[a], other);
      ++count;
    }
  }
  if (sum > 0) usual_distance_ = static_cast<float>(sum / count);
}

// A tenth of a second: a shorter clip is not even a posture.
int Space::least_frames() const noexcept {
  return std::max(2, static_cast<int>(std::lround(0.1F * rate_hz_)));
}

Style Space::SourceOf(const net::StyleSource& source) const {
  if (!source.reference.empty()) return StyleOf(gait::Analyse(source.reference, rate_hz_));
  return source.style > 0 ? styles_[static_cast<std::size_t>(source.style)] : neutral_;
}

namespace {

// A neutral performer, as a difference.
Style NoDifference() {
  Style none;
  none.difference = true;
  none.walk.emplace();
  none.standing = none.posture;
  return none;
}

}  // namespace

// neutral + strength (style - neutral). A style that is a difference already is scaled itself.
Style Space::ScaledBy(const Style& style, float strength) const {
  if (strength == 1) return style;
  const Style share[] = {neutral_, style};
  if (!style.difference) {
    const Weighted both[] = {{share[0], 1 - strength}, {share[1], strength}};
    return MeanOf(both);
  }
  Style none;
  none.difference = true;
  none.walk = style.walk;
  none.run = style.run;
  none.standing = style.standing;
  for (auto* const gait : {&none.walk, &none.run}) {
    if (*gait) (*gait)->curve = gait::Curve();
  }
  if (none.standing) *none.standing = gait::Curve().mean;
  const Weighted both[] = {{none, 1 - strength}, {style, strength}};
  return MeanOf(both);
}

net::StyleCode Space::Portable(const net::StyleCode& code) const {
  net::StyleCode own = code;
  own.resize(std::min(code.size(), kCodeSize));
  return IsCode(own) ? own : net::StyleCode();
}

net::StyleCode Space::MakeCode(const net::StyleRequest& request) const {
  std::vector<Weighted> sources;
  for (const net::StyleSource& source : request.sources) {
    if (source.weight == 0) continue;
    sources.push_back({SourceOf(source), source.weight});
  }
  if (sources.empty()) return ToCode(neutral_);
  // A mix of differences and of how people move: the neutral of the differences is unknown, so
  // the first one's kind counts.
  const bool difference = sources.front().style.difference;
  std::erase_if(sources, [&](const Weighted& one) { return one.style.difference != difference; });
  float sum = 0;
  for (const Weighted& one : sources) sum += one.weight;
  return ToCode(ScaledBy(MeanOf(sources), request.strength * (sources.size() == 1 ? sum : 1)));
}

net::StyleCode Space::Difference(const net::StyleCode& code, const net::StyleCode& from) const {
  const Style style = FromCode(code), neutral = FromCode(from);
  if (style.difference || neutral.difference) return code;
  return ToCode(DifferenceOf(style, neutral));
}

net::StyleCode Space::Mean(const net::StyleCode& a, const net::StyleCode& b, float share) const {
  const Weighted both[] = {{FromCode(a), 1 - share}, {FromCode(b), share}};
  if (both[0].style.difference != both[1].style.difference) return {};
  return ToCode(MeanOf(both));
}

std::span<const net::Slider> Space::sliders() const { return Sliders(); }
std::span<const net::Preset> Space::presets() const { return Presets(); }

Result<net::StyleCode> Space::Design(const net::StyleCode& code,
                                     const net::SliderValues& values) const {
  Style style = code.empty() ? NoDifference() : FromCode(code);
  const Result<Style> designed = WithSliders(style, values);
  if (!designed.ok()) return designed.status();
  return ToCode(designed.value());
}

net::SliderValues Space::SlidersOf(const net::StyleCode& code) const {
  const Style style = FromCode(code);
  net::SliderValues values;
  for (std::size_t i = 0; i < kSliderCount; ++i) {
    const net::Slider& slider = Sliders()[i];
    if (style.sliders[i] != 0) values.push_back({slider.name, slider.usual + style.sliders[i]});
  }
  return values;
}

net::NearestStyle Space::Nearest(const net::StyleCode& code) const {
  const Style style = FromCode(code);
  net::NearestStyle nearest{0, 1e9F};
  for (std::size_t s = 0; s < styles_.size(); ++s) {
    const Style& other = s == 0 ? neutral_ : styles_[s];
    if (other.difference != style.difference) continue;
    const float distance = Distance(style, other) / usual_distance_;
    if (distance < nearest.distance) nearest = {static_cast<int>(s), distance};
  }
  if (nearest.distance == 1e9F) return {0, 0};
  return nearest;
}

net::Findings Space::Describe(const net::StyleCode& code) const {
  const Style style = FromCode(code);
  net::Findings findings;
  DescribeGait("walk", style.walk, findings);
  DescribeGait("run", style.run, findings);
  if (style.standing && style.seconds > 0) findings.found.emplace_back("standing");
  std::string by_hand;
  for (const net::SliderValue& slider : SlidersOf(code)) {
    by_hand += (by_hand.empty() ? "by hand: " : ", ") + slider.name +
               Text(" %.4g", static_cast<double>(slider.value));
  }
  if (!by_hand.empty()) findings.found.push_back(std::move(by_hand));
  if (style.has_gait()) return findings;
  if (style.is_pose()) {
    findings.found.emplace_back("a pose");
    findings.weak.emplace_back("the example does not move: it is a posture only");
  } else {
    findings.found.emplace_back("no walk and no run");
    findings.weak.push_back(
        Text("%.1f s without 1.5 strides in a row: a posture only; show 3 s of "
             "a walk or a run",
             static_cast<double>(style.seconds)));
  }
  return findings;
}

net::Suitable Space::Suits(const net::StyleCode& code) const {
  const Style style = FromCode(code);
  if (style.has_gait()) return net::Suitable::kYes;
  return style.is_pose() ? net::Suitable::kAlone : net::Suitable::kNo;
}

}  // namespace styled::phase
