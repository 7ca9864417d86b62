#include "model/train/stgcn/recipe.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>
#include <utility>

#include "model/net/weights_file.h"
#include "model/train/checkpoint.h"
#include "model/train/device.h"
#include "model/train/stgcn/learner.h"
#include "model/train/stgcn/monitor.h"

namespace styled::train::st_gcn {
namespace {

using torch::Tensor;

constexpr double kRate_hz = 30;
constexpr int kCodeHop = 16;  // frames between windows of a mean code
constexpr std::size_t kCodeBatch = 64;

// The data that a run reads before its first random number.
struct Inputs {
  TrainingData data;
  stgcn::FeatureParameters parameters;
  Statistics statistics;
};

// Contents that correspond to a single label.
std::vector<bool> SingleActs(const clip::Manifest& manifest) {
  std::vector<bool> single;
  for (const std::size_t labels : manifest.content_labels) single.push_back(labels == 1);
  return single;
}

class StGcnRecipe : public Recipe {
 public:
  StGcnRecipe(const RunConfig& run, const Config& config, Inputs inputs)
      : run_(run),
        config_(config),
        inputs_(std::move(inputs)),
        train_(inputs_.data.train, inputs_.statistics, inputs_.parameters, config_.hop),
        validation_(inputs_.data.validation, inputs_.statistics, inputs_.parameters, kCodeHop),
        learner_(config_, run_.seed, train_, inputs_.statistics, styles(), SingleActs(manifest()),
                 DeviceOf(run_)),
        monitor_(train_, validation_, manifest().styles, contents(), learner_.kinematics(),
                 DeviceOf(run_)) {}

  Status CheckData() const;

  std::string_view family() const override { return kFamily; }
  Status Start() override {
    std::cout << monitor_.reals() << std::endl;
    return Status::Ok();
  }
  void Step(double progress) override { learner_.Step(progress); }
  int64_t iteration() const override { return learner_.iteration(); }
  Figures PopLosses(int) override { return learner_.means().Pop(); }
  bool Finite() const override { return learner_.Finite(); }
  MonitorReport Monitor() const override {
    return monitor_.Evaluate(learner_.average(), learner_.graph());
  }
  void Save(double wall_time_s, Checkpoint& checkpoint) const override;
  Status Restore(const Checkpoint& checkpoint) override { return learner_.Restore(checkpoint); }
  Status ExportWeights(const Checkpoint& checkpoint,
                       const std::filesystem::path& file) const override {
    return st_gcn::ExportWeights(checkpoint, file);
  }

 private:
  const clip::Manifest& manifest() const { return inputs_.data.manifest; }
  int styles() const { return static_cast<int>(manifest().styles.size()); }
  int contents() const { return static_cast<int>(manifest().contents.size()); }
  Tensor MeanCodes() const;
  std::string Metadata(double wall_time_s) const;

  const RunConfig run_;
  const Config config_;
  const Inputs inputs_;
  const WindowStore train_, validation_;
  Learner learner_;
  const st_gcn::Monitor monitor_;
};

Status StGcnRecipe::CheckData() const {
  if (learner_.HasAllDomains()) return Status::Ok();
  return Status::Error("manifest " + manifest().name + ": every style needs training clips of " +
                       std::to_string(config_.fewest_frames) + " frames and more");
}

// The mean code of each style's training windows, by the running mean of the encoder.
Tensor StGcnRecipe::MeanCodes() const {
  const torch::NoGradGuard no_grad;
  const Encoder& encoder = learner_.average().encoder;
  const int64_t code = learner_.average().generator.shape.code;
  Tensor sum = torch::zeros({styles(), code}), count = torch::zeros({styles(), 1});
  std::vector<Window> windows;
  std::vector<int64_t> style;
  const auto encode = [&] {
    const Tensor label = torch::tensor(style, torch::kInt64);
    const Tensor x = train_.Read(windows).to(DeviceOf(run_));
    const Tensor codes = encoder.Code(encoder.Features(learner_.graph(), x), label.to(x.device()));
    sum.index_add_(0, label, codes.cpu());
    count.index_add_(0, label, torch::ones({label.size(0), 1}));
    windows.clear();
    style.clear();
  };
  for (int clip = 0; clip < train_.clips(); ++clip) {
    int next = train_.Starts(clip).front();
    for (const int start : train_.Starts(clip)) {
      if (start < next) continue;
      next = start + kCodeHop;
      windows.push_back({clip, start, false});
      style.push_back(train_.StyleOf(clip));
      if (windows.size() == kCodeBatch) encode();
    }
  }
  if (!windows.empty()) encode();
  return sum / count.clamp_min(1);
}

std::string StGcnRecipe::Metadata(double wall_time_s) const {
  net::Model model;
  model.family = kFamily;
  for (const clip::ManifestStyle& style : manifest().styles) {
    model.styles.push_back({style.name, style.aliases});
  }
  model.rate_hz = static_cast<float>(kRate_hz);
  model.licence = manifest().licence;
  model.training = nlohmann::json{{"command", run_.command},
                                  {"data", manifest().name},
                                  {"seed", run_.seed},
                                  {"iterations", learner_.iteration()},
                                  {"wall_time_s", std::round(wall_time_s)}}
                       .dump();
  const Shape& shape = learner_.average().generator.shape;
  nlohmann::json header = net::HeaderOf(model);
  header["heading_tau_s"] = config_.heading_tau_s;
  header["width"] = shape.width;
  header["code"] = shape.code;
  header["noise"] = shape.noise;
  header["window"] = kWindowFrames;
  header["contents"] = manifest().contents;
  header["normalization"] = config_.normalization;
  return header.dump();
}

void StGcnRecipe::Save(double wall_time_s, Checkpoint& checkpoint) const {
  learner_.Save(checkpoint);
  checkpoint.tensors["codes.mean"] = MeanCodes();
  checkpoint.strings["metadata"] = Metadata(wall_time_s);
}

Result<Inputs> ReadInputs(const RunConfig& run, const Config& config) {
  Inputs inputs;
  inputs.parameters.rate_hz = static_cast<float>(kRate_hz);
  inputs.parameters.heading_tau_s = static_cast<float>(config.heading_tau_s);
  erd::FeatureParameters reading;  // of the clips: their rate, and which frames are still
  reading.rate_hz = inputs.parameters.rate_hz;
  reading.heading_tau_s = inputs.parameters.heading_tau_s;
  Result<TrainingData> data =
      LoadTrainingData(run.manifest, run.data, reading, config.fewest_frames);
  if (!data.ok()) return data.status();
  inputs.data = std::move(data.value());
  inputs.statistics =
      ComputeStatistics(inputs.data.train, inputs.parameters, config.floor_deviations);
  stgcn::SetHemisphere(inputs.statistics.mean, inputs.parameters);
  return inputs;
}

}  // namespace

Result<std::unique_ptr<Recipe>> MakeRecipe(const RunConfig& run, const Config& config) {
  return MakeChecked(run, Check(config), [&]() -> Result<std::unique_ptr<Recipe>> {
    Result<Inputs> inputs = ReadInputs(run, config);
    if (!inputs.ok()) return inputs.status();
    SeedTorch(run);
    auto recipe = std::make_unique<StGcnRecipe>(run, config, std::move(inputs.value()));
    const Status data = recipe->CheckData();
    if (!data.ok()) return data;
    return std::unique_ptr<Recipe>(std::move(recipe));
  });
}

}  // namespace styled::train::st_gcn
