#pragma once

#include <vector>

#include "tests/unit/net/stgcn/random_weights.h"

// The networks of FORMAT.md a second time, as plain loops in double: every layer in the order in
// which the equations have it, with dense adjacency, nothing folded, nothing left out. Slow.
namespace styled::stgcn {

// Frame, node, channel; features standardized.
using Clip = std::vector<std::vector<std::vector<double>>>;

Clip Relu(const Clip& x);
Clip Leaky(const Clip& x);
Clip Sum(const Clip& a, const Clip& b);      // (a + b) / sqrt 2
Clip PoolSpace(const Clip& x, int level);    // from `level`
Clip UnpoolSpace(const Clip& x, int level);  // to `level`

class Reference {
 public:
  explicit Reference(const WeightsFile& file) : file_(file) {}

  Clip Standardized(const std::vector<Features>& clip) const;
  // The clip in the style of `code`, in features' units. Any length.
  std::vector<Features> Generate(const std::vector<Features>& clip, const Code& code) const;
  // The code of exactly kReference frames.
  Code EncodeStyle(const std::vector<Features>& clip, int domain) const;
  Code MapNoise(const Noise& noise, int domain) const;

  // Layers that do not depend on time.
  Clip WithBias(const Clip& x, const std::string& name) const;  // g.in, e.in, g.out
  Clip Linear(const Clip& x, const std::string& name) const;    // without bias
  Clip GraphConvolution(const Clip& x, const std::string& name, int level) const;
  std::vector<double> Dense(const std::vector<double>& x, const std::string& name) const;

 private:
  struct Tensor {
    const net::NamedTensor& of;
    double operator()(std::size_t a, std::size_t b = 0, std::size_t c = 0, std::size_t d = 0) const;
  };
  Tensor Get(const std::string& name) const { return {file_.tensor(name)}; }
  std::size_t Channels(const std::string& name) const;

  Clip TimeConvolution(const Clip& x, const std::string& name) const;
  Clip Normalized(const Clip& x, const std::vector<double>& scale,
                  const std::vector<double>& shift) const;
  Clip InstanceNorm(const Clip& x, const std::string& name) const;
  Clip AdaIn(const Clip& x, const std::string& name, const Code& code) const;
  Clip Encoder(const Clip& x, const std::string& name, int level, bool norms) const;
  Clip Decoder(const Clip& x, const std::string& name, int level, const Code& code) const;

  const WeightsFile& file_;
};

}  // namespace styled::stgcn
