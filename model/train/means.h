#pragma once

#include <torch/torch.h>

#include <functional>
#include <string>
#include <vector>

#include "model/train/recipe.h"

namespace styled::train {

// Means of losses, each over the iterations that had it. The sums are kept on the device, so that
// the log is the only place that waits for it. One thread.
class Means {
 public:
  // A scalar of this iteration.
  void Add(const std::string& name, const torch::Tensor& value);
  Figures Pop();  // in the order of the first Add; restarts

  // From now on the sums stay where they are in memory, so that recorded work can add to them.
  void KeepSums() { keeps_sums_ = true; }
  // Records `work`, which adds to sums that are there: the names that it adds to. Nothing is
  // counted.
  std::vector<std::string> NamesOf(const std::function<void()>& work);
  // An iteration of recorded work, which added to these.
  void Count(const std::vector<std::string>& names);

 private:
  struct Sum {
    std::string name;
    torch::Tensor sum;
    int count;
  };
  std::vector<Sum> sums_;
  bool keeps_sums_ = false;
  std::vector<std::string>* recorded_ = nullptr;  // while work is recorded
};

}  // namespace styled::train
