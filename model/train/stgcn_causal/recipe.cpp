#include "model/train/stgcn_causal/recipe.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>
#include <utility>

#include "model/net/load.h"
#include "model/net/stgcn/network.h"
#include "model/net/weights_file.h"
#include "model/train/checkpoint.h"
#include "model/train/device.h"
#include "model/train/stgcn/monitor.h"
#include "model/train/stgcn/read_generator.h"
#include "model/train/stgcn_causal/learner.h"
#include "model/train/stgcn_causal/monitor.h"
#include "model/train/stgcn_causal/published_form.h"
#include "model/train/stgcn_causal/single_codes.h"

namespace styled::train::st_gcn_causal {
namespace {

constexpr int kFewestFrames = st_gcn::kWindowFrames / 2;  // of a clip: half a window is repeated
constexpr int kMonitorHop = 16;

// The data that a run reads before its first random number.
struct Inputs {
  st_gcn::LoadedGenerator teacher;
  TrainingData data;
  std::vector<int64_t> styles;  // of each style of the manifest, the teacher's
  torch::Tensor singles;        // of the teacher's styles (single_codes.h)
};

class CausalRecipe : public Recipe {
 public:
  CausalRecipe(const RunConfig& run, const Config& config, Inputs inputs)
      : run_(run),
        config_(config),
        inputs_(std::move(inputs)),
        teacher_(*inputs_.teacher.generator, inputs_.teacher.codes, inputs_.singles,
                 DeviceOf(run_)),
        kinematics_(inputs_.teacher.statistics, DeviceOf(run_)),
        train_(inputs_.data.train, inputs_.teacher.statistics, inputs_.teacher.parameters,
               config_.hop),
        validation_(inputs_.data.validation, inputs_.teacher.statistics, inputs_.teacher.parameters,
                    kMonitorHop),
        form_(inputs_.teacher.statistics),
        learner_(config_, run_.seed, train_, inputs_.styles, contents(), teacher_, form_,
                 inputs_.teacher.parameters.rate_hz, DeviceOf(run_)),
        windows_(train_, validation_, inputs_.data.manifest.styles, contents(), kinematics_,
                 DeviceOf(run_)),
        monitor_(windows_, kinematics_, inputs_.styles, teacher_) {}

  Status CheckData() const;

  std::string_view family() const override { return kFamily; }
  Status Start() override {
    std::cout << windows_.reals() << monitor_.teacher() << std::endl;
    learner_.Start();
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
    return st_gcn_causal::ExportWeights(checkpoint, file);
  }

 private:
  int contents() const { return static_cast<int>(inputs_.data.manifest.contents.size()); }
  std::string Metadata(double wall_time_s) const;

  const RunConfig run_;
  const Config config_;
  const Inputs inputs_;
  const Teacher teacher_;
  const st_gcn::Kinematics kinematics_;
  const st_gcn::WindowStore train_, validation_;
  const PublishedForm form_;
  Learner learner_;
  const st_gcn::Monitor windows_;
  const st_gcn_causal::Monitor monitor_;
};

Status CausalRecipe::CheckData() const {
  if (learner_.HasAllStyles()) return Status::Ok();
  return Status::Error("manifest " + inputs_.data.manifest.name +
                       ": every style needs training clips of half a window, 32 frames");
}

std::string CausalRecipe::Metadata(double wall_time_s) const {
  net::Model model = inputs_.teacher.model;
  model.family = kFamily;
  for (net::StyleInfo& style : model.styles) style.recognized = 0;  // that was the teacher's
  model.training = nlohmann::json{{"command", run_.command},
                                  {"data", inputs_.data.manifest.name},
                                  {"seed", run_.seed},
                                  {"iterations", learner_.iteration()},
                                  {"wall_time_s", std::round(wall_time_s)},
                                  {"from", nlohmann::json::parse(model.training)}}
                       .dump();
  const st_gcn::Shape& shape = learner_.average().shape;
  nlohmann::json header = net::HeaderOf(model);
  header["heading_tau_s"] = inputs_.teacher.parameters.heading_tau_s;
  header["width"] = shape.width;
  header["code"] = shape.code;
  header["noise"] = stgcn::kNoise;
  header["window"] = stgcn::kReference;
  header["contents"] = inputs_.data.manifest.contents;
  header["spacing"] = kSpacing;
  header["memory"] = static_cast<int>(kMemory);
  header["start_frames"] = static_cast<int>(kStartFrames);
  return header.dump();
}

void CausalRecipe::Save(double wall_time_s, Checkpoint& checkpoint) const {
  learner_.Save(checkpoint);
  checkpoint.tensors["mean"] = kinematics_.mean();
  checkpoint.tensors["deviation"] = kinematics_.deviation();
  for (const auto& [name, tensor] : inputs_.teacher.space) {
    checkpoint.tensors[std::string(kTeachers) + name] = tensor;
  }
  checkpoint.strings["metadata"] = Metadata(wall_time_s);
}

// The manifest's styles among the teacher's: the same ones, neutral first in both.
Result<std::vector<int64_t>> MatchStyles(const clip::Manifest& manifest,
                                         const net::Styles& teacher) {
  std::vector<int64_t> styles;
  for (const clip::ManifestStyle& style : manifest.styles) {
    const auto found = std::find_if(teacher.begin(), teacher.end(),
                                    [&style](const auto& one) { return one.name == style.name; });
    if (found == teacher.end()) {
      return Status::Error("has no style '" + style.name + "', which manifest " + manifest.name +
                           " has");
    }
    styles.push_back(found - teacher.begin());
  }
  for (std::size_t style = 0; style < teacher.size(); ++style) {
    if (std::find(styles.begin(), styles.end(), static_cast<int64_t>(style)) != styles.end()) {
      continue;
    }
    return Status::Error("has the style '" + teacher[style].name + "', which manifest " +
                         manifest.name + " has not");
  }
  return styles;
}

Result<Inputs> ReadInputs(const RunConfig& run, const Config& config) {
  Inputs inputs;
  Result<st_gcn::LoadedGenerator> teacher = st_gcn::ReadGenerator(config.init);
  if (!teacher.ok()) return Status::Error("--init " + teacher.status().message());
  inputs.teacher = std::move(teacher.value());
  erd::FeatureParameters reading;  // of the clips: their rate, and which frames are still
  reading.rate_hz = inputs.teacher.parameters.rate_hz;
  reading.heading_tau_s = inputs.teacher.parameters.heading_tau_s;
  Result<TrainingData> data = LoadTrainingData(run.manifest, run.data, reading, kFewestFrames);
  if (!data.ok()) return data.status();
  inputs.data = std::move(data.value());
  Result<std::vector<int64_t>> styles =
      MatchStyles(inputs.data.manifest, inputs.teacher.model.styles);
  if (!styles.ok()) {
    return Status::Error("--init " + config.init.string() + ": " + styles.status().message());
  }
  inputs.styles = std::move(styles.value());
  const auto whole = net::LoadAny(config.init);
  if (!whole.ok()) return Status::Error("--init " + whole.status().message());
  inputs.singles = SingleCodes(*whole.value().clips, inputs.data.train, inputs.styles,
                               config.single_codes, run.seed);
  return inputs;
}

}  // namespace

Result<std::unique_ptr<Recipe>> MakeRecipe(const RunConfig& run, const Config& config) {
  return MakeChecked(run, Check(config), [&]() -> Result<std::unique_ptr<Recipe>> {
    Result<Inputs> inputs = ReadInputs(run, config);
    if (!inputs.ok()) return inputs.status();
    SeedTorch(run);
    auto recipe = std::make_unique<CausalRecipe>(run, config, std::move(inputs.value()));
    const Status data = recipe->CheckData();
    if (!data.ok()) return data;
    return std::unique_ptr<Recipe>(std::move(recipe));
  });
}

}  // namespace styled::train::st_gcn_causal
