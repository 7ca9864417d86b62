#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/base/status.h"
#include "model/net/erd/features.h"
#include "model/net/erd/shape.h"
#include "model/net/stylizer.h"

namespace styled::net {
struct WeightsFile;
}

namespace styled::erd {

inline constexpr int kMaxBranches = net::kMaxActive + 1;  // and the input style's
// Limit of standardized features, in deviations. A feature farther out than nearly all training
// data carries no more information for the network. A dance reaches 51 with weights trained on
// walks, the toes of another rig 20. Without the limit such features dominate the others, and the
// style change of an unknown rig jerks a tenth more.
inline constexpr float kMaxStandardized = 4.0F;

// Recurrent state of one branch: h and c per layer, sized for the deepest branch.
template <Shape kShape>
struct BranchStateOf {
  alignas(64) std::array<Eigen::Matrix<float, kShape.latent, 1>, kNeutralLayers> h, c;

  // Of its first `layers`.
  STYLED_REALTIME void Carry(Checkpoint& to, int layers) noexcept {
    for (std::size_t layer = 0; layer < static_cast<std::size_t>(layers); ++layer) {
      to(h[layer], c[layer]);
    }
  }
};

// The recognizer's state, and the age of the whole state. Unused by a network without contents.
template <Shape kShape>
struct RecognizerStateOf {
  // Enough that the recognizer's certainty has reached 1, at any rate and rise.
  static constexpr int kMostFrames = 1 << 20;

  alignas(64) Eigen::Matrix<float, kShape.latent, 1> h, c;
  int frames = 0;  // steps since the start, at most kMostFrames

  STYLED_REALTIME void Carry(Checkpoint& to) noexcept {
    to(h, c);
    to.Within(frames, 0, kMostFrames);
  }
};

// The recurrent state of one performer: the neutral branch r_0, the live style branches and the
// recognizer. Value type, about 9 kB (wide: 18 kB), no pointers. Undefined until
// ShapedNetwork::Start fills it.
template <Shape kShape>
struct StateOf {
  BranchStateOf<kShape> neutral;
  std::array<BranchStateOf<kShape>, kMaxBranches> branch;
  std::array<int, kMaxBranches> style;  // style of branch[i]; -1: the branch is not live
  RecognizerStateOf<kShape> recognizer;

  // Of a network with `style_count` styles, neutral included, and with or without contents.
  STYLED_REALTIME void Carry(Checkpoint& to, int style_count, bool contents) noexcept {
    neutral.Carry(to, kNeutralLayers);
    for (std::size_t slot = 0; slot < branch.size(); ++slot) {
      to.Within(style[slot], -1, style_count - 1);
      if (style[slot] >= 0) branch[slot].Carry(to, kStyleLayers);
    }
    if (contents) to(recognizer);
  }
};

// One performer's step in a batch; the members are the arguments of ShapedNetwork::Step.
template <Shape kShape>
struct StepJobOf {
  const Features* features = nullptr;
  int input_style = 0;
  std::span<const net::StyleWeight> active;
  StateOf<kShape>* state = nullptr;
  net::Prediction* out = nullptr;
  int content = net::kContentRecognized;
};

// The network: encoder, recurrent branches, decoder. Input: features; output: rotations. stylizer.h
// wraps it for poses and streams. Immutable; shared by all performers and threads. One class per
// shape, since a step knows all its sizes when it is compiled; kPaper and kWide are built.
template <Shape kShape>
class ShapedNetwork {
 public:
  using State = StateOf<kShape>;
  using StepJob = StepJobOf<kShape>;

  // Reads the file format of model/net/erd/FORMAT.md. Errors name the file, the tensor or key, what
  // was expected and what was found.
  static Result<std::shared_ptr<const ShapedNetwork>> Load(const std::filesystem::path& file);
  static Result<std::shared_ptr<const ShapedNetwork>> Parse(std::span<const std::byte> bytes,
                                                            const std::string& name);
  // The same for a file whose common keys are already read; consumes its tensors.
  static Result<std::shared_ptr<const ShapedNetwork>> Read(net::WeightsFile& file);
  ~ShapedNetwork();
  ShapedNetwork(const ShapedNetwork&) = delete;
  ShapedNetwork& operator=(const ShapedNetwork&) = delete;

  const net::Model& model() const { return model_; }
  const FeatureParameters& features() const { return features_; }
  int style_count() const { return static_cast<int>(model_.styles.size()); }
  int content_count() const { return static_cast<int>(model_.contents.size()); }

  // Sets the learned initial states, with no style branch live. Noexcept, no allocation.
  STYLED_REALTIME void Start(State& state) const noexcept;

  // Advances `state` by one frame (equations in FORMAT.md) and writes `out`. Branches of `active`
  // that are not live start from their learned state; live branches that are not in `active` are
  // dropped. `input_style` is the style that the performer is assumed to move in (0 = neutral); its
  // branch is live as long as it is given. `active` may contain neutral and weights of 0 (weight 0
  // keeps the branch live); the weights of a style given twice are added. Ignored: styles that the
  // network lacks, and styles after the first kMaxActive. `content` is that of the motion: a
  // number of the network's contents, net::kContentRecognized or net::kContentUnknown; a number
  // that it lacks counts as unknown. The content of a state's first step also chooses the neutral
  // branch's initial state. A network without contents ignores it. `out.heading_rad` is not
  // written: the hips are relative to the features' heading. Standardized features are clamped to
  // +-kMaxStandardized, and NaN counts as the mean, so no input can leave a non-finite state
  // behind. Noexcept, no allocation, no lock. Pinned by tests/unit/net/erd and tests/parity.
  STYLED_REALTIME void Step(const Features& features, int input_style,
                            std::span<const net::StyleWeight> active, State& state,
                            net::Prediction& out,
                            int content = net::kContentRecognized) const noexcept;
  // The same for several performers, with the same results bit for bit, in less time: the weights
  // are read once for several of them. No state or output may appear twice.
  STYLED_REALTIME void StepTogether(std::span<const StepJob> jobs) const noexcept;
  // The recognizer's P after the last step: a share for each content, in `shares`, which has
  // content_count() of them. After Start it says nothing yet.
  STYLED_REALTIME void Recognized(const State& state, std::span<float> shares) const noexcept;

 private:
  struct Weights;
  ShapedNetwork();
  template <std::size_t Most>
  void StepSome(std::span<const StepJob> jobs) const noexcept;
  net::Model model_;
  FeatureParameters features_;
  std::unique_ptr<Weights> weights_;
};

// The paper's shape, by short names.
using BranchState = BranchStateOf<kPaper>;
using State = StateOf<kPaper>;
using StepJob = StepJobOf<kPaper>;
using Network = ShapedNetwork<kPaper>;
using WideNetwork = ShapedNetwork<kWide>;

}  // namespace styled::erd
