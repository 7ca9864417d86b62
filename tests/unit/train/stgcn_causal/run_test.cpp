// Whole runs of the causal spatio-temporal network on a made-up data set, from weights of st-gcn
// that were made there, too.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <torch/torch.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>

#include "model/net/safetensors.h"
#include "model/net/stgcn_causal/network.h"
#include "model/net/weights_file.h"
#include "model/train/checkpoint.h"
#include "model/train/stgcn/recipe.h"
#include "model/train/stgcn_causal/learner.h"
#include "model/train/stgcn_causal/recipe.h"
#include "model/train/trainer.h"
#include "tests/unit/train/stgcn/made_up_set.h"

namespace styled::train::st_gcn_causal {
namespace {

using testing::HasSubstr;
using torch::Tensor;

struct RunFlags : RunConfig, Config {};

Status Train(const RunFlags& flags) {
  const auto recipe = MakeRecipe(flags, flags);
  return recipe.ok() ? train::Train(flags, *recipe.value()) : recipe.status();
}

// The averaged network of a run with two styles.
Student Average(const Checkpoint& checkpoint) {
  const torch::NoGradGuard no_grad;
  st_gcn::Shape shape;
  shape.domains = 2;
  shape.width = 16;
  Student student(shape, torch::kCPU);
  student.parameters.flat().copy_(checkpoint.tensors.at("average"));
  return student;
}

void Check(const Status& status) { ASSERT_TRUE(status.ok()) << status.message(); }

class CausalRun : public testing::Test {
 protected:
  CausalRun() { MakeTeacher("teacher", 1); }

  // A few iterations of st-gcn: an arbitrary teacher is as good as another one here.
  void MakeTeacher(const std::string& out, uint64_t seed) {
    RunConfig run = Common(out);
    run.iterations = 12;
    run.seed = seed;
    st_gcn::Config config;
    config.warm_up = 10;
    config.width = 16;
    config.batch = 2;
    const auto recipe = st_gcn::MakeRecipe(run, config);
    Check(recipe.status());
    Check(train::Train(run, *recipe.value()));
  }
  RunConfig Common(const std::string& out) const {
    RunConfig run;
    run.manifest = set_.manifest();
    run.data = set_.root();
    run.out = set_.root() / out;
    run.device = "cpu";
    run.monitor_every = 1000;
    run.log_every = 1;
    return run;
  }
  std::filesystem::path Weights(const std::string& out) const {
    return set_.root() / out / "weights.safetensors";
  }
  RunFlags Flags(const std::string& out) const {
    RunFlags flags;
    static_cast<RunConfig&>(flags) = Common(out);
    flags.iterations = 6;
    flags.init = Weights("teacher");
    flags.batch = 2;
    flags.start_windows = 8;
    return flags;
  }
  Checkpoint Read(const std::string& out) const {
    Checkpoint checkpoint;
    Check(ReadCheckpoint(set_.root() / out / "checkpoint.pt", checkpoint));
    return checkpoint;
  }
  std::string Text(const std::filesystem::path& file) const {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  // A file of comma-separated values, by column.
  std::map<std::string, std::vector<double>> Columns(const std::string& file) const {
    std::istringstream in(Text(set_.root() / file));
    std::vector<std::string> header;
    std::map<std::string, std::vector<double>> columns;
    for (std::string line; std::getline(in, line);) {
      std::vector<std::string> cells;
      std::istringstream row(line);
      for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
      if (header.empty()) {
        header = cells;
        continue;
      }
      for (std::size_t i = 0; i < cells.size(); ++i) {
        columns[header[i]].push_back(std::stod(cells[i]));
      }
    }
    return columns;
  }

  MadeUpSet set_{"styled_causal_run_"};
};

TEST_F(CausalRun, ResumedIsBitForBitTheSameAsUninterrupted) {
  for (const char* precision : {"fp32", "bf16"}) {
    RunFlags whole = Flags(std::string("whole-") + precision);
    whole.precision = precision;
    Check(Train(whole));
    RunFlags parts = whole;
    parts.out = set_.root() / (std::string("parts-") + precision);
    parts.stop_at = 2;
    Check(Train(parts));
    parts.stop_at = 0;
    parts.resume = true;
    Check(Train(parts));
    const Checkpoint a = Read(whole.out.filename()), b = Read(parts.out.filename());
    ASSERT_EQ(a.tensors.size(), b.tensors.size());
    for (const auto& [name, tensor] : a.tensors) {
      if (name == "elapsed_s") continue;
      EXPECT_TRUE(torch::equal(tensor, b.tensors.at(name))) << name;
    }
    EXPECT_EQ(a.strings.at("sampler"), b.strings.at("sampler"));
  }
  RunFlags other = Flags("other");  // the control
  other.precision = "fp32";
  other.seed = 2;
  Check(Train(other));
  EXPECT_FALSE(
      torch::equal(Read("whole-fp32").tensors.at("student"), Read("other").tensors.at("student")));
}

TEST_F(CausalRun, FlagsThatCannotWorkAreRefused) {
  const auto refused = [this](auto change) {
    RunFlags flags = Flags("refused");
    change(flags);
    return Train(flags).message();
  };
  EXPECT_THAT(refused([](RunFlags& f) { f.init.clear(); }), HasSubstr("--init is needed"));
  EXPECT_THAT(refused([](RunFlags& f) { f.init = "none.safetensors"; }),
              HasSubstr("--init none.safetensors: "));
  EXPECT_THAT(refused([](RunFlags& f) { f.batch = 0; }), HasSubstr("--batch: found 0"));
  EXPECT_THAT(refused([](RunFlags& f) { f.hop = 0; }), HasSubstr("--hop: found 0"));
  EXPECT_THAT(refused([](RunFlags& f) { f.start_windows = -1; }),
              HasSubstr("--start-windows: found -1"));
  EXPECT_THAT(refused([](RunFlags& f) { f.neutral = 1.5; }), HasSubstr("--neutral: found 1.5"));
  EXPECT_THAT(refused([](RunFlags& f) { f.w_first = -1; }), HasSubstr("--w-first: found -1"));
  EXPECT_THAT(refused([](RunFlags& f) { f.generator_rate = std::nan(""); }),
              HasSubstr("--generator-rate: found nan"));
  EXPECT_THAT(refused([](RunFlags& f) { f.w_velocity = -3; }), HasSubstr("--w-velocity: found -3"));
  EXPECT_THAT(refused([](RunFlags& f) { f.lead_s = 0.6; }), HasSubstr("--lead: found 0.6"));
  EXPECT_THAT(refused([](RunFlags& f) { f.lead_s = std::nan(""); }),
              HasSubstr("--lead: found nan"));
  EXPECT_THAT(refused([](RunFlags& f) { f.gain = -1; }), HasSubstr("--gain: found -1"));
  EXPECT_THAT(refused([](RunFlags& f) { f.w_smooth = -1; }), HasSubstr("--w-smooth: found -1"));
  EXPECT_THAT(refused([](RunFlags& f) { f.iterations = 0; }),
              HasSubstr("give --minutes or --iterations"));
}

TEST_F(CausalRun, WeightsOfAnotherFamilyOrOfOtherStylesAreRefused) {
  Check(Train(Flags("run")));
  RunFlags flags = Flags("refused");
  flags.init = Weights("run");  // of this family: it has no style encoder
  EXPECT_THAT(Train(flags).message(),
              HasSubstr("key 'family': expected \"st-gcn\", found \"st-gcn-causal\""));

  // A manifest with a style that the weights have not, and one without one that they have.
  flags = Flags("refused");
  std::string manifest = Text(set_.manifest());
  const std::string odd = "{ name = \"odd\",";
  manifest.replace(manifest.find(odd), odd.size(), "{ name = \"rare\",");
  flags.manifest = set_.root() / "rare.toml";
  std::ofstream(flags.manifest) << manifest;
  EXPECT_THAT(Train(flags).message(), HasSubstr("has no style 'rare', which manifest made-up has"));
}

TEST_F(CausalRun, ACheckpointOfAnotherTeacherIsRefused) {
  RunFlags flags = Flags("run");
  flags.stop_at = 1;
  Check(Train(flags));
  MakeTeacher("another", 2);
  flags.resume = true;
  flags.init = Weights("another");
  EXPECT_THAT(Train(flags).message(), HasSubstr("was made with other weights of --init"));
}

TEST_F(CausalRun, AnExportedFileHasTheTensorsOfTheFormatAsTheyWere) {
  Check(Train(Flags("run")));
  const auto bytes = net::ReadFile(Weights("run"));
  ASSERT_TRUE(bytes.ok());
  const auto file = net::ParseWeights(bytes.value(), "weights");
  ASSERT_TRUE(file.ok()) << file.status().message();
  EXPECT_EQ(file.value().model.family, "st-gcn-causal");
  EXPECT_EQ(file.value().model.styles[1].aliases, std::vector<std::string>{"strange"});
  const nlohmann::json& header = file.value().header;
  EXPECT_EQ(header.at("width"), 16);
  EXPECT_EQ(header.at("code"), 64);
  EXPECT_EQ(header.at("spacing"), nlohmann::json({2, 4, 2, 1}));
  EXPECT_EQ(header.at("memory"), 21);
  EXPECT_EQ(header.at("start_frames"), 16);
  EXPECT_EQ(header.at("training").at("iterations"), 6);
  EXPECT_EQ(header.at("training").at("from").at("iterations"), 12) << "the teacher's";
  EXPECT_EQ(header.at("noise"), 16);
  EXPECT_EQ(header.at("window"), 64);

  const auto& tensors = file.value().view.tensors;
  const Checkpoint checkpoint = Read("run");
  const Student student = Average(checkpoint);
  const torch::NoGradGuard no_grad;
  std::map<std::string, Tensor> expected(student.parameters.named().begin(),
                                         student.parameters.named().end());
  expected["features.mean"] = checkpoint.tensors.at("mean");
  expected["features.deviation"] = checkpoint.tensors.at("deviation");
  expected["codes.mean"] = checkpoint.tensors.at("codes.mean");
  for (const auto& [name, tensor] : expected) {
    ASSERT_TRUE(tensors.contains(name)) << name;
    EXPECT_EQ(tensors.at(name).shape, tensor.sizes().vec()) << name;
    const Tensor values = tensor.contiguous();
    EXPECT_EQ(std::memcmp(tensors.at(name).bytes.data(), values.data_ptr(), values.nbytes()), 0)
        << name;
  }
  EXPECT_EQ(tensors.at("g.dec1.adain2.start_square").shape, std::vector<std::int64_t>{32});
  // The parts common to both families are the teacher's: the mean codes stay, the weights were
  // trained.
  const auto teacher_bytes = net::ReadFile(Weights("teacher"));
  const auto teacher = net::ParseWeights(teacher_bytes.value(), "teacher");
  const auto same = [&](const std::string& name) {
    const auto& of_teacher = teacher.value().view.tensors.at(name);
    return std::memcmp(tensors.at(name).bytes.data(), of_teacher.bytes.data(),
                       of_teacher.bytes.size()) == 0;
  };
  std::size_t copied = 0;  // of style encoder and mapping network
  for (const auto& [name, tensor] : teacher.value().view.tensors) {
    if (!name.starts_with("e.") && !name.starts_with("f.")) continue;
    EXPECT_TRUE(same(name)) << name;
    ++copied;
  }
  EXPECT_GT(copied, 20U);
  EXPECT_EQ(expected.size() + copied, tensors.size());
  EXPECT_TRUE(same("codes.mean"));
  EXPECT_TRUE(same("features.deviation"));
  EXPECT_FALSE(same("g.enc1.tconv1.weight"));
}

// The runtime, frame by frame, with the file that was exported; features in their own units.
TEST_F(CausalRun, TheRuntimeComputesTheSameFromTheFile) {
  Check(Train(Flags("run")));
  const auto network = stgcn_causal::Network::Load(Weights("run"));
  ASSERT_TRUE(network.ok()) << network.status().message();
  const Checkpoint checkpoint = Read("run");
  const Student student = Average(checkpoint);
  const torch::NoGradGuard no_grad;
  constexpr int64_t kFrames = 64;
  torch::manual_seed(1);
  const Tensor x = 0.2 * torch::randn({1, kFrames, 21, 7}).cumsum(1);
  const Tensor& mean = checkpoint.tensors.at("mean");
  const Tensor& deviation = checkpoint.tensors.at("deviation");
  const Tensor raw = (x * deviation + mean).contiguous();
  const Graph graph(torch::kCPU, torch::kFloat32, kFrames);
  const Tensor content = student.Encode(graph, x);
  const Tensor codes = checkpoint.tensors.at("codes.mean");
  const Tensor plain = student.Decode(graph, content, codes.narrow(0, 0, 1));
  const Tensor odd = student.Decode(graph, content, codes.narrow(0, 1, 1));
  EXPECT_GT((plain - odd).abs().max().item<double>(), 1e-2) << "the control: styles differ";

  stgcn_causal::State state = network.value()->MakeState();
  const net::StyleWeight whole{.style = 1, .weight = 1};
  for (int64_t t = 0; t < kFrames; ++t) {
    stgcn::Features features;
    std::memcpy(features.data(), raw[0][t].data_ptr(), sizeof features);
    stgcn_causal::Output out;
    network.value()->Step(features, 0, {&whole, 1}, state, out);
    const auto off = [&](stgcn::Features& of, const Tensor& expected) {
      const Tensor found = torch::from_blob(of.data(), {21, 7});
      return ((found - mean) / deviation - expected[0][t]).abs().max().item<double>();
    };
    EXPECT_LT(off(out.reconstruction, plain), 1e-4) << t;
    EXPECT_LT(off(out.styled, odd), 1e-4) << t;
  }
}

// Small, but whole: what a minute's training brings down.
TEST_F(CausalRun, LearnsWhatTheTeacherDoes) {
  RunFlags flags = Flags("learned");
  flags.batch = 4;
  flags.iterations = 120;
  flags.log_every = 20;
  flags.monitor_every = 20;
  flags.generator_rate = 2e-3;
  flags.ema = 0.9;
  Check(Train(flags));
  const auto log = Columns("learned/log.csv");
  // Means over the first 20 iterations and the last.
  for (const auto& [loss, share] : {std::pair{"reconstruction", 0.75},
                                    {"styled", 0.75},
                                    {"reconstruction_velocity", 0.85},
                                    {"styled_velocity", 0.85}}) {
    const std::vector<double>& values = log.at(loss);
    ASSERT_EQ(values.size(), 6U);
    EXPECT_LT(values.back(), share * values.front()) << loss;
  }
  const auto monitor = Columns("learned/monitor.csv");
  for (const char* const figure : {"styled_cm", "reconstruction_cm"}) {
    EXPECT_LT(monitor.at(figure).back(), 0.85 * monitor.at(figure).front()) << figure;
  }
  EXPECT_TRUE(monitor.contains("jerk_ratio_student"));
}

// The same seed and batches: a target that is later and larger gives another loss and another
// student, and the weight of smoothness makes the change smoother.
TEST_F(CausalRun, TheTargetMayBeLaterAndLargerAndTheChangeSmooth) {
  const auto run = [this](const std::string& out, auto change) {
    RunFlags flags = Flags(out);
    flags.iterations = 40;
    flags.log_every = 20;
    flags.generator_rate = 2e-3;
    change(flags);
    Check(Train(flags));
    return Columns(out + "/log.csv");
  };
  const auto plain = run("plain", [](RunFlags& f) { f.w_smooth = 1e-9; });
  const auto late = run("late", [](RunFlags& f) {
    f.lead_s = 0.08;
    f.gain = 3;
    f.w_smooth = 1e-9;
  });
  EXPECT_GT(late.at("styled").front(), plain.at("styled").front());
  EXPECT_FALSE(
      torch::equal(Read("plain").tensors.at("student"), Read("late").tensors.at("student")));
  const auto smooth = run("smooth", [](RunFlags& f) { f.w_smooth = 100; });
  EXPECT_LT(smooth.at("smooth").back(), 0.8 * plain.at("smooth").back());
}

}  // namespace
}  // namespace styled::train::st_gcn_causal
