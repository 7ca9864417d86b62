#include "model/net/stgcn_causal/stylizer.h"

#include <algorithm>

#include "model/body/heading.h"
#include "model/net/stgcn/features.h"
#include "model/net/stgcn_causal/network.h"
#include "model/net/stgcn_causal/space.h"

namespace styled::stgcn_causal {
namespace {

class CausalStream final : public net::Stream {
 public:
  explicit CausalStream(State initial) : state(std::move(initial)) {}

  std::span<const std::byte> memory() const noexcept override {
    return std::as_bytes(std::span(state.memory.data(), state.memory.size()));
  }

  State state;
  stgcn::HeadingState heading;
  stgcn::Features features;  // of the current step
  Output output;
};

// The total weight of the styles, within 0 .. 1: 0 if nothing is styled.
float Shown(const net::StepJob& job) noexcept {
  float sum = 0;
  for (const net::StyleWeight& style : job.styles) {
    if ((style.style > 0 || job.input_style > 0) && style.weight > 0) sum += style.weight;
  }
  return std::min(sum, 1.0F);
}

// The change of style is measured from a pose between the reconstruction and the input,
// kTowardInput of the way. Measured from the reconstruction, all of the performer's detail is kept,
// including their own style, which the network would have removed; measured from the input, none is
// kept.
void MeasureFromBetween(const net::StepJob& job) noexcept {
  const float share = kTowardInput * Shown(job);
  if (share <= 0) return;
  const net::Decoded& reconstruction = job.out->reconstruction;
  net::Decoded& styled = job.out->styled;
  for (std::size_t joint = 0; joint < styled.rotations.size(); ++joint) {
    const body::Quat& from = reconstruction.rotations[joint];
    body::Quat input = job.pose->rotations[joint];
    if (joint == body::kHips) input = body::Yaw(-job.out->heading_rad) * input;
    const body::Quat between = from.slerp(share, input);
    styled.rotations[joint] = from * (between.conjugate() * styled.rotations[joint]);
  }
}

class CausalStylizer final : public net::Stylizer {
 public:
  explicit CausalStylizer(std::shared_ptr<const Network> network)
      : CausalStylizer(network, std::make_shared<const ExampleSpace>(network)) {}
  CausalStylizer(std::shared_ptr<const Network> network, std::shared_ptr<const ExampleSpace> space)
      : network_(std::move(network)), space_(std::move(space)) {}

  const net::Model& model() const noexcept override { return network_->model(); }

  const net::StyleSpace* space() const noexcept override { return space_.get(); }

  std::shared_ptr<const net::Stylizer> With(int number, const net::StyleInfo& style,
                                            const net::StyleCode& code) const override {
    return std::make_shared<CausalStylizer>(network_->With(number, style, code), space_);
  }

  std::shared_ptr<const net::Stylizer> Retired(int number) const override {
    return std::make_shared<CausalStylizer>(network_->Retired(number), space_);
  }

  bool SharesStreams(const net::Stylizer& other) const noexcept override {
    const auto* const causal = dynamic_cast<const CausalStylizer*>(&other);
    return causal != nullptr && network_->SharesStates(*causal->network_);
  }

  std::unique_ptr<net::Stream> MakeStream() const override {
    return std::make_unique<CausalStream>(network_->MakeState());
  }

  void Start(net::Stream& stream) const noexcept override {
    auto& own = static_cast<CausalStream&>(stream);
    network_->Start(own.state);
    own.heading = stgcn::HeadingState();
  }

  void Carry(net::Stream& stream, Checkpoint& c) const noexcept override {
    auto& own = static_cast<CausalStream&>(stream);
    network_->Carry(own.state, c);
    c(own.heading);
  }

  void Step(std::span<const net::StepJob> jobs) const noexcept override {
    for (const net::StepJob& job : jobs) {
      auto& stream = static_cast<CausalStream&>(*job.stream);
      job.out->heading_rad =
          stgcn::ComputeFeatures(*job.pose, network_->features(), stream.heading, stream.features);
      network_->Step(stream.features, job.input_style, job.styles, stream.state, stream.output,
                     job.variations);
      stgcn::ToDecoded(stream.output.reconstruction, job.out->reconstruction);
      stgcn::ToDecoded(stream.output.styled, job.out->styled);
      MeasureFromBetween(job);
    }
  }

 private:
  std::shared_ptr<const Network> network_;
  std::shared_ptr<const ExampleSpace> space_;  // of the weights' own styles
};

}  // namespace

Result<std::shared_ptr<const net::Stylizer>> Load(net::WeightsFile& file) {
  auto network = Network::Read(file);
  if (!network.ok()) return network.status();
  return std::shared_ptr<const net::Stylizer>(
      std::make_shared<CausalStylizer>(std::move(network.value())));
}

}  // namespace styled::stgcn_causal
