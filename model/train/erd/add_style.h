#pragma once

#include <torch/torch.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "model/clip/manifest.h"
#include "model/train/erd/config.h"
#include "model/train/erd/weights.h"

// Styles that are added to trained weights (styletrain add-style): a run on neutral and the new
// styles alone, whose branches are then added to those of the initial weights.
namespace styled::train::style_erd {

// The indices that the manifest's styles except neutral will have in the weights. Refuses a
// manifest of other styles than config.add_styles, a style that `init` already has (unless
// config.replace), and more styles than a weights file can have.
Result<std::vector<int64_t>> PlacesOfAdded(const Config& config,
                                           const std::filesystem::path& manifest_file,
                                           const clip::Manifest& manifest,
                                           const LoadedWeights& init);

// `base` with the styles of `few`, a network whose other parameters are base's: their branches and
// columns of the style inputs. `places` as PlacesOfAdded gives them, one for each of few's styles
// but neutral. The rest of base is copied bit for bit.
std::unique_ptr<Generator> WithStyles(const Generator& base, const Generator& few,
                                      const std::vector<int64_t>& places, const torch::Tensor& mean,
                                      const torch::Tensor& deviation);
// The metadata for it: `styles`, names and aliases, at `places`; `training`, a JSON object, is
// appended to the list "added" in the record of base's training. `licence`: of the result.
std::string WithStyles(const std::string& base, const std::vector<clip::ManifestStyle>& styles,
                       const std::vector<int64_t>& places, const std::string& training,
                       const std::string& licence);

}  // namespace styled::train::style_erd
