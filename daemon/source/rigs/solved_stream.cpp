#include "daemon/source/rigs/solved_stream.h"

#include <algorithm>
#include <cmath>

#include "daemon/runtime/clock.h"
#include "proto/rigs/types.h"

namespace styled::source {
namespace {

// If a tick comes later than this, the frames in between are left out.
constexpr std::int64_t kCatchUp_ns = runtime::kSecond_ns / 10;

rig::RigBody CanonicalBody(float scale) {
  rig::RigBody made;
  for (int j = 0; j < body::kJointCount; ++j) {
    const body::JointRow& row = body::kHumanoid[static_cast<std::size_t>(j)];
    made.skeleton.names.emplace_back(row.name);
    made.skeleton.parents.push_back(row.parent);
    made.skeleton.offsets.emplace_back(scale * body::Offset(j));
  }
  made.rest.assign(body::kJointCount, rig::Quat::Identity());
  made.metres_per_unit = 1;
  made.dialect = rigs::kSlimeVr.dialect;
  return made;
}

}  // namespace

SolvedStream::SolvedStream(const config::Source& config)
    : stream_(config.performer.empty() ? config.name : config.performer),
      pose_(CanonicalBody(1).skeleton),
      period_ns_(std::llround(static_cast<double>(runtime::kSecond_ns) /
                              static_cast<double>(config.rate_hz))) {}

void SolvedStream::Restart(float scale) {
  has_body_ = has_body_ && scale == scale_;
  scale_ = scale;
  stream_.Restart();
}

std::uint64_t SolvedStream::SkipOld(std::int64_t now_ns) noexcept {
  if (now_ns - next_frame_ns_ <= kCatchUp_ns) return 0;
  const std::int64_t lost = (now_ns - next_frame_ns_) / period_ns_;
  next_frame_ns_ += lost * period_ns_;
  return static_cast<std::uint64_t>(lost);
}

void SolvedStream::SendFrame(std::int64_t time_ns, std::int64_t now_ns, std::uint64_t lost,
                             Outbox& out) {
  if (!has_body_) {
    out.LeaveHotSection();
    stream_.SetBody(CanonicalBody(scale_), out);
    has_body_ = true;
  }
  pose_.translations.front() = scale_ * solved_.hips_position_m;
  std::ranges::copy(solved_.rotations, pose_.rotations.begin());
  PerformerStream::FrameInfo info;
  info.source_time_ns = static_cast<std::uint64_t>(std::max<std::int64_t>(time_ns, 0));
  info.now_ns = now_ns;
  info.lost = lost;
  stream_.Send(pose_, info, out);
}

}  // namespace styled::source
