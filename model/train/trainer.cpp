#include "model/train/trainer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iostream>
#include <limits>
#include <sstream>

#include "model/base/text.h"
#include "model/train/checkpoint.h"
#include "model/train/curve.h"
#include "model/train/dataset.h"
#include "model/train/measure.h"
#include "model/train/stop.h"

namespace styled::train {
namespace {

using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Appends to a CSV file; the header is written first if the file is new or had other columns.
void AppendRow(const std::filesystem::path& file, const std::string& header,
               const std::string& row) {
  std::string present;
  std::getline(std::ifstream(file), present);
  std::ofstream out(file, std::ios::app);
  if (present != header) out << header << '\n';
  out << row << '\n';
}

// A row whose first columns are named in `lead`, with `values`, and then the figures.
void AppendFigures(const std::filesystem::path& file, const std::string& lead,
                   const std::string& values, const Figures& figures) {
  std::ostringstream header;
  std::ostringstream row;
  header << lead;
  row << values;
  for (const auto& [name, value] : figures) {
    header << ',' << name;
    row << ',' << value;
  }
  AppendRow(file, header.str(), row.str());
}

// One session of a run: the recipe with a clock, a log and a folder.
class Session {
 public:
  Session(const RunConfig& run, Recipe& recipe, const Validate& validate)
      : run_(run), recipe_(recipe), validate_(validate) {}

  // Starts or resumes the run, then trains until the end of the run or of the session.
  Status Run();

 private:
  Status Begin();
  Status Restore();
  bool Over(double progress) const;
  Status AfterStep(double progress);  // everything that is due
  Status SaveAndSay();                // after a signal
  Status Log(double progress);
  void LogMonitor();
  Status Save();
  Status ValidateNow();

  double Progress() const;
  double Elapsed() const { return elapsed_before_s_ + SecondsSince(started_); }
  std::string IterationAndTime() const;

  const RunConfig& run_;
  Recipe& recipe_;
  const Validate& validate_;
  double best_score_ = -std::numeric_limits<double>::infinity();
  int without_better_ = 0;  // validations since the best
  bool out_of_patience_ = false;
  double elapsed_before_s_ = 0;  // of earlier sessions
  int since_log_ = 0;            // iterations
  PaceMeter pace_;
  Clock::time_point started_ = Clock::now();
  Clock::time_point last_log_, last_save_, last_validation_;
};

double Session::Progress() const {
  double progress = 0;
  if (run_.iterations > 0) {
    progress = static_cast<double>(recipe_.iteration()) / static_cast<double>(run_.iterations);
  }
  if (run_.minutes > 0) progress = std::max(progress, Elapsed() / (60.0 * run_.minutes));
  return progress;
}

std::string Session::IterationAndTime() const {
  std::ostringstream text;
  text << recipe_.iteration() << ',' << Elapsed();
  return text.str();
}

Status Session::Log(double progress) {
  const double seconds = SecondsSince(last_log_);
  const Figures losses = recipe_.PopLosses(since_log_);
  std::ostringstream values;
  values << IterationAndTime() << ',' << progress;
  AppendFigures(run_.out / "log.csv", "iteration,elapsed_s,progress", values.str(), losses);

  std::cout << recipe_.iteration() << ": ";
  for (const auto& [name, mean] : losses) std::cout << name << ' ' << mean << "  ";
  const double remaining_s = progress > 0 ? Elapsed() * (1.0 - progress) / progress : 0;
  std::cout << "| " << since_log_ / seconds << " it/s, " << static_cast<int>(remaining_s / 60)
            << " min left" << std::endl;
  since_log_ = 0;
  last_log_ = Clock::now();
  if (recipe_.Finite()) return Status::Ok();
  return Status::Error("iteration " + std::to_string(recipe_.iteration()) +
                       ": a weight is no longer finite; the last checkpoint is kept");
}

void Session::LogMonitor() {
  const MonitorReport report = recipe_.Monitor();
  std::cout << "monitor " << recipe_.iteration() << ": " << report.summary << std::endl;
  AppendFigures(run_.out / "monitor.csv", "iteration,elapsed_s", IterationAndTime(),
                report.figures);
}

Status Session::Save() {
  Checkpoint checkpoint;
  recipe_.Save(Elapsed(), checkpoint);
  checkpoint.strings["family"] = recipe_.family();
  checkpoint.tensors["best"] =
      torch::tensor({best_score_, static_cast<double>(without_better_)}, torch::kFloat64);
  checkpoint.tensors["elapsed_s"] = torch::tensor({Elapsed()}, torch::kFloat64);
  const Status written = WriteCheckpoint(checkpoint, run_.out / "checkpoint.pt");
  if (!written.ok()) return written;
  last_save_ = Clock::now();
  return recipe_.ExportWeights(checkpoint, run_.out / "weights.safetensors");
}

Status Session::Restore() {
  const std::filesystem::path file = run_.out / "checkpoint.pt";
  Checkpoint checkpoint;
  const Status read = ReadCheckpoint(file, checkpoint);
  if (!read.ok()) return read;
  const auto refuse = [&file](const std::string& why) {
    return Status::Error(file.string() + ": " + why);
  };
  const std::string family = FamilyOf(checkpoint);
  if (family != recipe_.family()) {
    return refuse("found a run of the family \"" + family + "\", expected \"" +
                  std::string(recipe_.family()) + "\"");
  }
  const Status restored = recipe_.Restore(checkpoint);
  if (!restored.ok()) return refuse(restored.message());
  elapsed_before_s_ = checkpoint.tensors.at("elapsed_s").item<double>();
  best_score_ = checkpoint.tensors.at("best")[0].item<double>();
  without_better_ = static_cast<int>(checkpoint.tensors.at("best")[1].item<double>());
  return Status::Ok();
}

Status Session::ValidateNow() {
  const std::filesystem::path weights = run_.out / "weights.safetensors";
  const Result<Figures> figures = validate_(weights);
  if (!figures.ok()) return figures.status();
  const double score = figures.value().front().second;
  const bool better = score > best_score_;
  std::cout << "validation " << recipe_.iteration() << ":";
  for (const auto& [name, value] : figures.value()) std::cout << "  " << name << ' ' << value;
  std::cout << (better ? "  (best so far)" : "") << std::endl;
  const std::filesystem::path table = run_.out / "validation.csv";
  AppendFigures(table, "iteration,elapsed_s", IterationAndTime(), figures.value());

  without_better_ = better ? 0 : without_better_ + 1;
  out_of_patience_ = run_.patience > 0 && without_better_ >= run_.patience;
  if (better) {
    best_score_ = score;
    const std::filesystem::path best = run_.out / "best.safetensors";
    std::error_code error;
    std::filesystem::copy_file(weights, best, std::filesystem::copy_options::overwrite_existing,
                               error);
    if (error) return Status::Error(best.string() + ": " + error.message());
  }
  last_validation_ = Clock::now();
  const Status drawn = DrawCurve(table, run_.out / "curve.svg");
  return drawn.ok() ? Save() : drawn;  // a resumed run must know its best score
}

bool Session::Over(double progress) const {
  return progress >= 1.0 || (run_.stop_at > 0 && recipe_.iteration() >= run_.stop_at);
}

Status Session::Begin() {
  const Status begun = run_.resume ? Restore() : recipe_.Start();
  started_ = last_log_ = last_save_ = last_validation_ = Clock::now();
  return begun;
}

Status Session::AfterStep(double progress) {
  ++since_log_;
  if (pace_.AfterIteration(Clock::now())) {
    std::cout << "measured: "
              << PaceText(run_, validate_ != nullptr, pace_.per_minute(), PeakMemory_mb())
              << std::endl;
  }
  if (recipe_.iteration() % run_.log_every == 0) {
    const Status logged = Log(progress);
    if (!logged.ok()) return logged;
  }
  if (recipe_.iteration() % run_.monitor_every == 0) LogMonitor();
  const bool validate = validate_ && SecondsSince(last_validation_) > 60.0 * run_.validate_minutes;
  if (validate || SecondsSince(last_save_) > 60.0 * run_.checkpoint_minutes) {
    const Status saved = Save();
    if (!saved.ok()) return saved;
  }
  return validate ? ValidateNow() : Status::Ok();
}

Status Session::SaveAndSay() {
  const Status saved = Save();
  if (!saved.ok()) return saved;
  std::cout << "stopped by a signal at iteration " << recipe_.iteration() << "; "
            << (run_.out / "checkpoint.pt").string()
            << " is written. To go on: the same flags and --resume" << std::endl;
  return Status::Ok();
}

Status Session::Run() {
  const Status begun = Begin();
  if (!begun.ok()) return begun;
  const StopOnSignal stop;  // before, there is nothing to save
  for (double progress = Progress(); !Over(progress); progress = Progress()) {
    recipe_.Step(progress);
    const Status status = AfterStep(progress);
    if (!status.ok()) return status;
    if (StopSignal() != 0) return SaveAndSay();
    if (out_of_patience_) {
      std::cout << "no better score in " << run_.patience << " validations: the run ends"
                << std::endl;
      return Status::Ok();
    }
  }
  if (recipe_.iteration() % run_.monitor_every != 0) LogMonitor();
  const Status saved = Save();
  return saved.ok() && validate_ ? ValidateNow() : saved;
}

}  // namespace

Status CheckRun(const RunConfig& run) {
  for (const auto& [flag, value] : {std::pair{"--minutes", run.minutes},
                                    {"--checkpoint-minutes", run.checkpoint_minutes},
                                    {"--validate-minutes", run.validate_minutes}}) {
    if (!(value >= 0 && std::isfinite(value))) {
      return Status::Error(std::string(flag) + ": found " + NumberText(value) +
                           ", expected a number, 0 or more");
    }
  }
  if (run.minutes <= 0 && run.iterations <= 0) {
    return Status::Error("give --minutes or --iterations");
  }
  const Status folder = CheckDataFolder(run.data);
  if (!folder.ok()) return folder;
  if (run.device == "cuda" && !torch::cuda::is_available()) {
    return Status::Error("--device cuda: this libtorch sees no CUDA device");
  }
  std::error_code error;
  std::filesystem::create_directories(run.out, error);
  return error ? Status::Error("--out " + run.out.string() + ": " + error.message()) : Status::Ok();
}

Result<std::unique_ptr<Recipe>> MakeChecked(
    const RunConfig& run, const Status& flags,
    const std::function<Result<std::unique_ptr<Recipe>>()>& make) {
  if (!flags.ok()) return flags;
  const Status checked = CheckRun(run);
  if (!checked.ok()) return checked;
  try {
    return make();
  } catch (const std::exception& failure) {
    return Status::Error(std::string("libtorch: ") + Reason(failure));
  }
}

Status Train(const RunConfig& run, Recipe& recipe, const Validate& validate) {
  const Status checked = CheckRun(run);
  if (!checked.ok()) return checked;
  try {
    return Session(run, recipe, validate).Run();
  } catch (const std::exception& failure) {
    return Status::Error(std::string("libtorch: ") + Reason(failure));
  }
}

Status ExportRun(const std::filesystem::path& run, const std::filesystem::path& file,
                 const std::function<ExportFunction(const std::string& family)>& find) {
  Checkpoint checkpoint;
  const std::filesystem::path source = run / "checkpoint.pt";
  const Status read = ReadCheckpoint(source, checkpoint);
  if (!read.ok()) return read;
  const std::string family = FamilyOf(checkpoint);
  const ExportFunction export_weights = find(family);
  if (export_weights == nullptr) {
    return Status::Error(source.string() + ": the family \"" + family + "\" is not known");
  }
  const Status written = export_weights(checkpoint, file);
  return written.ok() ? written : Status::Error(source.string() + ": " + written.message());
}

}  // namespace styled::train
