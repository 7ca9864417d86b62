#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/base/realtime.h"
#include "model/base/status.h"
#include "model/net/erd/features.h"

namespace styled::erd {

inline constexpr int kLatent = 32;
inline constexpr int kNeutralLayers = 6;
inline constexpr int kStyleLayers = 4;
inline constexpr int kMaxStyles = 32;  // neutral included
inline constexpr int kMaxMix = 4;      // styles that a user may mix
inline constexpr int kMaxActive = 8;   // styles alive at once: a mix and what it fades from
inline constexpr int kMaxBranches = kMaxActive + 1;  // and the input's own style
inline constexpr float kMaxStrength = 1.5F;          // of one style
// Deviations: what lies further out than nearly all that was trained on tells the network no more.
// A dance reaches 51 with weights trained on walks, toes of another rig 20; unclamped, such
// features drown the others, and the change of style of a rig never seen jerks a tenth more.
inline constexpr float kMaxStandardized = 4.0F;

struct StyleInfo {
  std::string name;
  std::vector<std::string> aliases;
};

// What the weights' metadata says (model/net/erd/FORMAT.md).
struct Metadata {
  std::vector<StyleInfo> styles;  // [0] is neutral
  std::string licence, training;  // training: the JSON text
  FeatureParameters features;
};

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

// A branch that is to run in a step: `style` 1..N-1 and its weight alpha, clamped to
// [0, kMaxStrength]; not a number counts as 0.
struct ActiveStyle {
  int style = -1;
  float weight = 0;
};

// What one step gives. Unit quaternions, the hips' in the heading frame; their sign is the
// network's own, near the hemisphere of the features but not forced onto it.
struct Decoded {
  std::array<body::Quat, body::kJointCount> rotations;
  std::array<float, kVelocityFeatures> velocities_m_s;
  float hips_height_m;
};
struct StepOutput {
  // D(r_0(z), neutral), or D(r_0(z) + r_S(z), S) for an input of style S: what the network makes of
  // the input.
  Decoded reconstruction;
  Decoded styled;  // D(z', target styles); no style active: the target is neutral
};

// One performer's step among others'; members as the arguments of Network::Step.
struct StepJob {
  const Features* features = nullptr;
  int input_style = 0;
  std::span<const ActiveStyle> active;
  State* state = nullptr;
  StepOutput* out = nullptr;
};

// Style-ERD at run time (the encoder, the recurrent branches, the decoder), stage 3 of the stylist:
// one immutable network shared by all performers and threads, one State per recurrent stream.
class Network {
 public:
  // Reads model/net/erd/FORMAT.md's file. Errors name file, tensor or key, expected and found.
  static Result<std::shared_ptr<const Network>> Load(const std::filesystem::path& file);
  static Result<std::shared_ptr<const Network>> Parse(std::span<const std::byte> bytes,
                                                      const std::string& name);
  ~Network();
  Network(const Network&) = delete;
  Network& operator=(const Network&) = delete;

  const Metadata& metadata() const { return metadata_; }
  int style_count() const { return static_cast<int>(metadata_.styles.size()); }
  // Index of a style by name or alias, case-insensitive; -1 if unknown.
  int FindStyle(std::string_view name) const;

  // Learned initial states, no branch alive. Noexcept, no allocation.
  STYLED_REALTIME void Start(State& state) const noexcept;

  // Advances `state` by one frame (equations in FORMAT.md). Branches of `active` that are not alive
  // start from their learned state; branches alive but not in `active` are dropped. `input_style`
  // is what the performer is taken to be (0 = neutral); its branch lives while it is named. Neutral
  // entries of `active` and weights of 0 are allowed (weight 0 keeps the branch alive), a style
  // named twice has the sum. Ignored: styles the network lacks, and those after the first
  // kMaxActive. Standardized features are clamped to +-kMaxStandardized, not a number reads as the
  // mean: no input can leave a non-finite state behind. Noexcept, no allocation, no lock. Pinned by
  // tests/unit/net/erd and tests/parity.
  STYLED_REALTIME void Step(const Features& features, int input_style,
                            std::span<const ActiveStyle> active, State& state,
                            StepOutput& out) const noexcept;
  // The same for several performers, bit for bit, in less time: weights are read once for some of
  // them. No state or output appears twice.
  STYLED_REALTIME void StepTogether(std::span<const StepJob> jobs) const noexcept;

 private:
  struct Weights;
  Network();
  template <std::size_t Most>
  void StepSome(std::span<const StepJob> jobs) const noexcept;
  Metadata metadata_;
  std::unique_ptr<Weights> weights_;
};

}  // namespace styled::erd
