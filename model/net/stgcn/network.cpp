#include "model/net/stgcn/network.h"

#include <cassert>

#include "model/net/stgcn/weights.h"

namespace styled::stgcn {

Network::~Network() = default;

int Network::width() const { return weights_->width; }

const CodeSpace& Network::space() const { return *weights_->space; }

void Network::Encode(std::span<const Features> clip, Content& content, Scratch& scratch) const {
  assert(clip.size() >= kLeastFrames);
  const Weights& w = *weights_;
  const int frames = (static_cast<int>(clip.size()) + 3) / 4 * 4;
  const float* const in = RunInput(*w.kernels, w.generator.in, w.standard, clip, frames, scratch);
  const auto& [first, second] = w.generator.encoder;
  float* const middle = Sized(scratch.out[0], Size(frames / 2, kNodes[1], first.out));
  RunEncoder(*w.kernels, first, in, frames, middle, scratch);
  content.frames = static_cast<int>(clip.size());
  content.values.Grow(Size(frames / 4, kNodes[2], second.out));
  RunEncoder(*w.kernels, second, middle, frames / 2, content.values.data(), scratch);
}

void Network::Decode(const Content& content, const Code& code, std::span<Features> out,
                     Scratch& scratch) const {
  assert(out.size() == static_cast<std::size_t>(content.frames));
  const Weights& w = *weights_;
  const int frames = (content.frames + 3) / 4 * 4;
  const auto& [first, second] = w.generator.decoder;
  float* const middle = Sized(scratch.out[0], Size(frames / 2, kNodes[1], first.out));
  RunDecoder(*w.kernels, first, code, content.values.data(), frames / 4, middle, scratch);
  float* const last = Sized(scratch.out[1], Size(frames, kNodes[0], second.out));
  RunDecoder(*w.kernels, second, code, middle, frames / 2, last, scratch);

  const Linear& head = w.generator.out;
  const int columns = head.weight.columns();
  float* const y = Sized(scratch.frames, Size(frames, kNodes[0], columns));
  const net::RowTerm term{last, second.out};
  w.kernels->product({&head.weight,
                      {&term, 1},
                      frames * kNodes[0],
                      head.bias.data(),
                      1,
                      nullptr,
                      false,
                      y,
                      columns});
  for (std::size_t frame = 0; frame < out.size(); ++frame) {
    for (std::size_t i = 0; i < kFeatureCount; ++i) {
      const std::size_t row = frame * kNodes[0] + i / kChannels;
      const float value = y[row * static_cast<std::size_t>(columns) + i % kChannels];
      out[frame][i] = value * w.standard.deviation[i] + w.standard.mean[i];
    }
    // Constant in every pose; the network's output there is noise.
    out[frame][kChannels * body::kHips] = out[frame][kChannels * body::kHips + 2] = 0;
  }
}

}  // namespace styled::stgcn
