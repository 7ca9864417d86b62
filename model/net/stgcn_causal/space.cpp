#include "model/net/stgcn_causal/space.h"

#include <algorithm>

namespace styled::stgcn_causal {
namespace {

using net::StyleCode;
using stgcn::Features;
using stgcn::kCode;
using stgcn::kFeatureCount;

// The first frames of a stream are not the network's best: it does not know the example's own
// statistics yet. For a shorter example half of it is left out.
constexpr std::size_t kFirst = 32;
// Frames of the middle of an example that count for the bias, four strides; each takes 0.06 ms.
// With all of them the styles of set 2 are recognized as often, to 0.01.
constexpr std::size_t kMost = kFirst + 128;

StyleCode Head(const StyleCode& code) { return {code.begin(), code.begin() + kCode}; }

}  // namespace

int ExampleSpace::least_frames() const noexcept { return network_->space().least_frames(); }

bool ExampleSpace::IsCode(const StyleCode& code) const {
  return network_->points().IsSize(code.size());
}

StyleCode ExampleSpace::MakeCode(const net::StyleRequest& request) const {
  StyleCode code = network_->space().MakeCode(request);
  // Of one example at its own strength, the code is that example's; to read it costs as much as the
  // bias.
  const bool is_examples =
      request.sources.size() == 1 && request.strength == 1 && request.sources.front().weight == 1;
  Features bias{};
  bool any = false;
  for (const net::StyleSource& source : request.sources) {
    if (source.reference.empty()) continue;
    any = true;
    net::StyleSource alone = source;
    alone.weight = 1;
    const StyleCode own_code =
        is_examples ? code : network_->space().MakeCode({.sources = {alone}});
    const Features own = BiasOf(source.reference, own_code);
    for (std::size_t i = 0; i < bias.size(); ++i) {
      bias[i] += request.strength * source.weight * own[i];
    }
  }
  if (any) code.insert(code.end(), bias.begin(), bias.end());
  return code;
}

Features ExampleSpace::BiasOf(std::span<const body::Pose> example, const StyleCode& code) const {
  if (example.size() > kMost) example = example.subspan((example.size() - kMost) / 2, kMost);
  const int number = network_->style_count();
  const auto with = network_->With(number, {.name = "example"}, code);
  const net::StyleWeight active[] = {{number, 1.0F}};
  const std::size_t skip = std::min(kFirst, example.size() / 2);
  std::array<double, kFeatureCount> sum{};
  State state = with->MakeState(), again = with->MakeState();
  stgcn::HeadingState heading;
  Features features;
  Output neutral, out;
  for (std::size_t i = 0; i < example.size(); ++i) {
    stgcn::ComputeFeatures(example[i], with->features(), heading, features);
    with->Step(features, 0, {}, state, neutral);
    with->Step(neutral.reconstruction, 0, active, again, out);
    if (i < skip) continue;
    for (std::size_t k = 0; k < kFeatureCount; ++k) {
      sum[k] += static_cast<double>(features[k]) - static_cast<double>(out.styled[k]);
    }
  }
  Features bias;
  const auto n = static_cast<double>(example.size() - skip);
  for (std::size_t k = 0; k < kFeatureCount; ++k) {
    bias[k] = static_cast<float>(sum[k] / n) * network_->inverse_deviation()[k];
  }
  return bias;
}

net::NearestStyle ExampleSpace::Nearest(const StyleCode& code) const {
  return network_->space().Nearest(Head(code));
}

StyleCode ExampleSpace::Limited(const StyleCode& code) const {
  StyleCode limited = network_->space().Limited(Head(code));
  for (std::size_t i = kCode; i < code.size(); ++i) {
    limited.push_back(std::clamp(code[i], -kMaxStandardized, kMaxStandardized));
  }
  return limited;
}

}  // namespace styled::stgcn_causal
