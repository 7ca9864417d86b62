#include "model/train/trainer.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iostream>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include "model/base/text.h"
#include "model/net/erd/network.h"
#include "model/train/checkpoint.h"
#include "model/train/curve.h"
#include "model/train/erd/learner.h"
#include "model/train/erd/monitor.h"

namespace styled::train {
namespace {

using torch::Tensor;
using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Appends to a CSV file; the header goes first where the file is new or its columns were others.
void AppendRow(const std::filesystem::path& file, const std::string& header,
               const std::string& row) {
  std::string present;
  std::getline(std::ifstream(file), present);
  std::ofstream out(file, std::ios::app);
  if (present != header) out << header << '\n';
  out << row << '\n';
}

// STYLE[/CONTENT][*GAIN],...
Result<std::vector<Lesson>> ParseLessons(const std::string& text) {
  std::vector<Lesson> lessons;
  std::istringstream list(text + ',');  // so that nothing after a comma, or at all, is a part, too
  for (std::string part; std::getline(list, part, ',');) {
    if (part.empty()) return Status::Error("found no style in \"" + text + "\"");
    Lesson lesson;
    const std::size_t star = part.find('*');
    if (star != std::string::npos) {
      const char* const first = part.data() + star + 1;
      const char* const last = part.data() + part.size();
      const auto [end, error] = std::from_chars(first, last, lesson.gain);
      if (error != std::errc() || end != last || !(lesson.gain > 0 && lesson.gain <= 10)) {
        return Status::Error("found the gain \"" + part.substr(star + 1) + "\" in \"" + part +
                             "\", expected a number above 0, at most 10");
      }
      part.resize(star);
    }
    const std::size_t slash = part.find('/');
    if (slash != std::string::npos) {
      lesson.content = part.substr(slash + 1);
      if (lesson.content.empty()) {
        return Status::Error("found no content after the / of \"" + part + "\"");
      }
    }
    lesson.style = part.substr(0, slash);
    lessons.push_back(std::move(lesson));
  }
  return lessons;
}

// What add-style needs: a manifest of neutral and the styles, and weights that lack them or whose
// own are replaced. The places that the manifest's styles but neutral will have in the weights.
Result<std::vector<int64_t>> PlacesOfAdded(const TrainConfig& config,
                                           const clip::Manifest& manifest,
                                           const LoadedWeights& init) {
  std::string found, wanted;
  for (const clip::ManifestStyle& style : manifest.styles) found += " \"" + style.name + "\"";
  for (const std::string& name : config.add_styles) wanted += " and \"" + name + "\"";
  bool same = manifest.styles.size() == config.add_styles.size() + 1;
  for (std::size_t i = 1; same && i < manifest.styles.size(); ++i) {
    same = std::count(config.add_styles.begin(), config.add_styles.end(),
                      manifest.styles[i].name) == 1;
  }
  if (!same) {
    return Status::Error(config.manifest.string() + ": styles: found" + found +
                         ", expected the neutral style" + wanted);
  }
  std::vector<int64_t> places;
  auto behind = static_cast<int64_t>(init.styles.size());
  for (std::size_t i = 1; i < manifest.styles.size(); ++i) {
    const std::string& name = manifest.styles[i].name;
    const auto own = std::find(init.styles.begin(), init.styles.end(), name);
    if (own != init.styles.end() && !config.replace) {
      return Status::Error("add-style: " + config.init.string() + " already has a style \"" + name +
                           "\"; --replace learns it anew");
    }
    places.push_back(own != init.styles.end() ? own - init.styles.begin() : behind++);
  }
  if (behind > static_cast<int64_t>(net::kMaxStyles)) {
    return Status::Error("add-style: " + config.init.string() + " has " +
                         std::to_string(init.styles.size()) + " styles and would have " +
                         std::to_string(behind) + ", more than the " +
                         std::to_string(net::kMaxStyles) + " there can be");
  }
  return places;
}

// A run: a learner with a clock, a log and a folder.
class Trainer {
 public:
  Trainer(const TrainConfig& config, const clip::Manifest& manifest,
          const std::vector<TrainingClip>& clips, const std::vector<TrainingClip>& validation,
          const FeatureStatistics& statistics, const erd::FeatureParameters& parameters,
          const LoadedWeights* init, std::vector<int64_t> places, const Validate& validate,
          const torch::Device& device)
      : config_(config),
        validate_(validate),
        manifest_(manifest),
        init_(init),
        places_(std::move(places)),
        learner_(config, manifest, clips, statistics, parameters, device),
        monitor_(validation, static_cast<int>(manifest.styles.size()),
                 static_cast<int>(manifest.contents.size()), parameters, learner_.mean(),
                 learner_.deviation()) {}

  // Trains the classifier, or reads the checkpoint, then trains until the run's (or session's) end.
  // A new run starts from `init` where there is one.
  Status Run();

 private:
  Status Save();
  Status Restore();
  double Progress() const;
  double Elapsed() const { return elapsed_before_s_ + SecondsSince(started_); }
  void Log(int count, double seconds, double progress);
  void LogMonitor();
  std::string Metadata() const;

  // Judges the weights that Save wrote. `ended`: the run has not become better for too long.
  Status RunValidation(bool& ended);

  const TrainConfig& config_;
  const Validate& validate_;
  const clip::Manifest& manifest_;
  const LoadedWeights* const init_;
  const std::vector<int64_t> places_;  // of added styles in the weights
  Learner learner_;
  Monitor monitor_;
  double best_score_ = -std::numeric_limits<double>::infinity();
  int without_better_ = 0;
  double elapsed_before_s_ = 0;
  Clock::time_point started_ = Clock::now();
};

double Trainer::Progress() const {
  double progress = 0;
  if (config_.iterations > 0) {
    progress = static_cast<double>(learner_.iteration()) / static_cast<double>(config_.iterations);
  }
  if (config_.minutes > 0) progress = std::max(progress, Elapsed() / (60.0 * config_.minutes));
  return progress;
}

void Trainer::Log(int count, double seconds, double progress) {
  const auto means = learner_.tally().Take(count);
  std::ostringstream header, row;
  header << "iteration,elapsed_s,progress";
  row << learner_.iteration() << ',' << Elapsed() << ',' << progress;
  std::cout << learner_.iteration() << ": ";
  for (const auto& [name, mean] : means) {
    header << ',' << name;
    row << ',' << mean;
    std::cout << name << ' ' << mean << "  ";
  }
  AppendRow(config_.out / "log.csv", header.str(), row.str());
  const double remaining_s = progress > 0 ? Elapsed() * (1.0 - progress) / progress : 0;
  std::cout << "| " << count / seconds << " it/s, " << static_cast<int>(remaining_s / 60)
            << " min left" << std::endl;
}

void Trainer::LogMonitor() {
  const MonitorRow figures = monitor_.Evaluate(learner_.average());
  std::ostringstream header, row;
  header << "iteration,elapsed_s,reconstruction_deg";
  row << learner_.iteration() << ',' << Elapsed() << ',' << figures.reconstruction_deg;
  std::cout << "monitor " << learner_.iteration() << ": rec " << figures.reconstruction_deg
            << " deg";
  const auto add = [&](const std::string& figure, const std::vector<double>& values) {
    std::cout << " | " << figure;
    for (std::size_t i = 0; i < values.size(); ++i) {
      header << ',' << figure << '_' << manifest_.styles[i + 1].name;
      row << ',' << values[i];
      std::cout << ' ' << std::round(values[i] * 100) / 100;
    }
  };
  add("expression", figures.expression);
  add("cosine", figures.cosine);
  add("jerk_ratio", figures.jerk_ratio);
  std::cout << std::endl;
  AppendRow(config_.out / "monitor.csv", header.str(), row.str());
}

std::string Trainer::Metadata() const {
  nlohmann::json run{{"command", config_.command},
                     {"data", manifest_.name},
                     {"seed", config_.seed},
                     {"iterations", learner_.iteration()},
                     {"wall_time_s", std::round(Elapsed())}};
  const bool adding = !places_.empty();
  if (init_ != nullptr && !adding) run["from"] = nlohmann::json::parse(init_->metadata)["training"];
  const std::string training = run.dump();
  if (adding) {
    const std::vector<clip::ManifestStyle> added(manifest_.styles.begin() + 1,
                                                 manifest_.styles.end());
    return WithStyles(init_->metadata, added, places_, training);
  }
  WeightsMetadata metadata;
  for (const clip::ManifestStyle& style : manifest_.styles) {
    metadata.styles.emplace_back(style.name, style.aliases);
  }
  metadata.rate_hz = config_.rate_hz;
  metadata.heading_tau_s = config_.heading_tau_s;
  metadata.licence = manifest_.licence;
  metadata.training = training;
  return metadata.ToJson(learner_.average().shape);
}

Status Trainer::Save() {
  Checkpoint checkpoint;
  learner_.Save(checkpoint);
  std::unique_ptr<Generator> all;
  if (!places_.empty()) {
    all = WithStyles(*init_->generator, learner_.average(), places_, learner_.mean(),
                     learner_.deviation());
  }
  const Generator& weights = all ? *all : learner_.average();
  checkpoint.tensors["weights"] = weights.parameters.flat();  // what is exported
  checkpoint.tensors["best"] =
      torch::tensor({best_score_, static_cast<double>(without_better_)}, torch::kFloat64);
  checkpoint.tensors["elapsed_s"] = torch::tensor({Elapsed()}, torch::kFloat64);
  checkpoint.strings["metadata"] = Metadata();
  const Status written = WriteCheckpoint(checkpoint, config_.out / "checkpoint.pt");
  if (!written.ok()) return written;
  return WriteWeights(weights, learner_.mean(), learner_.deviation(), Metadata(),
                      config_.out / "weights.safetensors");
}

Status Trainer::Restore() {
  const std::filesystem::path file = config_.out / "checkpoint.pt";
  Checkpoint checkpoint;
  const Status read = ReadCheckpoint(file, checkpoint);
  if (!read.ok()) return read;
  const Status restored = learner_.Restore(checkpoint);
  if (!restored.ok()) return Status::Error(file.string() + ": " + restored.message());
  elapsed_before_s_ = checkpoint.tensors.at("elapsed_s").item<double>();
  best_score_ = checkpoint.tensors.at("best")[0].item<double>();
  without_better_ = static_cast<int>(checkpoint.tensors.at("best")[1].item<double>());
  return Status::Ok();
}

Status Trainer::RunValidation(bool& ended) {
  const std::filesystem::path weights = config_.out / "weights.safetensors";
  const auto figures = validate_(weights);
  if (!figures.ok()) return figures.status();
  std::ostringstream header;
  std::ostringstream row;
  header << "iteration,elapsed_s";
  row << learner_.iteration() << ',' << Elapsed();
  std::cout << "validation " << learner_.iteration() << ":";
  for (const auto& [name, value] : figures.value()) {
    header << ',' << name;
    row << ',' << value;
    std::cout << "  " << name << ' ' << value;
  }
  const double score = figures.value().front().second;
  const bool better = score > best_score_;
  std::cout << (better ? "  (best so far)" : "") << std::endl;
  AppendRow(config_.out / "validation.csv", header.str(), row.str());
  without_better_ = better ? 0 : without_better_ + 1;
  ended = config_.patience > 0 && without_better_ >= config_.patience;
  if (better) {
    best_score_ = score;
    std::error_code error;
    std::filesystem::copy_file(weights, config_.out / "best.safetensors",
                               std::filesystem::copy_options::overwrite_existing, error);
    if (error)
      return Status::Error((config_.out / "best.safetensors").string() + ": " + error.message());
  }
  const Status drawn = DrawCurve(config_.out / "validation.csv", config_.out / "curve.svg");
  return drawn.ok() ? Save() : drawn;  // a resumed run must know its best score
}

Status Trainer::Run() {
  if (init_ != nullptr && !config_.resume) {
    const Status adopted = learner_.Adopt(*init_);
    if (!adopted.ok()) {
      return Status::Error("--init " + config_.init.string() + ": " + adopted.message());
    }
  }
  if (config_.idle > 0) {
    const Status idle = learner_.ExpectIdle();
    if (!idle.ok()) return idle;
  }
  for (const std::string& given : config_.teachers) {
    // A path may have a colon, too.
    const std::size_t colon = std::filesystem::exists(given) ? std::string::npos : given.rfind(':');
    Result<std::vector<Lesson>> lessons = std::vector<Lesson>();
    if (colon != std::string::npos) lessons = ParseLessons(given.substr(colon + 1));
    if (!lessons.ok()) {
      return Status::Error("--teacher " + given + ": " + lessons.status().message());
    }
    const Result<LoadedWeights> teacher = ReadWeights(given.substr(0, colon));
    if (!teacher.ok()) return Status::Error("--teacher " + teacher.status().message());
    const Status fits = learner_.LearnFrom(teacher.value(), lessons.value());
    if (!fits.ok()) return Status::Error("--teacher " + given + ": " + fits.message());
  }
  if (config_.resume) {
    const Status restored = Restore();
    if (!restored.ok()) return restored;
  } else {
    learner_.TrainClassifier();
  }
  started_ = Clock::now();
  auto last_log = Clock::now();
  auto last_save = Clock::now();
  auto last_validation = Clock::now();
  int logged = 0;
  for (;;) {
    const double progress = Progress();
    if (progress >= 1.0 || (config_.stop_at > 0 && learner_.iteration() >= config_.stop_at)) break;
    learner_.Step(progress);
    ++logged;
    if (learner_.iteration() % config_.log_every == 0) {
      Log(logged, SecondsSince(last_log), progress);
      logged = 0;
      last_log = Clock::now();
      if (!learner_.Finite()) {
        return Status::Error("iteration " + std::to_string(learner_.iteration()) +
                             ": a weight is no longer finite; the last checkpoint is kept");
      }
    }
    if (learner_.iteration() % config_.monitor_every == 0) LogMonitor();
    if (SecondsSince(last_save) > 60.0 * config_.checkpoint_minutes) {
      const Status saved = Save();
      if (!saved.ok()) return saved;
      last_save = Clock::now();
    }
    if (validate_ && SecondsSince(last_validation) > 60.0 * config_.validate_minutes) {
      const Status saved = Save();
      if (!saved.ok()) return saved;
      bool ended = false;
      const Status validated = RunValidation(ended);
      if (!validated.ok()) return validated;
      last_validation = Clock::now();
      if (ended) {
        std::cout << "no better score in " << config_.patience << " validations: the run ends"
                  << std::endl;
        return Status::Ok();
      }
    }
  }
  if (learner_.iteration() % config_.monitor_every != 0) LogMonitor();
  const Status saved = Save();
  if (!saved.ok() || !validate_) return saved;
  bool ended = false;
  return RunValidation(ended);
}

}  // namespace

Status Train(const TrainConfig& config, const Validate& validate) {
  // 1. What cannot work is refused before anything is read.
  if (config.minutes <= 0 && config.iterations <= 0) {
    return Status::Error("give --minutes or --iterations");
  }
  if (config.window < 4 || config.per_style < 1 || config.rate_hz <= 0) {
    return Status::Error("--window must be at least 4, --per-style 1, --rate above 0");
  }
  const std::pair<const char*, double> not_negative[] = {
      {"--minutes", config.minutes},
      {"--rate", config.rate_hz},
      {"--heading-tau", config.heading_tau_s},
      {"--carry", config.carry},
      {"--session-start", config.session_start},
      {"--offset", config.offset},
      {"--noise", config.noise},
      {"--miscalibrated", config.miscalibrated},
      {"--generator-rate", config.generator_rate},
      {"--critic-rate", config.critic_rate},
      {"--decay-from", config.decay_from},
      {"--decay-to", config.decay_to},
      {"--beta1", config.beta1},
      {"--beta2", config.beta2},
      {"--ema", config.ema},
      {"--smooth-from", config.smooth_from},
      {"--smooth-full", config.smooth_full},
      {"--checkpoint-minutes", config.checkpoint_minutes},
      {"--validate-minutes", config.validate_minutes},
      {"--w-rotation", config.w_rotation},
      {"--w-position", config.w_position},
      {"--w-velocity", config.w_velocity},
      {"--w-height", config.w_height},
      {"--w-adversarial", config.w_adversarial},
      {"--w-perceptual", config.w_perceptual},
      {"--w-penalty", config.w_penalty},
      {"--w-moments", config.w_moments},
      {"--w-teacher", config.w_teacher},
      {"--w-smooth", config.w_smooth}};
  if (!(config.idle >= 0 && config.idle < 1) || (config.idle > 0 && config.teachers.empty())) {
    return Status::Error("--idle: found " + NumberText(config.idle) +
                         ", expected 0, or below 1 and a --teacher");
  }
  for (const auto& [flag, value] : not_negative) {
    if (!(value >= 0 && std::isfinite(value))) {
      return Status::Error(std::string(flag) + ": found " + NumberText(value) +
                           ", expected a number, 0 or more");
    }
  }
  const Status folder = CheckDataFolder(config.data);
  if (!folder.ok()) return folder;
  const bool cuda =
      config.device == "cuda" || (config.device == "auto" && torch::cuda::is_available());
  if (cuda && !torch::cuda::is_available()) {
    return Status::Error("--device cuda: this libtorch sees no CUDA device");
  }
  std::error_code error;
  std::filesystem::create_directories(config.out, error);
  if (error) return Status::Error("--out " + config.out.string() + ": " + error.message());

  // 2. Data.
  Result<clip::Manifest> manifest = clip::LoadManifest(config.manifest, config.data);
  if (!manifest.ok()) return manifest.status();
  erd::FeatureParameters parameters;
  parameters.rate_hz = static_cast<float>(config.rate_hz);
  parameters.heading_tau_s = static_cast<float>(config.heading_tau_s);
  const auto begin = Clock::now();
  Result<std::vector<TrainingClip>> clips =
      LoadClips(manifest.value(), "train", parameters, config.window + 1);
  if (!clips.ok()) return clips.status();
  Result<std::vector<TrainingClip>> validation =
      LoadClips(manifest.value(), "validation", parameters, config.window + 1);
  if (!validation.ok()) return validation.status();
  std::optional<LoadedWeights> init;
  FeatureStatistics statistics;
  if (config.init.empty()) {
    statistics = ComputeStatistics(clips.value(), parameters);
  } else {
    Result<LoadedWeights> loaded = ReadWeights(config.init);
    if (!loaded.ok()) return Status::Error("--init " + loaded.status().message());
    init.emplace(std::move(loaded.value()));
    if (init->features.rate_hz != parameters.rate_hz ||
        init->features.heading_tau_s != parameters.heading_tau_s) {
      return Status::Error(
          "--init " + config.init.string() +
          ": has another rate or heading filter than --rate and --heading-tau say");
    }
    std::copy_n(init->mean.data_ptr<float>(), erd::kFeatureCount, statistics.mean.begin());
    std::copy_n(init->deviation.data_ptr<float>(), erd::kFeatureCount,
                statistics.deviation.begin());
  }
  SetHemisphere(statistics.mean, parameters);
  std::cout << clips.value().size() << " training clips, " << validation.value().size()
            << " validation clips, " << SecondsSince(begin) << " s" << std::endl;

  std::vector<int64_t> places;
  if (!config.add_styles.empty()) {
    if (!init) return Status::Error("add-style: give --init, the weights to add to");
    Result<std::vector<int64_t>> fits = PlacesOfAdded(config, manifest.value(), *init);
    if (!fits.ok()) return fits.status();
    places = std::move(fits.value());
  }

  // 3. Train.
  try {
    at::set_num_threads(config.threads);
    torch::manual_seed(config.seed);
    Trainer trainer(config, manifest.value(), clips.value(), validation.value(), statistics,
                    parameters, init ? &*init : nullptr, std::move(places), validate,
                    cuda ? torch::Device(torch::kCUDA) : torch::Device(torch::kCPU));
    return trainer.Run();
  } catch (const std::exception& failure) {
    return Status::Error(std::string("libtorch: ") + Reason(failure));
  }
}

Status ExportRun(const std::filesystem::path& run, const std::filesystem::path& file) {
  Checkpoint checkpoint;
  const std::filesystem::path source = run / "checkpoint.pt";
  const Status read = ReadCheckpoint(source, checkpoint);
  if (!read.ok()) return read;
  try {
    const std::string& metadata = checkpoint.strings.at("metadata");
    const Result<GeneratorShape> shape = ShapeFromJson(metadata);
    if (!shape.ok()) return shape.status();
    const Tensor& mean = checkpoint.tensors.at("mean");
    const Tensor& deviation = checkpoint.tensors.at("deviation");
    Generator generator(shape.value(), mean, deviation);
    torch::NoGradGuard no_grad;
    generator.parameters.flat().copy_(checkpoint.tensors.at("weights"));
    return WriteWeights(generator, mean, deviation, metadata, file);
  } catch (const std::exception& failure) {
    return Status::Error(source.string() + ": " + Reason(failure));
  }
}

}  // namespace styled::train
