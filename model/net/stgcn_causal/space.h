#pragma once

#include <memory>
#include <span>

#include "model/net/stgcn_causal/network.h"
#include "model/net/style_space.h"

namespace styled::stgcn_causal {

// The styles of examples for a network of live streams: the code as CodeSpace reads it and, for an
// example, a bias of the output. The code moves the network among the styles that it was trained
// on. The bias covers the remaining distance to the example's own posture: it is the difference
// between the example's mean pose and that of the example made neutral and then styled again.
// (Styled directly, the example would keep some of its style in the content, which a neutral
// performer does not have.) Mean over nine styles never seen, walks: cosine with the example's own
// change 0.60, expression 0.57; without the bias 0.47, 0.35; with Difference to a neutral clip
// 0.83, 0.85; all before the change was measured from half-way (stylizer.h), since then 0.82, 0.75
// and 0.85, 0.97. Codes are of the sizes of PointSpace. Pinned by
// tests/unit/net/stgcn_causal/space_test.cpp.
class ExampleSpace final : public net::StyleSpace {
 public:
  explicit ExampleSpace(std::shared_ptr<const Network> network) : network_(std::move(network)) {}

  int least_frames() const noexcept override;
  bool IsCode(const net::StyleCode& code) const override;
  net::StyleCode MakeCode(const net::StyleRequest& request) const override;
  net::NearestStyle Nearest(const net::StyleCode& code) const override;
  net::StyleCode Limited(const net::StyleCode& code) const override;

 private:
  stgcn::Features BiasOf(std::span<const body::Pose> example, const net::StyleCode& code) const;

  std::shared_ptr<const Network> network_;
};

}  // namespace styled::stgcn_causal
