#include "daemon/styles/preview.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "daemon/looks/refusal.h"
#include "model/base/text.h"
#include "model/body/heading.h"
#include "model/rig/dialects.h"
#include "model/stylist/stylist.h"
#include "model/synthetic/performer.h"

namespace styled::pipeline {
namespace {

constexpr double kRate_hz = 60;   // of the walk
constexpr double kShown_hz = 15;  // length of the preview, approximately
constexpr double kSettle_s = 3;   // time until walk and style are steady
constexpr double kEnd_s = 8;
constexpr int kStrides = 2;
constexpr int kFade = 4;  // frames of the preview

using Positions = std::array<body::Vec3, body::kJointCount>;

struct Walk {
  std::vector<Positions> frames;   // world, m
  std::vector<std::size_t> lands;  // frames in which the left foot touches down, after kSettle_s
};

Walk MakeWalk(const RuntimeConfig& config, int style) {
  const rig::Skeleton skeleton = synthetic::MakeSkeleton({});
  auto bound = rig::BindDialect(skeleton, "canonical");  // always fits
  stylist::Stylist stylist(config.network,
                           std::make_shared<const rig::Binding>(std::move(bound.value())),
                           config.stylist);
  stylist::Settings settings;
  if (style > 0) settings.mix[0] = {style, 1};
  settings.transition_s = 0;
  stylist.Set(settings);
  synthetic::Options options;
  options.script = {{synthetic::Motion::kWalk, 3600}};
  synthetic::Performer performer(std::move(options));
  stylist::Output output(skeleton);
  rig::RigPose in(skeleton);
  body::Pose pose;
  body::WorldPose world;
  Walk walk;
  double before = 1;
  for (int frame = 0; frame < static_cast<int>(kEnd_s * kRate_hz); ++frame) {
    const double time_s = frame / kRate_hz;
    performer.Pose(time_s, pose);
    const double contact = performer.contacts()[0];
    if (before < 0.5 && contact >= 0.5 && time_s > kSettle_s) {
      walk.lands.push_back(walk.frames.size());
    }
    before = contact;
    in.translations[body::kHips] = pose.hips_position_m;
    in.rotations.assign(pose.rotations.begin(), pose.rotations.end());
    stylist.Process(std::llround(time_s * 1e9), in, output);
    body::ForwardKinematics(output.canonical, world);
    walk.frames.push_back(world.positions_m);
  }
  return walk;
}

// The strides in place, facing +Z, followed by some frames of the next stride.
std::vector<Positions> OnTheSpot(const Walk& walk, std::size_t begin, double frames, int count) {
  const auto at = [&](double frame) {
    const auto low = std::min(static_cast<std::size_t>(frame), walk.frames.size() - 2);
    const float share = static_cast<float>(frame - static_cast<double>(low));
    Positions between;
    for (std::size_t j = 0; j < between.size(); ++j) {
      between[j] = (1 - share) * walk.frames[low][j] + share * walk.frames[low + 1][j];
    }
    return between;
  };
  const auto first = static_cast<double>(begin);
  const body::Vec3 from = at(first)[body::kHips];
  body::Vec3 way = at(first + frames)[body::kHips] - from;
  way.y() = 0;
  const body::Quat facing = body::Yaw(-std::atan2(way.x(), way.z()));
  std::vector<Positions> shown;
  for (int i = 0; i < count + kFade; ++i) {
    const double share = static_cast<double>(i) / count;
    Positions& positions = shown.emplace_back(at(first + share * frames));
    body::Vec3 passed = from + static_cast<float>(share) * way;
    passed.y() = 0;
    for (body::Vec3& position : positions) position = facing * (position - passed);
  }
  return shown;
}

v1::PreviewReply Render(const RuntimeConfig& config, int style) {
  const Walk walk = MakeWalk(config, style);
  const std::size_t begin = walk.lands.front();
  const double frames = static_cast<double>(walk.lands[kStrides] - begin);
  const int count = static_cast<int>(std::lround(frames / kRate_hz * kShown_hz));
  std::vector<Positions> shown = OnTheSpot(walk, begin, frames, count);
  v1::PreviewReply preview;
  preview.set_rate_hz(static_cast<float>(count * kRate_hz / frames));
  preview.set_joints(body::kJointCount);
  for (int i = 0; i < count; ++i) {
    const float own = i < kFade ? static_cast<float>(i + 1) / (kFade + 1) : 1;
    for (std::size_t j = 0; j < body::kJointCount; ++j) {
      const auto frame = static_cast<std::size_t>(i);
      body::Vec3 position = shown[frame][j];
      if (i < kFade) {
        position = own * position + (1 - own) * shown[frame + static_cast<std::size_t>(count)][j];
      }
      for (const float metres : position) {
        preview.add_positions_mm(static_cast<int>(std::lround(1000 * metres)));
      }
    }
  }
  return preview;
}

}  // namespace

Status Previews::Make(const RuntimeConfig& config, const std::string& style,
                      v1::PreviewReply& reply) {
  const net::Styles& styles = config.network->model().styles;
  const int number = net::FindStyle(styles, style);
  if (number < 0) {
    return Refused(v1::CODE_UNKNOWN_STYLE, "no style \"" + Printable(style, 80) + "\"; see list");
  }
  const std::string& name = styles[static_cast<std::size_t>(number)].name;
  const auto made = config.made.find(name);
  const auto current = made == config.made.end() ? nullptr : made->second;
  const auto known = kept_.find(name);
  if (known != kept_.end() && known->second.weights_crc == config.weights_crc &&
      known->second.style == current) {
    reply = known->second.preview;
    return Status::Ok();
  }
  std::erase_if(kept_, [&config](const auto& kept) {  // of former weights, or of removed styles
    const auto& [of, what] = kept;
    return what.weights_crc != config.weights_crc ||
           (what.style != nullptr && !config.made.contains(of));
  });
  reply = Render(config, number);
  kept_[name] = {config.weights_crc, current, reply};
  return Status::Ok();
}

}  // namespace styled::pipeline
