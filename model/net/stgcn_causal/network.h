#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/base/status.h"
#include "model/net/kernels/rows.h"
#include "model/net/stgcn/code_space.h"
#include "model/net/stgcn/features.h"
#include "model/net/stgcn_causal/points.h"
#include "model/net/stylizer.h"

namespace styled::net {
struct WeightsFile;
}

namespace styled::stgcn_causal {

// Limit of standardized features, in deviations: erd's, for the reason given there. Here an outlier
// would also affect the statistics of the next second.
inline constexpr float kMaxStandardized = 4.0F;
// After the last style's end the second decoder continues alone for this many memories of the
// statistics, before it follows the first again. Larger: a smaller jump then, and a decoder's work
// for longer. With random weights, of the difference in the first frame after the end: 5 leaves 1
// to 2 hundredths (3 mm, 0.3 degrees), 8 1 to 2 thousandths.
inline constexpr int kMemoriesAlone = 8;

// The recurrent state of one stream and the scratch memory of its steps, made by
// Network::MakeState. Value type; a copy continues like the original.
struct State {
  net::AlignedFloats memory;  // rings, statistics, scratch; 0.3 MB at width 64
  std::uint64_t frame = 0;    // the next one
  double count = 0;           // N_(frame - 1)
  int alone = 0;              // remaining frames of the second decoder alone; 0: it follows
};

// Frames in the network's output units, those of stgcn/features.h: rotations are not of length 1;
// the hips' x and z are 0.
struct Output {
  stgcn::Features reconstruction;  // in the performer's own style
  stgcn::Features styled;          // in the requested styles
};

// A causal version of the generator of Park et al. 2021: it returns one frame for each input frame,
// computed from it and those before it (FORMAT.md). Immutable; shared by all threads, each with its
// own states. Pinned by tests/unit/net/stgcn_causal.
class Network {
 public:
  // Reads the file format of FORMAT.md. Errors name the file, the tensor or key, what was expected
  // and what was found.
  static Result<std::shared_ptr<const Network>> Load(const std::filesystem::path& file);
  static Result<std::shared_ptr<const Network>> Parse(std::span<const std::byte> bytes,
                                                      const std::string& name);
  // The same for a file whose common keys are already read; consumes its tensors.
  static Result<std::shared_ptr<const Network>> Read(net::WeightsFile& file);
  ~Network();
  Network& operator=(const Network&) = delete;

  // The styles: those of the file, followed by those of With.
  const net::Model& model() const { return model_; }
  const stgcn::FeatureParameters& features() const { return features_; }
  // 1 / deviation of each feature.
  std::span<const float> inverse_deviation() const;
  int width() const;
  int style_count() const { return static_cast<int>(model_.styles.size()); }

  // The space of this network's styles, by the styles of the file; and their points for its
  // decoder.
  const stgcn::CodeSpace& space() const;
  const PointSpace& points() const;
  // A copy of the network with `code`, of a size that PointSpace accepts, as the style `number`: a
  // new one, style_count(), or a replacement of a style that With has added. Its variations are
  // those of the nearest domain. The layers are shared, and states of one network are valid for the
  // other. Allocates.
  std::shared_ptr<const Network> With(int number, net::StyleInfo style,
                                      const net::StyleCode& code) const;
  // A copy of the network in which the style `number`, added by With, is retired.
  std::shared_ptr<const Network> Retired(int number) const;
  bool SharesStates(const Network& other) const { return weights_ == other.weights_; }

  // A started state. Allocates.
  State MakeState() const;
  // Returns a state of MakeState to its beginning. Noexcept, no allocation.
  STYLED_REALTIME void Start(State& state) const noexcept;
  // See model/base/checkpoint.h.
  STYLED_REALTIME void Carry(State& state, Checkpoint& c) const noexcept;

  // Advances `state` by one frame and writes `out`. `input_style`, `active` and `variations`: as in
  // net::StepJob and Stylizer::Step. Features that are not a number count as the mean, so no input
  // leaves a non-finite state behind. Noexcept, no allocation, no lock.
  STYLED_REALTIME void Step(const stgcn::Features& features, int input_style,
                            std::span<const net::StyleWeight> active, State& state, Output& out,
                            std::span<const net::VariationWeight> variations = {}) const noexcept;

 private:
  Network(const Network&) = default;
  struct Weights;
  Network() = default;
  net::Model model_;
  stgcn::FeatureParameters features_;
  // Of model_.styles: its point, and the domain whose variations it has.
  std::vector<std::shared_ptr<const Point>> points_;
  std::vector<int> domains_;
  std::shared_ptr<const Weights> weights_;
};

}  // namespace styled::stgcn_causal
