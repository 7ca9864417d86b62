#include "model/train/judge/data.h"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>

#include "model/base/hash.h"
#include "model/clip/clip.h"
#include "model/feet/legs.h"
#include "model/net/offset/stylizer.h"
#include "model/trial/trial.h"

namespace styled::judge {
namespace {

// A key for cached judges, computed from everything that they depend on but the seed.
std::string JudgeKey(const Data& data, const JudgeSettings& settings) {
  std::string text = std::to_string(body::HumanoidHash()) + kJudgeRecipe + "-" + kPartRecipe;
  for (const train::TrainingClip& c : data.judge) {
    text += std::filesystem::path(c.file).filename().string() + std::to_string(c.style) +
            std::to_string(c.content) + std::to_string(c.poses.size());
  }
  for (const double value :
       {static_cast<double>(settings.window), static_cast<double>(settings.iterations),
        static_cast<double>(settings.batch)}) {
    text += " " + std::to_string(value);
  }
  char key[17];
  std::snprintf(key, sizeof key, "%016llx", static_cast<unsigned long long>(HashOf(text)));
  return key;
}

using Rotations = Eigen::Matrix<double, erd::kRotationFeatures, 1>;

// The mean rotations of every cell of the generator's training clips.
struct MeanRotations {
  explicit MeanRotations(const Data& data);
  bool has(std::size_t cell) const { return counts[cell] > 0; }
  Rotations of(std::size_t cell) const { return sums[cell] / counts[cell]; }

  std::vector<Rotations> sums;  // by style * contents + content
  std::vector<double> counts;
};

MeanRotations::MeanRotations(const Data& data) {
  const std::size_t contents = data.manifest.contents.size();
  sums.assign(data.manifest.styles.size() * contents, Rotations::Zero());
  counts.assign(sums.size(), 0);
  erd::FeatureParameters parameters;
  train::SetHemisphere(train::ComputeStatistics(data.train, parameters).mean, parameters);
  for (const train::TrainingClip& c : data.train) {
    const std::size_t cell = static_cast<std::size_t>(c.style) * contents + c.content;
    for (const erd::Features& frame :
         MakeSequence(c.poses, c.style, c.content, false, parameters).frames) {
      sums[cell] +=
          Eigen::Map<const Eigen::VectorXf>(frame.data(), erd::kRotationFeatures).cast<double>();
      counts[cell] += 1;
    }
  }
}

// From one mean of rotations to another; means of none give the identity.
ConstantOffset Offset(const Rotations& neutral, const Rotations& target) {
  ConstantOffset offset;
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    const auto rotation = [joint](const Rotations& mean) {
      const Eigen::Vector4d q = mean.segment<4>(4 * joint);
      return q.norm() > 0 ? body::Quat(Eigen::Vector4f(q.normalized().cast<float>()))
                          : body::Quat::Identity();
    };
    offset.offset[joint] = rotation(neutral).conjugate() * rotation(target);
  }
  return offset;
}

}  // namespace

std::vector<ConstantOffset> StyleOffsets(const Data& data) {
  const std::size_t contents = data.manifest.contents.size();
  const MeanRotations means(data);
  std::vector<ConstantOffset> baselines;
  for (std::size_t style = 0; style < data.manifest.styles.size(); ++style) {
    Rotations neutral = Rotations::Zero();
    Rotations target = Rotations::Zero();
    for (std::size_t content = 0; content < contents; ++content) {
      const std::size_t cell = style * contents + content;
      if (!means.has(cell) || !means.has(content)) continue;
      neutral += means.of(content);
      target += means.of(cell);
    }
    baselines.push_back(Offset(neutral, target));
  }
  return baselines;
}

namespace {

// The offset of each style in each content, by style * contents + content.
std::vector<ConstantOffset> BaselinesPerContent(const Data& data) {
  const std::size_t contents = data.manifest.contents.size();
  const MeanRotations means(data);
  const std::vector<ConstantOffset> of_all = StyleOffsets(data);
  std::vector<ConstantOffset> baselines;
  for (std::size_t cell = 0; cell < means.sums.size(); ++cell) {
    const std::size_t content = cell % contents;
    const bool both = means.has(cell) && means.has(content);
    baselines.push_back(both ? Offset(means.of(content), means.of(cell)) : of_all[cell / contents]);
  }
  return baselines;
}

std::vector<Transferred> Transfer(const Data& data, const std::vector<int>& style_of,
                                  const std::function<Poses(std::size_t input, int style)>& make) {
  std::vector<Transferred> out;
  for (std::size_t i = 0; i < data.inputs.size(); ++i) {
    for (int style = 0; style < static_cast<int>(data.manifest.styles.size()); ++style) {
      if (style_of[style] == kAbsent) continue;
      out.push_back({static_cast<int>(i), style, data.contents[i], data.inputs[i], make(i, style)});
    }
  }
  return out;
}

}  // namespace

Result<Data> LoadData(const std::filesystem::path& manifest, const std::filesystem::path& inputs,
                      const std::filesystem::path& folder, const std::string& split) {
  if (Status status = train::CheckDataFolder(folder); !status.ok()) return status;
  Result<clip::Manifest> own = clip::LoadManifest(manifest, folder);
  if (!own.ok()) return own.status();
  Data data;
  data.split = split;
  data.manifest = std::move(own.value());
  erd::FeatureParameters parameters;
  parameters.rate_hz = static_cast<float>(kJudgeRate_hz);
  for (const auto& [name, clips] : {std::pair{std::string("train"), &data.train},
                                    {std::string("judge"), &data.judge},
                                    {split, &data.validation}}) {
    auto loaded = train::LoadClips(data.manifest, name, parameters, 2);
    if (!loaded.ok()) return loaded.status();
    *clips = std::move(loaded.value());
  }
  const auto add_input = [&data](const train::TrainingClip& c, int content) {
    if (c.style != 0 || content < 0) return;
    data.inputs.push_back(clip::ResamplePoses(c.poses, kJudgeRate_hz, kStreamRate_hz));
    data.contents.push_back(content);
  };
  if (inputs.empty()) {
    for (const train::TrainingClip& c : data.validation) add_input(c, c.content);
    return data;
  }
  Result<clip::Manifest> other = clip::LoadManifest(inputs, folder);
  if (!other.ok()) return other.status();
  const auto clips = train::LoadClips(other.value(), split, parameters, 2);
  if (!clips.ok()) return clips.status();
  const std::vector<std::string>& names = data.manifest.contents;
  for (const train::TrainingClip& c : clips.value()) {
    const auto found = std::find(names.begin(), names.end(), other.value().contents[c.content]);
    add_input(c, found == names.end() ? -1 : static_cast<int>(found - names.begin()));
  }
  if (data.inputs.empty()) {
    return Status::Error("inputs " + inputs.string() + ": no neutral clip of the split " + split +
                         " has a content of " + manifest.string());
  }
  return data;
}

Result<Panel> TrainPanel(const Data& data, const JudgeSettings& settings,
                         const std::filesystem::path& cache) {
  return TrainPanel(data.judge, data.manifest, settings, cache, JudgeKey(data, settings));
}

Result<Judges> TrainJudges(const Data& data, const JudgeSettings& settings,
                           const std::filesystem::path& cache) {
  return Judges::TrainOrLoad(data.judge, static_cast<int>(data.manifest.styles.size()),
                             static_cast<int>(data.manifest.contents.size()), settings, cache,
                             JudgeKey(data, settings));
}

Result<ActionClassifiers> TrainActionClassifiers(const Data& data, JudgeSettings settings,
                                                 int count, const std::filesystem::path& cache) {
  settings.count = count;
  return ActionClassifiers::TrainOrLoad(data.judge, static_cast<int>(data.manifest.styles.size()),
                                        static_cast<int>(data.manifest.contents.size()), settings,
                                        cache, JudgeKey(data, settings));
}

Result<std::vector<int>> StylesOf(const net::Styles& styles, const clip::Manifest& manifest) {
  std::vector<int> style_of;
  bool found = false;
  for (const clip::ManifestStyle& style : manifest.styles) {
    const int index = net::FindStyle(styles, style.name);
    style_of.push_back(index > 0 ? index : kAbsent);
    found = found || index > 0;
  }
  if (!found) return Status::Error("has none of the manifest's styles besides neutral");
  return style_of;
}

Result<std::vector<int>> ContentsOf(const net::Contents& contents, const clip::Manifest& manifest,
                                    const std::string& source) {
  std::vector<int> content_of;
  if (source == "recognized") return content_of;
  if (contents.empty()) return Status::Error("the network takes no content as input");
  content_of.assign(manifest.contents.size(), net::kContentUnknown);
  if (source == net::kUnknownContent) return content_of;
  bool found = false;
  for (std::size_t i = 0; i < content_of.size(); ++i) {
    const auto content = net::FindContent(contents, manifest.contents[i]);
    if (content.ok()) content_of[i] = content.value();
    found = found || content.ok();
  }
  if (!found) return Status::Error("has none of the manifest's contents");
  return content_of;
}

Result<Styler> LoadStyler(const std::filesystem::path& weights, const clip::Manifest& manifest) {
  auto network = trial::Load(weights);
  if (!network.ok()) return network.status();
  auto style_of = StylesOf(network.value()->model().styles, manifest);
  if (!style_of.ok()) return Status::Error(weights.string() + ": " + style_of.status().message());
  return Styler{network.value(), std::make_shared<const rig::Binding>(feet::HumanoidBinding()),
                std::move(style_of.value())};
}

std::vector<Transferred> Style(const Data& data, const Styler& styler,
                               const stylist::Options& options, bool absolute) {
  return Transfer(data, styler.style_of, [&](std::size_t input, int style) {
    Switch start{0, OneStyle(styler.style_of[style], absolute)};
    start.settings.input_style = styler.input_style;
    start.settings.input_content = styler.ContentOf(data.contents[input]);
    start.settings.root = styler.root;
    return StyleStream(styler.network, styler.binding, options, {&start, 1}, data.inputs[input]);
  });
}

namespace {

Poses Apply(const ConstantOffset& baseline, std::span<const body::Pose> input) {
  Poses output;
  for (const body::Pose& pose : input) output.push_back(baseline.Apply(pose));
  return output;
}

// All styles but neutral, which the inputs already have.
std::vector<int> EveryStyle(const Data& data) {
  std::vector<int> all(data.manifest.styles.size(), 0);
  all[0] = kAbsent;
  return all;
}

}  // namespace

std::vector<Transferred> ApplyBaseline(const Data& data, OffsetPer per) {
  const std::size_t contents = data.manifest.contents.size();
  const std::vector<ConstantOffset> baselines =
      per == OffsetPer::kStyle ? StyleOffsets(data) : BaselinesPerContent(data);
  return Transfer(data, EveryStyle(data), [&](std::size_t input, int style) {
    const auto place = static_cast<std::size_t>(style);
    const ConstantOffset& baseline =
        per == OffsetPer::kStyle
            ? baselines[place]
            : baselines[place * contents + static_cast<std::size_t>(data.contents[input])];
    return Apply(baseline, data.inputs[input]);
  });
}

std::vector<Transferred> ByBaseline(const Data& data, std::span<const Transferred> clips) {
  const std::vector<ConstantOffset> baselines = StyleOffsets(data);
  std::vector<Transferred> out;
  for (const Transferred& of : clips) {
    out.push_back({of.clip, of.style, of.content, of.input,
                   Apply(baselines[static_cast<std::size_t>(of.style)], of.input)});
  }
  return out;
}

std::vector<Transferred> Unstyled(const Data& data) {
  return Transfer(data, EveryStyle(data),
                  [&](std::size_t input, int) { return data.inputs[input]; });
}

Status WriteBaseline(const Data& data, const std::filesystem::path& file) {
  net::Model model;
  model.rate_hz = static_cast<float>(kJudgeRate_hz);
  model.licence = data.manifest.licence;
  model.training = nlohmann::json({{"data", data.manifest.name}}).dump();
  std::vector<offset::Offsets> offsets;
  for (const clip::ManifestStyle& style : data.manifest.styles) {
    model.styles.push_back({style.name, style.aliases});
  }
  for (const ConstantOffset& baseline : StyleOffsets(data)) {
    offset::Offsets& style = offsets.emplace_back();
    std::copy(std::begin(baseline.offset), std::end(baseline.offset), style.begin());
    for (body::Quat& q : style) q.normalize();
  }
  return offset::Write(file, model, offsets);
}

}  // namespace styled::judge
