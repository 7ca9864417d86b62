#pragma once

#include <torch/torch.h>

#include <vector>

#include "model/train/stgcn/kinematics.h"

namespace styled::train::st_gcn_causal {

// The published form of a performer's window whose style changes, differentiable: the change is
// applied to the performer's own pose, in · (between⁻¹ · sty) per joint in local rotations, where
// `between` is half-way from the reconstruction to the input (model/net/stgcn_causal/stylizer.h),
// and the difference of both heights of the hips. The later live stages (the low-pass, limits,
// feet) are left out. Windows are standardized, [B, T, 21, 7] in float32. Pinned by
// tests/unit/train/stgcn_causal/published_form_test.cpp.
class PublishedForm {
 public:
  explicit PublishedForm(const st_gcn::Statistics& statistics);

  // The part of a window's data that does not depend on the style.
  struct Basis {
    torch::Tensor rotations;  // [B, T, 21, 4]: in · between⁻¹, local
    torch::Tensor hips_m;     // [B, T]: height, in - rec

    Basis Select(const torch::Tensor& samples) const;
  };
  Basis BasisOf(const torch::Tensor& window, const torch::Tensor& reconstruction) const;

  // The published window: rotations on the hemisphere of the mean, positions that follow from them.
  torch::Tensor operator()(const Basis& basis, const torch::Tensor& styled) const;

  // The teacher's change of style `frames` later, `gain` times as large, applied to its output for
  // the window in its own style: the target of a student whose change is published late, by a
  // low-pass. `frames` need not be whole; the last ones of the window have no later change and keep
  // the last. Positions and the hips' height follow in the features themselves.
  torch::Tensor Later(const torch::Tensor& reconstruction, const torch::Tensor& styled,
                      double frames, double gain) const;

  const st_gcn::Kinematics& kinematics() const { return kinematics_; }

 private:
  torch::Tensor LocalRotations(const torch::Tensor& raw) const;
  torch::Tensor GlobalRotations(const torch::Tensor& local) const;
  // Unit rotations relative to the heading, on the hemisphere of the mean, in the features' form.
  torch::Tensor OnHemisphere(const torch::Tensor& global) const;

  st_gcn::Kinematics kinematics_;
  torch::Tensor parents_;  // [21]; the hips' is 0
  // Of each depth of the skeleton below the hips: its joints, and the places of their parents among
  // the joints of the depth before it.
  struct Depth {
    torch::Tensor joints, parents;
  };
  std::vector<Depth> depths_;
  torch::Tensor order_;  // [21]: a joint's place among those of all depths
};

}  // namespace styled::train::st_gcn_causal
