// The trainer with a recipe that has no network: one number that falls from step to step.

#include "model/train/trainer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <torch/torch.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <fstream>
#include <limits>
#include <sstream>
#include <thread>

#include "model/train/checkpoint.h"
#include "model/train/measure.h"
#include "model/train/stop.h"

namespace styled::train {
namespace {

class FakeRecipe : public Recipe {
 public:
  std::string_view family() const override { return name; }
  Status Start() override {
    ++starts;
    return start;
  }
  void Step(double progress) override {
    last_progress = progress;
    value *= 0.5;
    std::this_thread::sleep_for(pause);
    if (++steps == infinite_at) value = std::numeric_limits<double>::infinity();
    if (steps == raise_at) std::raise(SIGTERM);
    if (steps == throw_at) throw std::runtime_error("out of memory\nat 0x1");
  }
  int64_t iteration() const override { return steps; }
  Figures PopLosses(int iterations) override {
    counts.push_back(iterations);
    return {{"value", value}};
  }
  bool Finite() const override { return std::isfinite(value); }
  MonitorReport Monitor() const override { return {{{"twice", 2 * value}}, "twice"}; }
  void Save(double, Checkpoint& checkpoint) const override {
    checkpoint.tensors["value"] = torch::tensor({value}, torch::kFloat64);
    checkpoint.tensors["steps"] = torch::tensor({steps}, torch::kInt64);
  }
  Status Restore(const Checkpoint& checkpoint) override {
    value = checkpoint.tensors.at("value").item<double>();
    steps = checkpoint.tensors.at("steps").item<int64_t>();
    return Status::Ok();
  }
  Status ExportWeights(const Checkpoint& checkpoint,
                       const std::filesystem::path& file) const override {
    return Write(checkpoint, file);
  }
  static Status Write(const Checkpoint& checkpoint, const std::filesystem::path& file) {
    std::ofstream(file) << checkpoint.tensors.at("value").item<double>();
    return Status::Ok();
  }

  std::string name = "fake";
  Status start = Status::Ok();
  double value = 1024;
  double last_progress = -1;
  int64_t steps = 0, infinite_at = -1, throw_at = -1, raise_at = -1;
  std::chrono::milliseconds pause{0};  // in each step
  int starts = 0;
  std::vector<int> counts;
};

class TrainerTest : public testing::Test {
 protected:
  void SetUp() override {
    root_ = std::filesystem::temp_directory_path() / ("styled_trainer_" + std::to_string(getpid()));
    std::filesystem::create_directories(root_ / "data");
    run_.data = root_ / "data";
    run_.out = root_ / "run";
    run_.device = "cpu";
    run_.iterations = 10;
    run_.log_every = 4;
    run_.monitor_every = 5;
  }
  void TearDown() override { std::filesystem::remove_all(root_); }

  std::string Text(const std::string& file) const {
    std::ifstream in(run_.out / file);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  // The columns of a row of a table but the second, the time.
  std::vector<std::string> Row(const std::string& file, int row) const {
    std::ifstream in(run_.out / file);
    std::string line;
    for (int i = 0; i <= row; ++i) std::getline(in, line);
    std::istringstream cells(line);
    std::vector<std::string> columns;
    for (std::string cell; std::getline(cells, cell, ',');) columns.push_back(cell);
    if (columns.size() > 1) columns.erase(columns.begin() + 1);
    return columns;
  }

  std::filesystem::path root_;
  RunConfig run_;
};

TEST_F(TrainerTest, ARunIsLoggedMonitoredAndExported) {
  FakeRecipe recipe;
  const Status status = Train(run_, recipe);
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(recipe.starts, 1);
  EXPECT_EQ(recipe.steps, 10);
  EXPECT_DOUBLE_EQ(recipe.last_progress, 0.9);
  EXPECT_THAT(recipe.counts, testing::ElementsAre(4, 4));
  EXPECT_THAT(Row("log.csv", 0), testing::ElementsAre("iteration", "progress", "value"));
  EXPECT_THAT(Row("log.csv", 2), testing::ElementsAre("8", "0.7", "4"));
  EXPECT_THAT(Row("monitor.csv", 0), testing::ElementsAre("iteration", "twice"));
  EXPECT_THAT(Row("monitor.csv", 1), testing::ElementsAre("5", "64"));
  EXPECT_THAT(Row("monitor.csv", 2), testing::ElementsAre("10", "2"));
  EXPECT_TRUE(Row("monitor.csv", 3).empty()) << "the last row is written once";
  EXPECT_EQ(Text("weights.safetensors"), "1");
}

TEST_F(TrainerTest, AStoppedRunGoesOnFromItsCheckpoint) {
  FakeRecipe first;
  run_.stop_at = 3;
  ASSERT_TRUE(Train(run_, first).ok());
  EXPECT_EQ(first.steps, 3);
  run_.stop_at = 0;
  run_.resume = true;
  FakeRecipe second;
  ASSERT_TRUE(Train(run_, second).ok());
  EXPECT_EQ(second.starts, 0);
  EXPECT_EQ(second.steps, 10);
  EXPECT_EQ(second.value, 1);
}

TEST_F(TrainerTest, ASignalEndsASessionWithACheckpointAndNothingIsLost) {
  FakeRecipe first;
  first.raise_at = 3;  // no checkpoint would be due for minutes
  testing::internal::CaptureStdout();
  ASSERT_TRUE(Train(run_, first).ok());
  EXPECT_THAT(testing::internal::GetCapturedStdout(),
              testing::HasSubstr("stopped by a signal at iteration 3; " +
                                 (run_.out / "checkpoint.pt").string() + " is written"));
  EXPECT_EQ(StopSignal(), SIGTERM);
  EXPECT_EQ(first.steps, 3);
  EXPECT_EQ(Text("weights.safetensors"), "128");
  run_.resume = true;
  FakeRecipe second;
  ASSERT_TRUE(Train(run_, second).ok());
  EXPECT_EQ(StopSignal(), 0);
  EXPECT_EQ(second.steps, 10);
  EXPECT_EQ(second.value, 1);
}

TEST_F(TrainerTest, MeasuringWritesNothing) {
  FakeRecipe recipe;
  recipe.pause = std::chrono::milliseconds(100);
  testing::internal::CaptureStdout();
  ASSERT_TRUE(MeasureOnly(run_, false, recipe).ok());
  EXPECT_THAT(testing::internal::GetCapturedStdout(),
              testing::MatchesRegex("measured: [0-9]+ iterations a minute, [0-9]+ MB of memory; 10 "
                                    "iterations take some .* minutes\n"));
  EXPECT_EQ(recipe.starts, 1);
  EXPECT_GE(recipe.steps, PaceMeter::kSkipped + PaceMeter::kFewest);
  EXPECT_FALSE(std::filesystem::exists(run_.out));
  FakeRecipe refused;
  refused.start = Status::Error("no start");
  EXPECT_EQ(MeasureOnly(run_, false, refused).message(), "no start");
}

TEST_F(TrainerTest, ACheckpointOfAnotherFamilyIsRefusedAndAnOldOneIsOfStyleErd) {
  FakeRecipe recipe;
  ASSERT_TRUE(Train(run_, recipe).ok());
  run_.resume = true;
  FakeRecipe other;
  other.name = "other";
  EXPECT_THAT(Train(run_, other).message(),
              testing::HasSubstr("found a run of the family \"fake\", expected \"other\""));

  Checkpoint checkpoint;
  const std::filesystem::path file = run_.out / "checkpoint.pt";
  ASSERT_TRUE(ReadCheckpoint(file, checkpoint).ok());
  EXPECT_EQ(FamilyOf(checkpoint), "fake");
  checkpoint.strings.erase("family");
  ASSERT_TRUE(WriteCheckpoint(checkpoint, file).ok());
  EXPECT_THAT(Train(run_, recipe).message(), testing::HasSubstr("the family \"style-erd\""));
  FakeRecipe old;
  old.name = "style-erd";
  EXPECT_TRUE(Train(run_, old).ok());
}

TEST_F(TrainerTest, ExportIsThatOfTheCheckpointsFamily) {
  FakeRecipe recipe;
  ASSERT_TRUE(Train(run_, recipe).ok());
  const std::filesystem::path file = run_.out / "exported";
  const auto find = [](const std::string& family) -> ExportFunction {
    return family == "fake" ? FakeRecipe::Write : nullptr;
  };
  ASSERT_TRUE(ExportRun(run_.out, file, find).ok());
  EXPECT_EQ(Text("exported"), "1");
  EXPECT_THAT(
      ExportRun(run_.out, file, [](const auto&) -> ExportFunction { return nullptr; }).message(),
      testing::HasSubstr("the family \"fake\" is not known"));
  EXPECT_THAT(ExportRun(root_ / "none", file, find).message(),
              testing::HasSubstr("checkpoint.pt: not a checkpoint"));
}

TEST_F(TrainerTest, AnEndedRunKeepsTheLastCheckpoint) {
  FakeRecipe refused;
  refused.start = Status::Error("no start");
  EXPECT_EQ(Train(run_, refused).message(), "no start");
  run_.checkpoint_minutes = 0;  // after every iteration
  FakeRecipe infinite;
  infinite.infinite_at = 4;
  EXPECT_THAT(Train(run_, infinite).message(),
              testing::HasSubstr("iteration 4: a weight is no longer finite"));
  EXPECT_EQ(Text("weights.safetensors"), "128") << "of iteration 3";
  FakeRecipe throws;
  throws.throw_at = 6;
  EXPECT_EQ(Train(run_, throws).message(), "libtorch: out of memory");
  EXPECT_EQ(Text("weights.safetensors"), "32") << "of iteration 5";
}

TEST_F(TrainerTest, ValidationKeepsTheBestWeightsAndEndsARunWithoutPatience) {
  run_.validate_minutes = 0;  // after every iteration
  run_.patience = 2;
  const double scores[] = {0.1, 0.3, 0.2, 0.25, 0.9};
  int calls = 0;
  FakeRecipe recipe;
  const Status status = Train(run_, recipe, [&](const auto&) {
    return Result<Figures>(Figures{{"score", scores[calls++]}});
  });
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(recipe.steps, 4);
  EXPECT_EQ(Text("best.safetensors"), "256");
  EXPECT_THAT(Row("validation.csv", 4), testing::ElementsAre("4", "0.25"));
  EXPECT_FALSE(Text("curve.svg").empty());
}

TEST_F(TrainerTest, FlagsThatCannotWorkAreRefused) {
  const auto message = [this](auto change) {
    RunConfig run = run_;
    change(run);
    return CheckRun(run).message();
  };
  EXPECT_TRUE(CheckRun(run_).ok());
  EXPECT_TRUE(std::filesystem::is_directory(run_.out));
  EXPECT_THAT(message([](RunConfig& run) { run.iterations = 0; }),
              testing::HasSubstr("give --minutes or --iterations"));
  EXPECT_THAT(message([](RunConfig& run) { run.minutes = -1; }),
              testing::HasSubstr("--minutes: found -1"));
  EXPECT_THAT(message([](RunConfig& run) { run.validate_minutes = std::nan(""); }),
              testing::HasSubstr("--validate-minutes: found nan"));
  EXPECT_THAT(message([](RunConfig& run) { run.data = "/nowhere"; }),
              testing::HasSubstr("--data /nowhere: no such folder"));
}

}  // namespace
}  // namespace styled::train
