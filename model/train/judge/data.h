#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "model/base/status.h"
#include "model/clip/manifest.h"
#include "model/train/judge/action_classifier.h"
#include "model/train/judge/judges_file.h"
#include "model/train/judge/nets.h"
#include "model/train/judge/report.h"
#include "model/train/judge/stream.h"

namespace styled::judge {

inline constexpr const char* kValidation = "validation";
inline constexpr const char* kTest = "test";

// The data for judging weights: a manifest's clips at kJudgeRate_hz, by split, and the inputs.
struct Data {
  clip::Manifest manifest;
  std::string split = kValidation;  // the one that is judged, or kTest
  std::vector<train::TrainingClip> train, judge;
  std::vector<train::TrainingClip> validation;  // of `split`
  // The clips to be styled, at the stream's rate, with the content of each: the neutral clips of
  // `validation`, or of the same split of another manifest.
  std::vector<Poses> inputs;
  std::vector<int> contents;
};

// `inputs` may be empty: then the manifest's own neutral clips are used. Errors name the file.
Result<Data> LoadData(const std::filesystem::path& manifest, const std::filesystem::path& inputs,
                      const std::filesystem::path& folder, const std::string& split = kValidation);

// Judges for the manifest; read from `cache` if the same were trained before. All of them, or
// those of whole bodies alone, in half the time.
Result<Panel> TrainPanel(const Data& data, const JudgeSettings& settings,
                         const std::filesystem::path& cache);
Result<Judges> TrainJudges(const Data& data, const JudgeSettings& settings,
                           const std::filesystem::path& cache);
// `count` of them, with the judges' other settings.
Result<ActionClassifiers> TrainActionClassifiers(const Data& data, JudgeSettings settings,
                                                 int count, const std::filesystem::path& cache);

inline constexpr int kAbsent = -1;

// Weights as they run live, and which of the manifest's styles they have.
struct Styler {
  std::shared_ptr<const net::Stylizer> network;
  std::shared_ptr<const rig::Binding> binding;
  std::vector<int> style_of;  // manifest style -> network style, or kAbsent, as for neutral
  int input_style = 0;        // the style number that the network is given for the inputs
  stylist::Root root = stylist::Root::kFollow;
  // The content that the network gets with an input, by the manifest's content; empty: it
  // recognizes the content itself.
  std::vector<int> content_of;

  int ContentOf(int content) const {
    return content_of.empty() ? net::kContentRecognized
                              : content_of[static_cast<std::size_t>(content)];
  }
};
// The network's number of each style of the manifest. An error if it has none but neutral.
Result<std::vector<int>> StylesOf(const net::Styles& styles, const clip::Manifest& manifest);
// Styler::content_of for `source`: "recognized", "unknown", or "label", the manifest's contents. An
// error if the network takes no content, or has none of the manifest's.
Result<std::vector<int>> ContentsOf(const net::Contents& contents, const clip::Manifest& manifest,
                                    const std::string& source);
Result<Styler> LoadStyler(const std::filesystem::path& weights, const clip::Manifest& manifest);

// The dependence of a constant offset: on the style, or on style and content (which only an offline
// program knows). In a content without clips of the style it is that of all contents.
enum class OffsetPer { kStyle, kContent };

// Every input in every style: by the weights, and by the baseline, a constant offset per joint
// (mean target pose minus mean neutral pose, over the contents that both have, from the generator's
// training clips). `Unstyled`: the inputs themselves, to be judged as every style. Spans in the
// result point into `data`.
std::vector<Transferred> Style(const Data& data, const Styler& styler,
                               const stylist::Options& options, bool absolute);
std::vector<Transferred> ApplyBaseline(const Data& data, OffsetPer per = OffsetPer::kStyle);
std::vector<Transferred> Unstyled(const Data& data);
// The constant offset of each style on the same inputs as `clips`, in the same styles.
std::vector<Transferred> ByBaseline(const Data& data, std::span<const Transferred> clips);
// The same offsets, by style.
std::vector<ConstantOffset> StyleOffsets(const Data& data);

// Writes the constant offset as weights of the family constant-offset, with the manifest's styles.
Status WriteBaseline(const Data& data, const std::filesystem::path& file);

}  // namespace styled::judge
