#pragma once

#include <memory>
#include <vector>

#include "model/net/phase/style.h"
#include "model/net/style_space.h"

namespace styled::phase {

// The styles of the family as numbers (FORMAT.md). A code is valid for every file of the family.
class Space final : public net::StyleSpace {
 public:
  // `neutral`: of many people; `styles`: of the weights file, [0] is not used.
  Space(Style neutral, std::vector<Style> styles, float rate_hz);

  int least_frames() const noexcept override;
  bool IsCode(const net::StyleCode& code) const override { return phase::IsCode(code); }
  net::StyleCode MakeCode(const net::StyleRequest& request) const override;
  net::StyleCode Difference(const net::StyleCode& code, const net::StyleCode& from) const override;
  net::StyleCode Mean(const net::StyleCode& a, const net::StyleCode& b, float share) const override;
  // The whole code, or this family's part of a pair (several_space.h).
  net::StyleCode Portable(const net::StyleCode& code) const override;
  std::span<const net::Slider> sliders() const override;
  std::span<const net::Preset> presets() const override;
  Result<net::StyleCode> Design(const net::StyleCode& code,
                                const net::SliderValues& values) const override;
  net::SliderValues SlidersOf(const net::StyleCode& code) const override;
  net::NearestStyle Nearest(const net::StyleCode& code) const override;
  net::Findings Describe(const net::StyleCode& code) const override;
  net::Suitable Suits(const net::StyleCode& code) const override;

 private:
  Style SourceOf(const net::StyleSource& source) const;
  Style ScaledBy(const Style& style, float strength) const;

  Style neutral_;
  std::vector<Style> styles_;
  float rate_hz_;
  float usual_distance_ = 1;  // mean distance between two styles, rad
};

}  // namespace styled::phase
