// Whole runs of the spatio-temporal network on a made-up data set.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <torch/torch.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>

#include "model/net/safetensors.h"
#include "model/net/stgcn/network.h"
#include "model/net/weights_file.h"
#include "model/train/checkpoint.h"
#include "model/train/stgcn/networks.h"
#include "model/train/stgcn/read_generator.h"
#include "model/train/stgcn/recipe.h"
#include "model/train/trainer.h"
#include "tests/unit/train/stgcn/made_up_set.h"

namespace styled::train::st_gcn {
namespace {

using torch::Tensor;

struct RunFlags : RunConfig, Config {};

Status Train(const RunFlags& flags) {
  const auto recipe = MakeRecipe(flags, flags);
  return recipe.ok() ? train::Train(flags, *recipe.value()) : recipe.status();
}

void Check(const Status& status) { ASSERT_TRUE(status.ok()) << status.message(); }

class StGcnRun : public testing::Test {
 protected:
  RunFlags Flags(const std::string& out) const {
    RunFlags flags;
    flags.manifest = set_.manifest();
    flags.data = set_.root();
    flags.out = set_.root() / out;
    flags.device = "cpu";
    flags.iterations = 10;
    flags.warm_up = 3;
    flags.width = 16;
    flags.batch = 2;
    flags.monitor_every = 1000;
    flags.log_every = 1;
    flags.w_smooth = 0.1;
    return flags;
  }
  Checkpoint Read(const std::string& out) const {
    Checkpoint checkpoint;
    Check(ReadCheckpoint(set_.root() / out / "checkpoint.pt", checkpoint));
    return checkpoint;
  }
  std::string Text(const std::string& file) const {
    std::ifstream in(set_.root() / file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  // One column of a run's log.
  std::vector<double> Logged(const std::string& out, const std::string& column) const {
    std::istringstream in(Text(out + "/log.csv"));
    std::vector<double> values;
    std::vector<std::string> header;
    for (std::string line; std::getline(in, line);) {
      std::vector<std::string> cells;
      std::istringstream row(line);
      for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
      if (cells.front() == "iteration") {
        header = cells;
        continue;
      }
      const auto at = std::find(header.begin(), header.end(), column) - header.begin();
      if (at < static_cast<std::ptrdiff_t>(cells.size())) {
        values.push_back(std::stod(cells[static_cast<std::size_t>(at)]));
      }
    }
    return values;
  }

  MadeUpSet set_{"styled_stgcn_run_"};
};

void ExpectSameButTheClock(const Checkpoint& a, const Checkpoint& b) {
  ASSERT_EQ(a.tensors.size(), b.tensors.size());
  for (const auto& [name, tensor] : a.tensors) {
    if (name == "elapsed_s") continue;
    EXPECT_TRUE(torch::equal(tensor, b.tensors.at(name))) << name;
  }
  EXPECT_EQ(a.strings.at("sampler"), b.strings.at("sampler"));
}

TEST_F(StGcnRun, ResumedIsBitForBitTheSameAsUninterrupted) {
  for (const char* precision : {"fp32", "bf16"}) {
    RunFlags whole = Flags(std::string("whole-") + precision);
    whole.precision = precision;
    Check(Train(whole));
    for (const int stop_at : {2, 6}) {  // in the warm-up and after it
      RunFlags parts = whole;
      parts.out = set_.root() / ("parts" + std::to_string(stop_at) + precision);
      parts.stop_at = stop_at;
      Check(Train(parts));
      parts.stop_at = 0;
      parts.resume = true;
      Check(Train(parts));
      ExpectSameButTheClock(Read(whole.out.filename()), Read(parts.out.filename()));
    }
  }
  RunFlags other = Flags("other");  // the control
  other.seed = 2;
  Check(Train(other));
  EXPECT_FALSE(torch::equal(Read("whole-fp32").tensors.at("generator"),
                            Read("other").tensors.at("generator")));
}

TEST_F(StGcnRun, ACheckpointOfOtherDataOrAnotherShapeIsRefused) {
  RunFlags flags = Flags("run");
  flags.stop_at = 1;
  Check(Train(flags));
  flags.resume = true;
  RunFlags other = flags;
  other.heading_tau_s = 1;
  EXPECT_THAT(Train(other).message(), testing::HasSubstr("other data or another heading filter"));
  other = flags;
  other.width = 32;
  EXPECT_THAT(Train(other).message(), testing::HasSubstr("another width or other styles"));
}

TEST_F(StGcnRun, FlagsThatCannotWorkAreRefused) {
  const auto refused = [this](auto change) {
    RunFlags flags = Flags("refused");
    change(flags);
    return Train(flags).message();
  };
  // Files that no program could load afterwards.
  for (const int width : {0, 8, 24, 112}) {
    EXPECT_THAT(refused([width](RunFlags& f) { f.width = width; }),
                testing::HasSubstr("--width: found " + std::to_string(width) +
                                   ", expected a multiple of 16 up to 96"));
  }
  EXPECT_THAT(refused([](RunFlags& f) { f.batch = 0; }), testing::HasSubstr("--batch: found 0"));
  EXPECT_THAT(refused([](RunFlags& f) { f.hop = 0; }), testing::HasSubstr("--hop: found 0"));
  EXPECT_THAT(refused([](RunFlags& f) { f.penalty_every = 0; }),
              testing::HasSubstr("--penalty-every: found 0"));
  EXPECT_THAT(refused([](RunFlags& f) { f.warm_up = -1; }),
              testing::HasSubstr("--warm-up: found -1"));
  EXPECT_THAT(refused([](RunFlags& f) { f.ema = 1.5; }), testing::HasSubstr("--ema: found 1.5"));
  EXPECT_THAT(refused([](RunFlags& f) { f.w_fk = std::nan(""); }),
              testing::HasSubstr("--w-fk: found nan"));
  EXPECT_THAT(refused([](RunFlags& f) { f.iterations = 0; }),
              testing::HasSubstr("give --minutes or --iterations"));
}

TEST_F(StGcnRun, ExportedTensorsHaveTheNamesAndShapesOfTheFormat) {
  RunFlags flags = Flags("run");
  flags.ema = 0;  // the weights of the moment
  Check(Train(flags));
  const auto bytes = net::ReadFile(set_.root() / "run" / "weights.safetensors");
  ASSERT_TRUE(bytes.ok());
  const auto file = net::ParseWeights(bytes.value(), "weights");
  ASSERT_TRUE(file.ok()) << file.status().message();
  EXPECT_EQ(file.value().model.family, "st-gcn");
  EXPECT_EQ(file.value().model.styles[1].aliases, std::vector<std::string>{"strange"});
  EXPECT_EQ(file.value().header.at("width"), 16);
  EXPECT_EQ(file.value().header.at("window"), 64);
  EXPECT_EQ(file.value().header.at("training").at("iterations"), 10);
  const auto& tensors = file.value().view.tensors;
  const std::map<std::string, std::vector<std::int64_t>> expected{
      {"features.mean", {21, 7}},
      {"features.deviation", {21, 7}},
      {"g.in.node_bias", {21, 16}},
      {"g.enc1.norm1.scale", {16}},
      {"g.enc1.gconv1.weight", {48, 16}},
      {"g.enc1.gconv1.node_bias", {21, 16}},
      {"g.enc1.gconv2.weight", {96, 16}},
      {"g.enc1.gconv2.node_bias", {10, 32}},
      {"g.enc1.tconv2.weight", {32, 32, 3}},
      {"g.enc2.skip.weight", {64, 32}},
      {"g.dec1.adain1.weight", {128, 64}},
      {"g.dec1.gconv1.node_bias", {5, 32}},
      {"g.dec2.adain2.bias", {32}},
      {"g.dec2.gconv2.node_bias", {21, 16}},
      {"g.out.weight", {7, 16}},
      {"e.res2.tconv2.bias", {64}},
      {"e.conv.weight", {64, 64, 16, 5}},
      {"e.heads.weight", {2, 64, 64}},
      {"e.free.bias", {64}},
      {"f.noise.weight", {256, 16}},
      {"f.label.weight", {256, 2}},
      {"f.out.weight", {64, 1024}},
      {"codes.mean", {2, 64}}};
  for (const auto& [name, shape] : expected) {
    ASSERT_TRUE(tensors.contains(name)) << name;
    EXPECT_EQ(tensors.at(name).shape, shape) << name;
  }
  for (const auto& [name, tensor] : tensors) {
    EXPECT_FALSE(name.starts_with("d.") || name.starts_with("e.res1.norm")) << name;
  }
  // Weights and values: the layout of the trunk's convolution is another in training.
  const Checkpoint checkpoint = Read("run");
  const auto floats = [&](const std::string& name) {
    const net::TensorView& tensor = tensors.at(name);
    Tensor out = torch::empty(tensor.shape);
    std::memcpy(out.data_ptr(), tensor.bytes.data(), tensor.bytes.size());
    return out;
  };
  EXPECT_TRUE(torch::equal(floats("codes.mean"), checkpoint.tensors.at("codes.mean")));
  Shape shape;
  shape.domains = 2;
  shape.width = 16;
  const Encoder encoder(shape, torch::kCPU);
  const torch::NoGradGuard no_grad;
  encoder.parameters.flat().copy_(checkpoint.tensors.at("encoder"));
  EXPECT_TRUE(torch::equal(floats("e.conv.weight").permute({0, 2, 3, 1}),
                           encoder.parameters.Find("e.conv.weight")));
  EXPECT_TRUE(torch::equal(floats("e.heads.weight"), encoder.parameters.Find("e.heads.weight")));
}

TEST_F(StGcnRun, TheGeneratorOfAFileIsTheOneThatWasWritten) {
  Check(Train(Flags("run")));
  const auto file = set_.root() / "run" / "weights.safetensors";
  const auto loaded = ReadGenerator(file);
  ASSERT_TRUE(loaded.ok()) << loaded.status().message();
  const LoadedGenerator& read = loaded.value();
  const Checkpoint checkpoint = Read("run");
  EXPECT_TRUE(
      torch::equal(read.generator->parameters.flat(), checkpoint.tensors.at("average.generator")));
  EXPECT_TRUE(torch::equal(read.codes, checkpoint.tensors.at("codes.mean")));
  EXPECT_EQ(read.statistics.mean[8], checkpoint.tensors.at("mean").flatten()[8].item<float>());
  EXPECT_EQ(read.statistics.deviation[146],
            checkpoint.tensors.at("deviation").flatten()[146].item<float>());
  EXPECT_EQ(read.model.styles[1].name, "odd");
  EXPECT_FLOAT_EQ(read.parameters.heading_tau_s, 0.25F);
  EXPECT_FALSE(read.generator->parameters.Find("g.out.bias").requires_grad());

  std::string bytes = Text("run/weights.safetensors");
  const auto family = bytes.find("st-gcn");
  ASSERT_NE(family, std::string::npos);
  const auto other = set_.root() / "other.safetensors";
  std::ofstream(other, std::ios::binary) << bytes.replace(family, 6, "xt-gcn");
  EXPECT_THAT(ReadGenerator(other).status().message(),
              testing::HasSubstr("other.safetensors: key 'family': expected \"st-gcn\", found "
                                 "\"xt-gcn\""));
  EXPECT_THAT(ReadGenerator(set_.root() / "none").status().message(), testing::HasSubstr("none"));
}

TEST_F(StGcnRun, ThePapersRunHasItsOwnSettingsAndExportsTheSameFormat) {
  RunFlags flags = Flags("paper");
  AsInThePaper(flags);
  EXPECT_EQ(flags.width, 64);
  EXPECT_EQ(flags.warm_up, 0);
  EXPECT_EQ(flags.diversity_target_cm, 0);
  EXPECT_EQ(flags.penalty_every, 1);
  EXPECT_EQ(flags.w_fk, 0);
  EXPECT_EQ(flags.ema, 0);
  EXPECT_DOUBLE_EQ(flags.generator_rate, 1e-4);
  EXPECT_DOUBLE_EQ(flags.critic_rate, 1e-6);
  EXPECT_DOUBLE_EQ(flags.mapping_rate, 1e-5);
  EXPECT_DOUBLE_EQ(flags.beta1, 0.9);
  EXPECT_TRUE(flags.both_turns);
  EXPECT_FALSE(flags.node_bias || flags.same_clip || flags.content_critic || flags.scaled_heads ||
               flags.encoder_learns_from_references || flags.shared_contents ||
               flags.even_contents || flags.floor_deviations || flags.judge_published ||
               flags.free_head_teaches);
  EXPECT_TRUE(flags.critic_layer);
  EXPECT_EQ(flags.normalization, "subset");
  EXPECT_EQ(flags.fewest_frames, 8);
  flags.width = 16;
  flags.iterations = 3;
  Check(Train(flags));
  // Both turns are in every iteration, and the weight of diversity is constant.
  EXPECT_EQ(Logged("paper", "style_noise").size(), 3U);
  EXPECT_EQ(Logged("paper", "style_reference").size(), 3U);
  for (const double weight : Logged("paper", "w_diversity_noise")) EXPECT_EQ(weight, 1);
  const auto bytes = net::ReadFile(set_.root() / "paper" / "weights.safetensors");
  const auto file = net::ParseWeights(bytes.value(), "weights");
  ASSERT_TRUE(file.ok()) << file.status().message();
  const auto& bias = file.value().view.tensors.at("g.enc1.gconv2.node_bias");
  EXPECT_EQ(bias.shape, (std::vector<std::int64_t>{10, 32}));
  for (const std::byte byte : bias.bytes) EXPECT_EQ(byte, std::byte{0});
  EXPECT_EQ(file.value().header.at("normalization"), "subset");
  EXPECT_TRUE(stgcn::Network::Parse(bytes.value(), "weights").ok());
  EXPECT_LT(Read("paper").tensors.at("deviation").min().item<float>(), 0.02F) << "without floors";
  EXPECT_THAT(ReadGenerator(set_.root() / "paper" / "weights.safetensors").status().message(),
              testing::HasSubstr("key 'normalization': expected \"neighbours\""));
}

TEST_F(StGcnRun, UnevenContentsNeedUnsharedOnes) {
  Config config;
  config.even_contents = false;
  EXPECT_THAT(st_gcn::Check(config).message(), testing::HasSubstr("--shared-contents 0"));
  config.shared_contents = false;
  EXPECT_TRUE(st_gcn::Check(config).ok());
}

// Small, but whole: the losses that a minute's training brings down, and what it makes visible.
TEST_F(StGcnRun, LearnsToReconstructAndToStoop) {
  RunFlags flags = Flags("learned");
  flags.width = 16;
  flags.batch = 4;
  flags.iterations = 300;
  flags.warm_up = 120;
  flags.log_every = 50;
  flags.critic_rate = flags.generator_rate = 2e-3;
  flags.encoder_rate = 1e-3;
  Check(Train(flags));
  const std::vector<double> identity = Logged("learned", "identity");
  ASSERT_EQ(identity.size(), 6U);
  EXPECT_LT(identity[1], 0.7 * identity[0]);

  std::istringstream monitor(Text("learned/monitor.csv"));
  std::string header, row;
  std::getline(monitor, header);
  std::getline(monitor, row);
  std::map<std::string, double> figures;
  std::istringstream names(header), values(row);
  for (std::string name, value;
       std::getline(names, name, ',') && std::getline(values, value, ',');) {
    figures[name] = std::stod(value);
    std::cout << name << ' ' << value << std::endl;
  }
  EXPECT_GT(figures.at("expression_reference"), 0.4);
  EXPECT_GT(figures.at("cosine_reference"), 0.6);
  EXPECT_GT(figures.at("expression_noise"), 0.4);
}

}  // namespace
}  // namespace styled::train::st_gcn
