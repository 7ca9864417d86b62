#include "model/train/means.h"

namespace styled::train {

using torch::Tensor;

void Means::Add(const std::string& name, const Tensor& value) {
  const torch::NoGradGuard no_grad;
  if (recorded_ != nullptr) recorded_->push_back(name);
  for (Sum& one : sums_) {
    if (one.name != name) continue;
    one.sum += value.detach();
    if (recorded_ == nullptr) ++one.count;
    return;
  }
  TORCH_CHECK(recorded_ == nullptr, "no sum of ", name, " before it is recorded");
  sums_.push_back({name, value.detach().clone(), 1});
}

Figures Means::Pop() {
  Figures figures;
  for (Sum& one : sums_) {
    if (one.count == 0) continue;
    figures.emplace_back(one.name, one.sum.item<double>() / one.count);
    one.sum.zero_();
    one.count = 0;
  }
  if (!keeps_sums_) sums_.clear();
  return figures;
}

std::vector<std::string> Means::NamesOf(const std::function<void()>& work) {
  std::vector<std::string> names;
  recorded_ = &names;
  work();
  recorded_ = nullptr;
  return names;
}

void Means::Count(const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    for (Sum& one : sums_) {
      if (one.name == name) ++one.count;
    }
  }
}

}  // namespace styled::train
