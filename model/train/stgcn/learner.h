#pragma once

#include <torch/torch.h>

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "model/base/status.h"
#include "model/train/adam.h"
#include "model/train/checkpoint.h"
#include "model/train/recipe.h"
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

// Means of losses, each over the iterations that had it. Kept on the device, so that the log is
// the only place that waits for it.
class Means {
 public:
  void Add(const std::string& name, const torch::Tensor& value);
  Figures Pop();  // in the order of the first Add; restarts

 private:
  struct Sum {
    std::string name;
    torch::Tensor sum;
    int count;
  };
  std::vector<Sum> sums_;
};

// Steers the weight of the diversity loss, which is constant in the paper, to a variety of outputs:
// with a constant weight variety falls while the networks learn.
class DiversityWeight {
 public:
  DiversityWeight(double start, double target_cm) : target_cm_(target_cm), weight_(start) {}
  void Observe(double distance_cm);
  double weight() const { return weight_; }
  void Set(double weight) { weight_ = weight; }

 private:
  double target_cm_, weight_;
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
    // With w_posture: the target mean of the output, [B, 21, 7]; [B]: 1 if there is one.
    torch::Tensor wanted, has_wanted;
  };
  // The result of a turn for a batch.
  struct Made {
    torch::Tensor own_code, target_code;  // [B, code]: of the source, of the target
    torch::Tensor reconstruction, raw;    // decoded with them
    torch::Tensor fake, other_fake;       // published; of the target's two codes
    torch::Tensor free_loss;
  };

  Batch NextBatch();
  void AddWanted(const std::vector<Sample>& samples, Batch& batch) const;
  torch::Tensor Noise(int64_t stream) const;
  Made Make(const Batch& batch, Turn turn);
  void StepTurn(const Batch& batch, Turn turn, double decay);
  void StepWarmUp(const Batch& batch);
  void StepCritic(const Batch& batch, const torch::Tensor& fake, double decay);
  void StepGenerator(const Batch& batch, const Made& made, Turn turn, double decay);
  // losses.cpp, with StepCritic and StepGenerator
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
};

}  // namespace styled::train::st_gcn
