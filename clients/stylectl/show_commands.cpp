// list, status.
#include <algorithm>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "clients/stylectl/cli.h"
#include "clients/stylectl/commands.h"
#include "clients/stylectl/licence_report.h"
#include "clients/stylectl/report.h"
#include "model/tools/number.h"

namespace styled::stylectl {
namespace {

using client::CallStatus;

struct StatusArguments {
  bool all_counters = false;
  double watch_s = 0;  // 0: once
};

int List(Session& session) {
  v1::ListReply list;
  if (const CallStatus status = session.control().List(&list); !status.ok()) {
    return session.Fail(status);
  }
  if (session.json) {
    nlohmann::json object = ListJson(list);
    object["ok"] = true;
    session.out << object.dump() << "\n";
  } else {
    session.out << ListText(list);
  }
  return kExitOk;
}

int Licences(Session& session) {
  v1::ListReply list;
  if (const CallStatus status = session.control().List(&list); !status.ok()) {
    return session.Fail(status);
  }
  if (session.json) {
    nlohmann::json object = LicencesJson(list);
    object["ok"] = true;
    session.out << object.dump() << "\n";
  } else {
    session.out << LicencesText(list);
  }
  return kExitOk;
}

int Status(Session& session, const StatusArguments& arguments) {
  v1::StatusReply reply;
  if (const CallStatus status = session.control().Status(&reply); !status.ok()) {
    return session.Fail(status);
  }
  if (session.json) {
    nlohmann::json object = StatusJson(reply);
    object["ok"] = true;
    session.out << object.dump() << "\n";
  } else {
    session.out << StatusText(reply, arguments.all_counters);
  }
  return kExitOk;
}

// Continues while the daemon is down.
int Watch(Session& session, const StatusArguments& arguments) {
  constexpr const char* kHome = "\x1b[H\x1b[2J";
  for (;;) {
    if (!session.json) session.raw << kHome;
    (void)Status(session, arguments);
    session.out << std::flush;
    std::this_thread::sleep_for(std::chrono::duration<double>(arguments.watch_s));
    if (!session.out) return kExitOk;  // the reader has closed the pipe
  }
}

// One line of `stages`.
std::vector<std::string> StageRow(const std::string& endpoint, const CallStatus& status,
                                  const v1::StatusReply& reply) {
  if (!status.ok()) return {endpoint, "-", "", "", "", status.reason()};
  const v1::Stats& stats = reply.stats();
  const auto live = std::ranges::count_if(stats.performers(), &v1::PerformerStats::live);
  const v1::StandbyState& standby = stats.standby();
  std::string note;
  if (stats.has_standby() && !standby.heard()) note = standby.peer() + " does not answer";
  if (standby.role() == "following") note = standby.ready() ? "ready" : standby.why_not();
  return {endpoint,
          stats.has_standby() ? standby.role() : "alone",
          stats.has_standby() ? std::to_string(standby.term()) : "",
          std::to_string(live) + " of " + std::to_string(stats.performers_size()),
          reply.weights(),
          note};
}

// For several daemons at once, including those that do not answer.
int Stages(Session& session, std::vector<std::string> endpoints) {
  if (endpoints.empty()) endpoints = {session.options.endpoint};
  std::vector<std::vector<std::string>> rows{{"DAEMON", "ROLE", "TERM", "LIVE", "WEIGHTS", "NOTE"}};
  nlohmann::json object{{"ok", true}, {"daemons", nlohmann::json::array()}};
  bool all = true;
  for (const std::string& endpoint : endpoints) {
    client::ControlOptions options = session.options;
    options.endpoint = endpoint;
    auto control = client::Control::Connect(options);
    if (!control.ok()) return session.Usage(control.status().message());
    v1::StatusReply reply;
    const CallStatus status = control.value()->Status(&reply);
    all = all && status.ok();
    rows.push_back(StageRow(endpoint, status, reply));
    nlohmann::json row =
        status.ok() ? StatusJson(reply) : nlohmann::json{{"error", status.reason()}};
    row["endpoint"] = endpoint;
    object["daemons"].push_back(std::move(row));
  }
  object["ok"] = all;
  session.out << (session.json ? object.dump() + "\n" : Table(rows));
  return all ? kExitOk : kExitNoDaemon;
}

}  // namespace

void DeclareShowCommands(Session& session) {
  session.AddOnline("list", "styles and presets", [&session] { return List(session); });
  const auto arguments = std::make_shared<StatusArguments>();
  CLI::App* status = session.AddOnline(
      "status", "the daemon, its performers, its counters", [&session, arguments] {
        return arguments->watch_s > 0 ? Watch(session, *arguments) : Status(session, *arguments);
      });
  status
      ->add_option("--watch", arguments->watch_s,
                   "repeat at this interval in seconds (default 1), until Ctrl-C")
      ->expected(0, 1)
      ->default_str("1")
      ->check(Number(0.1, 3600.0));
  status->add_flag("--all", arguments->all_counters, "also show counters that are 0");
  const auto endpoints = std::make_shared<std::vector<std::string>>();
  CLI::App* stages =
      session.AddOnline("stages", "which of several daemons leads and which follows",
                        [&session, endpoints] { return Stages(session, *endpoints); });
  stages->add_option("ENDPOINT", *endpoints, "control addresses (default: that of --endpoint)");
  const std::string licences =
      "the styles that may be used commercially, the licences, and the names to credit";
  session.AddOnline("licences", licences, [&session] { return Licences(session); });
  // As it is spelt in the United States. --help does not show it, so that pages and completion name
  // the command once.
  session.AddOnline("licenses", licences, [&session] { return Licences(session); })->group("");
}

}  // namespace styled::stylectl
