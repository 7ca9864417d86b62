// stylesim simulates a rig: it plays BVH files or its own synthetic performer to the daemon, over
// the native protocol (proto/styled/v1/WIRE.md) or a rig's (proto/rigs), with seeded faults. It can
// also write the synthetic performer as BVH.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "model/base/random_id.h"
#include "model/base/version.h"
#include "model/rig/dialects.h"
#include "model/synthetic/performer.h"
#include "model/tools/number.h"
#include "sim/faults/faults.h"
#include "sim/player/clip_motion.h"
#include "sim/player/clock.h"
#include "sim/player/link.h"
#include "sim/player/performer_motion.h"
#include "sim/player/player.h"
#include "sim/player/props.h"
#include "sim/player/stream.h"
#include "sim/rigs/rig_stream.h"
#include "sim/rigs/stream_server.h"

namespace {

using styled::Result;
using styled::Status;
namespace synthetic = styled::synthetic;
namespace player = styled::player;
namespace faults = styled::faults;
namespace rigs = styled::rigs;

constexpr int kFailed = 1;  // an error of a file, an address or a socket
constexpr int kBadArguments = 2;

struct Arguments {
  std::vector<std::string> to;
  std::string as = "native";
  std::vector<std::string> quirks;
  std::vector<std::filesystem::path> clips;
  std::string performer = "sim";
  int performers = 1;
  double rate_hz = 120, seconds = 0, start_wait_ms = 0;
  bool loop = false;
  std::uint64_t seed = 1;
  std::string script, faults, dialect = "auto";
  std::vector<std::string> joints;  // CANONICAL=NAME
  float metres_per_unit = 0;
  std::filesystem::path write;
  std::string timecode;
  std::optional<double> timecode_s = {};
  std::vector<std::string> props = {};
};

std::atomic<bool> stop_requested{false};

extern "C" void RequestStop(int) { stop_requested = true; }

void AddOptions(CLI::App& app, Arguments& a) {
  app.set_version_flag("--version", styled::VersionText("stylesim"));
  app.add_option("--as", a.as, "the rig to simulate: " + rigs::Words())->capture_default_str();
  app.add_option("--quirk", a.quirks, "a habit of that rig; an unknown one lists the known ones");
  app.add_option("--to", a.to,
                 "where to send, udp://HOST:PORT or tcp://HOST:PORT (default: the rig's usual port "
                 "on 127.0.0.1, 7000 for native); a rig that is a server listens there; may be "
                 "given several times: all get the same");
  app.add_option("--bvh", a.clips,
                 "BVH files, or folders of them, instead of the synthetic performer; several are "
                 "played one after the other, each as a new session");
  app.add_option("--performer", a.performer,
                 "its name, 1 to 32 of A-Za-z0-9_-; of several NAME-1, NAME-2, ...")
      ->capture_default_str();
  app.add_option("--performers", a.performers,
                 "number of performers; the k-th begins with the k-th file, or is another person")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--rate", a.rate_hz, "frames per second; clips are resampled (C2)")
      ->check(styled::Number(1.0, 1000.0))
      ->capture_default_str();
  app.add_option("--seconds", a.seconds,
                 "stop after this time (0: at the motion's end, if it has one)")
      ->check(styled::Number(0.0, 1e9))
      ->capture_default_str();
  app.add_flag("--loop", a.loop, "restart with the first file after the last");
  app.add_option("--seed", a.seed, "seed of the synthetic performer")->capture_default_str();
  app.add_option(
      "--script", a.script,
      "motions of the synthetic performer, repeated for ever, e.g. stand:2,walk:5,turn-left:3; "
      "words: stand, walk, run, turn-left, turn-right, {wave,raise}-{left,right,both}. "
      "Without it: random order");
  app.add_option("--dialect", a.dialect, "rig dialect of the files, sent in the body")
      ->capture_default_str();
  app.add_option("--joints", a.joints,
                 "joints of the files that are not recognized, CANONICAL=NAME, e.g. "
                 "leftUpperArm=Arm_01; they are sent under the first name")
      ->take_all()
      ->allow_extra_args(false);
  app.add_option("--metres-per-unit", a.metres_per_unit,
                 "unit of the files, sent in the body (0: unknown, scaled by hips height)")
      ->check(styled::Number(0.0, 1000.0))
      ->capture_default_str();
  app.add_option("--faults", a.faults,
                 "WORD=PROBABILITY,... per frame: loss, duplicate, reorder, corrupt, truncate, "
                 "nan, oversized, restart, late, burst (frames held back and sent at once), step "
                 "(the rig's clock jumps), occlude (a joint unseen for a while); and seed=1, "
                 "late-ms=100, restart-pause-ms=150, burst-frames=5, step-s=1, occlude-frames=30, "
                 "jitter-ms=0 (each frame up to so much late, in order), drift-ppm=0 (how much too "
                 "fast the rig's clock runs)");
  app.add_option("--timecode", a.timecode,
                 "SMPTE timecode of the first frame, HH:MM:SS, counted at 30 frames a second")
      ->check([&a](const std::string& text) {
        int hours = 0, minutes = 0, seconds = 0, end = 0;
        const int read =
            std::sscanf(text.c_str(), "%2d:%2d:%2d%n", &hours, &minutes, &seconds, &end);
        const bool good = read == 3 && end == static_cast<int>(text.size()) && hours >= 0 &&
                          hours < 24 && minutes >= 0 && minutes < 60 && seconds >= 0 &&
                          seconds < 60;
        if (!good) return "'" + text + "': expected HH:MM:SS";
        a.timecode_s = (hours * 60 + minutes) * 60 + seconds;
        return std::string();
      });
  app.add_option("--prop", a.props,
                 "an object that the rig tracks (native, natnet, mvn, rokoko): NAME=right_hand or "
                 "NAME=left_hand, held by the first performer, or NAME=X,Y,Z, standing there "
                 "(metres; left, up, forward); may be given several times")
      ->allow_extra_args(false)
      ->check([](const std::string& text) {
        const auto prop = player::ParseProp(text);
        return prop.ok() ? std::string() : prop.status().message();
      });
  app.add_option("--start-wait-ms", a.start_wait_ms, "how long to wait for a TCP listener")
      ->check(styled::Number(0.0, 600000.0))
      ->capture_default_str();
  app.add_option("--write", a.write,
                 "write the synthetic performer as a BVH file (centimetres) instead of sending it; "
                 "needs --seconds");
}

int Fail(const Status& status) {
  std::fprintf(stderr, "stylesim: %s\n", status.message().c_str());
  return kFailed;
}
int RefuseArguments(const Status& status) {
  (void)Fail(status);
  return kBadArguments;
}

std::string PerformerName(const Arguments& a, int k) {
  return a.performers == 1 ? a.performer : a.performer + "-" + std::to_string(k + 1);
}

Status CheckStreamFaults(const faults::Spec& spec) {
  if (spec.probability[static_cast<std::size_t>(faults::Fault::kTruncate)] <= 0) {
    return Status::Ok();
  }
  return Status::Error(
      "--faults truncate: expected a udp:// address (a record cut short would "
      "tear the TCP stream)");
}

Status Check(const Arguments& a, const faults::Spec& spec) {
  const std::string longest = PerformerName(a, a.performers - 1);
  if (!player::IsPerformerName(longest)) {
    return Status::Error("--performer '" + longest + "': expected 1 to 32 of A-Za-z0-9_-");
  }
  if (std::ranges::any_of(a.to, player::IsStream)) {
    if (Status status = CheckStreamFaults(spec); !status.ok()) return status;
  }
  if (!a.write.empty() && (!a.clips.empty() || a.seconds <= 0)) {
    return Status::Error("--write: expected --seconds above 0 and no --bvh");
  }
  if (a.as != "native" && a.timecode_s) {
    return Status::Error("--timecode: expected --as native (for others it is a --quirk)");
  }
  if (a.as == "native" && !a.quirks.empty()) return Status::Error("--quirk: native has none");
  return Status::Ok();
}

std::unique_ptr<player::Motion> MakePerformer(const Arguments& a,
                                              const std::vector<synthetic::ScriptItem>& script,
                                              int k) {
  const auto index = static_cast<std::uint64_t>(k);
  return std::make_unique<player::PerformerMotion>(
      synthetic::Vary(a.seed, index, script), synthetic::VaryProportions(a.seed, index), a.rate_hz);
}

Result<std::unique_ptr<player::Motion>> MakeClips(const Arguments& a,
                                                  const std::vector<std::filesystem::path>& files,
                                                  int k) {
  auto joints = styled::rig::ParseJoints("--joints", a.joints);
  if (!joints.ok()) return joints.status();
  auto made = player::ClipMotion::Make(files, {a.rate_hz, a.dialect, a.metres_per_unit, a.loop,
                                               static_cast<std::size_t>(k), joints.value()});
  if (!made.ok()) return made.status();
  return std::unique_ptr<player::Motion>(std::move(made.value()));
}

using Motions = std::vector<std::unique_ptr<player::Motion>>;

Result<Motions> MakeMotions(const Arguments& a, const std::vector<synthetic::ScriptItem>& script) {
  const auto files = player::FindClips(a.clips);
  if (!files.ok()) return files.status();
  Motions motions;
  for (int k = 0; k < a.performers; ++k) {
    if (files.value().empty()) {
      motions.push_back(MakePerformer(a, script, k));
      continue;
    }
    auto clips = MakeClips(a, files.value(), k);
    if (!clips.ok()) return clips.status();
    motions.push_back(std::move(clips.value()));
  }
  return motions;
}

std::vector<player::PropSpec> Props(const Arguments& a) {
  std::vector<player::PropSpec> props;
  for (const std::string& text : a.props) props.push_back(player::ParseProp(text).value());
  return props;
}

using Senders = std::vector<std::unique_ptr<player::Sender>>;

// Native datagrams: one sender per performer.
Senders MakeNative(const Arguments& a, Motions motions, const faults::Spec& spec) {
  Senders senders;
  for (int k = 0; k < a.performers; ++k) {
    senders.push_back(std::make_unique<player::Stream>(
        player::StreamOptions{PerformerName(a, k), a.rate_hz, styled::RandomId, a.timecode_s,
                              Props(a)},
        std::move(motions[static_cast<std::size_t>(k)]),
        faults::Faults(spec, static_cast<std::uint64_t>(k))));
  }
  return senders;
}

Result<std::unique_ptr<rigs::Rig>> MakeRig(const Arguments& a) {
  rigs::Options options{{}, a.rate_hz, a.seed, a.quirks, Props(a)};
  for (int k = 0; k < a.performers; ++k) options.performers.push_back(PerformerName(a, k));
  return rigs::Make(a.as, options);
}

std::string AllOf(const std::vector<std::string>& addresses) {
  std::string text;
  for (const std::string& address : addresses) text += (text.empty() ? "" : " or ") + address;
  return text;
}

// `server`: the rig, if it is one, which listens.
int Play(const Arguments& a, const std::vector<std::string>& to, rigs::Rig* server,
         Senders senders) {
  for (const std::string& one : to) {
    const Status address = player::CheckAddress(one, server != nullptr ? 0 : 1);
    if (!address.ok()) return RefuseArguments(address);
  }
  const auto say_goes_on = [](const std::string& failure) {
    std::fprintf(stderr, "stylesim: %s; sending to the others continues\n", failure.c_str());
  };
  const auto on_failure = [say_goes_on](const std::string& url, const std::string& why) {
    say_goes_on(url + ": " + why);
  };
  std::vector<player::NamedLink> links;
  Status failure = Status::Ok();
  for (const std::string& one : to) {
    auto link =
        server != nullptr ? rigs::Listen(*server, one) : player::Connect(one, a.start_wait_ms);
    if (link.ok()) {
      links.push_back({one, std::move(link.value())});
      continue;
    }
    failure = link.status();
    if (to.size() > 1) say_goes_on(failure.message());
  }
  if (links.empty()) return Fail(failure);
  const auto link = links.size() == 1 ? std::move(links.front().link)
                                      : player::ToAll(std::move(links), on_failure);
  player::SteadyClock clock;
  const auto on_refused = [&to] {
    std::fprintf(
        stderr,
        "stylesim: no program listens at %s (Connection refused); sending continues. Is styled "
        "running, with a source at that port?\n",
        AllOf(to).c_str());
  };
  player::Player player({a.rate_hz, a.seconds, on_refused}, std::move(senders));
  const Status status = player.Run(clock, *link, stop_requested);
  std::printf("stylesim: %s\n", player::Summary(player).c_str());
  return status.ok() ? 0 : Fail(status);
}

// Another rig type: one sender for all performers.
int RunRig(const Arguments& a, Motions motions, const faults::Spec& spec) {
  if (spec.probability[static_cast<std::size_t>(faults::Fault::kOversized)] > 0) {
    return RefuseArguments(Status::Error("--faults oversized: expected --as native"));
  }
  auto rig = MakeRig(a);
  if (!rig.ok()) return RefuseArguments(rig.status());
  const auto to = a.to.empty() ? std::vector{rig.value()->default_address()} : a.to;
  rigs::Rig* const server = rig.value()->is_server() ? rig.value().get() : nullptr;
  if (server != nullptr && to.size() > 1) {
    return RefuseArguments(Status::Error("--to: given " + std::to_string(to.size()) +
                                         " times; expected once, since " + a.as +
                                         " is a server: several daemons connect to it"));
  }
  if (server != nullptr && player::IsStream(to.front())) {
    if (const Status status = CheckStreamFaults(spec); !status.ok()) return RefuseArguments(status);
  }
  auto stream =
      rigs::RigStream::Make(std::move(rig.value()), std::move(motions), a.rate_hz, spec, Props(a));
  if (!stream.ok()) return Fail(stream.status());
  Senders senders;
  senders.push_back(std::move(stream.value()));
  return Play(a, to, server, std::move(senders));
}

int Run(const Arguments& a) {
  const auto spec = faults::Parse(a.faults);
  if (!spec.ok()) return RefuseArguments(spec.status());
  const auto script = synthetic::ParseScript(a.script);
  if (!script.ok()) return RefuseArguments(script.status());
  if (const Status status = Check(a, spec.value()); !status.ok()) return RefuseArguments(status);
  if (!a.write.empty()) {
    const auto motion = MakePerformer(a, script.value(), 0);
    const Status status = player::WriteMotion(*motion, a.seconds, a.rate_hz, a.write);
    return status.ok() ? 0 : Fail(status);
  }
  auto motions = MakeMotions(a, script.value());
  if (!motions.ok()) return Fail(motions.status());
  if (a.as != "native") return RunRig(a, std::move(motions.value()), spec.value());
  const auto to = a.to.empty() ? std::vector<std::string>{"udp://127.0.0.1:7000"} : a.to;
  return Play(a, to, nullptr, MakeNative(a, std::move(motions.value()), spec.value()));
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Simulates a rig: plays BVH files, or a synthetic performer, to styled.",
               "stylesim");
  Arguments arguments;
  AddOptions(app, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kBadArguments;
  }
  // Without SA_RESTART a signal ends the sleep between two frames.
  struct sigaction action {};
  action.sa_handler = RequestStop;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  try {
    return Run(arguments);
  } catch (const std::exception& error) {
    return Fail(Status::Error(error.what()));
  }
}
