#include "clients/vmc/cli.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>

#include "clients/cpp/key_options.h"
#include "clients/cpp/reach.h"
#include "clients/vmc/find_target.h"
#include "clients/vmc/forwarder.h"
#include "model/base/version.h"

namespace styled::stylevmc {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

struct Arguments {
  Options options;
  client::KeyOptions keys;
  std::vector<std::string> to, find;
  std::string root = "hips", as = "vmc", trackers = "hip,feet";
  double user_height_m = 0;
  double statistics_s = 10, seconds = 0;
};

void Declare(CLI::App& app, Arguments& a) {
  app.set_version_flag("--version", VersionText("stylevmc"));
  app.add_option(
         "--to", a.to,
         "address of an application that listens for VMC, [PERFORMER=]HOST:PORT; may be repeated, "
         "usual port: 39539")
      ->allow_extra_args(false);
  app.add_option("--find", a.find,
                 "the same, found in the network by its name or the beginning of it, "
                 "[PERFORMER=]NAME, at the start; styleoscquery --list prints the names")
      ->allow_extra_args(false);
  app.add_option("--performer", a.options.performer,
                 "SOURCE.NAME, for targets without one; default: the first one seen, another "
                 "once that one was silent for 5 s")
      ->check([](const std::string& id) {
        if (client::IsPerformerId(id)) return std::string();
        return "'" + id + "' is not SOURCE.NAME ([A-Za-z0-9_-]{1,32} each)";
      });
  app.add_option("--publish", a.options.publishers, "the daemon's publisher; may be repeated")
      ->envname("STYLED_PUBLISHER")
      ->allow_extra_args(false)
      ->capture_default_str();
  client::Declare(app, a.keys);
  app.add_option("--rate", a.options.rate_hz,
                 "maximum frames per second of each performer (VSeeFace is known to fail "
                 "above 200)")
      ->check(CLI::Range(1.0, 240.0))
      ->capture_default_str();
  app.add_option(
         "--root", a.root,
         "the bone that carries the performer through the room: hips (the root stays at the "
         "origin) or root (it moves over the floor)")
      ->check(CLI::IsMember({"hips", "root"}))
      ->capture_default_str();
  app.add_option("--as", a.as,
                 "protocol: vmc, or vrchat: OSC trackers for VRChat, whose usual port is 9000")
      ->check(CLI::IsMember({"vmc", "vrchat"}))
      ->capture_default_str();
  app.add_option("--trackers", a.trackers,
                 "with --as vrchat: hip, feet, knees, chest, elbows, separated by commas, or all")
      ->capture_default_str();
  app.add_option("--user-height", a.user_height_m,
                 "with --as vrchat: height in metres of the avatar's user, to which "
                 "the performer is scaled; 0: unscaled")
      ->check(CLI::Range(0.0, 3.0))
      ->capture_default_str();
  app.add_option("--statistics", a.statistics_s, "seconds between two lines of statistics; 0: none")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  app.add_option("--seconds", a.seconds, "end by itself; 0: never")->check(CLI::Range(0.0, 1e9));
  app.footer(
      "Exit codes: 0, 1 failed, 2 usage, 3 with --seconds when nothing was forwarded.\n"
      "Examples:\n"
      "  stylevmc --to 127.0.0.1:39539\n"
      "  stylevmc --to 192.168.1.20:39539 --to [fd00::5]:39540 --performer stage.anna\n"
      "  stylevmc --to 127.0.0.1:9000 --as vrchat --user-height 1.7\n"
      "  stylevmc --find VRChat --as vrchat --user-height 1.7\n"
      "  stylevmc --to stage.anna=127.0.0.1:39539 --to stage.ben=127.0.0.1:39540 --rate 60");
}

// CLI11's range checks accept NaN.
bool AnyNan(const Arguments& a) {
  return std::isnan(a.options.rate_hz + a.statistics_s + a.seconds + a.user_height_m);
}

std::string Targets(const Channel& channel) {
  std::string text;
  for (const auto& target : channel.targets) text += (text.empty() ? "" : ", ") + target->text();
  return text;
}

// "; no program listens at 127.0.0.1:39539": as far as their machines report it.
std::string NoListener(const Channel& channel) {
  std::string text;
  for (const auto& target : channel.targets) {
    if (!target->NoListener()) continue;
    text += (text.empty() ? "; no program listens at " : ", ") + target->text();
  }
  return text;
}

// Prints one line per channel: performer, targets, counts.
class Report {
 public:
  Report(const Options& options, std::ostream& out, std::ostream& err) : out_(out), err_(err) {
    for (const std::string& endpoint : options.publishers) {
      lookouts_.push_back(
          std::make_unique<client::Lookout>(endpoint, client::Peer::kPublisher, options.curve));
    }
  }

  // Examines why no daemon answers, only while none does.
  void Watch(Forwarder& forwarder) {
    const bool connected = forwarder.connected() > 0;
    for (const auto& lookout : lookouts_) {
      if (connected) {
        lookout->Rest();
      } else {
        (void)lookout->Look();
      }
    }
  }

  void Print(Forwarder& forwarder, bool interval) {
    const double passed_s = std::chrono::duration<double>(Clock::now() - since_).count();
    auto& channels = forwarder.channels();
    frames_.resize(channels.size(), 0);
    for (std::size_t i = 0; i < channels.size(); ++i) {
      const Channel& channel = channels[i];
      const Counts& counts = channel.counts;
      out_ << "stylevmc: " << (channel.current.empty() ? "nobody yet" : channel.current) << " -> "
           << Targets(channel) << ": ";
      if (interval) {
        const auto fresh = static_cast<double>(counts.frames - frames_[i]);
        frames_[i] = counts.frames;
        char rate[32];
        std::snprintf(rate, sizeof rate, "%.1f frames/s, ", fresh / passed_s);
        out_ << rate;
      }
      out_ << counts.frames << " frames, " << counts.thinned << " thinned out, " << counts.missed
           << " missed, " << counts.bodiless << " without a body, " << counts.failed
           << " datagrams refused" << NoListener(channel)
           << (forwarder.connected() == 0 ? "; no daemon answers" + Why() : "") << "\n";
    }
    out_.flush();
    since_ = Clock::now();
  }

  // Prints the last error, at most once per second, the performer when it changes, and each target
  // where no program listens, once.
  void PrintNews(Forwarder& forwarder) {
    auto& channels = forwarder.channels();
    shown_.resize(channels.size());
    no_listener_.resize(channels.size());
    for (std::size_t i = 0; i < channels.size(); ++i) {
      Channel& channel = channels[i];
      if (std::string no_listener = NoListener(channel); no_listener != no_listener_[i]) {
        if (!no_listener.empty()) {
          err_ << "stylevmc: " << no_listener.substr(2)
               << ": is VMC's receiver on in the application, on this port?\n";
        } else {
          out_ << "stylevmc: a program listens now: " << Targets(channel) << "\n";
          out_.flush();
        }
        no_listener_[i] = std::move(no_listener);
      }
      if (shown_[i] != channel.current && channel.wanted.empty()) {
        out_ << "stylevmc: " << channel.current << " -> " << Targets(channel) << "\n";
        out_.flush();
      }
      shown_[i] = channel.current;
    }
    if (Clock::now() < next_error_) return;
    for (Channel& channel : channels) {
      if (channel.counts.last_error.empty()) continue;
      err_ << "stylevmc: " << channel.counts.last_error << "\n";
      channel.counts.last_error.clear();
      next_error_ = Clock::now() + std::chrono::seconds(1);
    }
  }

 private:
  // " at tcp://...: no program listens there (Connection refused); is styled running, ..."
  std::string Why() const {
    std::string text;
    for (const auto& lookout : lookouts_) {
      const client::Reach& reach = lookout->found();
      text += (text.empty() ? " at " : ", nor at ") + lookout->endpoint();
      if (!reach.text.empty()) text += ": " + reach.text;
      const std::string advice = client::Advice(reach.obstacle, client::Peer::kPublisher);
      if (!advice.empty()) text += "; " + advice;
    }
    return text;
  }

  std::vector<std::unique_ptr<client::Lookout>> lookouts_;
  std::ostream& out_;
  std::ostream& err_;
  Clock::time_point since_ = Clock::now(), next_error_ = Clock::now();
  std::vector<std::uint64_t> frames_;
  std::vector<std::string> shown_, no_listener_;
};

Clock::duration Seconds(double seconds) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

int Forward(const Arguments& a, Forwarder& forwarder, const std::atomic<bool>& stop,
            std::ostream& out, std::ostream& err) {
  Report report(a.options, out, err);
  const auto begin = Clock::now();
  auto next = begin + Seconds(a.statistics_s);
  while (!stop && (a.seconds == 0 || Clock::now() < begin + Seconds(a.seconds))) {
    forwarder.Step(milliseconds(50));
    report.Watch(forwarder);
    report.PrintNews(forwarder);
    if (a.statistics_s == 0 || Clock::now() < next) continue;
    report.Print(forwarder, true);
    next = Clock::now() + Seconds(a.statistics_s);
  }
  report.Print(forwarder, false);
  const auto& channels = forwarder.channels();
  const bool any = std::any_of(channels.begin(), channels.end(),
                               [](const Channel& channel) { return channel.counts.frames > 0; });
  return a.seconds > 0 && !stop && !any ? kExitNothing : kExitOk;
}

}  // namespace

int Run(std::vector<std::string> arguments, const std::atomic<bool>& stop, std::ostream& out,
        std::ostream& err) {
  Arguments a;
  CLI::App app{"stylevmc: styled performers to VSeeFace, Warudo, VNyan, Unity, Unreal, by VMC",
               "stylevmc"};
  Declare(app, a);
  const auto fail = [&err](const std::string& text, int code) {
    err << "stylevmc: " << text << (code == kExitUsage ? "\n  see stylevmc --help\n" : "\n");
    return code;
  };
  std::reverse(arguments.begin(), arguments.end());  // what CLI11 takes
  try {
    app.parse(arguments);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error, out, err), kExitOk;
    return fail(error.what(), kExitUsage);
  }
  if (a.root == "root") a.options.carrier = Carrier::kRoot;
  if (AnyNan(a)) return fail("a value is nan; expected a number", kExitUsage);
  const auto trackers = ParseTrackerSet(a.trackers);
  if (!trackers.ok()) return fail(trackers.status().message(), kExitUsage);
  if (a.as == "vrchat") a.options.vrchat = {trackers.value(), a.user_height_m};
  if (a.to.empty() && a.find.empty()) {
    return fail("no target; expected --to HOST:PORT or --find NAME", kExitUsage);
  }
  for (const std::string& text : a.to) {
    auto target = ParseTarget(text);
    if (!target.ok()) return fail(target.status().message(), kExitUsage);
    a.options.targets.push_back(std::move(target.value()));
  }
  auto curve = client::ReadKeys(a.keys);
  if (!curve.ok()) return fail(curve.status().message(), kExitUsage);
  a.options.curve = std::move(curve.value());
  auto found = FindTargets(a.find, a.options.vrchat.has_value());
  if (!found.ok()) return fail(found.status().message(), kExitFailed);
  for (TargetSpec& target : found.value()) a.options.targets.push_back(std::move(target));
  auto forwarder = Forwarder::Open(a.options);
  if (!forwarder.ok()) return fail(forwarder.status().message(), kExitFailed);
  return Forward(a, *forwarder.value(), stop, out, err);
}

}  // namespace styled::stylevmc
