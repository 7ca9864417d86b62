#include "tests/support/rig_run.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "model/rig/dialects.h"
#include "sim/player/clip_motion.h"
#include "sim/player/performer_motion.h"
#include "sim/player/stream.h"
#include "sim/rigs/rig_stream.h"
#include "sim/rigs/stream_server.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"

namespace styled::support {
namespace {

constexpr float kDegrees = 57.29578F;

std::unique_ptr<player::Motion> MakeMotion(const RigRun& run, std::uint64_t performer) {
  if (run.clip.empty()) {
    const auto script = synthetic::ParseScript("walk:3,wave-left:2,turn-left:2");
    return std::make_unique<player::PerformerMotion>(synthetic::Vary(1, performer, script.value()),
                                                     synthetic::Proportions(), run.rate_hz);
  }
  auto motion = player::ClipMotion::Make({run.clip}, {.rate_hz = run.rate_hz});
  EXPECT_TRUE(motion.ok()) << motion.status().message();
  rig::RigPose passed;
  for (int i = 0; i < static_cast<int>(run.clip_from_s * run.rate_hz); ++i) {
    (void)motion.value()->Next(passed);
  }
  return std::move(motion.value());
}

std::unique_ptr<rigs::RigStream> MakeStream(const RigRun& run, std::unique_ptr<rigs::Rig> rig) {
  const auto spec = faults::Parse(run.faults);
  EXPECT_TRUE(spec.ok()) << spec.status().message();
  std::vector<std::unique_ptr<player::Motion>> motions;
  for (std::uint64_t k = 0; k < run.performers.size(); ++k) {
    motions.push_back(MakeMotion(run, k));
  }
  auto stream =
      rigs::RigStream::Make(std::move(rig), std::move(motions), run.rate_hz, spec.value());
  EXPECT_TRUE(stream.ok()) << stream.status().message();
  return std::move(stream.value());
}

// The player of the run, and the first performer's canonical pose in the last frame sent.
struct Playing {
  std::unique_ptr<player::Sender> sender;
  std::function<const body::Pose&()> pose;
  std::string server;                  // its address, if the simulated rig is a server
  std::unique_ptr<player::Link> link;  // to that server
};

// There is no simulated rig for the native protocol: the motion is sent on its own skeleton, which
// the daemon binds. A second binding here computes the expected poses.
Playing PlayNative(const RigRun& run) {
  const auto spec = faults::Parse(run.faults);
  EXPECT_TRUE(spec.ok()) << spec.status().message();
  EXPECT_TRUE(run.performers.size() == 1 && run.quirks.empty()) << "native: one, without quirks";
  struct Twin {
    std::unique_ptr<player::Motion> motion;
    rig::Binding binding;
    rig::RigPose on_rig;
    body::Pose canonical;
  };
  auto motion = MakeMotion(run, 0);
  auto binding = rig::BindDialect(motion->body().skeleton, motion->body().dialect);
  EXPECT_TRUE(binding.ok()) << binding.status().message();
  const auto twin = std::make_shared<Twin>(
      Twin{std::move(motion), std::move(binding.value()), rig::RigPose(), body::Pose()});
  Playing playing;
  playing.sender = std::make_unique<player::Stream>(
      player::StreamOptions{run.performers[0], run.rate_hz, [] { return std::uint64_t{7}; }, {}},
      MakeMotion(run, 0), faults::Faults(spec.value()));
  playing.pose = [twin]() -> const body::Pose& {
    (void)twin->motion->Next(twin->on_rig);
    twin->binding.Bind(twin->on_rig, twin->canonical);
    return twin->canonical;
  };
  return playing;
}

Playing Play(const RigRun& run) {
  if (run.type == "udp" || run.type == "tcp") return PlayNative(run);
  Playing playing;
  auto rig = rigs::Make(run.stand_in.empty() ? run.type : run.stand_in,
                        {run.performers, run.rate_hz, 1, run.quirks});
  EXPECT_TRUE(rig.ok()) << rig.status().message();
  if (!rig.ok()) return playing;
  if (rig.value()->is_server()) {
    const bool tcp = player::IsStream(rig.value()->default_address());
    auto listening = rigs::Listen(*rig.value(), tcp ? "tcp://127.0.0.1:0" : "udp://127.0.0.1:0",
                                  &playing.server);
    EXPECT_TRUE(listening.ok()) << listening.status().message();
    playing.link = std::move(listening.value());
  }
  auto stream = MakeStream(run, std::move(rig.value()));
  playing.pose = [&made = *stream]() -> const body::Pose& { return made.poses()[0]; };
  playing.sender = std::move(stream);
  return playing;
}

void Compare(const std::vector<body::Pose>& sent, double rate_hz, RigResult& result) {
  if (result.frames.empty()) return;
  // The last frame received corresponds to the last one sent.
  const auto last_ns = static_cast<double>(result.frames.back().source_time_ns());
  for (const v1::Frame& frame : result.frames) {
    const double back_s = (last_ns - static_cast<double>(frame.source_time_ns())) * 1e-9;
    const auto index = static_cast<std::ptrdiff_t>(sent.size()) - 1 - std::lround(back_s * rate_hz);
    if (index < 0 || frame.styles_size() > 0) continue;
    ++result.compared;
    const body::Pose& pose = sent[static_cast<std::size_t>(index)];
    for (int j = 0; j < body::kJointCount; ++j) {
      const auto& r = frame.rotations();
      const body::Quat got(r[4 * j + 3], r[4 * j], r[4 * j + 1], r[4 * j + 2]);
      const float deg = kDegrees * got.angularDistance(pose.rotations[static_cast<std::size_t>(j)]);
      if (deg <= result.worst_deg) continue;
      result.worst_deg = deg;
      result.where = std::string(body::kHumanoid[static_cast<std::size_t>(j)].name) + " in frame " +
                     std::to_string(index);
    }
    const auto& p = frame.root_position();
    const float m = (body::Vec3(p[0], p[1], p[2]) - pose.hips_position_m).norm();
    result.worst_m = std::max(result.worst_m, m);
  }
}

}  // namespace

std::uint64_t RigResult::Counter(const std::string& name) const {
  for (const auto& [counter, value] : counters) {
    if (counter == name) return value;
  }
  ADD_FAILURE() << "no counter " << name;
  return 0;
}

RigResult StreamAsRig(const RigRun& run) {
  RigResult result;
  Playing playing = Play(run);
  if (playing.sender == nullptr) return result;
  std::string keys = run.keys;
  const bool server = !playing.server.empty();
  if (server) keys += "\nserver = \"" + playing.server.substr(6) + "\"";
  std::unique_ptr<player::Link> link = std::move(playing.link);
  Daemon daemon({},
                "[[source]]\nname = \"suit\"\ntype = \"" + run.type +
                    "\"\nlisten = \"127.0.0.1:0\"\n" + keys + "\n",
                {}, run.weights);
  if (testing::Test::HasFatalFailure()) return result;
  if (!server) {
    const bool tcp = run.type.ends_with("tcp");
    auto connected = player::Connect((tcp ? "tcp://" : "udp://") + daemon.listens.at(2), 1000);
    EXPECT_TRUE(connected.ok()) << connected.status().message();
    link = std::move(connected.value());
  }
  Subscriber subscriber(daemon.publish, {""});
  EXPECT_TRUE(subscriber.WaitFor([&] { return subscriber.LastStats().has_value(); }, 10));
  const std::string id =
      run.expected_performer.empty() ? "suit." + run.performers[0] : run.expected_performer;
  ControlClient control(daemon.control);
  std::vector<body::Pose> sent;
  Paced(run.frames, run.rate_hz, [&](int i) {
    if (!run.style.empty() && i == run.style_from_frame) {
      EXPECT_EQ(control.SetStyle(id, run.style, 1, 0).code(), v1::CODE_OK);
    }
    const auto begin = std::chrono::steady_clock::now();
    const auto step = playing.sender->Tick(*link);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    if (took.count() > 0.25 / run.rate_hz) ++result.interrupted;
    if (step == player::Sender::Step::kSent) sent.push_back(playing.pose());
  });
  EXPECT_TRUE(playing.sender->Flush(*link).ok());
  const std::string topic = "styled/" + id + "/canonical/";
  // Waits until no new frames arrive for a while.
  std::size_t before = 0;
  for (int i = 0; i < 40; ++i) {
    Sleep(0.1);
    const std::size_t now = subscriber.Frames(topic).size();
    if (now > 0 && now == before) break;
    before = now;
  }
  result.frames = subscriber.Frames(topic);
  result.rig_frames = subscriber.Frames("styled/" + id + "/rig/");
  result.source_frames = subscriber.Frames("source/" + id + "/");
  result.bodies = subscriber.Bodies();
  result.sent = static_cast<int>(sent.size());
  result.received = static_cast<int>(result.frames.size());
  const auto status = control.Status();
  for (const auto& counter : status.stats().counters()) {
    result.counters.emplace_back(counter.name(), counter.value());
  }
  EXPECT_EQ(daemon.Stop(), 0);
  result.log = daemon.Log();
  Compare(sent, run.rate_hz, result);
  return result;
}

void ExpectTheSameMotion(const RigResult& result, int may_lack) {
  EXPECT_GE(result.received, result.sent - may_lack) << result.log;
  EXPECT_EQ(result.Counter("source.malformed"), 0U);
  const std::uint64_t held = result.Counter("stylist.held");
  // The rest of a frame that seemed to pause is one more.
  EXPECT_LE(held, 2U * static_cast<unsigned>(result.interrupted));
  if (held > 0) return;  // a joint that was held differs from what was sent
  EXPECT_LT(result.worst_deg, 0.5F) << result.where;
  EXPECT_LT(result.worst_m, 0.005F);
}

}  // namespace styled::support
