// The trainer's side of the parity tests: a clip's features as in the training set, run through the
// trainer's own network, with styles switched on the way.
#include <torch/torch.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "model/train/checkpoint.h"
#include "model/train/dataset.h"
#include "model/train/erd/weights.h"
#include "tests/parity/reference_file.h"

namespace styled::parity {
namespace {

using torch::Tensor;

struct Arguments {
  std::filesystem::path clip, weights, out;
  std::string dialect = "auto", schedule = kSchedule;
  int frames = 1000, every = 1, features_every = 1;
};

Result<train::TrainingClip> LoadClip(const Arguments& a,
                                     const train::style_erd::LoadedWeights& weights) {
  clip::Manifest manifest;
  manifest.name = "parity";
  manifest.styles = {{"neutral", {}, {}}};
  manifest.contents = {"any"};
  manifest.entries = {{a.clip, "neutral", "any", a.dialect, "validation", 1}};
  auto clips = train::LoadClips(manifest, "validation", weights.features, a.frames);
  if (!clips.ok()) return clips.status();
  return std::move(clips.value().front());
}

// Ŝ[s] = α_s, Ŝ[neutral] = max(0, 1 - Σα), normalized to sum 1 (model/net/erd/FORMAT.md).
Tensor Target(const Tensor& alpha) {
  Tensor target = alpha.clone();
  target[0] = (1.0 - alpha.sum()).clamp_min(0.0);
  return (target / target.sum()).unsqueeze(0);
}

// Resets the states of the groups in `fresh` to the learned initial ones.
void StartBranches(const train::style_erd::Stack& branches, const std::set<int>& fresh,
                   train::style_erd::StackState& state) {
  const train::style_erd::StackState learned = branches.Initial(1);
  for (std::size_t layer = 0; layer < state.h.size(); ++layer) {
    state.h[layer] = state.h[layer].clone();
    state.c[layer] = state.c[layer].clone();
    for (const int style : fresh) {
      state.h[layer][style - 1] = learned.h[layer][style - 1];
      state.c[layer][style - 1] = learned.c[layer][style - 1];
    }
  }
}

// Runs the generator segment by segment; r_0 and the branches that stay live keep their states.
Status RunGenerator(const train::style_erd::LoadedWeights& weights, const Tensor& features,
                    const std::vector<Segment>& schedule, Reference& reference) {
  const train::style_erd::Generator& generator = *weights.generator;
  const int64_t styles = generator.shape.styles;
  const Tensor u = ((features - weights.mean) / weights.deviation).unsqueeze(1);  // [T, 1, 211]
  Tensor neutral_target = torch::zeros({1, styles});
  neutral_target[0][0] = 1.0;
  train::style_erd::StackState r0_state = generator.neutral.Initial(1);
  train::style_erd::StackState branch_state = generator.branches.Initial(1);
  std::set<int> alive;
  for (std::size_t i = 0; i < schedule.size(); ++i) {
    const int begin = schedule[i].first_frame;
    const int end = i + 1 < schedule.size() ? schedule[i + 1].first_frame : reference.frames;
    if (begin >= end) return Status::Error("schedule: a segment begins behind the last frame");

    // 1. The mix; a branch that was not live starts from its learned state.
    Tensor alpha = torch::zeros({styles});
    std::set<int> wanted, fresh;
    for (const auto& [name, weight] : schedule[i].mix) {
      const auto found = std::find(weights.styles.begin(), weights.styles.end(), name);
      const auto style = static_cast<int>(found - weights.styles.begin());
      if (style == 0 || found == weights.styles.end()) {
        return Status::Error("schedule: the weights have no style \"" + name + "\"");
      }
      alpha[style] = weight;
      wanted.insert(style);
      if (!alive.contains(style)) fresh.insert(style);
    }
    StartBranches(generator.branches, fresh, branch_state);
    alive = wanted;

    // 2. z' = r_0(z) + Σ_s α_s r_s(z): every branch runs; those without weight add nothing.
    const Tensor z = generator.Encode(u.slice(0, begin, end), neutral_target, {});
    const Tensor r0 = generator.Neutral(z, r0_state);
    const Tensor residuals = generator.Branches(z.repeat({1, styles - 1, 1}), branch_state);
    const Tensor mixed = r0 + (residuals * alpha.slice(0, 1).view({1, styles - 1, 1})).sum(1, true);

    // 3. Both decodings.
    const Tensor rec = generator.Decode(r0, neutral_target).rotations.contiguous();
    const Tensor sty = generator.Decode(mixed, Target(alpha)).rotations.contiguous();
    for (int frame = begin; frame < end; ++frame) {
      Outputs& outputs = reference.outputs[frame];
      std::copy_n(rec[frame - begin].data_ptr<float>(), outputs.reconstruction.size(),
                  outputs.reconstruction.begin());
      std::copy_n(sty[frame - begin].data_ptr<float>(), outputs.styled.size(),
                  outputs.styled.begin());
    }
  }
  return Status::Ok();
}

// Keeps every n-th frame, each segment's first frame and the one after it; n = 0: no frame.
template <typename Rows>
void Thin(const std::vector<Segment>& schedule, int every, Rows& rows) {
  std::erase_if(rows, [&](const auto& row) {
    const int since = row.first - SegmentAt(schedule, row.first).first_frame;
    return every == 0 || (row.first % every != 0 && since > 1);
  });
}

Status Run(const Arguments& a) {
  auto schedule = ParseSchedule(a.schedule);
  if (!schedule.ok()) return schedule.status();
  auto weights = train::style_erd::ReadWeights(a.weights);
  if (!weights.ok()) return weights.status();
  auto weights_crc = FileCrc(a.weights), clip_crc = FileCrc(a.clip);
  if (!clip_crc.ok()) return clip_crc.status();
  auto clip = LoadClip(a, weights.value());
  if (!clip.ok()) return clip.status();

  const torch::NoGradGuard no_grad;
  Reference reference;
  reference.schedule = a.schedule;
  reference.clip_crc = clip_crc.value();
  reference.weights_crc = weights_crc.value();
  reference.frames = a.frames;
  Tensor features = torch::empty({a.frames, erd::kFeatureCount});
  train::FillWindow(clip.value(), 0, a.frames, false, true, weights.value().features,
                    {.features = features.data_ptr<float>()});
  Status status = RunGenerator(weights.value(), features, schedule.value(), reference);
  if (!status.ok()) return status;
  for (int frame = 0; frame < a.frames; ++frame) {
    erd::Features& row = reference.features[frame];
    std::copy_n(features[frame].data_ptr<float>(), row.size(), row.begin());
    reference.outputs[frame].heading_rad =
        std::atan2(clip.value().heading_sin[frame], clip.value().heading_cos[frame]);
  }
  Thin(schedule.value(), a.every, reference.outputs);
  Thin(schedule.value(), a.features_every, reference.features);
  return WriteReference(reference, a.out);
}

}  // namespace
}  // namespace styled::parity

int main(int argc, char** argv) {
  styled::parity::Arguments a;
  CLI::App app{"Computes what the parity tests compare with, by the trainer's own code."};
  app.add_option("clip", a.clip, "BVH file")->required();
  app.add_option("weights", a.weights, "safetensors file")->required();
  app.add_option("out", a.out, "safetensors file to write")->required();
  app.add_option("--dialect", a.dialect, "rig dialect of the clip")->capture_default_str();
  app.add_option("--schedule", a.schedule, "FRAME:STYLE=WEIGHT,...;FRAME:...")
      ->capture_default_str();
  app.add_option("--frames", a.frames, "how many, from the first on")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  app.add_option("--every", a.every, "keep outputs of every n-th frame and around switches")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--features-every", a.features_every, "the same of features; 0: none")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  torch::set_num_threads(1);
  styled::Status status = styled::Status::Ok();
  try {
    status = styled::parity::Run(a);
  } catch (const std::exception& error) {
    status = styled::Status::Error(styled::train::Reason(error));
  }
  if (status.ok()) return 0;
  std::fprintf(stderr, "styled_parity_reference: %s\n", status.message().c_str());
  return 1;
}
