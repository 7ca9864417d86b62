#include "model/train/judge/stream.h"

#include <algorithm>
#include <cmath>

#include "model/body/heading.h"
#include "model/stylist/grounding.h"

namespace styled::judge {

Poses Thin(std::span<const body::Pose> poses) {
  Poses thin;
  for (std::size_t i = 0; i < poses.size(); i += kStreamPerJudge) thin.push_back(poses[i]);
  return thin;
}

stylist::Settings OneStyle(int style, bool absolute) {
  stylist::Settings settings;
  settings.mix[0] = {style, 1.0F};
  settings.transition_s = 0;
  settings.absolute = absolute;
  return settings;
}

namespace {

// Feeds canonical poses of a constant rate to a stylist.
class Feed {
 public:
  Feed(const rig::Skeleton& skeleton, double rate_hz)
      : output_(skeleton), source_(skeleton), rate_hz_(rate_hz) {}

  const body::Pose& Next(const body::Pose& input, stylist::Stylist& stylist) {
    source_.translations[0] = input.hips_position_m;
    std::copy(input.rotations.begin(), input.rotations.end(), source_.rotations.begin());
    const auto time_ns =
        static_cast<std::int64_t>(std::llround(1e9 * static_cast<double>(frame_++) / rate_hz_));
    stylist.Process(time_ns + 1, source_, output_);
    return output_.canonical;
  }

 private:
  stylist::Output output_;
  rig::RigPose source_;
  double rate_hz_;
  std::size_t frame_ = 0;
};

}  // namespace

Poses StyleStream(const std::shared_ptr<const net::Stylizer>& network,
                  const std::shared_ptr<const rig::Binding>& binding,
                  const stylist::Options& options, std::span<const Switch> switches,
                  std::span<const body::Pose> input, double rate_hz, const neutral::Known* known) {
  stylist::Stylist stylist(network, binding, options);
  if (known != nullptr) stylist.Know(*known);
  Feed feed(binding->skeleton(), rate_hz);
  Poses styled;
  styled.reserve(input.size());
  auto next = switches.begin();
  for (std::size_t i = 0; i < input.size(); ++i) {
    while (next != switches.end() && next->frame <= i) stylist.Set((next++)->settings);
    styled.push_back(feed.Next(input[i], stylist));
  }
  return styled;
}

neutral::Known LearnNeutral(const std::shared_ptr<const net::Stylizer>& network,
                            const std::shared_ptr<const rig::Binding>& binding,
                            const stylist::Options& options, std::span<const body::Pose> input,
                            double rate_hz) {
  stylist::Stylist stylist(network, binding, options);
  Feed feed(binding->skeleton(), rate_hz);
  for (const body::Pose& pose : input) feed.Next(pose, stylist);
  return stylist.Tell();
}

body::Pose ConstantOffset::Apply(const body::Pose& pose) const {
  body::Pose out = pose;
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    out.rotations[joint] = (pose.rotations[joint] * offset[joint]).normalized();
  }
  out.hips_position_m.y() += stylist::GroundShift_m(pose, out);
  return out;
}

Chain ChainClips(std::span<const Poses> clips, double rate_hz, double seconds, int blend) {
  Chain chain;
  const auto heading = [](const body::Pose& pose) {
    body::WorldPose world;
    body::ForwardKinematics(pose, world);
    return body::Heading_rad(world);
  };
  // Appends a clip, overlapping its first `blend` frames with the chain's last.
  const auto append = [&](int index) {
    const Poses& clip = clips[index];
    const std::size_t overlap = chain.poses.empty() ? 0 : static_cast<std::size_t>(blend);
    const std::size_t at = chain.poses.size() - overlap;
    body::Quat turn = body::Quat::Identity();
    body::Vec3 move = body::Vec3::Zero();
    if (overlap > 0) {
      // The two clips coincide in heading and place on the floor in the middle of the overlap.
      const body::Pose& to = chain.poses[at + overlap / 2];
      const body::Pose& from = clip[overlap / 2];
      turn = body::Yaw(heading(to) - heading(from));
      move = to.hips_position_m - turn * from.hips_position_m;
      move.y() = 0;
    }
    for (std::size_t i = 0; i < clip.size(); ++i) {
      body::Pose pose = clip[i];
      pose.hips_position_m = turn * pose.hips_position_m + move;
      pose.rotations[body::kHips] = turn * pose.rotations[body::kHips];
      if (i < overlap) {
        const float x = (static_cast<float>(i) + 1) / static_cast<float>(overlap + 1);
        const body::Pose old = chain.poses[at + i];
        body::Interpolate(old, pose, x * x * (3 - 2 * x), chain.poses[at + i]);
      } else {
        chain.poses.push_back(pose);
      }
    }
    if (!chain.parts.empty()) chain.parts.back().end = at;
    chain.parts.push_back({index, at + overlap, chain.poses.size()});
  };

  std::vector<int> usable;
  for (std::size_t i = 0; i < clips.size(); ++i) {
    if (clips[i].size() >= 3 * static_cast<std::size_t>(blend))
      usable.push_back(static_cast<int>(i));
  }
  if (usable.empty()) return chain;
  while (static_cast<double>(chain.poses.size()) < seconds * rate_hz) {
    for (const int index : usable) append(index);
  }
  for (const int index : usable) append(index);
  return chain;
}

}  // namespace styled::judge
