#pragma once

#include <torch/torch.h>

#include <string>
#include <vector>

#include "model/clip/manifest.h"
#include "model/train/recipe.h"
#include "model/train/stgcn/learner.h"

namespace styled::train::st_gcn {

// A quick classifier of windows: ridge regression from means, deviations and speeds of the features
// to labels. It sees less than styleeval's judges, and learns in a second.
class QuickJudge {
 public:
  // Windows [N, 64, 21, 7], labels int64 [N] below `labels`. Every label that occurs has the same
  // weight.
  void Learn(const torch::Tensor& windows, const torch::Tensor& label, int64_t labels);
  torch::Tensor Judge(const torch::Tensor& windows) const;  // int64 [N]

 private:
  torch::Tensor mean_, deviation_, weights_;
};

// A cheap check of a run's progress: neutral validation windows in each style, by noise and by one
// training window of the style each. Figures: identity_cm, the mean joint distance of a window
// decoded with its own code; apart_cm, of two outputs of one window by noise; then for both kinds
// style and content, the shares that quick judges recognize; expression and cosine, the shift of
// the mean pose along the real one's and the cosine between the two, means over styles; jerk_ratio,
// mean joint jerk over the input's. Not the evaluation: styleeval has judges of its own, which were
// trained on other clips. Only contents in which a style was recorded count. One thread.
class Monitor {
 public:
  // `validation` holds the clips of the split; needs neutral ones.
  Monitor(const WindowStore& train, const WindowStore& validation,
          const std::vector<clip::ManifestStyle>& styles, int contents,
          const Kinematics& kinematics, const torch::Device& device);

  MonitorReport Evaluate(const Networks& networks, const Graph& graph) const;
  const std::string& reals() const { return reals_; }  // the judges' results for real windows

  // The parts of Evaluate, for other networks of the same features: the windows to be styled,
  // standardized [N, 64, 21, 7]; and a function that adds to `report` the figures, with `name`
  // appended to theirs, of a network's published outputs in each style but neutral.
  const torch::Tensor& source() const { return source_; }
  void Judge(const std::string& name, const std::vector<torch::Tensor>& outputs,
             MonitorReport& report) const {
    Report(Measure(name, outputs), report);
  }

 private:
  struct Kind {
    std::string name;
    double style = 0, content = 0, expression = 0, cosine = 0, jerk = 0;
    std::vector<double> style_of;  // per style
  };
  void TeachJudges(const WindowStore& train, const WindowStore& validation, int contents);
  void MeasureShifts(const WindowStore& train, int contents);
  void AddStyle(int64_t style, const torch::Tensor& outputs, Kind& kind) const;
  void Report(const Kind& kind, MonitorReport& report) const;
  Kind Measure(const std::string& name, const std::vector<torch::Tensor>& outputs) const;

  const Kinematics& kinematics_;
  const torch::Device device_;
  std::vector<std::string> names_;  // of the styles; [0] neutral
  torch::Tensor source_, content_;  // [N, 64, 21, 7], [N]
  torch::Tensor reference_;         // [styles, 64, 21, 7]
  torch::Tensor shift_m_;           // [styles, contents, 63]: of real mean poses, neutral's less
  torch::Tensor present_;           // [styles, contents] bool
  QuickJudge style_judge_, content_judge_;
  std::string reals_;
};

}  // namespace styled::train::st_gcn
