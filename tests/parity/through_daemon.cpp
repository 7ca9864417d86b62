#include "tests/parity/through_daemon.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/support/daemon.h"
#include "tests/support/rig.h"

namespace styled::parity {
namespace {

constexpr const char* kName = "dancer";
constexpr const char* kPerformer = "tcp.dancer";

// Publishes the network's output unchanged: no low-pass, no fade, no feet, no pose out of domain.
const std::vector<std::string> kSettings{"model.precision=float32",
                                         "model.change_tau_ms=0",
                                         "model.out_of_domain_end_rad=4.0",
                                         "model.limb_gate=false",
                                         "model.out_of_domain_begin_rad=3.9",
                                         "model.tilt_end_rad=4.0",
                                         "model.tilt_begin_rad=3.9",
                                         "model.ground=false",
                                         "model.feet=false",
                                         "model.knees=false",
                                         "model.neutral=false",
                                         "model.posture=0",
                                         "performers.stale_ms=60000",
                                         "performers.late_ms=10000",
                                         "performers.backlog_ms=10000"};

std::string BodyOf(const clip::Clip& clip) {
  v1::Body body;
  body.set_performer(kName);
  for (int joint = 0; joint < clip.skeleton.joint_count(); ++joint) {
    body.add_names(clip.skeleton.names[joint]);
    body.add_parents(clip.skeleton.parents[joint]);
    for (const float value : clip.skeleton.offsets[joint]) body.add_offsets(value);
  }
  body.set_dialect("auto");
  return body.SerializeAsString();
}

std::string FrameOf(const clip::Clip& clip, int frame) {
  const rig::RigPose& pose = clip.frames[frame];
  v1::SourceFrame message;
  message.set_performer(kName);
  message.set_source_time_ns(TimeOf_ns(clip, frame));
  for (const float value : pose.translations[0]) message.add_root_position(value);
  for (const rig::Quat& rotation : pose.rotations) {
    for (const float value : rotation.coeffs()) message.add_rotations(value);
  }
  return message.SerializeAsString();
}

// Sets a mix; returns the first sequence number of the reply.
std::uint64_t SetMix(support::ControlClient& control, const Segment& segment, bool absolute) {
  v1::Request request;
  request.set_performer(kPerformer);
  v1::Look& set = *request.mutable_set();
  for (const auto& [style, weight] : segment.mix) {
    auto& entry = *set.add_mix();
    entry.set_style(style);
    entry.set_weight(weight);
  }
  set.set_transition_ms(0);
  set.set_absolute(absolute);
  const v1::Reply reply = control.Ask(request);
  EXPECT_EQ(reply.code(), v1::CODE_OK) << reply.reason();
  EXPECT_EQ(reply.applied_size(), 1);
  return reply.applied_size() == 1 ? reply.applied(0).first_sequence() : ~0ULL;
}

}  // namespace

std::uint64_t TimeOf_ns(const clip::Clip& clip, int frame) {
  return 1'000'000'000 + static_cast<std::uint64_t>(std::llround(frame * 1e9 / clip.rate_hz));
}

std::vector<v1::Frame> StreamThroughDaemon(const clip::Clip& clip, int frames,
                                           const std::vector<Segment>& schedule,
                                           const std::filesystem::path& weights, bool absolute) {
  support::Daemon daemon(kSettings, "", {}, weights);
  if (testing::Test::HasFatalFailure()) return {};
  support::ControlClient control(daemon.control);
  support::Subscriber subscriber(daemon.publish,
                                 {"styled/" + std::string(kPerformer) + "/canonical/",
                                  "body/" + std::string(kPerformer) + "/"});
  support::TcpLink link(daemon.tcp);
  support::Rig rig(kName);

  std::vector<std::uint64_t> first_sequences{SetMix(control, schedule[0], absolute)};
  link.Send(rig.Datagram(native::Kind::kBody, BodyOf(clip)));
  EXPECT_TRUE(subscriber.WaitForBody()) << daemon.Log();
  for (int frame = 0; frame < frames; ++frame) {
    const auto segment = first_sequences.size();
    if (segment < schedule.size() && schedule[segment].first_frame == frame) {
      EXPECT_TRUE(subscriber.WaitForFrames(static_cast<std::size_t>(frame), "", 60));
      first_sequences.push_back(SetMix(control, schedule[segment], absolute));
    }
    link.Send(rig.Datagram(native::Kind::kSourceFrame, FrameOf(clip, frame)));
  }
  EXPECT_TRUE(subscriber.WaitForFrames(static_cast<std::size_t>(frames), "", 60)) << daemon.Log();
  const std::vector<v1::Frame> published = subscriber.Frames();
  for (std::size_t i = 0; i < schedule.size(); ++i) {
    const auto first = static_cast<std::size_t>(schedule[i].first_frame);
    if (first >= published.size()) break;
    EXPECT_EQ(published[first].sequence(), first_sequences[i]) << "frame " << first;
  }
  EXPECT_EQ(daemon.Stop(), 0) << daemon.Log();
  return published;
}

}  // namespace styled::parity
