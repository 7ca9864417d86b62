#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "model/train/judge/action_classifier.h"
#include "model/train/judge/data.h"
#include "model/train/judge/report.h"

namespace styled::judge {

// The two figures of Park et al. 2021 (section 7) of one set of clips, by ActionClassifiers.
struct ActionFigures {
  std::string key, title;
  Share accuracy;           // of windows whose content is recognized; mean over cells
  std::vector<double> fmd;  // by classifier; NaN with fewer windows than kLeastActionWindows

  double Fmd() const;
};

// Twice the number of features; fewer windows have no covariance worth a distance.
inline constexpr std::size_t kLeastActionWindows = 64;

// Compares sets of clips with the real clips of `data.validation`. Distances are between all
// windows of all styles but neutral, with equal numbers per style and content on both sides; there
// are as many of each as the smaller side has. Both arguments must outlive this object.
class ActionComparison {
 public:
  ActionComparison(const Data& data, const ActionClassifiers& classifiers);

  // The real clips, and their distance from those that trained the generator: the floor.
  ActionFigures OfReal() const;
  ActionFigures OfStyled(std::string key, std::string title,
                         std::span<const Transferred> clips) const;

 private:
  using Windows = std::vector<Eigen::RowVectorXd>;
  // By classifier, then by cell (style * contents + content).
  using Cells = std::vector<std::vector<Windows>>;

  Cells NoWindows() const;
  ClipVerdict Gather(std::span<const body::Pose> poses, int clip, int style, int content,
                     Cells& cells) const;
  std::vector<double> Distances(const Cells& cells) const;

  const Data& data_;
  const ActionClassifiers& classifiers_;
  Cells real_;
  std::vector<ClipVerdict> verdicts_on_real_;
};

// A row per set; the first must be of real clips.
void Print(std::span<const ActionFigures> sets, const ActionClassifiers& classifiers);
nlohmann::json ToJson(std::span<const ActionFigures> sets, const ActionClassifiers& classifiers);

}  // namespace styled::judge
