#include "model/train/judge/gait_stream.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "model/clip/clip.h"
#include "model/train/judge/nets.h"
#include "model/train/judge/unseen_live.h"

namespace styled::judge {
namespace {

constexpr int kLeadBlend = 8;  // frames at kJudgeRate_hz, fewer than kSettling

stylist::Options OptionsFor(NeutralKnown known) {
  stylist::Options options;
  options.neutral = known != NeutralKnown::kMean;
  return options;
}

Poses AtStreamRate(const Poses& poses) {
  return clip::ResamplePoses(poses, kJudgeRate_hz, kStreamRate_hz);
}

Poses From(const Poses& poses, std::size_t first) {
  return {poses.begin() + static_cast<std::ptrdiff_t>(std::min(first, poses.size())), poses.end()};
}

// A walk and a run of the same person, if they have other clips of both.
Poses CalibrationOf(std::span<const GaitSource> sources, std::size_t source) {
  std::vector<Poses> clips;
  for (const GaitKind gait : {GaitKind::kRun, GaitKind::kWalk}) {
    const int other = NeutralSourceOf(sources, source, gait);
    if (other >= 0) clips.push_back(sources[static_cast<std::size_t>(other)].poses);
  }
  assert(!clips.empty());
  return ChainClips(clips, kJudgeRate_hz, 0, kLeadBlend).poses;
}

}  // namespace

LedIn WithLeadIn(const Poses& clip, double seconds) {
  const auto frames = static_cast<std::size_t>(std::lround(seconds * kJudgeRate_hz)) + kLeadBlend;
  const std::array<Poses, 2> both{
      Poses(clip.begin(),
            clip.begin() + static_cast<std::ptrdiff_t>(std::min(frames, clip.size()))),
      clip};
  const Chain chain = ChainClips(both, kJudgeRate_hz, 0, kLeadBlend);
  if (chain.parts.size() < both.size()) return {clip, 0};  // too short for a blend
  return {chain.poses, chain.poses.size() - clip.size()};
}

GaitStream::GaitStream(const Styler& styler, const std::vector<GaitSource>& sources,
                       NeutralKnown known)
    : sources_(sources), mode_(known), restyler_(styler, OptionsFor(known)) {
  if (known != NeutralKnown::kCalibrated) return;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    known_.push_back(restyler_.Calibrated(AtStreamRate(CalibrationOf(sources, i))));
  }
}

InAndOut GaitStream::Style(std::size_t source, const net::StyleCode& code) const {
  LedIn in{sources_[source].poses, 0};
  if (mode_ == NeutralKnown::kLearned) in = WithLeadIn(in.poses, kLearning_s);
  Poses out = Thin(restyler_.RestyleBy(AtStreamRate(in.poses), code,
                                       known_.empty() ? nullptr : &known_[source]));
  out.resize(in.poses.size(), out.empty() ? body::Pose() : out.back());
  const std::size_t first = in.begin + kSettling;
  return {From(in.poses, first), From(out, first)};
}

}  // namespace styled::judge
