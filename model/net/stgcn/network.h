#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "model/base/status.h"
#include "model/net/kernels/rows.h"
#include "model/net/stgcn/features.h"
#include "model/net/stgcn/graph_conv.h"
#include "model/net/stgcn/time_conv.h"
#include "model/net/stylizer.h"

namespace styled::net {
struct WeightsFile;
}

namespace styled::stgcn {

inline constexpr int kCode = 64;             // numbers in a style code
inline constexpr int kNoise = 16;            // numbers that the mapping network takes
inline constexpr int kReference = 64;        // frames that the style encoder takes
inline constexpr int kReferenceHop = 16;     // between the windows of a longer reference
inline constexpr int kAllWindows = 1 << 20;  // of a reference: no bound
inline constexpr int kLeastFrames = 8;       // of a clip
// Channels of the finest level: a multiple of the kernels' block size, and few enough that the
// weights fit into net::kMaxFileBytes.
inline constexpr int kWidthStep = net::kRowPanel;
inline constexpr int kMaxWidth = 96;
inline constexpr int kFreeHead = -1;  // the head of the style encoder that needs no domain

// A style: the decoder's normalizations are computed from it. The style encoder's codes are
// unbounded; the mapping network's lie in (-1, 1).
using Code = Eigen::Matrix<float, kCode, 1>;
using Noise = Eigen::Matrix<float, kNoise, 1>;  // standard normal

class CodeSpace;

// Memory of one thread's calls; grows with the longest clip, about 150 kB per frame at width 64.
struct Scratch {
  net::AlignedFloats frames, block, graph, skip, pooled, interpolated, time1, time2, between,
      out[2];
  TimeScratch time;
};

// The networks of Park et al. 2021 (FORMAT.md): the generator, here in two halves, and those that
// define styles (code_space.h). Features go in and come out in their units (features.h); the
// networks see them standardized. Immutable; shared by all threads, each with its own scratch.
// Allocates; not for live streams. Pinned by tests/unit/net/stgcn and tests/parity.
class Network {
 public:
  // Reads the file format of model/net/stgcn/FORMAT.md. Errors name the file, the tensor or key,
  // what was expected and what was found.
  static Result<std::shared_ptr<const Network>> Load(const std::filesystem::path& file);
  static Result<std::shared_ptr<const Network>> Parse(std::span<const std::byte> bytes,
                                                      const std::string& name);
  // The same for a file whose common keys are already read; consumes its tensors.
  static Result<std::shared_ptr<const Network>> Read(net::WeightsFile& file);
  ~Network();
  Network(const Network&) = delete;
  Network& operator=(const Network&) = delete;

  const net::Model& model() const { return model_; }
  const FeatureParameters& features() const { return features_; }
  int width() const;

  // The generator's encoding of a clip, to be decoded in any style.
  struct Content {
    int frames = 0;             // of the clip
    net::AlignedFloats values;  // [frames / 4 rounded up, 5, 4 width]
  };
  // `clip`: at least kLeastFrames. A length that is not a multiple of 4 is extended with its last
  // frame. All normalizations are over the whole clip.
  void Encode(std::span<const Features> clip, Content& content, Scratch& scratch) const;
  // out: content.frames features. Rotations are not of length 1; the hips' x and z are 0.
  void Decode(const Content& content, const Code& code, std::span<Features> out,
              Scratch& scratch) const;

  // The space of this network's styles: codes for Decode.
  const CodeSpace& space() const;

 private:
  struct Weights;
  Network();
  net::Model model_;
  FeatureParameters features_;
  std::unique_ptr<Weights> weights_;
};

}  // namespace styled::stgcn
