// Faults of the daemon's own process: killed, reloaded, out of descriptors, out of disk.
#include <signal.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>

#include "tests/faults/faults.h"
#include "tests/faults/stage.h"
#include "tests/support/clients.h"

namespace styled::faults {
namespace {

using support::ControlClient;
using support::Daemon;
using support::Sleep;

double Seconds(std::int64_t ns) { return static_cast<double>(ns) * 1e-9; }

// A daemon that comes back on the addresses that it had.
std::unique_ptr<Daemon> Restartable(const std::string& state) {
  const auto with = [&state](const std::string& publish, const std::string& control) {
    return std::vector<std::string>{"publish.address=" + publish, "control.address=" + control,
                                    "state.dir=" + state};
  };
  // The first one only finds free ports.
  std::string publish, control;
  {
    Daemon probe;
    publish = probe.publish;
    control = probe.control;
    probe.Stop();
  }
  return std::make_unique<Daemon>(with(publish, control));
}

Outcome Kill(const Effort& effort) {
  const support::TemporaryFolder state;
  const auto daemon = Restartable(state.path());
  const Watcher watcher(daemon->publish);
  {
    Feed feed(daemon->udp, 1);
    if (!watcher.Sees(5)) return Failed("no frame before the first kill");
    ControlClient control(daemon->control);
    if (control.SetStyle("rig.p0", "style2", 1, 0).code() != v1::CODE_OK) return Failed("no style");
    Sleep(0.5);  // until it is on disk
  }
  double slowest_ready_s = 0, slowest_frame_s = 0;
  int restored = 0;
  const int kills = effort.Times(50);
  for (int i = 0; i < kills; ++i) {
    daemon->child->Signal(SIGKILL);
    (void)daemon->child->Wait(5);
    const std::int64_t from_ns = Now_ns();
    daemon->Start();
    slowest_ready_s = std::max(slowest_ready_s, Seconds(Now_ns() - from_ns));
    Feed feed(daemon->udp, 1);
    if (!watcher.Sees(10)) return Failed(Format("no frame after kill %d", i + 1));
    slowest_frame_s = std::max(slowest_frame_s, Seconds(watcher.seen().last_ns - from_ns));
    if (watcher.seen().style == "style2") ++restored;
    Sleep(0.05 + 0.01 * (i % 7));
  }
  return {
      restored == kills, slowest_ready_s <= 1 && slowest_frame_s <= 2,
      Format("%d kills: ready after %.2f s at most, frames at the subscriber after %.2f s at most, "
             "style restored %d times",
             kills, slowest_ready_s, slowest_frame_s, restored)};
}

Outcome Reload(const Effort& effort) {
  Daemon daemon;
  const Watcher watcher(daemon.publish);
  Feed feed(daemon.udp, 8);
  if (!watcher.Sees(5)) return Failed("no frame");
  Sleep(1);
  const int reloads = effort.Times(500);
  for (int i = 0; i < reloads; ++i) {
    daemon.child->Signal(SIGHUP);
    Sleep(0.02);
  }
  Sleep(0.5);
  ControlClient control(daemon.control);
  const auto lost = control.Counter("pipeline.lost");
  const Watcher::Seen seen = watcher.seen();
  const std::int64_t from_ns = Now_ns();
  daemon.child->Signal(SIGTERM);
  const int code = daemon.child->Wait(5).value_or(-1);
  const double exit_s = Seconds(Now_ns() - from_ns);
  return {
      seen.longest_gap <= 1 && code == 0, exit_s <= 0.5,
      Format("%d reloads, %llu frames: %llu missing (longest gap %llu), %llu lost on the way in; "
             "SIGTERM to exit %.3f s, code %d",
             reloads, static_cast<unsigned long long>(seen.frames),
             static_cast<unsigned long long>(seen.missing),
             static_cast<unsigned long long>(seen.longest_gap),
             static_cast<unsigned long long>(lost), exit_s, code)};
}

// Strangers' connections use up what the process may open; then they go.
Outcome NoDescriptors(const Effort& effort) {
  Daemon daemon;
  const Watcher watcher(daemon.publish);
  Feed feed(daemon.udp, 2);
  if (!watcher.Sees(5)) return Failed("no frame");
  const rlimit few{static_cast<rlim_t>(Descriptors(daemon.child->pid()) + 4), 4096};
  if (prlimit(daemon.child->pid(), RLIMIT_NOFILE, &few, nullptr) != 0) {
    return Failed("prlimit is not allowed here");
  }
  const Watcher::Seen before = watcher.seen();
  {
    std::vector<std::unique_ptr<support::TcpLink>> strangers;
    for (int i = 0; i < 40; ++i) {
      strangers.push_back(std::make_unique<support::TcpLink>(daemon.tcp));
    }
    daemon.child->Signal(SIGHUP);  // cannot even read its configuration
    Sleep(effort.Seconds(5));
    if (!daemon.child->Running()) return Failed("the daemon ended");
  }
  const Watcher::Seen after = watcher.seen();
  // Newcomers get in again.
  const std::int64_t from_ns = Now_ns();
  const Watcher newcomer(daemon.publish);
  const bool back = newcomer.Sees(10);
  const double back_s = Seconds(Now_ns() - from_ns);
  return {back && after.missing == before.missing && after.frames > before.frames, back_s <= 5,
          Format("%llu frames meanwhile, %llu missing; a new subscriber served %.2f s after",
                 static_cast<unsigned long long>(after.frames - before.frames),
                 static_cast<unsigned long long>(after.missing - before.missing), back_s)};
}

// Neither settings nor a recording can be written any more.
Outcome FullDisk(const Effort& effort) {
  const support::TemporaryFolder state;
  Daemon daemon({"state.dir=" + state.path().string(), "record.file=" + (state / "take.styrec"),
                 "record.min_free_mb=0"});
  const Watcher watcher(daemon.publish);
  Feed feed(daemon.udp, 2);
  if (!watcher.Sees(5)) return Failed("no frame");
  const rlimit none{0, RLIM_INFINITY};
  if (prlimit(daemon.child->pid(), RLIMIT_FSIZE, &none, nullptr) != 0) {
    return Failed("prlimit is not allowed here");
  }
  const Watcher::Seen before = watcher.seen();
  ControlClient control(daemon.control);
  (void)control.SetStyle("*", "style1", 1, 0);
  Sleep(effort.Seconds(5));
  if (!daemon.child->Running()) return Failed("the daemon ended");
  const rlimit all{RLIM_INFINITY, RLIM_INFINITY};
  (void)prlimit(daemon.child->pid(), RLIMIT_FSIZE, &all, nullptr);
  (void)control.SetStyle("*", "style2", 1, 0);
  const std::int64_t from_ns = Now_ns();
  bool kept = false;
  while (!kept && Seconds(Now_ns() - from_ns) < 10) {
    Sleep(0.05);
    kept = support::ReadText(state / "performers.toml").find("style2") != std::string::npos;
  }
  const double kept_s = Seconds(Now_ns() - from_ns);
  const Watcher::Seen after = watcher.seen();
  return {kept && after.missing == before.missing && after.frames > before.frames, kept_s <= 5,
          Format("%llu frames meanwhile, %llu missing; settings kept again %.2f s after%s",
                 static_cast<unsigned long long>(after.frames - before.frames),
                 static_cast<unsigned long long>(after.missing - before.missing), kept_s,
                 kept ? "" : " (not at all)")};
}

// The daemon is stopped for 22 ms ten times a second, as a busy machine does it. The sender writes
// its own time of sending into each frame, on this machine's monotonic clock; the daemon counts by
// the kernel's timestamps and does not know of that.
Outcome Stalls(const Effort& effort) {
  Daemon daemon;
  const Watcher watcher(daemon.publish);
  Feed feed(daemon.udp, 1, [](support::Rig& rig) {
    rig.time_ns = static_cast<std::uint64_t>(Now_ns());
    return true;
  });
  if (!watcher.Sees(5)) return Failed("no frame");
  Sleep(1);
  ControlClient control(daemon.control);
  const auto counted_before = control.Counter("pipeline.over_budget_frames");
  const Watcher::Seen before = watcher.seen();
  const std::int64_t until_ns = Now_ns() + static_cast<std::int64_t>(effort.Seconds(60) * 1e9);
  int stops = 0;
  for (; Now_ns() < until_ns; ++stops) {
    daemon.child->Signal(SIGSTOP);
    Sleep(0.022);
    daemon.child->Signal(SIGCONT);
    Sleep(0.078);
  }
  Sleep(1.5);  // the log and the statistics have the last second, too
  const Watcher::Seen after = watcher.seen();
  const v1::StatusReply status = control.Status();
  const auto counted = control.Counter("pipeline.over_budget_frames") - counted_before;
  const auto late = after.over_period - before.over_period;
  const auto frames = after.frames - before.frames;
  // Beside the rounding of few: the sender is interrupted between its clock and its sending, and
  // the daemon between the frame's time and its sending, once in a while.
  const double allowed = 0.05 * static_cast<double>(late) + 3 + 0.1 * stops;
  const bool counts = std::abs(static_cast<double>(counted) - static_cast<double>(late)) <= allowed;
  const auto& performer = status.stats().performers(0);
  const bool tells = performer.latency_p99_minute_us() > 8333 &&
                     performer.latency_p99_overall_us() > 8333 &&
                     performer.over_budget() >= counted;
  const bool logs = daemon.Log().find("pipeline.over_budget_frames: ") != std::string::npos &&
                    daemon.Log().find("in all; source rig") != std::string::npos;
  return {counts && tells && logs && late >= static_cast<std::uint64_t>(stops), true,
          Format("%d stops, %llu frames: %llu left more than 8.33 ms after they were sent, "
                 "%llu counted; p99 %.1f ms of the last minute, %.1f ms since the start%s",
                 stops, static_cast<unsigned long long>(frames),
                 static_cast<unsigned long long>(late), static_cast<unsigned long long>(counted),
                 static_cast<double>(performer.latency_p99_minute_us()) / 1000,
                 static_cast<double>(performer.latency_p99_overall_us()) / 1000,
                 logs ? "" : "; the log does not say so")};
}

// An hour of a show: clients come and go, the configuration is read again, styles change.
Outcome Soak(const Effort& effort) {
  Daemon daemon;
  const int pid = daemon.child->pid();
  const Watcher watcher(daemon.publish);
  Feed feed(daemon.udp, 8);
  if (!watcher.Sees(5)) return Failed("no frame");
  ControlClient control(daemon.control);
  const double seconds = effort.Seconds(3600);
  const double settle_s = std::min(60.0, seconds / 4);
  const std::int64_t from_ns = Now_ns();
  // Of resident memory over time, by least squares.
  double count = 0, sum_x = 0, sum_y = 0, sum_xx = 0, sum_xy = 0;
  int fewest = 1 << 30, most = 0;
  for (int i = 0; Seconds(Now_ns() - from_ns) < seconds; ++i) {
    (void)control.SetStyle("*", "style" + std::to_string(1 + i % 4), 1, 300);
    {
      const Watcher passer_by(daemon.publish);
      Sleep(0.5);
    }
    if (i % 10 == 9) daemon.child->Signal(SIGHUP);
    Sleep(0.5);
    const double at_s = Seconds(Now_ns() - from_ns);
    if (at_s < settle_s) continue;
    const double mb = static_cast<double>(ResidentBytes(pid)) / 1048576;
    count += 1;
    sum_x += at_s;
    sum_y += mb;
    sum_xx += at_s * at_s;
    sum_xy += at_s * mb;
    const int descriptors = Descriptors(pid);
    fewest = std::min(fewest, descriptors);
    most = std::max(most, descriptors);
  }
  const double slope =
      3600 * (count * sum_xy - sum_x * sum_y) / std::max(1e-9, count * sum_xx - sum_x * sum_x);
  const Watcher::Seen seen = watcher.seen();
  const auto lost = control.Counter("pipeline.lost");
  return {
      slope <= 1 && most - fewest <= 2 && seen.missing == 0, true,
      Format(
          "%.0f s, %llu frames, %llu missing at the subscriber, %llu lost and counted on the way "
          "in; RSS %.1f MB, slope %.2f MB/h; %d to %d descriptors",
          seconds, static_cast<unsigned long long>(seen.frames),
          static_cast<unsigned long long>(seen.missing), static_cast<unsigned long long>(lost),
          count > 0 ? sum_y / count : 0, slope, fewest, most)};
}

}  // namespace

std::vector<Fault> ProcessFaults() {
  return {{"kill", "kill -9, fifty times",
           "ready <= 1 s, subscribers resume <= 2 s, style restored", Kill},
          {"reload", "500 SIGHUP under load, then SIGTERM", "no gap over one frame, exit <= 500 ms",
           Reload},
          {"descriptors", "no file descriptor left", "no exit, nothing lost, back <= 5 s",
           NoDescriptors},
          {"disk", "the disk is full", "no exit, nothing lost, back <= 5 s", FullDisk},
          {"stalls", "stopped for 22 ms ten times a second",
           "frames that leave later than a period are counted to 5 %, logged, and in p99", Stalls},
          {"soak", "an hour with clients, reloads and styles that change",
           "RSS slope <= 1 MB/h, descriptors constant, nothing missing", Soak}};
}

}  // namespace styled::faults
