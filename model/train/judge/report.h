#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "model/clip/manifest.h"
#include "model/train/judge/metrics.h"
#include "model/train/judge/nets.h"
#include "model/train/judge/stream.h"
#include "model/train/judge/text.h"

namespace styled::judge {

// A clip and its styled version, to be judged; both at kStreamRate_hz and of equal length.
struct Transferred {
  int clip = 0;     // number of the input, for the bootstrap
  int style = 0;    // the target
  int content = 0;  // the content of the input
  std::span<const body::Pose> input;
  Poses output;
};

inline constexpr Expression kNoExpression{kNotMeasured, kNotMeasured};

// Frechet distances of one style by one judge's features. `real`: training clips of the target
// against real target clips.
struct Distances {
  double fmd = kNotMeasured, fmd_real = kNotMeasured, fmd_neutral = kNotMeasured;
  // The same by the content judge's features, as Park et al. 2021 measure it.
  double content_fmd = kNotMeasured, content_fmd_real = kNotMeasured;
  double content_fmd_neutral = kNotMeasured;
};

// Every figure for one target style, averaged over contents with equal weights. NaN where it was
// not measured (text.h).
struct StyleFigures {
  Share sra, cra;
  Share sra_real;   // the style judge on real clips of the target
  Share cra_input;  // the content judge on the inputs
  std::vector<double> sra_by_content, cra_by_content;
  std::vector<double> taken_for;  // per style, the share of windows that the judge mistakes for it
  Expression expression = kNoExpression, expression_walk = kNoExpression;
  // the shift of the training clips from neutral to target: the reachable value
  Expression expression_real = kNoExpression;
  std::vector<Expression> expression_by_content;
  std::vector<Distances> distances;  // by judge
  double fmd_windows = 0;            // windows on either side
  // jerk of the output over the input's, at 120 and at 30 Hz
  double jitter_stream = kNotMeasured, jitter_clip = kNotMeasured;
  double jitter_real = kNotMeasured;  // jerk of real target clips over the input's, at 120 Hz
  FeetFigures feet;

  // Over judges: the mean, and the spread where there are several.
  double Distance(double Distances::*of) const;
  double DistanceSpread(double Distances::*of) const;
};

struct Figures {
  std::string name;
  std::vector<StyleFigures> styles;  // [0], neutral, is empty
  Share sra, cra, cra_input;         // over all cells
  Share sra_first;                   // of each clip's first window, when states are fresh
  std::vector<int> unknown;          // cells that the style judge was not trained on: in no SRA
  Share sra_with_unknown;            // except in this one
};

// Judges transferred clips in comparison with real ones. Construction evaluates all real clips
// once.
class Evaluator {
 public:
  // Outputs are compared with `validation`; `train` is the other real set of the Frechet distance;
  // `judge` gives the principal axes. The manifest and judges must outlive this object.
  Evaluator(const clip::Manifest& manifest, const Judges& judges,
            const std::vector<train::TrainingClip>& train,
            const std::vector<train::TrainingClip>& judge,
            const std::vector<train::TrainingClip>& validation);

  const Share& real_style() const { return real_style_; }
  const Share& real_content() const { return real_content_; }
  Figures Measure(const std::string& name, std::span<const Transferred> clips) const;

  std::string CellName(int cell) const;
  nlohmann::json ToJson(const Figures& figures) const;
  // `offset`: the constant offset's figures on the same inputs, of which the means stand below.
  void Print(const Figures& figures, const Figures* offset = nullptr) const;
  nlohmann::json RealToJson() const;

 private:
  using Rows = std::vector<Eigen::RowVectorXd>;
  // One judge's features of each window.
  struct Features {
    Rows embeddings, content_features;
  };
  // The sums over one (style, content) cell of real or transferred clips.
  struct Cell {
    Eigen::VectorXd position_sum = Eigen::VectorXd::Zero(erd::kPositionFeatures);
    double frames = 0;
    std::vector<Features> features;   // by judge
    std::map<int, double> taken_for;  // windows by the style judges' answer, mean over judges
    Mean jerk;

    Eigen::VectorXd MeanPose() const { return position_sum / std::max(1.0, frames); }
    std::size_t windows() const { return features.empty() ? 0 : features[0].embeddings.size(); }
  };
  using Cells = std::vector<Cell>;  // style * contents + content

  int cell_of(int style, int content) const { return style * contents_ + content; }
  // `first`: also the verdict on the first window alone.
  void Gather(const Sequence& sequence, int stride, Cell& cell, ClipVerdict* style,
              ClipVerdict* content, ClipVerdict* first = nullptr) const;
  StyleFigures MeanOf(const Figures& figures) const;  // over styles
  void MeasureStyle(int style, const Cells& out, const Cells& in, StyleFigures& figures) const;
  Distances MeasureDistances(int style, const Cells& out, const Cells& in,
                             std::span<const int> counts, std::size_t judge) const;
  // Equal numbers of windows of each content, as rows.
  Eigen::MatrixXd Pick(const Cells& cells, int style, std::span<const int> counts,
                       std::size_t judge, Rows Features::*features) const;

  const clip::Manifest& manifest_;
  const Judges& judges_;
  int styles_, contents_;
  std::vector<Pca> pca_;  // by judge
  Cells real_, other_real_;
  std::vector<bool> known_;  // by cell: the judge was trained on a window of it
  std::vector<ClipVerdict> real_styles_, real_contents_;
  Share real_style_, real_content_;
};

// How well the network reconstructs neutral clips that it was not trained on.
struct Reconstruction {
  Mean angle_deg, position_cm;
};
Reconstruction MeasureReconstruction(const net::Stylizer& network, std::span<const Poses> clips);

}  // namespace styled::judge
