#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "tests/unit/net/stgcn/reference.h"
#include "tests/unit/net/stgcn_causal/random_weights.h"

namespace styled::stgcn_causal {

using Doubles = std::vector<double>;

// One stream of FORMAT.md's network a second time, in double: every input that a convolution ever
// had is kept, statistics are plain sums, nothing is folded, nothing left out. Slow.
class Reference {
 public:
  explicit Reference(const WeightsFile& file);

  struct Output {
    Doubles reconstruction, styled;  // [21 * 7], in features' units
  };
  // `active` maps style to α, each 0 to 1.5.
  Output Step(const Features& features, int input_style, const std::map<int, double>& active);

 private:
  using Clip = stgcn::Clip;  // of one frame

  struct Sums {
    double count;    // N
    Doubles of_x;    // S
    Doubles square;  // Q
  };
  // The memory of one run through the encoder or a decoder, by layer.
  struct Past {
    std::map<std::string, std::vector<Clip>> inputs;
    std::map<std::string, Sums> sums;
  };

  double Value(const std::string& tensor, std::size_t i) const;
  Clip TimeConvolution(const Clip& x, const std::string& name, int spacing, Past& past) const;
  // x̂, times scale plus shift.
  Clip Normalized(const Clip& x, const std::string& name, const Doubles& scale,
                  const Doubles& shift, Past& past) const;
  Clip InstanceNorm(const Clip& x, const std::string& name, Past& past) const;
  Clip AdaIn(const Clip& x, const std::string& name, const Doubles& code, Past& past) const;
  Clip Encoder(const Clip& x, const std::string& name, int level, int spacing, Past& past) const;
  Clip Decoder(const Clip& x, const std::string& name, int level, int spacing, const Doubles& code,
               Past& past) const;
  Doubles Decode(const Clip& content, const Doubles& code, Past& past) const;
  Doubles Code(int domain) const;

  const WeightsFile& file_;
  stgcn::Reference layers_;
  std::array<int, 4> spacing_;
  int memory_, start_frames_;
  Past encoder_, own_, styled_;
  int alone_ = 0;
};

}  // namespace styled::stgcn_causal
