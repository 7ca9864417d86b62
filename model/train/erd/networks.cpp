#include "model/train/erd/networks.h"

#include <cmath>

#include "model/net/erd/features.h"
#include "model/net/erd/network.h"
#include "model/train/checkpoint.h"
#include "model/train/erd/lstm.h"

namespace styled::train::style_erd {
namespace {

using torch::Tensor;
namespace F = torch::nn::functional;

constexpr double kLeak = 0.2;

// [T, B, C] -> [T, B, kernel * C]: each frame with its neighbours, the ends repeated. A convolution
// over time is then one matrix product, and so are its first and second derivatives.
Tensor Neighbours(const Tensor& x, int64_t kernel) {
  const int64_t half = kernel / 2;
  const int64_t frames = x.size(0);
  std::vector<Tensor> padded(half, x.narrow(0, 0, 1));
  padded.push_back(x);
  padded.insert(padded.end(), half, x.narrow(0, frames - 1, 1));
  const Tensor all = torch::cat(padded, 0);
  std::vector<Tensor> shifted;
  for (int64_t k = 0; k < kernel; ++k) shifted.push_back(all.narrow(0, k, frames));
  return torch::cat(shifted, 2);
}

Tensor InstanceNorm(const Tensor& x) {
  const Tensor centred = x - x.mean(0, true);
  return centred * (centred.square().mean(0, true) + 1e-5).rsqrt();
}

Tensor Leaky(const Tensor& x) { return torch::leaky_relu(x, kLeak); }

// Features as encoder and recognizer see them.
Tensor Known(const Tensor& u) { return u.clamp(-erd::kMaxStandardized, erd::kMaxStandardized); }

}  // namespace

GeneratorShape GeneratorShape::Of(const erd::Shape& widths) {
  GeneratorShape shape;
  shape.latent = widths.latent;
  shape.encoder = {widths.encoder};
  shape.decoder = {widths.decoder.begin(), widths.decoder.end()};
  return shape;
}

Affine::Affine(Parameters& parameters, const std::string& name, int64_t in, int64_t out) {
  const double bound = 1.0 / std::sqrt(static_cast<double>(in));
  weight = parameters.Add(name + ".weight", {out, in}, bound);
  bias = parameters.Add(name + ".bias", {out}, bound);
}

Tensor Affine::operator()(const Tensor& x) const { return torch::linear(x, weight, bias); }

Stack::Stack(Parameters& parameters, const std::string& name, int64_t groups_, int64_t layers,
             int64_t width, int64_t starts)
    : groups(groups_) {
  TORCH_CHECK(groups == 1 || starts == 1, "several starts of several groups");
  const double bound = 1.0 / std::sqrt(static_cast<double>(width));
  for (int64_t layer = 0; layer < layers; ++layer) {
    const std::string prefix = name + "." + std::to_string(layer) + ".";
    input.push_back(parameters.Add(prefix + "input", {groups, 4 * width, width}, bound));
    hidden.push_back(parameters.Add(prefix + "hidden", {groups, 4 * width, width}, bound));
    bias.push_back(parameters.Add(prefix + "bias", {groups, 4 * width}, bound));
    h0.push_back(parameters.Add(prefix + "h0", {groups * starts, width}, bound));
    c0.push_back(parameters.Add(prefix + "c0", {groups * starts, width}, bound));
  }
}

StackState StackState::Concrete() const {
  StackState copy;
  for (const Tensor& state : h) copy.h.push_back(state.detach().clone());
  for (const Tensor& state : c) copy.c.push_back(state.detach().clone());
  return copy;
}

StackState Stack::Initial(int64_t samples) const {
  StackState state;
  for (std::size_t layer = 0; layer < input.size(); ++layer) {
    state.h.push_back(h0[layer].narrow(0, 0, groups).unsqueeze(1).expand({-1, samples, -1}));
    state.c.push_back(c0[layer].narrow(0, 0, groups).unsqueeze(1).expand({-1, samples, -1}));
  }
  return state;
}

StackState Stack::InitialOf(const Tensor& starts) const {
  StackState state;
  for (std::size_t layer = 0; layer < input.size(); ++layer) {
    state.h.push_back(h0[layer].index_select(0, starts).unsqueeze(0));
    state.c.push_back(c0[layer].index_select(0, starts).unsqueeze(0));
  }
  return state;
}

StackState Stack::Start(const StackState& initial, const StackState& carried, const Tensor& mask) {
  StackState state = initial;
  for (std::size_t layer = 0; layer < state.h.size(); ++layer) {
    state.h[layer] = torch::where(mask, carried.h[layer], state.h[layer]);
    state.c[layer] = torch::where(mask, carried.c[layer], state.c[layer]);
  }
  return state;
}

Tensor Stack::operator()(Tensor x, StackState& state) const {
  for (std::size_t layer = 0; layer < input.size(); ++layer) {
    auto [y, last_c] =
        LstmLayer(x, input[layer], hidden[layer], bias[layer], state.h[layer], state.c[layer]);
    state.h[layer] = y.select(1, y.size(1) - 1).detach().clone();
    state.c[layer] = last_c.detach();
    x = y;
  }
  return x;
}

Generator::Generator(const GeneratorShape& shape_, const Tensor& mean, const Tensor& deviation)
    : shape(shape_),
      rotation_mean_(mean.narrow(0, 0, erd::kRotationFeatures)),
      rotation_deviation_(deviation.narrow(0, 0, erd::kRotationFeatures)) {
  int64_t width = erd::kFeatureCount + shape.styles + shape.contents;
  std::vector<int64_t> widths = shape.encoder;
  widths.push_back(shape.latent);
  for (const int64_t next : widths) {
    encoder_.emplace_back(parameters, "encoder." + std::to_string(encoder_.size()), width, next);
    width = next;
  }
  // One state per content, and one for an unknown content.
  neutral = Stack(parameters, "neutral", 1, shape.neutral_layers, shape.latent, shape.contents + 1);
  branches = Stack(parameters, "branches", shape.styles - 1, shape.style_layers, shape.latent);
  width = shape.latent + shape.styles;
  for (const int64_t next : shape.decoder) {
    decoder_.emplace_back(parameters, "decoder." + std::to_string(decoder_.size()), width, next);
    width = next;
  }
  rotation_ = Affine(parameters, "head.rotation", width, erd::kRotationFeatures);
  velocity_ = Affine(parameters, "head.velocity", width, erd::kVelocityFeatures);
  height_ = Affine(parameters, "head.height", width, 1);
  if (shape.contents > 0) AddRecognizer();
  parameters.Flatten(mean.device());
}

void Generator::AddRecognizer() {
  const int64_t hidden = shape.encoder.at(0);
  recognizer_.emplace_back(parameters, "recognizer.0", erd::kFeatureCount, hidden);
  recognizer_.emplace_back(parameters, "recognizer.1", hidden, shape.latent);
  recognizer = Stack(parameters, "recognizer.lstm", 1, 1, shape.latent);
  recognized_ = Affine(parameters, "recognizer.head", shape.latent, shape.contents);
}

Tensor Generator::Encode(const Tensor& u, const Tensor& one_hot, const Tensor& content) const {
  std::vector<Tensor> parts{Known(u), one_hot.unsqueeze(0).expand({u.size(0), -1, -1})};
  if (shape.contents > 0) parts.push_back(content);
  Tensor x = torch::cat(parts, 2);
  for (std::size_t i = 0; i < encoder_.size(); ++i) {
    x = encoder_[i](x);
    if (i + 1 < encoder_.size()) x = torch::relu(x);
  }
  return x;
}

Tensor Generator::Recognize(const Tensor& u, StackState& state) const {
  const Tensor in = recognizer_[1](torch::relu(recognizer_[0](Known(u))));
  return recognized_(recognizer(in.unsqueeze(0), state).squeeze(0));
}

Tensor Generator::Neutral(const Tensor& z, StackState& state) const {
  return neutral(z.unsqueeze(0), state).squeeze(0);
}

Tensor Generator::Branches(const Tensor& z, StackState& state) const {
  const int64_t groups = branches.groups;
  const Tensor grouped =
      z.view({z.size(0), groups, z.size(1) / groups, z.size(2)}).transpose(0, 1).contiguous();
  return branches(grouped, state).transpose(0, 1).reshape(z.sizes());
}

Decoded Generator::Decode(const Tensor& z, const Tensor& target) const {
  Tensor x = torch::cat({z, target.unsqueeze(0).expand({z.size(0), -1, -1})}, 2);
  for (const Affine& layer : decoder_) x = torch::relu(layer(x));
  const Tensor raw = (rotation_(x) * rotation_deviation_ + rotation_mean_)
                         .view({x.size(0), x.size(1), body::kJointCount, 4});
  Decoded out;
  out.rotations = raw * (raw.square().sum(-1, true) + 1e-12).rsqrt();
  out.velocities = velocity_(x);
  out.height = height_(x);
  return out;
}

Decoded Generator::Transfer(const Tensor& u, const Slots& slots, const ContentInput& content,
                            const Tensor& goes_on, Carried& carried) const {
  const Tensor z = Encode(u, slots.input_one_hot, content.content);
  const StackState neutral_start =
      content.start.defined() ? neutral.InitialOf(content.start) : neutral.Initial(slots.count());
  carried.neutral = Stack::Start(neutral_start, carried.neutral, goes_on.view({1, -1, 1}));
  const bool placed = slots.window_of_place.defined();
  const Tensor carries = placed ? goes_on.index_select(0, slots.window_of_place) : goes_on;
  carried.branches = Stack::Start(branches.Initial(slots.per_branch(branches.groups)),
                                  carried.branches, carries.view({branches.groups, -1, 1}));
  const Tensor r0 = Neutral(z, carried.neutral);
  const Tensor residual = placed
                              ? Branches(z.index_select(1, slots.window_of_place), carried.branches)
                                    .index_select(1, slots.place_of_window)
                              : Branches(z, carried.branches);
  const Tensor own = residual * slots.styled;
  return Decode(torch::cat({r0 + own, r0 + residual - own}, 1),
                torch::cat({slots.input_one_hot, slots.target_one_hot}, 0));
}

Carried Generator::Start(const Slots& slots) const {
  Carried start;
  start.neutral = neutral.Initial(slots.count()).Concrete();
  start.branches = branches.Initial(slots.per_branch(branches.groups)).Concrete();
  if (shape.contents > 0) {
    start.recognizer = recognizer.Initial(slots.count()).Concrete();
    start.age_s = torch::zeros({slots.count()}, parameters.flat().options());
  }
  return start;
}

void Carried::CopyFrom(const Carried& other) {
  const torch::NoGradGuard no_grad;
  const auto copy = [](const std::vector<Tensor>& from, const std::vector<Tensor>& to) {
    for (std::size_t i = 0; i < to.size(); ++i) to[i].copy_(from[i]);
  };
  for (const auto [from, to] :
       {std::pair(&other.neutral, &neutral), std::pair(&other.branches, &branches),
        std::pair(&other.recognizer, &recognizer)}) {
    copy(from->h, to->h);
    copy(from->c, to->c);
  }
  if (age_s.defined()) age_s.copy_(other.age_s);
}

void SaveCarried(const Carried& carried, const std::string& prefix, Checkpoint& checkpoint) {
  auto& t = checkpoint.tensors;
  t[prefix + "neutral.h"] = torch::stack(carried.neutral.h);
  t[prefix + "neutral.c"] = torch::stack(carried.neutral.c);
  t[prefix + "branches.h"] = torch::stack(carried.branches.h);
  t[prefix + "branches.c"] = torch::stack(carried.branches.c);
  if (!carried.age_s.defined()) return;
  t[prefix + "recognizer.h"] = torch::stack(carried.recognizer.h);
  t[prefix + "recognizer.c"] = torch::stack(carried.recognizer.c);
  t[prefix + "age_s"] = carried.age_s;
}

void RestoreCarried(const Checkpoint& checkpoint, const std::string& prefix, Carried& carried) {
  const auto unstack = [&](const std::string& name, std::vector<Tensor>& layers) {
    const Tensor& all = checkpoint.tensors.at(prefix + name);
    TORCH_CHECK(
        all.size(0) == static_cast<int64_t>(layers.size()) && all[0].sizes() == layers[0].sizes(),
        "carried states of another batch");
    for (std::size_t i = 0; i < layers.size(); ++i) {
      layers[i] = all[static_cast<int64_t>(i)].clone().to(layers[i].device());
    }
  };
  unstack("neutral.h", carried.neutral.h);
  unstack("neutral.c", carried.neutral.c);
  unstack("branches.h", carried.branches.h);
  unstack("branches.c", carried.branches.c);
  if (!carried.age_s.defined()) return;
  unstack("recognizer.h", carried.recognizer.h);
  unstack("recognizer.c", carried.recognizer.c);
  carried.age_s.copy_(checkpoint.tensors.at(prefix + "age_s"));
}

Status Generator::CopyStyles(const Generator& from, const std::vector<int64_t>& source) {
  const torch::NoGradGuard no_grad;
  const Tensor index = torch::tensor(source, torch::kInt64);
  const Tensor branch_index = index.narrow(0, 1, index.size(0) - 1) - 1;
  const bool ignores_contents = from.shape.contents == 0 && shape.contents > 0;
  for (const auto& [name, tensor] : parameters.named()) {
    if (ignores_contents && name.starts_with("recognizer.")) continue;
    Tensor value = from.parameters.Find(name).detach();
    if (name.starts_with("branches.")) value = value.index_select(0, branch_index);
    if (name == "encoder.0.weight" || name == "decoder.0.weight") {
      const int64_t after = name == "encoder.0.weight" ? from.shape.contents : 0;
      const int64_t plain = value.size(1) - from.shape.styles - after;
      std::vector<Tensor> parts{value.narrow(1, 0, plain),
                                value.narrow(1, plain, from.shape.styles).index_select(1, index),
                                value.narrow(1, value.size(1) - after, after)};
      if (ignores_contents && name == "encoder.0.weight") {
        parts.push_back(torch::zeros({value.size(0), shape.contents}, value.options()));
      }
      value = torch::cat(parts, 1);
    }
    const bool is_start = name.ends_with(".h0") || name.ends_with(".c0");
    if (ignores_contents && name.starts_with("neutral.") && is_start) {
      value = value.expand({shape.contents + 1, -1});
    }
    if (value.sizes() != tensor.sizes()) return Status::Error("tensor " + name + " does not fit");
    tensor.copy_(value);
  }
  return Status::Ok();
}

Critic::Critic(int64_t features, int64_t styles, int64_t contents, int64_t frames, bool attention) {
  int64_t width = features;
  for (const int64_t next : {84, 56, 36, 24, 16}) {
    convolutions_.emplace_back(parameters, "convolution." + std::to_string(convolutions_.size()),
                               3 * width, next);
    width = next;
  }
  if (!attention) {
    heads_ = Affine(parameters, "heads", frames * width, styles);
    return;
  }
  attention_.emplace_back(parameters, "attention.0", styles + contents, 64);
  attention_.emplace_back(parameters, "attention.1", 64, 64);
  feature_attention_ = Affine(parameters, "attention.feature", 64, width);
  time_attention_ = Affine(parameters, "attention.time", 64, frames);
}

Tensor Critic::operator()(const Tensor& x, const Tensor& labels) const {
  Tensor m = x;
  for (std::size_t i = 0; i < convolutions_.size(); ++i) {
    m = convolutions_[i](Neighbours(m, 3));
    if (i + 1 < convolutions_.size()) m = Leaky(m);
  }
  if (attention_.empty()) {
    const Tensor all = heads_(m.transpose(0, 1).flatten(1));  // [B, styles]
    return (all * labels.narrow(1, 0, all.size(1))).sum(1);
  }
  Tensor attention = labels;
  for (const Affine& layer : attention_) attention = Leaky(layer(attention));
  const Tensor wf = feature_attention_(attention);               // [B, 16]
  const Tensor wt = time_attention_(attention).transpose(0, 1);  // [T, B]
  return ((m * wf.unsqueeze(0)).sum(2) * wt).sum(0);
}

ContentClassifier::ContentClassifier(int64_t features, int64_t contents) {
  int64_t width = features;
  for (int layer = 0; layer < 4; ++layer) {
    convolutions_.emplace_back(parameters, "convolution." + std::to_string(layer), 5 * width,
                               width / 2);
    width /= 2;
  }
  head_ = Affine(parameters, "head", 2 * width, contents);
}

std::vector<Tensor> ContentClassifier::Maps(const Tensor& x) const {
  std::vector<Tensor> maps{x};
  for (const Affine& convolution : convolutions_) {
    maps.push_back(Leaky(InstanceNorm(convolution(Neighbours(maps.back(), 5)))));
  }
  maps.erase(maps.begin());
  return maps;
}

Tensor ContentClassifier::Logits(const Tensor& x) const {
  const Tensor last = Maps(x).back();
  return head_(torch::cat({last.mean(0), last.amax(0)}, 1));
}

}  // namespace styled::train::style_erd
