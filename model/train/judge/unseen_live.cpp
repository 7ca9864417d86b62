#include "model/train/judge/unseen_live.h"

#include <algorithm>

#include "model/train/judge/variety.h"

namespace styled::judge {
namespace {

constexpr int kLiveStride = 4;  // frames between windows that are judged

Poses WithoutBeginning(const Poses& poses) {
  const std::size_t first = std::min(kSettling, poses.size() - 1);
  return {poses.begin() + static_cast<std::ptrdiff_t>(first), poses.end()};
}

// Mean pose, and the deviation over time of each of its numbers.
struct Stance {
  Eigen::VectorXd mean, spread;
};
Stance StanceOf(const Poses& poses) {
  const Eigen::MatrixXd local = LocalPositions(poses, kJudgeRate_hz).cast<double>();
  const Eigen::VectorXd mean = local.rowwise().mean();
  return {mean, (local.colwise() - mean).array().square().rowwise().mean().sqrt().matrix()};
}

Mean Recognized(const Judges* judges, const Poses& poses, int style) {
  Mean share;
  if (judges == nullptr) return share;
  const std::vector<Verdicts> by_judge =
      judges->Judge(MakeSequence(poses, style, 0, false, judges->parameters()), kLiveStride);
  share.AddJudged(Hits(by_judge, &Verdicts::style, style),
                  static_cast<double>(by_judge.front().starts.size()));
  return share;
}

}  // namespace

LiveUnseenFigures MeasureLiveUnseen(const ByCode& network, const net::StyleCode& code,
                                    const Poses& source, const Poses& normal, const Poses& example,
                                    const Judges* judges, int style) {
  const Poses styled = WithoutBeginning(network.restyle(source, code));
  const Poses before = WithoutBeginning(source);
  const ConstantOffset offset = OffsetBetween(normal, example);
  Poses by_offset;
  for (const body::Pose& pose : before) by_offset.push_back(offset.Apply(pose));
  const Stance wanted = StanceOf(example), plain = StanceOf(normal), in = StanceOf(before);
  const Stance out = StanceOf(styled), out_offset = StanceOf(by_offset);
  const Eigen::VectorXd shift = wanted.mean - plain.mean;
  const double unchanged = (in.spread - wanted.spread).norm();
  const auto movement = [&](const Stance& of) {
    return unchanged > 0 ? (of.spread - wanted.spread).norm() / unchanged : 0;
  };
  LiveUnseenFigures figures;
  figures.network = MeasureExpression(out.mean - in.mean, shift);
  figures.offset = MeasureExpression(out_offset.mean - in.mean, shift);
  figures.movement = movement(out);
  figures.offset_movement = movement(out_offset);
  const double jerk = MeanJerk(before, kJudgeRate_hz).value();
  if (jerk > 0) figures.jerk = MeanJerk(styled, kJudgeRate_hz).value() / jerk;
  figures.recognized = Recognized(judges, styled, style);
  figures.offset_recognized = Recognized(judges, by_offset, style);
  figures.real_recognized = Recognized(judges, WithoutBeginning(example), style);
  return figures;
}

}  // namespace styled::judge
