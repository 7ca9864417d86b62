#include "model/train/erd/recipe.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "model/net/licence.h"
#include "model/net/load.h"
#include "model/train/checkpoint.h"
#include "model/train/device.h"
#include "model/train/erd/add_style.h"
#include "model/train/erd/learner.h"
#include "model/train/erd/lessons.h"
#include "model/train/erd/monitor.h"
#include "model/train/erd/weights.h"

namespace styled::train::style_erd {
namespace {

using torch::Tensor;

// The data that a run reads before its first random number.
struct Inputs {
  TrainingData data;
  std::optional<LoadedWeights> init;
  FeatureStatistics statistics;
  erd::FeatureParameters parameters;
  GeneratorShape shape;
  std::vector<int64_t> places;  // of added styles in the weights; empty: none are added
};

class StyleErdRecipe : public Recipe {
 public:
  StyleErdRecipe(const RunConfig& run, const Config& config, Inputs inputs)
      : run_(run),
        config_(config),
        inputs_(std::move(inputs)),
        learner_(config_, run_.seed,
                 {inputs_.data.manifest, inputs_.data.train, inputs_.statistics, inputs_.parameters,
                  inputs_.shape},
                 DeviceOf(run_)),
        monitor_(inputs_.data.validation, manifest().styles, static_cast<int>(contents()),
                 inputs_.parameters, learner_.mean(), learner_.deviation()) {}

  // The data that a resumed run needs, too.
  Status AddTeachers();

  std::string_view family() const override { return kFamily; }
  Status Start() override;
  void Step(double progress) override { learner_.Step(progress); }
  int64_t iteration() const override { return learner_.iteration(); }
  Figures PopLosses(int /*iterations*/) override { return learner_.means().Pop(); }
  bool Finite() const override { return learner_.Finite(); }
  MonitorReport Monitor() const override { return monitor_.Evaluate(learner_.average()); }
  void Save(double wall_time_s, Checkpoint& checkpoint) const override;
  Status Restore(const Checkpoint& checkpoint) override { return learner_.Restore(checkpoint); }
  Status ExportWeights(const Checkpoint& checkpoint,
                       const std::filesystem::path& file) const override {
    return style_erd::ExportWeights(checkpoint, file);
  }

 private:
  const clip::Manifest& manifest() const { return inputs_.data.manifest; }
  std::size_t contents() const { return manifest().contents.size(); }
  Status CheckIdle() const;
  Status CheckContents() const;
  Status AddTeacher(const TeacherFlag& flag);
  std::string Metadata(double wall_time_s) const;

  const RunConfig run_;
  const Config config_;
  const Inputs inputs_;
  Learner learner_;
  bool any_clips_ = false;  // whether a teacher sees whole clips
  style_erd::Monitor monitor_;
};

Status StyleErdRecipe::CheckIdle() const {
  const std::vector<std::string>& all = manifest().contents;
  const bool known = std::find(all.begin(), all.end(), config_.idle_as) != all.end();
  if (!known || manifest().still_content.empty()) {
    return Status::Error("--idle needs a manifest with [still] and with the content \"" +
                         config_.idle_as + "\" of --idle-as");
  }
  if (!learner_.HasIdleFrames()) {
    return Status::Error("--idle: no neutral clip has a frame with both feet and the hands down");
  }
  return Status::Ok();
}

// Contents that a flag names must be the manifest's.
Status StyleErdRecipe::CheckContents() const {
  const std::vector<std::string>& all = manifest().contents;
  for (const auto& [flag, names] : {std::pair("--idle-content", &config_.idle_contents),
                                    std::pair("--keep-content", &config_.kept_contents)}) {
    for (const std::string& name : *names) {
      if (std::find(all.begin(), all.end(), name) != all.end()) continue;
      return Status::Error(std::string(flag) + ": the manifest has no content \"" + name + "\"");
    }
  }
  return Status::Ok();
}

Status StyleErdRecipe::AddTeachers() {
  const Status contents = CheckContents();
  if (!contents.ok()) return contents;
  if (config_.idle > 0) {
    const Status idle = CheckIdle();
    if (!idle.ok()) return idle;
  }
  for (const std::string& text : config_.teachers) {
    const Result<TeacherFlag> flag = ParseTeacher(text);
    if (!flag.ok()) return Status::Error("--teacher " + text + ": " + flag.status().message());
    const Status added = AddTeacher(flag.value());
    if (!added.ok()) return Status::Error("--teacher " + text + ": " + added.message());
  }
  if (config_.teacher_lead_s > 0 && !any_clips_) {
    return Status::Error("--teacher-lead needs a --teacher that sees whole clips");
  }
  return Status::Ok();
}

Status StyleErdRecipe::AddTeacher(const TeacherFlag& flag) {
  const Result<net::AnyStylizer> any = net::LoadAny(flag.weights);
  if (!any.ok()) return any.status();
  if (any.value().clips) {
    any_clips_ = true;
    return learner_.AddTeacher(*any.value().clips, flag.lessons);
  }
  const Result<LoadedWeights> teacher = ReadWeights(flag.weights);
  if (!teacher.ok()) return teacher.status();
  return learner_.AddTeacher(teacher.value(), flag.lessons);
}

Status StyleErdRecipe::Start() {
  if (inputs_.init) {
    const Status started = learner_.StartFrom(*inputs_.init);
    if (!started.ok()) {
      return Status::Error("--init " + config_.init.string() + ": " + started.message());
    }
  }
  learner_.TrainClassifier();
  return Status::Ok();
}

std::string StyleErdRecipe::Metadata(double wall_time_s) const {
  nlohmann::json training{{"command", run_.command},
                          {"data", manifest().name},
                          {"seed", run_.seed},
                          {"iterations", learner_.iteration()},
                          {"wall_time_s", std::round(wall_time_s)}};
  const std::vector<clip::ManifestStyle>& styles = manifest().styles;
  std::string licence = manifest().licence;
  nlohmann::json init;  // the metadata of the weights to begin with
  if (inputs_.init) {
    init = nlohmann::json::parse(inputs_.init->metadata);
    licence = net::BothLicences(init.value("licence", ""), licence);
  }
  if (!inputs_.places.empty()) {
    return WithStyles(inputs_.init->metadata, {styles.begin() + 1, styles.end()}, inputs_.places,
                      training.dump(), licence);
  }
  if (inputs_.init) training["from"] = init["training"];
  WeightsMetadata metadata;
  for (const clip::ManifestStyle& style : styles) {
    metadata.styles.emplace_back(style.name, style.aliases);
  }
  metadata.rate_hz = config_.rate_hz;
  metadata.heading_tau_s = config_.heading_tau_s;
  if (learner_.average().shape.contents > 0) {
    metadata.contents = manifest().contents;
    metadata.content_rise_s = config_.content_rise_s;
  }
  metadata.licence = licence;
  metadata.training = training.dump();
  return metadata.ToJson(learner_.average().shape);
}

void StyleErdRecipe::Save(double wall_time_s, Checkpoint& checkpoint) const {
  learner_.Save(checkpoint);
  checkpoint.strings["metadata"] = Metadata(wall_time_s);
  if (inputs_.places.empty()) {
    checkpoint.tensors["weights"] = learner_.average().parameters.flat();
    return;
  }
  const auto all = WithStyles(*inputs_.init->generator, learner_.average(), inputs_.places,
                              learner_.mean(), learner_.deviation());
  checkpoint.tensors["weights"] = all->parameters.flat();
}

// Contents are inputs by their places, so those of `init` must be the manifest's. Weights without
// them can be given some.
Status CheckInitContents(const Config& config, const LoadedWeights& init,
                         const clip::Manifest& manifest) {
  const auto found =
      nlohmann::json::parse(init.metadata).at("contents").get<std::vector<std::string>>();
  if (found.empty() || (config.content_input && found == manifest.contents)) return Status::Ok();
  if (!config.content_input) {
    return Status::Error("--init " + config.init.string() +
                         ": takes contents as input; give --content-input 1");
  }
  const auto list = [](const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
    return text;
  };
  return Status::Error("--init " + config.init.string() + ": contents: found " + list(found) +
                       "; expected the manifest's: " + list(manifest.contents));
}

// The statistics and parameters of `init`, which must fit the flags.
Status UseInit(const Config& config, Inputs& inputs) {
  Result<LoadedWeights> loaded = ReadWeights(config.init);
  if (!loaded.ok()) return Status::Error("--init " + loaded.status().message());
  const LoadedWeights& init = inputs.init.emplace(std::move(loaded.value()));
  const Status contents = CheckInitContents(config, init, inputs.data.manifest);
  if (!contents.ok()) return contents;
  inputs.shape = init.generator->shape;
  if (init.features.rate_hz != inputs.parameters.rate_hz ||
      init.features.heading_tau_s != inputs.parameters.heading_tau_s) {
    return Status::Error("--init " + config.init.string() +
                         ": has another rate or heading filter than --rate and --heading-tau");
  }
  std::copy_n(init.mean.data_ptr<float>(), erd::kFeatureCount, inputs.statistics.mean.begin());
  std::copy_n(init.deviation.data_ptr<float>(), erd::kFeatureCount,
              inputs.statistics.deviation.begin());
  return Status::Ok();
}

Result<Inputs> ReadInputs(const RunConfig& run, const Config& config) {
  Inputs inputs;
  if (config.wide) inputs.shape = GeneratorShape::Of(erd::kWide);
  inputs.parameters.rate_hz = static_cast<float>(config.rate_hz);
  inputs.parameters.heading_tau_s = static_cast<float>(config.heading_tau_s);
  Result<TrainingData> data =
      LoadTrainingData(run.manifest, run.data, inputs.parameters, config.window + 1);
  if (!data.ok()) return data.status();
  inputs.data = std::move(data.value());
  if (config.init.empty()) {
    inputs.statistics = ComputeStatistics(inputs.data.train, inputs.parameters);
  } else {
    const Status used = UseInit(config, inputs);
    if (!used.ok()) return used;
  }
  SetHemisphere(inputs.statistics.mean, inputs.parameters);
  if (config.add_styles.empty()) return inputs;
  if (!inputs.init) return Status::Error("add-style: give --init, the weights to add to");
  Result<std::vector<int64_t>> places =
      PlacesOfAdded(config, run.manifest, inputs.data.manifest, *inputs.init);
  if (!places.ok()) return places.status();
  inputs.places = std::move(places.value());
  return inputs;
}

}  // namespace

Result<std::unique_ptr<Recipe>> MakeRecipe(const RunConfig& run, const Config& config) {
  return MakeChecked(run, Check(config), [&]() -> Result<std::unique_ptr<Recipe>> {
    Result<Inputs> inputs = ReadInputs(run, config);
    if (!inputs.ok()) return inputs.status();
    SeedTorch(run);
    auto recipe = std::make_unique<StyleErdRecipe>(run, config, std::move(inputs.value()));
    const Status taught = recipe->AddTeachers();
    if (!taught.ok()) return taught;
    return std::unique_ptr<Recipe>(std::move(recipe));
  });
}

Status ExportWeights(const Checkpoint& checkpoint, const std::filesystem::path& file) {
  try {
    const std::string& metadata = checkpoint.strings.at("metadata");
    const Result<GeneratorShape> shape = ShapeFromJson(metadata);
    if (!shape.ok()) return shape.status();
    const Tensor& mean = checkpoint.tensors.at("mean");
    const Tensor& deviation = checkpoint.tensors.at("deviation");
    Generator generator(shape.value(), mean, deviation);
    const torch::NoGradGuard no_grad;
    generator.parameters.flat().copy_(checkpoint.tensors.at("weights"));
    return WriteWeights(generator, mean, deviation, metadata, file);
  } catch (const std::exception& failure) {
    return Status::Error(Reason(failure));
  }
}

}  // namespace styled::train::style_erd
