#pragma once

#include <torch/torch.h>

#include <array>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "model/base/status.h"
#include "model/train/adam.h"
#include "model/train/checkpoint.h"
#include "model/train/means.h"
#include "model/train/one_ahead.h"
#include "model/train/recipe.h"
#include "model/train/recorded_work.h"
#include "model/train/stgcn/adam_with_decay.h"
#include "model/train/stgcn/config.h"
#include "model/train/stgcn/kinematics.h"
#include "model/train/stgcn/networks.h"
#include "model/train/stgcn/postures.h"
#include "model/train/stgcn/windows.h"

namespace styled::train::st_gcn {

// The networks that are exported.
struct Networks {
  Networks(const Shape& shape, const torch::Device& device, bool scaled_heads);

  Generator generator;
  Encoder encoder;
  Mapping mapping;

  std::array<std::pair<const char*, Parameters*>, 3> parts() {
    return {{{"generator", &generator.parameters},
             {"encoder", &encoder.parameters},
             {"mapping", &mapping.parameters}}};
  }
  std::array<std::pair<const char*, const Parameters*>, 3> parts() const {
    return {{{"generator", &generator.parameters},
             {"encoder", &encoder.parameters},
             {"mapping", &mapping.parameters}}};
  }
};

// The type of activations: bfloat16 products are twice as fast on CPUs that support them, and half
// as fast on others. `precision`: of Config.
torch::Dtype TypeOf(const std::string& precision, const torch::Device& device);

// Steers the weight of the diversity loss, which is constant in the paper, to a variety of outputs:
// with a constant weight variety falls while the networks learn.
class DiversityWeight {
 public:
  DiversityWeight(double start, double target_cm, const torch::Device& device);
  // The weight until now; then it follows the distance of two outputs. Scalars on the device.
  torch::Tensor Observe(const torch::Tensor& distance_cm);
  const torch::Tensor& weight() const { return weight_; }
  void Set(double weight) { weight_.fill_(weight); }

 private:
  double target_cm_;
  torch::Tensor weight_;
};

// The source of the codes of a generator's step.
enum class Turn { kNoise, kReferences };

// The networks being trained, their optimizers, and one iteration of training (Park et al. 2021,
// section 3.3). Knows nothing of files, logs and clocks. `config` and `store` must outlive it. One
// thread.
class Learner {
 public:
  Learner(const Config& config, uint64_t seed, const WindowStore& store,
          const Statistics& statistics, int domains, const std::vector<bool>& single_act,
          const torch::Device& device);

  // One iteration. `progress` in [0, 1] decides the learning rates.
  void Step(double progress);

  // Everything that the next Step depends on. Restore refuses a checkpoint of other statistics or
  // another shape, and leaves the learner unusable then.
  void Save(Checkpoint& checkpoint) const;
  Status Restore(const Checkpoint& checkpoint);

  bool Finite() const;
  int64_t iteration() const { return iteration_; }
  const Networks& average() const { return average_; }  // running mean of the weights
  const Kinematics& kinematics() const { return kinematics_; }
  const Graph& graph() const { return exact_graph_; }  // float32
  Means& means() { return means_; }
  bool HasAllDomains() const { return sampler_.HasAll(); }

  // The gradients of an iteration stay in these, for tests.
  const Networks& networks() const { return networks_; }
  const Critic& critic() const { return critic_; }

 private:
  struct Batch {
    torch::Tensor source, same_clip, reference1, reference2;  // [B, 64, 21, 7]
    torch::Tensor domain, target, content;                    // [B]
    torch::Tensor paired;                                     // [B]: 1 where the critic compares
    torch::Tensor noise, other_noise;                         // [B, noise]
    // With w_posture: the target mean of the output, [B, 21, 7]; [B]: 1 if there is one.
    torch::Tensor wanted, has_wanted;
    // With w_read: the shifts of ReadPosture, [B, 1, 21, 7].
    torch::Tensor read_wanted, read_source;

    std::array<torch::Tensor*, 14> all() {
      return {&source, &same_clip,  &reference1,  &reference2, &domain,
              &target, &content,    &paired,      &noise,      &other_noise,
              &wanted, &has_wanted, &read_wanted, &read_source};
    }
  };
  // The result of a turn for a batch.
  struct Made {
    torch::Tensor own_code, target_code;  // [B, code]: of the source, of the target
    torch::Tensor reconstruction, raw;    // decoded with them
    torch::Tensor fake, other_fake;       // Judged; of the target's two codes
    torch::Tensor free_loss;
  };

  // The recordings of a turn, and what the first part leaves to the second.
  struct RecordedTurn {
    RecordedWork critic, generator;
    Made made;
  };

  OneAhead<Batch>::Made MakeBatch(int64_t iteration);
  const Batch& NextBatch();
  void AddWanted(const std::vector<Sample>& samples, Batch& batch) const;
  void AddReadShifts(int64_t iteration, Batch& batch) const;
  torch::Tensor Noise(int64_t iteration, int64_t stream) const;
  Made Make(const Batch& batch, Turn turn);
  // The window that the losses see.
  torch::Tensor Judged(const torch::Tensor& decoded) const {
    return config_.judge_published ? kinematics_.Published(decoded) : decoded;
  }
  bool Penalized() const;
  void Run(RecordedWork& recorded, const std::function<void()>& work);
  void StepTurn(const Batch& batch, Turn turn, double decay);
  void StepBothTurns(const Batch& batch, double decay);
  void StepWarmUp(const Batch& batch);
  // The gradients; then a step along them.
  void TeachCritic(const Batch& batch, const torch::Tensor& fake);
  void StepCritic(double decay);
  void TeachGenerator(const Batch& batch, const Made& made, Turn turn);
  void StepGenerator(Turn turn, double decay);
  // losses.cpp, with the four before
  torch::Tensor Losses(const Batch& batch, const Made& made, Turn turn);
  torch::Tensor BodyLosses(const Batch& batch, const Made& made);
  torch::Tensor Posture(const Batch& batch, const Made& made);
  torch::Tensor ReadPosture(const Batch& batch);
  torch::Tensor Diversity(const Made& made, Turn turn, const std::string& suffix);
  torch::Tensor FreeLoss(const torch::Tensor& features, const torch::Tensor& code) const;
  void StepAdam(Parameters& parameters, AdamWithDecay& adam, double rate) const;
  void UpdateAverage();

  const Config& config_;
  const uint64_t seed_;
  const torch::Device device_;
  const WindowStore& store_;
  const Kinematics kinematics_;
  const Graph graph_, exact_graph_;
  const Postures postures_;
  Sampler sampler_;
  Networks networks_, average_;
  Critic critic_;
  AdamWithDecay generator_adam_, encoder_adam_, mapping_adam_, critic_adam_;
  std::array<DiversityWeight, 2> diversity_;  // by Turn
  int64_t iteration_ = 0;
  Means means_;
  const bool records_;  // whether iterations are recorded and launched as a whole
  RecordedWork warm_up_;
  std::array<std::array<RecordedTurn, 2>, 2>
      turns_;                // by Turn, and whether the critic is penalized
  Batch batch_;              // on the device
  OneAhead<Batch> batches_;  // destroyed first: it uses the others
};

}  // namespace styled::train::st_gcn
