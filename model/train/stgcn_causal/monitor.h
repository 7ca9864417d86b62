#pragma once

#include <torch/torch.h>

#include <vector>

#include "model/train/recipe.h"
#include "model/train/stgcn/monitor.h"
#include "model/train/stgcn_causal/learner.h"

namespace styled::train::st_gcn_causal {

// A cheap check of a run's progress: neutral validation windows in each style, as published.
// Figures: reconstruction_cm and styled_cm, the mean joint distance to the teacher's output for the
// window, without its first 8 frames; start_cm, styled_cm of those frames; identity_cm, from the
// reconstruction to the window; then for the styled windows the measurements of st-gcn's monitor,
// with "student" appended to its names. One thread. References must outlive it.
class Monitor {
 public:
  // `styles`: of each style that `windows` judges, the teacher's; the first is neutral.
  Monitor(const st_gcn::Monitor& windows, const st_gcn::Kinematics& kinematics,
          std::vector<int64_t> styles, const Teacher& teacher);

  MonitorReport Evaluate(const Student& student, const Graph& graph) const;
  // The same figures of the teacher.
  const std::string& teacher() const { return teacher_report_; }

 private:
  torch::Tensor CodeOf(std::size_t style) const;  // for each window

  const st_gcn::Monitor& windows_;
  const st_gcn::Kinematics& kinematics_;
  const std::vector<int64_t> styles_;
  const Teacher& teacher_;
  std::vector<torch::Tensor> wanted_;  // by style: the teacher's, as published
  std::string teacher_report_;
};

}  // namespace styled::train::st_gcn_causal
