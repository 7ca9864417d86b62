#include "model/net/erd/stylizer.h"

#include <algorithm>
#include <array>

#include "model/net/erd/features.h"
#include "model/net/erd/network.h"

namespace styled::erd {
namespace {

// A crowd's streams are larger than the caches.
void Prefetch(const FeatureState& state) noexcept {
  constexpr std::size_t kLine = 64;
  const auto bytes = std::as_bytes(std::span(&state, 1));
  for (std::size_t at = 0; at < bytes.size(); at += kLine) __builtin_prefetch(&bytes[at]);
}

template <Shape kShape>
class ErdStream final : public net::Stream {
 public:
  struct Memory {
    StateOf<kShape> network;
    FeatureState features;  // the filtered heading and the last positions
  } frames;
  Features features;  // of the current step

  std::span<const std::byte> memory() const noexcept override {
    return std::as_bytes(std::span(&frames, 1));
  }
};

template <Shape kShape>
class ErdStylizer final : public net::Stylizer {
 public:
  explicit ErdStylizer(std::shared_ptr<const ShapedNetwork<kShape>> network)
      : network_(std::move(network)) {}

  const net::Model& model() const noexcept override { return network_->model(); }

  std::unique_ptr<net::Stream> MakeStream() const override {
    auto stream = std::make_unique<ErdStream<kShape>>();
    Start(*stream);
    return stream;
  }

  void Start(net::Stream& stream) const noexcept override {
    auto& memory = static_cast<ErdStream<kShape>&>(stream).frames;
    network_->Start(memory.network);
    memory.features = FeatureState();
  }

  void Carry(net::Stream& stream, Checkpoint& c) const noexcept override {
    auto& memory = static_cast<ErdStream<kShape>&>(stream).frames;
    memory.network.Carry(c, network_->style_count(), network_->content_count() > 0);
    c(memory.features);
  }

  void Step(std::span<const net::StepJob> jobs) const noexcept override {
    std::array<StepJobOf<kShape>, net::kTogether> steps;
    for (; !jobs.empty(); jobs = jobs.subspan(std::min(jobs.size(), net::kTogether))) {
      const std::size_t count = std::min(jobs.size(), net::kTogether);
      for (std::size_t k = 0; k < count; ++k) {
        const net::StepJob& job = jobs[k];
        if (k + 1 < count) {
          Prefetch(static_cast<const ErdStream<kShape>&>(*jobs[k + 1].stream).frames.features);
        }
        auto& stream = static_cast<ErdStream<kShape>&>(*job.stream);
        auto& memory = stream.frames;
        job.out->heading_rad =
            ComputeFeatures(*job.pose, network_->features(), memory.features, stream.features);
        steps[k] = {&stream.features, job.input_style, job.styles,
                    &memory.network,  job.out,         job.content};
      }
      network_->StepTogether(std::span(steps).first(count));
    }
  }

 private:
  std::shared_ptr<const ShapedNetwork<kShape>> network_;
};

template <Shape kShape>
Result<std::shared_ptr<const net::Stylizer>> LoadShape(net::WeightsFile& file) {
  auto network = ShapedNetwork<kShape>::Read(file);
  if (!network.ok()) return network.status();
  return std::shared_ptr<const net::Stylizer>(
      std::make_shared<ErdStylizer<kShape>>(std::move(network.value())));
}

}  // namespace

Result<std::shared_ptr<const net::Stylizer>> Load(net::WeightsFile& file) {
  // A file of neither shape is compared with the paper's.
  const auto latent = file.header.find("latent");
  const bool wide = latent != file.header.end() && *latent == kWide.latent;
  return wide ? LoadShape<kWide>(file) : LoadShape<kPaper>(file);
}

}  // namespace styled::erd
