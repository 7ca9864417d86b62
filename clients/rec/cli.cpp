#include "clients/rec/cli.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

#include "clients/rec/commands.h"
#include "clients/rec/time_text.h"
#include "model/base/terminal_text.h"
#include "model/base/version.h"

namespace styled::rec {
namespace {

using std::string;
using std::vector;

class Program {
 public:
  explicit Program(const Dependencies& to) : to_(to) { Declare(); }
  int Run(vector<string> arguments);

 private:
  void Declare();
  void DeclareRecord();
  void DeclareReceive();
  void DeclarePlay();
  void DeclareExport();
  void DeclareExplain();
  void DeclareJetStream();
  void DeclareFetch();
  void Broker(CLI::App* command);
  void AboutTheFile(CLI::App* command);
  void FileToRead(CLI::App* command);
  // `run` is called after the command line was parsed. `check`, if given, is called before it; its
  // error is a usage error.
  using Command = Status (*)(const Arguments&, const Dependencies&);
  CLI::App* Add(const string& name, const string& text, Command run,
                std::function<Status()> check = {});
  int Usage(const string& text);

  Dependencies to_;
  Command run_ = nullptr;
  std::function<Status()> check_;
  Arguments a_;
  CLI::App app_{
      "stylerec: records the data of rigs and of styled; plays it back, "
      "exports it",
      "stylerec"};
};

CLI::App* Program::Add(const string& name, const string& text, Command run,
                       std::function<Status()> check) {
  CLI::App* command = app_.add_subcommand(name, text);
  command->callback([this, run, check = std::move(check)] {
    run_ = run;
    check_ = check;
  });
  return command;
}

void Program::AboutTheFile(CLI::App* command) {
  command->add_option("OUT", a_.file, "the new recording, e.g. walk.styrec")->required();
  command->add_option("--seconds", a_.seconds, "stop after this time (0: at Ctrl-C)")
      ->check(CLI::Range(0.0, 1e9));
  command->add_option("--description", a_.description, "stored in the file");
  command->add_option("--config", a_.config, "the daemon's styled.toml: its text is stored");
  command->add_option("--weights", a_.weights, "the daemon's weights: name and hash are stored");
}

void Program::FileToRead(CLI::App* command) {
  command->add_option("FILE", a_.file, "a recording")->required();
  command->add_flag("--salvage", a_.salvage,
                    "continue although the file does not begin like a recording");
}

void Program::DeclareRecord() {
  CLI::App* record = Add("record", "record the messages of daemons", RunRecord);
  record->add_option("--from", a_.from, "publishers")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->capture_default_str();
  CLI::Option* performer =
      record->add_option("--performer", a_.performer, "SOURCE.NAME; default: everyone")
          ->check([](const string& id) {
            if (client::IsPerformerId(id)) return string();
            return "'" + id + "' is not SOURCE.NAME ([A-Za-z0-9_-]{1,32} each)";
          });
  record->add_option("--topics", a_.topics, "prefixes of topics instead of all, e.g. source/,body/")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->excludes(performer);
  client::Declare(*record, a_.keys);
  AboutTheFile(record);
}

void Program::DeclareReceive() {
  const auto check = [this] {
    if (a_.forward.size() <= a_.listen.size()) return Status::Ok();
    return Status::Error("receive: found " + std::to_string(a_.forward.size()) +
                         " addresses in --forward, expected at most one per --listen");
  };
  CLI::App* receive =
      Add("receive", "record the datagrams that arrive at a port, unchanged", RunReceive, check);
  receive
      ->add_option("--listen", a_.listen,
                   "[NAME=]udp://HOST:PORT, comma-separated; NAME of the daemon's source "
                   "(default rig, rig2, ...); HOST numeric, 0.0.0.0: every interface")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->required();
  receive
      ->add_option(
          "--forward", a_.forward,
          "HOST:PORT for each port in turn: forwards the datagrams there, and its answers back")
      ->delimiter(',')
      ->allow_extra_args(false);
  receive->add_option("--type", a_.type, "stored in the file: the source's type in styled.toml")
      ->capture_default_str();
  AboutTheFile(receive);
}

void Program::DeclarePlay() {
  const auto check = [this] {
    if (!a_.to.empty() || !a_.publish.empty()) return CheckPlay(a_);
    return Status::Error("play: nothing to play to; expected --to or --publish");
  };
  CLI::App* play = Add("play", "play a recording into a daemon, or to subscribers", RunPlay, check);
  FileToRead(play);
  play->add_option(
      "--to", a_.to,
      "[NAME=]udp://HOST:PORT or tcp://HOST:PORT: target of the datagrams (of source NAME); "
      "'original': the recorded address. A recording without arrivals sends the frames "
      "published on source/");
  play->add_option(
      "--publish", a_.publish,
      "publish the recorded messages again, e.g. on tcp://127.0.0.1:7001 (port 0: any)");
  play->add_option("--wait", a_.wait_s, "with --publish: seconds to wait for a first subscriber")
      ->check(CLI::Range(0.0, 86400.0));
  play->add_option("--control", a_.control,
                   "the daemon's control socket: recorded commands are repeated at their places, "
                   "and --speed max waits for the daemon");
  client::Declare(*play, a_.keys);
  play->add_option("--speed", a_.speed, "times real time, or max")->capture_default_str();
  play->add_flag("--loop", a_.loop, "restart at the end, until Ctrl-C");
  play->add_option("--from", a_.from_s, "seconds to skip at the beginning of the recording")
      ->check(CLI::Range(0.0, 1e9));
  play->add_option("--to-time", a_.until_s, "end there")->check(CLI::Range(0.0, 1e9));
  play->add_flag("--as-recorded", a_.as_recorded,
                 "keep session ids and epochs; a daemon or subscriber that has seen them before "
                 "drops all of it as repetitions");
}

void Program::DeclareExport() {
  const auto check = [this] {
    if (!a_.exports.empty()) return Status::Ok();
    return Status::Error("export: nothing to write; expected --out FILE, of " +
                         clip::FormatNames());
  };
  CLI::App* command = Add("export", "write a performer's motion to a file: " + clip::FormatNames(),
                          RunExport, check);
  FileToRead(command);
  command->add_option("--performer", a_.performer, "SOURCE.NAME")->required();
  command
      ->add_option("--what", a_.what,
                   "rig, canonical or the name of an [[output]] (all styled), or source (as "
                   "captured)")
      ->type_name("TEXT:{rig,canonical,source}")
      ->check([](const string& name) {
        if (client::IsPerformerId("x." + name)) return string();
        return "'" + name +
               "' is not rig, canonical, source or an output's name ([A-Za-z0-9_-]{1,32})";
      })
      ->capture_default_str();
  command
      ->add_option_function<vector<string>>(
          "--out",
          [this](const vector<string>& files) {
            for (const string& file : files)
              a_.exports.emplace_back(clip::FindFormat(file).value(), file);
          },
          "file to write, in the format of its extension: " + clip::FormatNames())
      ->allow_extra_args(false)
      ->check([](const string& file) { return clip::FindFormat(file).status().message(); });
  // With its option, a format can be written to a file of any name.
  for (const clip::Format& format : clip::Formats()) {
    command->add_option_function<string>(
        "--" + string(format.extension.substr(1)),
        [this, &format](const string& file) { a_.exports.emplace_back(&format, file); },
        string(format.summary));
  }
  command->add_flag("--overwrite", a_.overwrite, "overwrite existing files");
  command
      ->add_option(
          "--rate", a_.rate_hz,
          "frames per second; default: the recording's own, or the times of its frames in a format "
          "that has them")
      ->check(CLI::Range(1.0, 1000.0));
}

void Program::DeclareExplain() {
  CLI::App* explain =
      Add("explain", "what the daemon made of a performer's frames, and why", RunExplain);
  FileToRead(explain);
  explain->add_option("PERFORMER", a_.performer, "SOURCE.NAME")->required();
  explain->add_option("SEQUENCE", a_.sequence,
                      "the frame with this number, as subscribers got it; default: all");
}

void Program::Broker(CLI::App* command) {
  stylenats::Declare(*command, "the server that records, nats://HOST:PORT or tls://HOST:PORT",
                     a_.broker, a_.login);
  command->add_option("--domain", a_.domain,
                      "JetStream domain of the recording, if it is another server's");
}

void Program::DeclareJetStream() {
  const auto check = [this] {
    if (a_.action == "delete" && !a_.yes) {
      return Status::Error("jetstream delete removes the recordings of all sites; expected --yes");
    }
    for (const string& stream : a_.streams) {
      if (stream == "canonical30") {
        return Status::Error(
            "--streams canonical30: the audience tier is every fourth frame of canonical; expected "
            "canonical");
      }
      if (!client::IsPerformerId("x." + stream)) {
        return Status::Error("--streams '" + stream +
                             "': expected rig, canonical or an output's name");
      }
    }
    return Status::Ok();
  };
  CLI::App* command =
      Add("jetstream", "record, on a NATS server's disk, the messages of stylenats of all sites",
          RunJetStream, check);
  command
      ->add_option(
          "ACTION", a_.action,
          "create: begin to record, or change streams and limits; status: show the recordings; "
          "delete: end it, and delete all of it")
      ->required()
      ->type_name("TEXT:{create,status,delete}")
      ->check([](const string& action) {
        const bool known = action == "create" || action == "status" || action == "delete";
        return known ? string() : "'" + action + "': expected create, status or delete";
      });
  command
      ->add_option("--max-gb", a_.max_gb,
                   "create: GB (10^9 bytes) on the disk; beyond that the oldest are removed")
      ->check(CLI::Range(0.001, 1e6))
      ->capture_default_str();
  command->add_option("--max-hours", a_.max_hours, "create: hours after which a frame is removed")
      ->check(CLI::Range(0.0001, 1e6))
      ->capture_default_str();
  command
      ->add_option("--streams", a_.streams,
                   "create: comma-separated, of rig, canonical and the names of [[output]]s")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->capture_default_str();
  command->add_flag("--yes", a_.yes, "delete: all of it");
  Broker(command);
}

void Program::DeclareFetch() {
  const auto check = [this] {
    for (const auto& [option, text] :
         {std::pair{"fetch: --from ", &a_.from_time}, {"fetch: --to ", &a_.to_time}}) {
      if (text->empty()) continue;
      const auto time = ParseTime(*text, 0);
      if (!time.ok()) return Status::Error(option + time.status().message());
    }
    return Status::Ok();
  };
  CLI::App* fetch =
      Add("fetch", "copy a span of time of a site from a server's recording to a file", RunFetch,
          check);
  fetch->add_option("OUT", a_.file, "the new recording, e.g. walk.styrec")->required();
  fetch->add_option("--site", a_.site, "the site, as stylenats --site has it")->required();
  fetch->add_option("--performer", a_.performer, "SOURCE.NAME; default: everyone");
  fetch->add_option("--from", a_.from_time,
                    "a time: 2026-11-26T14:03:05, with Z at its end for UTC, or -15m (s, m, h, d) "
                    "before now; default: the recording's beginning");
  fetch->add_option("--to", a_.to_time, "a time; default: now");
  fetch->add_option("--description", a_.description, "stored in the file");
  Broker(fetch);
}

void Program::Declare() {
  app_.require_subcommand(0, 1);  // Run reports a missing command
  app_.set_version_flag("--version", VersionText("stylerec"));
  app_.footer(
      "Exit codes: 0 done, 1 failed, 2 usage.\n"
      "Examples:\n"
      "  stylerec record --from tcp://127.0.0.1:7001 show.styrec\n"
      "  stylerec receive --listen udp://0.0.0.0:7000 --forward 127.0.0.1:7010 rig.styrec\n"
      "  stylerec play rig.styrec --to udp://127.0.0.1:7000\n"
      "  stylerec export show.styrec --performer rig.anna --out anna.glb\n"
      "  stylerec jetstream create --max-gb 10 --max-hours 24 --nats nats://rec.example:4225\n"
      "  stylerec fetch --site stage --from -15m late.styrec --nats nats://rec.example:4225");
  DeclareRecord();
  DeclareReceive();
  CLI::App* info =
      Add("info", "show the content of a recording, and whether it is complete", RunInfo);
  FileToRead(info);
  info->add_flag("--json", a_.json, "one JSON object");
  DeclarePlay();
  DeclareExport();
  DeclareExplain();
  DeclareJetStream();
  DeclareFetch();
}

int Program::Run(vector<string> arguments) {
  std::reverse(arguments.begin(), arguments.end());  // the order that CLI11 wants
  try {
    app_.parse(arguments);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app_.exit(error, to_.out, to_.err), kExitOk;
    return Usage(error.what());
  }
  if (run_ == nullptr) return Usage("a command is required");
  const string command = app_.get_subcommands().front()->get_name();
  // CLI11's range checks accept NaN.
  for (const double value :
       {a_.seconds, a_.wait_s, a_.from_s, a_.until_s, a_.rate_hz, a_.max_gb, a_.max_hours}) {
    if (std::isnan(value)) return Usage(command + ": a value is nan; expected a number");
  }
  const Status usage = check_ ? check_() : Status::Ok();
  if (!usage.ok()) return Usage(usage.message());
  const Status status = run_(a_, to_);
  if (status.ok()) return kExitOk;
  to_.err << "stylerec: " << ForTerminal(status.message()) << "\n";
  return kExitFailed;
}

int Program::Usage(const string& text) {
  to_.err << "stylerec: " << ForTerminal(text)
          << "\n  see stylerec --help, stylerec COMMAND --help\n";
  return kExitUsage;
}

}  // namespace

int Run(vector<string> arguments, const std::atomic<bool>& stop, std::ostream& out,
        std::ostream& err) {
  return Program({stop, out, err}).Run(std::move(arguments));
}

}  // namespace styled::rec
