#include "model/train/judge/action_figures.h"

#include <algorithm>
#include <cstdio>

#include "model/train/judge/sha256.h"
#include "model/train/judge/text.h"

namespace styled::judge {
namespace {

Eigen::MatrixXd Stacked(const std::vector<Eigen::RowVectorXd>& rows) {
  Eigen::MatrixXd samples(static_cast<Eigen::Index>(rows.size()), rows.front().cols());
  for (std::size_t i = 0; i < rows.size(); ++i) samples.row(static_cast<Eigen::Index>(i)) = rows[i];
  return samples;
}

// `count` of the windows, evenly spread.
void AppendSome(const std::vector<Eigen::RowVectorXd>& from, std::size_t count,
                std::vector<Eigen::RowVectorXd>& to) {
  for (std::size_t i = 0; i < count; ++i) to.push_back(from[from.size() * i / count]);
}

}  // namespace

double ActionFigures::Fmd() const {
  Mean mean;
  for (const double value : fmd) mean.Add(value);
  return Measured(mean);
}

ActionComparison::ActionComparison(const Data& data, const ActionClassifiers& classifiers)
    : data_(data), classifiers_(classifiers), real_(NoWindows()) {
  for (std::size_t i = 0; i < data.validation.size(); ++i) {
    const train::TrainingClip& clip = data.validation[i];
    if (clip.style == 0) continue;
    verdicts_on_real_.push_back(
        Gather(clip.poses, static_cast<int>(i), clip.style, clip.content, real_));
  }
}

ActionComparison::Cells ActionComparison::NoWindows() const {
  const std::size_t cells = data_.manifest.styles.size() * data_.manifest.contents.size();
  return Cells(static_cast<std::size_t>(classifiers_.settings().count),
               std::vector<Windows>(cells));
}

ClipVerdict ActionComparison::Gather(std::span<const body::Pose> poses, int clip, int style,
                                     int content, Cells& cells) const {
  const int cell = style * static_cast<int>(data_.manifest.contents.size()) + content;
  const std::vector<ActionClassifiers::Verdicts> by_seed = classifiers_.Judge(
      MakeSequence(poses, style, content, false, classifiers_.parameters()), kStride);
  std::vector<double> hits;
  for (std::size_t i = 0; i < by_seed.size(); ++i) {
    const std::vector<int>& answers = by_seed[i].content;
    hits.push_back(static_cast<double>(std::count(answers.begin(), answers.end(), content)));
    Windows& windows = cells[i][static_cast<std::size_t>(cell)];
    for (Eigen::Index row = 0; row < by_seed[i].features.rows(); ++row) {
      windows.emplace_back(by_seed[i].features.row(row));
    }
  }
  ClipVerdict verdict{.cell = cell, .clip = clip};
  verdict.Add(hits, static_cast<double>(by_seed.front().content.size()));
  return verdict;
}

std::vector<double> ActionComparison::Distances(const Cells& cells) const {
  std::vector<double> distances;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    Windows found;
    Windows real;
    for (std::size_t cell = 0; cell < cells[i].size(); ++cell) {
      const std::size_t count = std::min(cells[i][cell].size(), real_[i][cell].size());
      AppendSome(cells[i][cell], count, found);
      AppendSome(real_[i][cell], count, real);
    }
    distances.push_back(found.size() < kLeastActionWindows
                            ? kNotMeasured
                            : FrechetDistance(Stacked(found), Stacked(real)));
  }
  return distances;
}

ActionFigures ActionComparison::OfReal() const {
  Cells other = NoWindows();
  for (const train::TrainingClip& clip : data_.train) {
    if (clip.style == 0) continue;
    Gather(clip.poses, 0, clip.style, clip.content, other);
  }
  return {.key = "real",
          .title = "real clips",
          .accuracy = MacroShare(verdicts_on_real_, kIntervalSeed),
          .fmd = Distances(other)};
}

ActionFigures ActionComparison::OfStyled(std::string key, std::string title,
                                         std::span<const Transferred> clips) const {
  Cells cells = NoWindows();
  std::vector<ClipVerdict> verdicts;
  for (const Transferred& clip : clips) {
    if (clip.style == 0) continue;
    verdicts.push_back(Gather(Thin(clip.output), clip.clip, clip.style, clip.content, cells));
  }
  return {.key = std::move(key),
          .title = std::move(title),
          .accuracy = MacroShare(verdicts, kIntervalSeed),
          .fmd = Distances(cells)};
}

void Print(std::span<const ActionFigures> sets, const ActionClassifiers& classifiers) {
  std::printf(
      "\naction classifiers (ST-GCN, Park et al. 2021), seeds %u to %u, SHA-256 %s\n%-18s %-22s "
      "FMD-a\n",
      classifiers.settings().seed,
      classifiers.settings().seed + static_cast<unsigned>(classifiers.settings().count) - 1,
      Shown(classifiers.hash()).c_str(), "", "accuracy [95 %]");
  for (const ActionFigures& set : sets) {
    std::printf("%-18s %s [%.2f %.2f]  %s\n", set.title.c_str(), Padded(set.accuracy, 0, 2).c_str(),
                set.accuracy.low, set.accuracy.high,
                Padded(set.Fmd(), Spread(set.fmd), 0, 2).c_str());
  }
}

nlohmann::json ToJson(std::span<const ActionFigures> sets, const ActionClassifiers& classifiers) {
  nlohmann::json json = {{"sha256", classifiers.hash()}, {"sets", nlohmann::json::object()}};
  for (const ActionFigures& set : sets) {
    json["sets"][set.key] = {{"title", set.title},
                             {"accuracy", Value(Measured(set.accuracy))},
                             {"accuracy_spread", Value(set.accuracy.spread())},
                             {"accuracy_low", set.accuracy.low},
                             {"accuracy_high", set.accuracy.high},
                             {"windows", set.accuracy.windows},
                             {"fmd", Value(set.Fmd())},
                             {"fmd_spread", Value(Spread(set.fmd))}};
  }
  return json;
}

}  // namespace styled::judge
