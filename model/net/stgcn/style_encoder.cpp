#include "model/net/stgcn/style_encoder.h"

#include <algorithm>
#include <cassert>

namespace styled::stgcn {
namespace {

using net::RowKernels;
using net::RowMajor;
using net::RowTerm;
using net::TensorReader;

constexpr float kLeak = 0.2F;  // of the leaky ReLU, also in net::RowKernels::activate
// Windows of a reference that share one pass over the style encoder's largest matrix (21 MB).
constexpr int kWindowsTogether = 8;

// The convolution over 16 frames of 5 nodes as one matrix; the trunk's floats are in the order
// frame, node, channel, the file's in channel, frame, node.
Linear ReadConv(TensorReader& tensors, int channels) {
  constexpr int kFrames = kReference / 4;
  const RowMajor weight = tensors.Tensor("e.conv.weight", {channels, channels, kFrames, kNodes[2]});
  const RowMajor bias = tensors.Vector("e.conv.bias", channels).transpose();
  constexpr int kPlaces = kFrames * kNodes[2];
  const std::array<int, 1> depth{kPlaces * channels};
  Linear linear;
  linear.weight = net::PackedColumns(depth, channels);
  for (int out = 0; out < channels; ++out) {
    for (int place = 0; place < kPlaces; ++place) {
      for (int in = 0; in < channels; ++in) {
        linear.weight.At(0, out, place * channels + in) = weight(out, in * kPlaces + place);
      }
    }
  }
  Copy(bias, linear.bias);
  return linear;
}

// A reference shorter than a window: both ends repeated, the clip in the middle. Empty if the clip
// is long enough.
std::vector<Features> FilledReference(std::span<const Features> clip) {
  std::vector<Features> filled;
  if (clip.size() >= kReference) return filled;
  const std::size_t before = (kReference - clip.size()) / 2;
  filled.assign(kReference, clip.back());
  std::fill_n(filled.begin(), before, clip.front());
  std::copy(clip.begin(), clip.end(), filled.begin() + static_cast<std::ptrdiff_t>(before));
  return filled;
}

// The windows of a reference: their first frames. One window of a short clip; of a long one at most
// `most`, over all of it.
std::vector<int> WindowBegins(std::size_t frames, int most) {
  const int last = static_cast<int>(frames) - kReference;
  const int apart = last / kReferenceHop + 1;  // windows kReferenceHop apart
  const int count = std::min(most, apart);
  const int spread = count < apart ? last : (count - 1) * kReferenceHop;
  std::vector<int> begins{0};
  for (int i = 1; i < count; ++i) begins.push_back(spread * i / (count - 1));
  return begins;
}

}  // namespace

StyleEncoder::StyleEncoder(LayerReader& layers, int width, int domains, int most_windows)
    : most_windows_(most_windows) {
  assert(most_windows > 1);
  const int trunk = 4 * width;
  in_ = layers.ReadLinear("e.in", width, kChannels, kNodes[0]);
  blocks_[0] = ReadEncoder(layers, "e.res1", 0, width, 2 * width, false);
  blocks_[1] = ReadEncoder(layers, "e.res2", 1, 2 * width, trunk, false);
  conv_ = ReadConv(layers.tensors(), trunk);
  const RowMajor heads = layers.tensors().Tensor("e.heads.weight", {domains, kCode, trunk});
  const RowMajor bias = layers.tensors().Matrix("e.heads.bias", domains, kCode);
  for (int domain = 0; domain < domains; ++domain) {
    heads_.push_back({Eigen::Map<const RowMajor>(heads.row(domain).data(), kCode, trunk),
                      bias.row(domain).transpose()});
  }
  heads_.push_back(ReadDense(layers.tensors(), "e.free", kCode, trunk));
}

Code StyleEncoder::Encode(const RowKernels& kernels, const Standardization& standard,
                          std::span<const Features> clip, int domain, Scratch& scratch) const {
  assert(!clip.empty());
  const std::vector<Features> filled = FilledReference(clip);
  if (!filled.empty()) clip = filled;
  const std::vector<int> begins = WindowBegins(clip.size(), most_windows_);
  const int deep = conv_.weight.depths()[0], out = conv_.weight.columns();
  net::AlignedFloats trunk(Size(kWindowsTogether, deep)), hidden(Size(kWindowsTogether, out));
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(out);
  for (std::size_t done = 0; done < begins.size(); done += kWindowsTogether) {
    const int count = std::min<int>(kWindowsTogether, static_cast<int>(begins.size() - done));
    for (int i = 0; i < count; ++i) {
      const auto begin = static_cast<std::size_t>(begins[done + static_cast<std::size_t>(i)]);
      EncodeWindow(kernels, standard, clip.subspan(begin, kReference), trunk.data() + Size(i, deep),
                   scratch);
    }
    const RowTerm term{trunk.data(), deep};
    kernels.product({&conv_.weight,
                     {&term, 1},
                     count,
                     conv_.bias.data(),
                     1,
                     nullptr,
                     false,
                     hidden.data(),
                     out});
    const Eigen::Map<const net::RowMajor> rows(hidden.data(), count, out);
    sum += rows.cwiseMax(kLeak * rows).colwise().sum().transpose().cast<double>();
  }
  // Heads are linear: the code of the mean is the mean of the codes.
  const Eigen::VectorXf mean = (sum / static_cast<double>(begins.size())).cast<float>();
  const auto head = domain == kFreeHead ? heads_.size() - 1 : static_cast<std::size_t>(domain);
  return heads_[head].Apply(mean);
}

// The style encoder's blocks on one window: [16, 5, 4 width], activated.
void StyleEncoder::EncodeWindow(const RowKernels& kernels, const Standardization& standard,
                                std::span<const Features> window, float* y,
                                Scratch& scratch) const {
  const auto& [first, second] = blocks_;
  const float* const in = RunInput(kernels, in_, standard, window, kReference, scratch);
  float* const middle = Sized(scratch.out[0], Size(kReference / 2, kNodes[1], first.out));
  RunEncoder(kernels, first, in, kReference, middle, scratch);
  RunEncoder(kernels, second, middle, kReference / 2, y, scratch);
  kernels.activate(y, nullptr, kReference / 4 * kNodes[2], second.out, nullptr, nullptr, y);
}

}  // namespace styled::stgcn
