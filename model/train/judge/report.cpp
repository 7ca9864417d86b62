#include "model/train/judge/report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <initializer_list>

#include "model/body/heading.h"
#include "model/clip/clip.h"
#include "model/train/judge/text.h"

namespace styled::judge {
namespace {

constexpr int kSparseStride = 24;  // for splits with plenty of clips
constexpr int kFmdDimensions = 32;
constexpr std::uint64_t kSeed = 1;
// least share of windows mistaken for another style that is printed
constexpr double kWorthSaying = 0.05;

nlohmann::json ShareToJson(const Share& share) {
  return {{"value", Value(Measured(share))},
          {"spread", Value(share.spread())},
          {"low", share.low},
          {"high", share.high},
          {"windows", share.windows},
          {"worst", share.worst}};
}

double Deepest_cm(const FeetFigures& feet) {
  return feet.penetration_cm.count > 0 ? feet.deepest_cm : kNotMeasured;
}

// The Frechet distances with their names in JSON, in the order of the table.
struct DistanceColumn {
  const char* key;
  double Distances::*of;
  int width;
};
constexpr std::array<DistanceColumn, 6> kDistances{{
    {"fmd", &Distances::fmd, 7},
    {"fmd_real_real", &Distances::fmd_real, 5},
    {"fmd_neutral_target", &Distances::fmd_neutral, 6},
    {"content_fmd", &Distances::content_fmd, 6},
    {"content_fmd_real_real", &Distances::content_fmd_real, 5},
    {"content_fmd_neutral_target", &Distances::content_fmd_neutral, 5},
}};

// A share as a table's cell: the spread over judges where there are several, and the interval.
std::string Interval(const Share& share) {
  if (share.windows <= 0) return "      -          ";
  char text[48];
  std::snprintf(text, sizeof text, " [%.2f %.2f]", share.low, share.high);
  return Padded(share, 5, 3) + text;
}

std::string Joined(std::initializer_list<std::string> cells) {
  std::string text;
  for (const std::string& cell : cells) text.append(text.empty() ? 0 : 1, ' ').append(cell);
  return text;
}

std::string ShiftsAndDistances(const StyleFigures& of) {
  const auto both = [](const Expression& expression) {
    return Joined({Padded(expression.fraction, 5, 2), Padded(expression.cosine, 5, 2)});
  };
  std::string text =
      Joined({both(of.expression), both(of.expression_walk), both(of.expression_real)});
  for (const DistanceColumn& column : kDistances) {
    text += " " + Padded(of.Distance(column.of), of.DistanceSpread(column.of), column.width, 2);
  }
  return text;
}

std::string JerkAndFeet(const StyleFigures& of) {
  return Joined({Padded(of.jitter_stream, 6, 2), Padded(of.jitter_clip, 5, 2),
                 Padded(of.jitter_real, 5, 2), Padded(Measured(of.feet.skate_in_cm_s), 6, 1), ">",
                 Padded(Measured(of.feet.skate_out_cm_s), 4, 1),
                 Padded(Measured(of.feet.penetration_cm), 4, 2),
                 Padded(Deepest_cm(of.feet), 4, 1)});
}

std::vector<ClipVerdict> Of(std::span<const ClipVerdict> verdicts, int style, int contents) {
  std::vector<ClipVerdict> of;
  for (const ClipVerdict& verdict : verdicts) {
    if (verdict.cell / contents == style) of.push_back(verdict);
  }
  return of;
}

void PrintHeader(bool several) {
  const int share = several ? 7 : 0;  // characters of " ±0.003"
  const int distance = several ? 6 : 0;
  std::printf("%-10s", "style");
  for (const char* const share_of : {"SRA", "CRA"}) {
    const std::string title = std::string(share_of) + (several ? " judges [95 %]" : " [95 %]");
    std::printf(" %-*s %-*s", 17 + share, title.c_str(), 5 + share,
                share_of[0] == 'S' ? "real" : "in");
  }
  std::printf("  %-11s %-11s %-11s ", " expr   cos", " walk   cos", " real   cos");
  for (const char* const title : {"FMD", "FMD-c"}) {
    const DistanceColumn* const column = &kDistances[title[3] == '-' ? 3 : 0];
    std::printf(" %*s%*s %*s%*s %*s%*s", column[0].width, title, distance, "", column[1].width,
                "real", distance, "", column[2].width, "neutr", distance, "");
  }
  std::printf("  %5s %5s %5s  %-12s %-9s\n", "jit120", "jit30", "real", " skate cm/s", "floor cm");
}

// A distance by each judge.
std::vector<double> OfJudges(std::span<const Distances> distances, double Distances::*of) {
  std::vector<double> values;
  for (const Distances& judge : distances) values.push_back(judge.*of);
  return values;
}

// Over the styles that have them, by judge.
std::vector<Distances> MeanDistances(std::span<const StyleFigures> styles) {
  std::vector<Distances> means;
  for (const StyleFigures& style : styles) {
    means.resize(std::max(means.size(), style.distances.size()));
  }
  for (std::size_t judge = 0; judge < means.size(); ++judge) {
    for (const DistanceColumn& column : kDistances) {
      Mean mean;
      for (const StyleFigures& style : styles) {
        if (judge < style.distances.size()) mean.Add(style.distances[judge].*column.of);
      }
      means[judge].*column.of = Measured(mean);
    }
  }
  return means;
}

}  // namespace

double StyleFigures::Distance(double Distances::*of) const {
  Mean mean;
  for (const double value : OfJudges(distances, of)) mean.Add(value);
  return Measured(mean);
}

double StyleFigures::DistanceSpread(double Distances::*of) const {
  return Spread(OfJudges(distances, of));
}

Evaluator::Evaluator(const clip::Manifest& manifest, const Judges& judges,
                     const std::vector<train::TrainingClip>& train,
                     const std::vector<train::TrainingClip>& judge,
                     const std::vector<train::TrainingClip>& validation)
    : manifest_(manifest),
      judges_(judges),
      styles_(static_cast<int>(manifest.styles.size())),
      contents_(static_cast<int>(manifest.contents.size())),
      real_(static_cast<std::size_t>(styles_ * contents_)),
      other_real_(real_),
      known_(real_.size(), false) {
  const auto sequence = [&](const train::TrainingClip& clip) {
    return MakeSequence(clip.poses, clip.style, clip.content, false, judges.parameters());
  };
  Cell of_judge;
  for (const train::TrainingClip& clip : judge) {
    const std::size_t before = of_judge.windows();
    Gather(sequence(clip), kSparseStride, of_judge, nullptr, nullptr);
    if (of_judge.windows() > before) known_[cell_of(clip.style, clip.content)] = true;
  }
  for (const Features& features : of_judge.features) {
    const Rows& rows = features.embeddings;
    Eigen::MatrixXd samples(static_cast<Eigen::Index>(rows.size()), rows.front().cols());
    for (std::size_t i = 0; i < rows.size(); ++i) samples.row(i) = rows[i];
    pca_.push_back(FitPca(samples, kFmdDimensions));
  }

  for (const train::TrainingClip& clip : train) {
    Gather(sequence(clip), kSparseStride, other_real_[cell_of(clip.style, clip.content)], nullptr,
           nullptr);
  }
  for (std::size_t i = 0; i < validation.size(); ++i) {
    const train::TrainingClip& clip = validation[i];
    const int cell = cell_of(clip.style, clip.content);
    ClipVerdict style{.cell = cell, .clip = static_cast<int>(i)};
    ClipVerdict content = style;
    Gather(sequence(clip), kStride, real_[cell], &style, &content);
    if (known_[cell]) real_styles_.push_back(style);
    real_contents_.push_back(content);
    real_[cell].jerk.Add(
        MeanJerk(clip::ResamplePoses(clip.poses, kJudgeRate_hz, kStreamRate_hz), kStreamRate_hz));
  }
  real_style_ = MacroShare(real_styles_, kSeed);
  real_content_ = MacroShare(real_contents_, kSeed);
}

void Evaluator::Gather(const Sequence& sequence, int stride, Cell& cell, ClipVerdict* style,
                       ClipVerdict* content, ClipVerdict* first) const {
  const std::vector<Verdicts> by_judge = judges_.Judge(sequence, stride);
  const auto windows = static_cast<double>(by_judge.front().starts.size());
  const auto hits = [&by_judge](std::vector<int> Verdicts::*answers, int right) {
    return Hits(by_judge, answers, right);
  };
  if (style != nullptr) style->Add(hits(&Verdicts::style, sequence.style), windows);
  if (content != nullptr) content->Add(hits(&Verdicts::content, sequence.content), windows);
  if (first != nullptr && windows > 0) {
    std::vector<double> of_first;
    for (const Verdicts& verdicts : by_judge) {
      of_first.push_back(verdicts.style.front() == sequence.style ? 1 : 0);
    }
    first->Add(of_first, 1);
  }
  cell.features.resize(by_judge.size());
  for (std::size_t judge = 0; judge < by_judge.size(); ++judge) {
    const Verdicts& verdicts = by_judge[judge];
    Features& features = cell.features[judge];
    for (std::size_t i = 0; i < verdicts.starts.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      cell.taken_for[verdicts.style[i]] += 1.0 / static_cast<double>(by_judge.size());
      features.embeddings.emplace_back(verdicts.embedding.row(row));
      features.content_features.emplace_back(verdicts.content_features.row(row));
    }
  }
  for (const erd::Features& frame : sequence.frames) {
    cell.position_sum += Eigen::Map<const Eigen::VectorXf>(frame.data() + erd::kPositionBegin,
                                                           erd::kPositionFeatures)
                             .cast<double>();
    cell.frames += 1;
  }
}

Figures Evaluator::Measure(const std::string& name, std::span<const Transferred> clips) const {
  Figures figures{.name = name,
                  .styles = {},
                  .sra = {},
                  .cra = {},
                  .cra_input = {},
                  .sra_first = {},
                  .unknown = {},
                  .sra_with_unknown = {}};
  figures.styles.resize(static_cast<std::size_t>(styles_));
  Cells out(real_.size());
  Cells in(real_.size());
  std::vector<ClipVerdict> sra;
  std::vector<ClipVerdict> sra_with_unknown;
  std::vector<ClipVerdict> cra;
  std::vector<ClipVerdict> cra_input;
  std::vector<ClipVerdict> sra_first;
  std::vector<Mean> jerk_30_out(out.size());
  std::vector<Mean> jerk_30_in(out.size());
  for (const Transferred& clip : clips) {
    const int cell = cell_of(clip.style, clip.content);
    ClipVerdict style{.cell = cell, .clip = clip.clip};
    ClipVerdict content = style;
    ClipVerdict content_input = style;
    ClipVerdict first = style;
    const Poses thin_out = Thin(clip.output);
    const Poses thin_in = Thin(clip.input);
    Gather(MakeSequence(thin_out, clip.style, clip.content, false, judges_.parameters()), kStride,
           out[cell], &style, &content, &first);
    Gather(MakeSequence(thin_in, clip.style, clip.content, false, judges_.parameters()), kStride,
           in[cell], nullptr, &content_input);
    sra_with_unknown.push_back(style);
    if (known_[cell]) sra.push_back(style);
    cra.push_back(content);
    cra_input.push_back(content_input);
    if (known_[cell]) sra_first.push_back(first);
    out[cell].jerk.Add(MeanJerk(clip.output, kStreamRate_hz));
    in[cell].jerk.Add(MeanJerk(clip.input, kStreamRate_hz));
    jerk_30_out[cell].Add(MeanJerk(thin_out, kJudgeRate_hz));
    jerk_30_in[cell].Add(MeanJerk(thin_in, kJudgeRate_hz));
    figures.styles[clip.style].feet.Add(MeasureFeet(clip.input, clip.output, kStreamRate_hz));
  }
  figures.sra = MacroShare(sra, kSeed);
  figures.sra_with_unknown = MacroShare(sra_with_unknown, kSeed);
  figures.cra = MacroShare(cra, kSeed);
  figures.cra_input = MacroShare(cra_input, kSeed);
  figures.sra_first = MacroShare(sra_first, kSeed);

  figures.styles[0].sra = MacroShare(Of(sra, 0, contents_), kSeed);
  for (int style = 1; style < styles_; ++style) {
    StyleFigures& of = figures.styles[style];
    of.sra = MacroShare(Of(sra, style, contents_), kSeed);
    of.cra = MacroShare(Of(cra, style, contents_), kSeed);
    of.cra_input = MacroShare(Of(cra_input, style, contents_), kSeed);
    of.sra_real = MacroShare(Of(real_styles_, style, contents_), kSeed);
    of.taken_for.resize(static_cast<std::size_t>(styles_));
    double contents = 0;
    for (int content = 0; content < contents_; ++content) {
      const int place = cell_of(style, content);
      const auto windows = static_cast<double>(out[place].windows());
      if (windows > 0 && known_[place]) {
        contents += 1;
        for (const auto& [other, count] : out[place].taken_for) {
          of.taken_for[other] += count / windows;
        }
      } else if (windows > 0) {
        figures.unknown.push_back(place);
      }
      const auto share = [&](const std::vector<ClipVerdict>& verdicts) {
        Mean mean;
        for (const ClipVerdict& verdict : verdicts) {
          if (verdict.cell == place) mean.Add({verdict.hits, verdict.windows});
        }
        return Measured(mean);
      };
      of.sra_by_content.push_back(share(sra));
      of.cra_by_content.push_back(share(cra));
    }
    for (double& share : of.taken_for) share /= std::max(1.0, contents);
    MeasureStyle(style, out, in, of);
    double at_30_out = 0;
    double at_30_in = 0;
    for (int content = 0; content < contents_; ++content) {
      at_30_out += jerk_30_out[cell_of(style, content)].value();
      at_30_in += jerk_30_in[cell_of(style, content)].value();
    }
    of.jitter_clip = at_30_in > 0 ? at_30_out / at_30_in : kNotMeasured;
  }
  return figures;
}

void Evaluator::MeasureStyle(int style, const Cells& out, const Cells& in,
                             StyleFigures& figures) const {
  Eigen::VectorXd shift = Eigen::VectorXd::Zero(erd::kPositionFeatures);
  Eigen::VectorXd real_shift = shift;
  Eigen::VectorXd other_shift = shift;
  figures.expression_by_content.resize(static_cast<std::size_t>(contents_),
                                       {kNotMeasured, kNotMeasured});
  std::vector<int> counts(static_cast<std::size_t>(contents_), 0);
  double jerk_out = 0;
  double jerk_in = 0;
  double jerk_real = 0;
  for (int content = 0; content < contents_; ++content) {
    const Cell& styled = out[cell_of(style, content)];
    const Cell& input = in[cell_of(style, content)];
    const Cell& real = real_[cell_of(style, content)];
    const Cell& neutral = real_[cell_of(0, content)];
    if (styled.frames == 0 || real.frames == 0 || neutral.frames == 0) continue;
    const Eigen::VectorXd here = styled.MeanPose() - input.MeanPose();
    const Eigen::VectorXd real_here = real.MeanPose() - neutral.MeanPose();
    figures.expression_by_content[content] = MeasureExpression(here, real_here);
    if (manifest_.contents[content] == "walk") {
      figures.expression_walk = figures.expression_by_content[content];
    }
    other_shift += other_real_[cell_of(style, content)].MeanPose() -
                   other_real_[cell_of(0, content)].MeanPose();
    shift += here;
    real_shift += real_here;
    jerk_out += styled.jerk.value();
    jerk_in += input.jerk.value();
    jerk_real += real.jerk.value();
    counts[content] = static_cast<int>(std::min({styled.windows(), real.windows(), input.windows(),
                                                 other_real_[cell_of(style, content)].windows()}));
    figures.fmd_windows += counts[content];
  }
  if (jerk_in <= 0) return;  // no content has both styled and real clips
  figures.expression = MeasureExpression(shift, real_shift);
  figures.expression_real = MeasureExpression(other_shift, real_shift);
  figures.jitter_stream = jerk_in > 0 ? jerk_out / jerk_in : kNotMeasured;
  figures.jitter_real = jerk_in > 0 ? jerk_real / jerk_in : kNotMeasured;
  if (figures.fmd_windows < 2 * kFmdDimensions) return;
  for (std::size_t judge = 0; judge < pca_.size(); ++judge) {
    figures.distances.push_back(MeasureDistances(style, out, in, counts, judge));
  }
}

Distances Evaluator::MeasureDistances(int style, const Cells& out, const Cells& in,
                                      std::span<const int> counts, std::size_t judge) const {
  const auto axes = [&](const Cells& cells) {
    return pca_[judge].Project(Pick(cells, style, counts, judge, &Features::embeddings));
  };
  const auto pooled = [&](const Cells& cells) {
    return Pick(cells, style, counts, judge, &Features::content_features);
  };
  const Eigen::MatrixXd target = axes(real_);
  const Eigen::MatrixXd pooled_target = pooled(real_);
  return {.fmd = FrechetDistance(axes(out), target),
          .fmd_real = FrechetDistance(axes(other_real_), target),
          .fmd_neutral = FrechetDistance(axes(in), target),
          .content_fmd = FrechetDistance(pooled(out), pooled_target),
          .content_fmd_real = FrechetDistance(pooled(other_real_), pooled_target),
          .content_fmd_neutral = FrechetDistance(pooled(in), pooled_target)};
}

Eigen::MatrixXd Evaluator::Pick(const Cells& cells, int style, std::span<const int> counts,
                                std::size_t judge, Rows Features::*features) const {
  Rows rows;
  for (int content = 0; content < contents_; ++content) {
    if (counts[content] == 0) continue;
    const Rows& from = cells[cell_of(style, content)].features[judge].*features;
    for (int i = 0; i < counts[content]; ++i) {
      rows.push_back(from[from.size() * static_cast<std::size_t>(i) / counts[content]]);
    }
  }
  Eigen::MatrixXd samples(static_cast<Eigen::Index>(rows.size()), rows.front().cols());
  for (std::size_t i = 0; i < rows.size(); ++i) samples.row(i) = rows[i];
  return samples;
}

std::string Evaluator::CellName(int cell) const {
  if (cell < 0) return "none";
  return manifest_.styles[cell / contents_].name + " " + manifest_.contents[cell % contents_];
}

nlohmann::json Evaluator::ToJson(const Figures& figures) const {
  const auto with_worst = [this](const Share& share) {
    nlohmann::json json = ShareToJson(share);
    json["worst_cell"] = CellName(share.worst_cell);
    return json;
  };
  nlohmann::json json = {{"title", figures.name},
                         {"sra", with_worst(figures.sra)},
                         {"sra_first_windows", ShareToJson(figures.sra_first)},
                         {"cra", with_worst(figures.cra)},
                         {"cra_of_inputs", with_worst(figures.cra_input)},
                         {"sra_with_unknown", ShareToJson(figures.sra_with_unknown)},
                         {"unknown_to_style_judge", nlohmann::json::array()}};
  for (const int cell : figures.unknown) json["unknown_to_style_judge"].push_back(CellName(cell));
  for (int style = 1; style < styles_; ++style) {
    const StyleFigures& of = figures.styles[style];
    json["styles"][manifest_.styles[style].name] = {
        {"sra", with_worst(of.sra)},
        {"sra_of_real", with_worst(of.sra_real)},
        {"cra", with_worst(of.cra)},
        {"cra_of_inputs", with_worst(of.cra_input)},
        {"expression", Value(of.expression.fraction)},
        {"expression_cosine", Value(of.expression.cosine)},
        {"expression_walk", Value(of.expression_walk.fraction)},
        {"expression_walk_cosine", Value(of.expression_walk.cosine)},
        {"expression_of_training_clips", Value(of.expression_real.fraction)},
        {"expression_cosine_of_training_clips", Value(of.expression_real.cosine)},
        {"fmd_windows", of.fmd_windows},
        {"jitter_120", Value(of.jitter_stream)},
        {"jitter_30", Value(of.jitter_clip)},
        {"jitter_120_of_real", Value(of.jitter_real)},
        {"skate_in_cm_s", Value(Measured(of.feet.skate_in_cm_s))},
        {"skate_out_cm_s", Value(Measured(of.feet.skate_out_cm_s))},
        {"penetration_cm", Value(Measured(of.feet.penetration_cm))},
        {"deepest_cm", Value(Deepest_cm(of.feet))}};
    for (const DistanceColumn& column : kDistances) {
      nlohmann::json& here = json["styles"][manifest_.styles[style].name];
      here[column.key] = Value(of.Distance(column.of));
      here[std::string(column.key) + "_spread"] = Value(of.DistanceSpread(column.of));
    }
    nlohmann::json& by_content = json["styles"][manifest_.styles[style].name]["by_content"];
    nlohmann::json& taken_for = json["styles"][manifest_.styles[style].name]["taken_for"];
    for (int other = 0; other < styles_; ++other) {
      taken_for[manifest_.styles[other].name] = of.taken_for[other];
    }
    for (int content = 0; content < contents_; ++content) {
      const Expression& expression = of.expression_by_content[content];
      by_content[manifest_.contents[content]] = {{"sra", Value(of.sra_by_content[content])},
                                                 {"cra", Value(of.cra_by_content[content])},
                                                 {"expression", Value(expression.fraction)},
                                                 {"expression_cosine", Value(expression.cosine)}};
    }
  }
  return json;
}

nlohmann::json Evaluator::RealToJson() const {
  nlohmann::json json = {{"style", ShareToJson(real_style_)},
                         {"content", ShareToJson(real_content_)}};
  for (int style = 0; style < styles_; ++style) {
    json["styles"][manifest_.styles[style].name] = {
        {"style", ShareToJson(MacroShare(Of(real_styles_, style, contents_), kSeed))},
        {"content", ShareToJson(MacroShare(Of(real_contents_, style, contents_), kSeed))}};
  }
  return json;
}

StyleFigures Evaluator::MeanOf(const Figures& figures) const {
  StyleFigures mean;
  // The mean of a figure over the styles that have it.
  const auto average = [&](const auto& figure) {
    Mean of_styles;
    for (int style = 1; style < styles_; ++style) {
      StyleFigures of = figures.styles[style];
      if (std::isfinite(figure(of))) of_styles.Add(figure(of));
    }
    figure(mean) = Measured(of_styles);
  };
  for (Expression StyleFigures::*expression :
       {&StyleFigures::expression, &StyleFigures::expression_walk,
        &StyleFigures::expression_real}) {
    average([=](StyleFigures& of) -> double& { return (of.*expression).fraction; });
    average([=](StyleFigures& of) -> double& { return (of.*expression).cosine; });
  }
  for (double StyleFigures::*figure :
       {&StyleFigures::jitter_stream, &StyleFigures::jitter_clip, &StyleFigures::jitter_real}) {
    average([=](StyleFigures& of) -> double& { return of.*figure; });
  }
  mean.distances = MeanDistances(figures.styles);
  std::vector<ClipVerdict> real;  // of the styles that are judged
  for (int style = 1; style < styles_; ++style) {
    const StyleFigures& of = figures.styles[style];
    mean.feet.Add(of.feet);
    if (of.sra.windows <= 0) continue;
    const std::vector<ClipVerdict> of_style = Of(real_styles_, style, contents_);
    real.insert(real.end(), of_style.begin(), of_style.end());
  }
  mean.sra_real = MacroShare(real, kSeed, 0);
  mean.sra = figures.sra;
  mean.cra = figures.cra;
  mean.cra_input = figures.cra_input;
  return mean;
}

void Evaluator::Print(const Figures& figures, const Figures* offset) const {
  std::printf("\n%s\n", figures.name.c_str());
  PrintHeader(judges_.settings().count > 1);
  const auto row = [](const char* name, const StyleFigures& of) {
    std::printf("%-10.10s %s %s %s %s  %s %s\n", name, Interval(of.sra).c_str(),
                Padded(of.sra_real, 5, 3).c_str(), Interval(of.cra).c_str(),
                Padded(of.cra_input, 5, 3).c_str(), ShiftsAndDistances(of).c_str(),
                JerkAndFeet(of).c_str());
  };
  for (int style = 1; style < styles_; ++style) {
    row(manifest_.styles[style].name.c_str(), figures.styles[style]);
  }
  row("mean", MeanOf(figures));
  if (offset != nullptr) row("offset", MeanOf(*offset));
  std::printf(
      "%.0f windows; first windows SRA %.3f; CRA over inputs %.3f; worst SRA %.2f (%s), worst CRA "
      "%.2f (%s)\n",
      figures.sra.windows, figures.sra_first.value,
      figures.cra.value / std::max(1e-9, figures.cra_input.value), figures.sra.worst,
      CellName(figures.sra.worst_cell).c_str(), figures.cra.worst,
      CellName(figures.cra.worst_cell).c_str());
  if (!figures.unknown.empty()) {
    std::printf(
        "%zu cells are in no SRA, since the judge has never seen a real one (with them it is %.3f "
        "[%.2f %.2f]):",
        figures.unknown.size(), figures.sra_with_unknown.value, figures.sra_with_unknown.low,
        figures.sra_with_unknown.high);
    for (const int cell : figures.unknown) std::printf(" %s;", CellName(cell).c_str());
    std::printf("\n");
  }
  for (int style = 1; style < styles_; ++style) {
    const std::vector<double>& taken_for = figures.styles[style].taken_for;
    std::string others;
    for (int other = 0; other < styles_; ++other) {
      if (other == style || taken_for[other] < kWorthSaying) continue;
      char text[80];
      std::snprintf(text, sizeof text, " %s %.2f", manifest_.styles[other].name.c_str(),
                    taken_for[other]);
      others += text;
    }
    if (!others.empty()) {
      std::printf("%s is mistaken for%s\n", manifest_.styles[style].name.c_str(), others.c_str());
    }
  }
}

Reconstruction MeasureReconstruction(const net::Stylizer& network, std::span<const Poses> clips) {
  Reconstruction figures;
  const std::unique_ptr<net::Stream> stream = network.MakeStream();
  for (const Poses& clip : clips) {
    network.Start(*stream);
    net::Prediction step;
    for (const body::Pose& pose : clip) {
      const net::StepJob job{&pose, 0, {}, stream.get(), &step};
      network.Step({&job, 1});
      body::Pose in = pose;
      in.rotations[body::kHips] = body::Yaw(-step.heading_rad) * pose.rotations[body::kHips];
      body::Pose rec = in;
      std::copy(step.reconstruction.rotations.begin(), step.reconstruction.rotations.end(),
                rec.rotations.begin());
      body::WorldPose world_in;
      body::WorldPose world_rec;
      body::ForwardKinematics(in, world_in);
      body::ForwardKinematics(rec, world_rec);
      for (int joint = 0; joint < body::kJointCount; ++joint) {
        figures.angle_deg.Add(
            body::Log(in.rotations[joint].conjugate() * rec.rotations[joint]).norm() * 180 / M_PI);
        figures.position_cm.Add(
            100 * (world_in.positions_m[joint] - world_rec.positions_m[joint]).norm());
      }
    }
  }
  return figures;
}

}  // namespace styled::judge
