#include "model/train/judge/report.h"

#include <algorithm>
#include <cmath>

#include "model/body/heading.h"
#include "model/clip/clip.h"
#include "model/train/judge/text.h"

namespace styled::judge {
namespace {

constexpr int kSparseStride = 24;  // for splits with plenty of clips
constexpr int kFmdDimensions = 32;

// A distance by each judge.
std::vector<double> OfJudges(std::span<const Distances> distances, double Distances::*of) {
  std::vector<double> values;
  for (const Distances& judge : distances) values.push_back(judge.*of);
  return values;
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
  real_style_ = MacroShare(real_styles_, kIntervalSeed);
  real_content_ = MacroShare(real_contents_, kIntervalSeed);
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
  figures.sra = MacroShare(sra, kIntervalSeed);
  figures.sra_with_unknown = MacroShare(sra_with_unknown, kIntervalSeed);
  figures.cra = MacroShare(cra, kIntervalSeed);
  figures.cra_input = MacroShare(cra_input, kIntervalSeed);
  figures.sra_first = MacroShare(sra_first, kIntervalSeed);

  figures.styles[0].sra = MacroShare(OfStyle(sra, 0, contents_), kIntervalSeed);
  for (int style = 1; style < styles_; ++style) {
    StyleFigures& of = figures.styles[style];
    of.sra = MacroShare(OfStyle(sra, style, contents_), kIntervalSeed);
    of.cra = MacroShare(OfStyle(cra, style, contents_), kIntervalSeed);
    of.cra_input = MacroShare(OfStyle(cra_input, style, contents_), kIntervalSeed);
    of.sra_real = MacroShare(OfStyle(real_styles_, style, contents_), kIntervalSeed);
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
