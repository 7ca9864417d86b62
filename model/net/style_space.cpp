#include "model/net/style_space.h"

#include <algorithm>
#include <cstddef>

namespace styled::net {
namespace {

StyleCode Neutral(const StyleSpace& space) {
  StyleRequest request;
  request.sources.emplace_back().style = 0;
  return space.MakeCode(request);
}

}  // namespace

bool StyleSpace::IsCode(const StyleCode& code) const {
  return code.size() == Neutral(*this).size();
}

StyleCode StyleSpace::Mean(const StyleCode& a, const StyleCode& b, float share) const {
  if (a.size() != b.size()) return {};
  StyleCode mean = a;
  for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += share * (b[i] - a[i]);
  return Limited(mean);
}

Result<StyleCode> StyleSpace::Design(const StyleCode& /*code*/,
                                     const SliderValues& /*values*/) const {
  return Status::Error("these weights have no sliders; expected weights of the family \"phase\"");
}

Findings StyleSpace::Describe(const StyleCode& /*code*/) const { return {}; }

StyleCode StyleSpace::Difference(const StyleCode& code, const StyleCode& from) const {
  StyleCode difference = Neutral(*this);
  difference.resize(std::max({difference.size(), code.size(), from.size()}));
  for (std::size_t i = 0; i < code.size(); ++i) difference[i] += code[i];
  for (std::size_t i = 0; i < from.size(); ++i) difference[i] -= from[i];
  return Limited(difference);
}

}  // namespace styled::net
