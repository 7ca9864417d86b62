#pragma once

#include "model/train/adam.h"

namespace styled::train::st_gcn {

// Adam (Kingma & Ba 2015) with the gradient of half the squared weights, times `decay`, added to
// the losses'. On the CPU in one pass over the memory: the networks have four million numbers, and
// an operation of libtorch per term took a tenth of an iteration. first, second and steps are the
// whole state.
class AdamWithDecay : public Adam {
 public:
  AdamWithDecay(const Parameters& parameters, double beta1, double beta2)
      : Adam(parameters, beta1, beta2), beta1_(beta1), beta2_(beta2) {}
  void Step(Parameters& parameters, double rate, double decay);

 private:
  double beta1_, beta2_;
};

}  // namespace styled::train::st_gcn
