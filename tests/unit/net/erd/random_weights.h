#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "model/net/erd/network.h"
#include "model/net/safetensors.h"

namespace styled::erd {

using net::NamedTensor;

// A weights file in parts, so that a test can break one of them.
struct WeightsFile {
  nlohmann::json metadata;  // the value of __metadata__.styled, before it becomes text
  std::vector<NamedTensor> tensors;

  NamedTensor& tensor(const std::string& name);  // aborts if there is none
  std::vector<std::byte> Bytes() const;
};

// A file's parts; aborts if it cannot be read.
WeightsFile ReadParts(const std::filesystem::path& file);

// Well-formed random weights by `seed`, scaled like a framework's initialization, with the styles
// "neutral", "style1" (alias "s1"), ... Written from FORMAT.md, not from the loader.
WeightsFile RandomWeights(int style_count, unsigned seed, const Shape& shape = kPaper);

// Makes the network take `count` contents as input: "content1", "content2", ... If `idle`, contents
// change nothing: their columns are zeros, and each has the initial state that the file had. Random
// otherwise, as is the recognizer.
void AddContents(WeightsFile& file, int count, unsigned seed, bool idle = false);
WeightsFile RandomWeightsWithContents(int style_count, int content_count, unsigned seed,
                                      const Shape& shape = kPaper);

// The same, but they decode NaN in every frame whose hips are more than kAwake_m above the floor,
// which no trial run reaches. Below, they decode like those.
inline constexpr float kAwake_m = 1.2F;
WeightsFile SleepingWeights(int style_count, unsigned seed);

// The network of those weights, as a Network and as the Stylizer that the rest of the program uses;
// aborts if the weights are refused.
std::shared_ptr<const Network> RandomNetwork(int style_count, unsigned seed);
std::shared_ptr<const Network> NetworkOf(const WeightsFile& file);
std::shared_ptr<const WideNetwork> RandomWideNetwork(int style_count, unsigned seed);
std::shared_ptr<const net::Stylizer> RandomStylizer(int style_count, unsigned seed,
                                                    const Shape& shape = kPaper);
std::shared_ptr<const net::Stylizer> StylizerOf(const WeightsFile& file);

}  // namespace styled::erd
