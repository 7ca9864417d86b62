// Faults of the input: datagrams that are lost, clocks that step, invalid values.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
#include <random>

#include "daemon/pipeline/pipeline.h"
#include "tests/faults/faults.h"
#include "tests/faults/stage.h"
#include "tests/support/clients.h"
#include "tests/support/native_frames.h"
#include "tests/unit/net/erd/random_weights.h"

namespace styled::faults {
namespace {

using support::ControlClient;
using support::Daemon;
using support::Sleep;

// Of each share of loss: withheld = counted as lost, none else.
Outcome Loss(const Effort& effort) {
  std::string measured;
  bool exact = true;
  for (const int percent : {1, 10, 30}) {
    Daemon daemon;
    const Watcher watcher(daemon.publish);
    std::mt19937 random(static_cast<unsigned>(percent));
    std::map<std::string, int> left;  // first and last frames always go: what is lost is between
    Feed feed(daemon.udp, 4, [&](const support::Rig& rig) {
      return ++left[rig.performer] < 60 || static_cast<int>(random() % 100) >= percent;
    });
    if (!watcher.Sees(5)) return Failed("no frame");
    Sleep(effort.Seconds(10));
    const Feed::Sent sent = feed.Stop();
    // A datagram withheld last counts as missed only when another one follows.
    Sleep(0.5);
    ControlClient control(daemon.control);
    const auto lost = control.Counter("pipeline.lost");
    const auto kernel = control.Counter("source.kernel_dropped");
    const auto frames = control.Counter("pipeline.frames");
    const bool good = daemon.child->Running() && lost <= sent.withheld + kernel &&
                      lost + 8 >= sent.withheld && frames + kernel == sent.frames &&
                      watcher.seen().missing == 0 && watcher.seen().bad == 0;
    exact = exact && good;
    measured += Format(
        "%s%d %%: %llu withheld, %llu counted, %llu of %llu sent styled",
        measured.empty() ? "" : "; ", percent, static_cast<unsigned long long>(sent.withheld),
        static_cast<unsigned long long>(lost), static_cast<unsigned long long>(frames),
        static_cast<unsigned long long>(sent.frames));
  }
  return {exact, true, measured};
}

// Debian's libfaketime, "" where it is not installed.
std::string FakeTime() {
  const std::string folder = "/usr/lib";
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const auto library = entry.path() / "faketime/libfaketime.so.1";
    if (std::filesystem::exists(library, error)) return library.string();
  }
  return "";
}

// The machine's wall clock is set under the daemon; frames carry it as a label, and the kernel's
// stamps, which are not set with it here, say when a datagram came.
Outcome MachineClockSteps(const Effort& effort) {
  const std::string library = FakeTime();
  if (library.empty()) return Failed("not tried: libfaketime is not installed");
  const support::TemporaryFolder folder;
  const std::string offset = folder / "offset";
  support::WriteText(offset, "+0\n");
  Daemon daemon({}, "",
                {{"LD_PRELOAD", library},
                 {"FAKETIME_TIMESTAMP_FILE", offset},
                 {"FAKETIME_NO_CACHE", "1"},
                 {"DONT_FAKE_MONOTONIC", "1"}});
  const Watcher watcher(daemon.publish);
  Feed feed(daemon.udp, 1);
  if (!watcher.Sees(5)) return Failed("no frame");
  double longest_s = 0;
  int followed = 0;
  const int steps = effort.Times(20);
  for (int i = 0; i < steps; ++i) {
    const int step_s = i % 2 == 0 ? 3600 : -3600;
    support::WriteText(offset, (step_s > 0 ? "+" : "") + std::to_string(step_s) + "\n");
    const std::int64_t from_ns = Now_ns();
    if (!watcher.Sees(5)) return Failed(Format("no frame after step %d", i + 1));
    longest_s = std::max(longest_s, static_cast<double>(watcher.seen().last_ns - from_ns) * 1e-9);
    Sleep(0.3);
    const auto wall_s =
        std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
    const double ahead_s = static_cast<double>(watcher.seen().last_wall_ns) * 1e-9 - wall_s;
    followed += std::abs(ahead_s - step_s) < 60 ? 1 : 0;
  }
  ControlClient control(daemon.control);
  const Watcher::Seen seen = watcher.seen();
  const auto jumps = control.Counter("pipeline.clock_jumps");
  const auto sessions = control.Counter("pipeline.sessions");
  return {daemon.child->Running() && followed == steps && jumps == 0 && sessions == 1 &&
              seen.missing == 0 && seen.bad == 0,
          longest_s <= 5,
          Format("%d steps, in the labels of %d: frames again after %.3f s at most, %llu missing, "
                 "%llu taken for the sender's",
                 steps, followed, longest_s, static_cast<unsigned long long>(seen.missing),
                 static_cast<unsigned long long>(jumps))};
}

// The sender's clock is set, by an hour either way.
Outcome ClockSteps(const Effort& effort) {
  Daemon daemon;
  const Watcher watcher(daemon.publish);
  std::atomic<std::int64_t> step_ns{0};
  Feed feed(daemon.udp, 1, [&step_ns](support::Rig& rig) {
    rig.time_ns += static_cast<std::uint64_t>(step_ns.exchange(0));
    return true;
  });
  if (!watcher.Sees(5)) return Failed("no frame");
  constexpr std::int64_t kHour_ns = 3'600'000'000'000;
  double longest_s = 0;
  const int steps = effort.Times(20);
  for (int i = 0; i < steps; ++i) {
    Sleep(0.3);
    step_ns = i % 2 == 0 ? kHour_ns + 1 : -kHour_ns;
    const std::int64_t from_ns = Now_ns();
    if (!watcher.Sees(5)) return Failed(Format("no frame after step %d", i + 1));
    longest_s = std::max(longest_s, static_cast<double>(watcher.seen().last_ns - from_ns) * 1e-9);
  }
  Sleep(0.3);
  ControlClient control(daemon.control);
  const auto jumps = control.Counter("pipeline.clock_jumps");
  const Watcher::Seen seen = watcher.seen();
  return {jumps == static_cast<std::uint64_t>(steps) && seen.missing == 0 && seen.bad == 0,
          longest_s <= 5,
          Format("%d steps: %llu counted, frames again after %.3f s at most, %llu missing", steps,
                 static_cast<unsigned long long>(jumps), longest_s,
                 static_cast<unsigned long long>(seen.missing))};
}

class NoClock final : public runtime::Clock {
 public:
  std::int64_t Now_ns() const noexcept override { return now_ns; }
  std::int64_t Wall_ns() const noexcept override { return now_ns; }
  std::int64_t now_ns = 1'000'000'000;
};

// Looks at every frame that is published.
class Inspector final : public publish::Publisher {
 public:
  void Send(std::string_view topic, std::span<const std::byte> payload) noexcept override {
    if (topic.starts_with("body/") || topic == "stats/") return;
    if (!frame_.ParseFromArray(payload.data(), static_cast<int>(payload.size()))) ++bad;
    ++frames;
    for (const float value : frame_.root_position()) bad += std::isfinite(value) ? 0 : 1;
    for (int i = 0; i + 3 < frame_.rotations_size(); i += 4) {
      double square = 0;
      for (int k = 0; k < 4; ++k) square += std::pow(frame_.rotations(i + k), 2);
      if (!(std::abs(square - 1) < 1e-3)) ++bad;
    }
  }
  bool NextSubscription(publish::SubscriptionEvent& event) override {
    if (reported_) return false;
    reported_ = true;
    event = {true, ""};
    return true;
  }
  int fd() const override { return -1; }
  std::uint64_t frames = 0, bad = 0;

 private:
  v1::Frame frame_;
  bool reported_ = false;
};

// Frames with one or many values that a sensor, a driver or an attacker may send, through the
// pipeline, in and out of style.
Outcome Poison(const Effort& effort) {
  NoClock clock;
  runtime::Counters counters;
  Inspector inspector;
  pipeline::Mailboxes mailboxes;
  auto live = std::make_shared<pipeline::RuntimeConfig>();
  live->network = erd::RandomStylizer(5, 1);
  pipeline::Pipeline daemon({clock, counters, inspector, mailboxes}, {"rig"}, {}, live, 1, 100);
  const auto deliver = [&](const support::Bytes& bytes) {
    const std::span<const std::byte> one(bytes);
    support::HandOn({&one, 1}, {}, counters, daemon);
    while (daemon.DoWork() > 0) continue;
    clock.now_ns += 1'000'000'000 / 120;
  };
  support::Rig rig("a");
  while (daemon.DoWork() > 0) continue;
  deliver(rig.Body());
  auto exchange = std::make_unique<pipeline::Exchange>();
  exchange->request.set_performer("rig.a");
  auto& mix = *exchange->request.mutable_set()->add_mix();
  mix.set_style("style1");
  mix.set_weight(1);
  (void)mailboxes.commands.Push(std::move(exchange));
  while (daemon.DoWork() > 0) continue;

  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const std::vector<float> poison{std::numeric_limits<float>::quiet_NaN(),
                                  kInfinity,
                                  -kInfinity,
                                  0.0F,
                                  -0.0F,
                                  1e-45F,
                                  1e-30F,
                                  1e10F,
                                  -1e19F,
                                  1e30F,
                                  3.4e38F,
                                  -3.4e38F,
                                  1e4F};
  std::mt19937_64 random(7);
  const int cases = effort.Times(100'000);
  for (int i = 0; i < cases; ++i) {
    deliver(rig.Frame([&](v1::SourceFrame& frame) {
      // One value, one joint, a handful, all; now and then nothing, so that it recovers.
      const int kind = static_cast<int>(random() % 6);
      const auto value = [&] { return poison[random() % poison.size()]; };
      auto& rotations = *frame.mutable_rotations();
      auto& root = *frame.mutable_root_position();
      const auto at = static_cast<int>(random() % static_cast<unsigned>(rotations.size()));
      if (kind == 0) rotations[at] = value();
      if (kind == 1) {
        for (int k = 0; k < 4; ++k) rotations[at / 4 * 4 + k] = value();
      }
      if (kind == 2) root[static_cast<int>(random() % 3)] = value();
      if (kind == 3) {
        for (int k = 0; k < 8; ++k)
          rotations[static_cast<int>(random() % 4) + at / 4 * 4] = value();
      }
      if (kind == 4) {
        for (float& rotation : rotations) rotation = value();
        for (float& place : root) place = value();
      }
      if (random() % 500 == 0) frame.set_source_time_ns(random());
    }));
  }
  return {inspector.bad == 0 && inspector.frames > static_cast<std::uint64_t>(cases), true,
          Format("%d frames in, %llu published on three topics, %llu values that are none", cases,
                 static_cast<unsigned long long>(inspector.frames),
                 static_cast<unsigned long long>(inspector.bad))};
}

}  // namespace

std::vector<Fault> InputFaults() {
  return {{"loss", "1, 10 and 30 % of the datagrams are lost", "no exit, counters exact", Loss},
          {"clock", "the sender's clock steps by an hour, either way",
           "no exit, back <= 5 s, counted", ClockSteps},
          {"machine-clock", "the machine's clock steps by an hour, either way",
           "no exit, back <= 5 s, nothing missing", MachineClockSteps},
          {"poison", "100,000 frames of NaN, Inf, 0, 3e38 and the like",
           "nothing non-finite or non-unit is published", Poison}};
}

}  // namespace styled::faults
