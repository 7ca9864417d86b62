#pragma once

#include <array>
#include <string>

#include "model/net/stgcn/features.h"
#include "model/net/stgcn/layers.h"
#include "model/net/weights_file.h"

// Reading of the keys, tensors and layers that the files of whole clips (FORMAT.md) and of live
// streams (stgcn_causal/FORMAT.md) have in common. A fault is added if the file differs from its
// format; the result must then not be used. Start-up code: it allocates. Pinned by
// tests/unit/net/stgcn/load_test.cpp.
namespace styled::stgcn {

// Reads the key "width". Returns 0, and adds a fault, if the kernels cannot run it.
int ReadWidth(const nlohmann::json& object, net::Faults& faults);
// "normalization", optional: "neighbours" or "subset" (graph.h).
Normalization ReadNormalization(const nlohmann::json& object, net::Faults& faults);
// "contents": names of the acts of the training data, for people.
void CheckContents(const nlohmann::json& object, net::Faults& faults);
// "heading_tau_s" and the file's rate.
void ReadParameters(const net::WeightsFile& file, FeatureParameters& features, net::Faults& faults);

// How features are standardized.
struct Standardization {
  Features mean, deviation, inverse_deviation;
};
// Deviations must be usable as divisors. The hemispheres of `features` become the mean rotations.
Standardization ReadStandardization(net::TensorReader& tensors, FeatureParameters& features,
                                    net::Faults& faults);

// A matrix, or one term of several, in the order of the kernels.
void Pack(const net::RowMajor& from, float scale, std::size_t term, net::PackedColumns& to);
void Copy(const net::RowMajor& from, net::AlignedFloats& to);

// Reads layers from a file's tensors.
class LayerReader {
 public:
  explicit LayerReader(net::TensorReader& tensors,
                       Normalization normalization = Normalization::kNeighbours)
      : tensors_(tensors), normalization_(normalization) {}

  // A 1 x 1 convolution of every node; with `nodes` above 0, and a bias of each node.
  Linear ReadLinear(const std::string& name, int out, int in, int nodes);
  Norm ReadNorm(const std::string& name, int channels);
  // How a block handles nodes from `level` to the coarser one, or from the coarser one to `level`.
  // The skip path of the former pools this many frames.
  EncoderNodes ReadEncoder(const std::string& name, int level, int in, int out, int frames);
  DecoderNodes ReadDecoder(const std::string& name, int level, int in, int out);
  net::TensorReader& tensors() { return tensors_; }

 private:
  GraphConv ReadGraph(const std::string& name, int out, int in,
                      const std::array<Eigen::MatrixXf, kLabelCount>& mixing,
                      const Eigen::MatrixXf& pooling);
  net::PackedColumns ReadSkip(const std::string& name, int out, int in);

  net::TensorReader& tensors_;
  Normalization normalization_;
};

}  // namespace styled::stgcn
