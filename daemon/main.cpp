// styled: arguments, configuration, signals, exit code. 0: clean stop. 1: could not run. 2: bad
// arguments or configuration.
#include <google/protobuf/stubs/logging.h>
#include <malloc.h>
#include <signal.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <iostream>

#include "daemon/config/config.h"
#include "daemon/config/machine.h"
#include "daemon/replay/replay.h"
#include "daemon/runtime/journal.h"
#include "daemon/runtime/notify.h"
#include "daemon/runtime/realtime.h"
#include "daemon/styles/make_config.h"
#include "daemon/supervisor.h"
#include "model/base/text.h"
#include "model/base/version.h"
#include "model/net/default_weights.h"

namespace {

constexpr int kFailed = 1;
constexpr int kBadArguments = 2;

struct Arguments {
  std::string config_file, check_file, weights, ready_file, replay, replay_to;
  bool as_decided = false;
  std::vector<std::string> settings;
};

int Parse(int argc, char** argv, Arguments& arguments) {
  CLI::App app{"styled: restyles live motion capture and publishes it over ZeroMQ"};
  app.add_option("--config", arguments.config_file, "configuration file (TOML)");
  app.add_option("--check-config", arguments.check_file, "check a configuration file and exit");
  app.add_option("--set", arguments.settings, "section.key=value, over file and environment")
      ->allow_extra_args(false);
  app.add_option("--weights", arguments.weights, "weights file (as --set model.weights=FILE)");
  app.add_option("--ready-file", arguments.ready_file,
                 "where to write the endpoints, as JSON, once all is open");
  auto* const replay =
      app.add_option("--replay", arguments.replay,
                     "replay a recording on its own clock and exit; without --config, with the "
                     "configuration in the recording");
  auto* const replay_to =
      app.add_option("--replay-to", arguments.replay_to,
                     "with --replay: file for the recording of the published frames");
  app.add_flag("--as-decided", arguments.as_decided,
               "with --replay: frames are late, skipped or without style as they were then")
      ->needs(replay);
  replay->needs(replay_to);
  replay_to->needs(replay);
  app.set_version_flag("--version", [] {
    return styled::VersionText("styled") + "\n" + styled::net::DescribeDefaultWeights();
  });
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? 0 : kBadArguments;
  }
  // A shell produces an empty name from an unset variable. Ignoring it would run another command.
  for (const char* const name : {"--config", "--check-config", "--replay", "--replay-to"}) {
    const CLI::Option* const option = app.get_option(name);
    if (option->count() == 0 || !option->as<std::string>().empty()) continue;
    std::cerr << "styled: " << name << ": found an empty name, expected a file\n";
    return kBadArguments;
  }
  return -1;
}

bool ToJournal() {
  return styled::runtime::IsJournal(std::getenv("JOURNAL_STREAM"), STDERR_FILENO);
}

int Refuse(const std::string& why, int code) {
  std::cerr << (ToJournal() ? "<3>" : "")
            << "styled: " << styled::Printable(why, styled::runtime::kLongestLine) << "\n";
  styled::runtime::Notifier::FromEnvironment().SetStatus(why);
  return code;
}

// Logs to stderr, with colours if that is a terminal; to the journal if stderr is connected to it.
void StartLog(const std::string& level) {
  if (ToJournal()) {
    const std::vector<styled::runtime::LogField> always{{"SYSLOG_IDENTIFIER", "styled"},
                                                        {"STYLED_VERSION", STYLED_VERSION}};
    auto sink = std::make_shared<styled::runtime::JournalSink>(always);
    spdlog::set_default_logger(std::make_shared<spdlog::logger>("styled", std::move(sink)));
  } else {
    spdlog::set_default_logger(spdlog::stderr_color_mt("styled"));
    spdlog::set_formatter(styled::runtime::LineFormatter());
  }
  spdlog::set_level(spdlog::level::from_str(level));
}

styled::Result<styled::Origin> MakeOrigin(const Arguments& arguments) {
  styled::Origin origin;
  origin.file = arguments.check_file.empty() ? arguments.config_file : arguments.check_file;
  origin.ready_file = arguments.ready_file;
  auto overrides = styled::config::EnvironmentOverrides(environ);
  if (!overrides.ok()) return overrides.status();
  origin.overrides = std::move(overrides.value());
  for (const auto& setting : arguments.settings) {
    auto parsed = styled::config::ParseOverride(setting);
    if (!parsed.ok()) return parsed.status();
    origin.overrides.push_back(std::move(parsed.value()));
  }
  if (!arguments.weights.empty()) {
    origin.overrides.push_back({"model.weights", "'" + arguments.weights + "'", "--weights"});
  }
  return origin;
}

// Opens no sockets, so that it can run beside a running daemon.
int Replay(const Arguments& arguments, const styled::Origin& origin) {
  auto reader = styled::recording::Reader::Open(arguments.replay);
  if (!reader.ok()) return Refuse(reader.status().message(), kBadArguments);
  const auto config = origin.file.empty()
                          ? styled::replay::ConfigOf(*reader.value(), origin.overrides)
                          : styled::config::Load(origin.file, origin.overrides);
  if (!config.ok()) return Refuse(config.status().message(), kBadArguments);
  const auto summary = styled::replay::ReplayToFile(*reader.value(), config.value(),
                                                    arguments.replay_to, arguments.as_decided);
  if (!summary.ok()) return Refuse(summary.status().message(), kFailed);
  std::cout << "styled: " << summary.value() << "\n";
  return 0;
}

// Allocations of at least this size get pages of their own, which return to the system when they
// are freed. By default glibc raises this bound to the size of the largest block that was freed, up
// to 32 MiB. After one large request all later ones would then lie in heaps, among small blocks
// that keep their pages in use. Measured after four minutes of tests/hostile/abuse.cpp: 49 MB of
// free blocks in 73 MB of heaps, and growing; with the bound, 15 MB in 33 MB, and constant.
constexpr int kOwnPages_bytes = 128 * 1024;

// Blocks the signals for all threads that start later; the supervisor reads them from a descriptor.
void BlockSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&signals, signal);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  signal(SIGPIPE, SIG_IGN);
  signal(SIGXFSZ, SIG_IGN);  // a recording that reaches its size limit is an error like a full disk
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  const int done = Parse(argc, argv, arguments);
  if (done >= 0) return done;
  auto origin = MakeOrigin(arguments);
  if (!origin.ok()) return Refuse(origin.status().message(), kBadArguments);
  if (!arguments.replay.empty()) return Replay(arguments, origin.value());
  auto config = styled::config::Load(origin.value().file, origin.value().overrides);
  if (!config.ok()) return Refuse(config.status().message(), kBadArguments);
  if (!arguments.check_file.empty()) {
    // Also loads the weights, because presets can only be checked against their styles.
    std::uint32_t crc = 0;
    const auto made = styled::pipeline::MakeRuntimeConfig(config.value(), nullptr, crc);
    if (!made.ok()) return Refuse(made.status().message(), kBadArguments);
    const auto folder = styled::config::CheckRecordFolder(config.value().record.file);
    if (!folder.ok()) return Refuse(arguments.check_file + ": " + folder.message(), kBadArguments);
    for (const auto& warning : styled::config::MissingInterfaces(config.value())) {
      std::cerr << "styled: " << arguments.check_file << ": warning: " << warning << "\n";
    }
    std::cout << arguments.check_file << ": ok\n";
    return 0;
  }

  mallopt(M_MMAP_THRESHOLD, kOwnPages_bytes);
  BlockSignals();
  StartLog(config.value().log.level);
  google::protobuf::SetLogHandler(nullptr);  // hostile messages are counted, not printed
  styled::runtime::HotSection::Find();
  try {
    styled::Supervisor supervisor(std::move(config.value()), std::move(origin.value()));
    const styled::Status status = supervisor.Start();
    if (!status.ok()) return Refuse(status.message(), kFailed);
    supervisor.Run();
  } catch (const std::exception& error) {
    return Refuse(error.what(), kFailed);
  }
  return 0;
}
