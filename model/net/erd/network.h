#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "model/base/realtime.h"
#include "model/base/status.h"
#include "model/net/erd/features.h"
#include "model/net/stylizer.h"

namespace styled::net {
struct WeightsFile;
}

namespace styled::erd {

inline constexpr int kLatent = 32;
inline constexpr int kNeutralLayers = 6;
inline constexpr int kStyleLayers = 4;
inline constexpr int kMaxBranches = net::kMaxActive + 1;  // and the input's own style
// Deviations: what lies further out than nearly all that was trained on tells the network no more.
// A dance reaches 51 with weights trained on walks, toes of another rig 20; unclamped, such
// features drown the others, and the change of style of a rig never seen jerks a tenth more.
inline constexpr float kMaxStandardized = 4.0F;

// Recurrent state of one branch: h and c per layer. Sized for the deepest.
struct BranchState {
  alignas(64) std::array<Eigen::Matrix<float, kLatent, 1>, kNeutralLayers> h, c;
};

// One recurrent state of one performer: r_0's and those of the style branches now alive. Value
// type, about 9 kB, no pointers. Undefined until Network::Start fills it.
struct State {
  BranchState neutral;
  std::array<BranchState, kMaxBranches> branch;
  std::array<int, kMaxBranches> style;  // style index of branch[i], or -1: not alive
};

// One performer's step among others'; members as the arguments of Network::Step.
struct StepJob {
  const Features* features = nullptr;
  int input_style = 0;
  std::span<const net::StyleWeight> active;
  State* state = nullptr;
  net::Prediction* out = nullptr;
};

// The network itself: the encoder, the recurrent branches, the decoder. Features in, rotations out;
// stylizer.h puts poses and streams around it. Immutable: shared by all performers and threads.
class Network {
 public:
  // Reads model/net/erd/FORMAT.md's file. Errors name file, tensor or key, expected and found.
  static Result<std::shared_ptr<const Network>> Load(const std::filesystem::path& file);
  static Result<std::shared_ptr<const Network>> Parse(std::span<const std::byte> bytes,
                                                      const std::string& name);
  // The same of a file whose common keys are read; takes its tensors.
  static Result<std::shared_ptr<const Network>> Read(net::WeightsFile& file);
  ~Network();
  Network(const Network&) = delete;
  Network& operator=(const Network&) = delete;

  const net::Model& model() const { return model_; }
  const FeatureParameters& features() const { return features_; }
  int style_count() const { return static_cast<int>(model_.styles.size()); }

  // Learned initial states, no branch alive. Noexcept, no allocation.
  STYLED_REALTIME void Start(State& state) const noexcept;

  // Advances `state` by one frame (equations in FORMAT.md). Branches of `active` that are not alive
  // start from their learned state; branches alive but not in `active` are dropped. `input_style`
  // is what the performer is taken to be (0 = neutral); its branch lives while it is named. Neutral
  // entries of `active` and weights of 0 are allowed (weight 0 keeps the branch alive), a style
  // named twice has the sum. Ignored: styles the network lacks, and those after the first
  // kMaxActive. `out.heading_rad` is not written: the hips are relative to the features' heading.
  // Standardized features are clamped to +-kMaxStandardized, not a number reads as the
  // mean: no input can leave a non-finite state behind. Noexcept, no allocation, no lock. Pinned by
  // tests/unit/net/erd and tests/parity.
  STYLED_REALTIME void Step(const Features& features, int input_style,
                            std::span<const net::StyleWeight> active, State& state,
                            net::Prediction& out) const noexcept;
  // The same for several performers, bit for bit, in less time: weights are read once for some of
  // them. No state or output appears twice.
  STYLED_REALTIME void StepTogether(std::span<const StepJob> jobs) const noexcept;

 private:
  struct Weights;
  Network();
  template <std::size_t Most>
  void StepSome(std::span<const StepJob> jobs) const noexcept;
  net::Model model_;
  FeatureParameters features_;
  std::unique_ptr<Weights> weights_;
};

}  // namespace styled::erd
