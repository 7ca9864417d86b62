// Reads the file format of model/net/stgcn_causal/FORMAT.md into a Network; an error is one
// sentence.
#include <algorithm>

#include "model/net/stgcn/layer_reader.h"
#include "model/net/stgcn/size.h"
#include "model/net/stgcn_causal/network.h"
#include "model/net/stgcn_causal/weights.h"
#include "model/net/weights_file.h"

namespace styled::stgcn_causal {
namespace {

using net::Faults;
using net::RowMajor;
using stgcn::kChannels;
using stgcn::kCode;
using stgcn::kFeatureCount;
using stgcn::kNodes;
using stgcn::kPathShare;
using stgcn::LayerReader;
using stgcn::Size;

constexpr int kMostSpacing = 16;
constexpr int kMostFrames = 1000;
// Windows of an example that are read; each takes 2 ms. With all of them the styles of set 2 from
// a walk and a run are recognized as often (SRA 0.98 in gaits and gestures).
constexpr int kMostWindows = 6;
using Spacing = std::array<int, 4>;  // of enc1, enc2, dec1, dec2

// A whole number from `least` to `most`, or 0.
int WholeNumber(const nlohmann::json& value, int least, int most) {
  const double number = value.is_number_integer() ? value.get<double>() : 0;
  return number >= least && number <= most ? static_cast<int>(number) : 0;
}

int ReadFrames(const nlohmann::json& object, const std::string& key, int least, Faults& faults) {
  const nlohmann::json* const value = net::FindKey(object, key, faults);
  if (value == nullptr) return 0;
  const int frames = WholeNumber(*value, least, kMostFrames);
  if (frames == 0) {
    faults.Key(
        key, "a whole number from " + std::to_string(least) + " to " + std::to_string(kMostFrames),
        net::Shown(*value));
  }
  return frames;
}

Spacing ReadSpacing(const nlohmann::json& object, Faults& faults) {
  Spacing spacing{};
  const nlohmann::json* const value = net::FindKey(object, "spacing", faults);
  if (value == nullptr) return spacing;
  bool good = value->is_array() && value->size() == spacing.size();
  for (std::size_t i = 0; good && i < spacing.size(); ++i) {
    spacing[i] = WholeNumber((*value)[i], 1, kMostSpacing);
    good = spacing[i] > 0;
  }
  if (!good) {
    faults.Key("spacing", "4 whole numbers from 1 to " + std::to_string(kMostSpacing),
               net::Shown(*value));
  }
  return spacing;
}

// Reads blocks from a file's tensors and gives them their places in a stream's memory.
class BlockReader {
 public:
  BlockReader(LayerReader& layers, Layout& layout) : layers_(layers), layout_(layout) {}

  EncoderBlock ReadEncoder(const std::string& name, int level, int in, int out, int spacing) {
    EncoderBlock block{layers_.ReadEncoder(name, level, in, out, 1), {}, {}, {}, {}, {}, {}};
    const int wide = block.graph1.in_nodes(), nodes = block.graph1.out_nodes();
    block.affine1 = layers_.ReadNorm(name + ".norm1", in);
    block.affine2 = layers_.ReadNorm(name + ".norm2", in);
    block.norm1 = ReadPastNorm(name + ".norm1", in, Equal(wide), 1);
    block.norm2 = ReadPastNorm(name + ".norm2", in, Equal(nodes), 1);
    block.time1 = ReadTimeConv(name + ".tconv1", in, 1, spacing, nodes, 1);
    block.time2 = ReadTimeConv(name + ".tconv2", out, kPathShare, spacing, nodes, 1);
    return block;
  }

  DecoderBlock ReadDecoder(const std::string& name, int level, int in, int out, int spacing) {
    DecoderBlock block{layers_.ReadDecoder(name, level, in, out), 0, 0, {}, {}, {}, {}};
    const int nodes = block.graph1.in_nodes(), wide = block.graph2.out_nodes();
    block.norm1 = ReadPastNorm(name + ".adain1", in, Equal(nodes), kDecodings);
    block.norm2 = ReadPastNorm(name + ".adain2", out, block.cluster_sizes, kDecodings);
    block.time1 = ReadTimeConv(name + ".tconv1", out, 1, spacing, nodes, kDecodings);
    block.time2 = ReadTimeConv(name + ".tconv2", out, kPathShare, spacing, wide, kDecodings);
    return block;
  }

 private:
  static std::vector<float> Equal(int nodes) {
    return std::vector<float>(static_cast<std::size_t>(nodes), 1.0F);
  }

  PastNorm ReadPastNorm(const std::string& name, int channels,
                        const std::vector<float>& node_weights, int copies) {
    const RowMajor mean = layers_.tensors().Vector(name + ".start_mean", channels);
    const RowMajor square = layers_.tensors().Vector(name + ".start_square", channels);
    return {mean, square, node_weights, copies, layout_};
  }

  PastConv ReadTimeConv(const std::string& name, int channels, float scale, int spacing, int nodes,
                        int copies) {
    const RowMajor weight = layers_.tensors().Tensor(name + ".weight", {channels, channels, kTaps});
    const Eigen::VectorXf bias = layers_.tensors().Vector(name + ".bias", channels);
    return {weight, bias, scale, spacing, nodes, copies, layout_};
  }

  LayerReader& layers_;
  Layout& layout_;
};

// Places for a step's intermediate results, each as large as the largest result that uses it.
class ScratchSizes {
 public:
  void Add(const EncoderBlock& block) {
    const stgcn::GraphConv &first = block.graph1, &second = block.graph2;
    Cover(1, first, second, block.in, block.out);
    skip_ = std::max(skip_, Size(second.in_nodes(), block.in));
  }
  void Add(const DecoderBlock& block) {
    const stgcn::GraphConv &first = block.graph1, &second = block.graph2;
    Cover(kDecodings, first, second, block.in, block.out);
    skip_ = std::max(skip_, kDecodings * Size(first.in_nodes(), block.out));
  }
  void ReserveFrom(Layout& layout, Scratch& scratch) const {
    scratch.affine = layout.Reserve(2 * channels_);
    scratch.sums = layout.Reserve(2 * channels_);
    scratch.activated = layout.Reserve(activated_);
    scratch.between = layout.Reserve(between_);
    scratch.skip = layout.Reserve(skip_);
    scratch.graph = layout.Reserve(graph_);
  }

 private:
  void Cover(int copies, const stgcn::GraphConv& first, const stgcn::GraphConv& second, int in,
             int out) {
    const auto many = static_cast<std::size_t>(copies);
    channels_ = std::max({channels_, static_cast<std::size_t>(in), static_cast<std::size_t>(out)});
    activated_ = std::max({activated_, many * Size(first.in_nodes(), first.in_channels()),
                           many * Size(second.in_nodes(), second.in_channels())});
    between_ = std::max(between_, many * Size(first.out_nodes(), first.out_channels()));
    graph_ = std::max({graph_, first.ScratchSize(copies), second.ScratchSize(copies)});
  }

  std::size_t channels_ = 0, activated_ = 0, between_ = 0, skip_ = 0, graph_ = 0;
};

}  // namespace

Result<std::shared_ptr<const Network>> Network::Load(const std::filesystem::path& file) {
  const Result<std::vector<std::byte>> bytes = net::ReadFile(file);
  if (!bytes.ok()) return bytes.status();
  return Parse(bytes.value(), file.string());
}

Result<std::shared_ptr<const Network>> Network::Parse(std::span<const std::byte> bytes,
                                                      const std::string& name) {
  Result<net::WeightsFile> file = net::ParseWeights(bytes, name);
  if (!file.ok()) return file.status();
  return Read(file.value());
}

Result<std::shared_ptr<const Network>> Network::Read(net::WeightsFile& file) {
  const std::shared_ptr<Network> network(new Network);
  const auto weights = std::make_shared<Weights>();
  network->weights_ = weights;
  Weights& w = *weights;
  Faults faults(file.name);
  network->model_ = file.model;
  stgcn::ReadParameters(file, network->features_, faults);
  net::ExpectEqual(file.header, "code", static_cast<unsigned>(kCode), faults);
  net::ExpectEqual(file.header, "noise", static_cast<unsigned>(stgcn::kNoise), faults);
  net::ExpectEqual(file.header, "window", static_cast<unsigned>(stgcn::kReference), faults);
  stgcn::CheckContents(file.header, faults);
  const int width = w.width = stgcn::ReadWidth(file.header, faults);
  const Spacing spacing = ReadSpacing(file.header, faults);
  w.memory = ReadFrames(file.header, "memory", 2, faults);
  w.start_frames = ReadFrames(file.header, "start_frames", 1, faults);
  if (!faults.none()) return faults.status();

  net::TensorReader tensors(file.view, faults);
  LayerReader layers(tensors);
  const stgcn::Standardization standard =
      stgcn::ReadStandardization(tensors, network->features_, faults);
  if (!faults.none()) return faults.status();
  const auto copy = [](const stgcn::Features& from, net::AlignedFloats& to) {
    to.Grow(kFeatureCount);
    std::copy(from.begin(), from.end(), to.data());
  };
  copy(standard.mean, w.mean);
  copy(standard.deviation, w.deviation);
  copy(standard.inverse_deviation, w.inverse_deviation);

  Layout layout;
  BlockReader blocks(layers, layout);
  w.in = layers.ReadLinear("g.in", width, kChannels, kNodes[0]);
  w.encoder[0] = blocks.ReadEncoder("g.enc1", 0, width, 2 * width, spacing[0]);
  w.encoder[1] = blocks.ReadEncoder("g.enc2", 1, 2 * width, 4 * width, spacing[1]);
  w.decoder[0] = blocks.ReadDecoder("g.dec1", 1, 4 * width, 2 * width, spacing[2]);
  w.decoder[1] = blocks.ReadDecoder("g.dec2", 0, 2 * width, width, spacing[3]);
  w.out = layers.ReadLinear("g.out", kChannels, width, 0);
  w.points = std::make_unique<const PointSpace>(layers, width);
  for (std::size_t i = 0; i < w.decoder.size(); ++i) {
    w.decoder[i].adain1 = w.points->norm(2 * i);
    w.decoder[i].adain2 = w.points->norm(2 * i + 1);
  }
  const int domains = network->style_count();
  w.space = std::make_unique<const stgcn::CodeSpace>(layers, network->features_, standard, width,
                                                     domains, kMostWindows);
  tensors.Finish();
  if (!faults.none()) return faults.status();
  for (std::size_t s = 1; s < network->model_.styles.size(); ++s) {
    network->model_.styles[s].varies = true;
  }
  for (int domain = 0; domain < domains; ++domain) {
    const stgcn::Code& code = w.space->mean_code(domain);
    network->points_.push_back(w.points->PointOf({code.begin(), code.end()}));
    network->domains_.push_back(domain);
  }
  w.variations = std::make_unique<const Variations>(*w.space, *w.points);

  ScratchSizes sizes;
  for (const EncoderBlock& block : w.encoder) sizes.Add(block);
  for (const DecoderBlock& block : w.decoder) sizes.Add(block);
  Scratch& s = w.scratch;
  const auto wide = static_cast<std::size_t>(width);
  constexpr auto kNode = [](int level) {
    return static_cast<std::size_t>(kNodes[static_cast<std::size_t>(level)]);
  };
  s.standardized = layout.Reserve(kFeatureCount);
  s.points = layout.Reserve(kDecodings * w.points->size());
  s.in = layout.Reserve(kNode(0) * wide);
  s.encoded = {layout.Reserve(kNode(1) * 2 * wide), layout.Reserve(kNode(2) * 4 * wide)};
  s.decoded = {layout.Reserve(kDecodings * kNode(1) * 2 * wide),
               layout.Reserve(kDecodings * kNode(0) * wide)};
  s.out = layout.Reserve(kDecodings * kNode(0) * static_cast<std::size_t>(w.out.weight.columns()));
  sizes.ReserveFrom(layout, s);
  w.state_size = layout.size();
  return std::shared_ptr<const Network>(network);
}

}  // namespace styled::stgcn_causal
