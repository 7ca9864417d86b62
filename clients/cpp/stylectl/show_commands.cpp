// list, status.
#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "clients/cpp/stylectl/cli.h"
#include "clients/cpp/stylectl/commands.h"
#include "clients/cpp/stylectl/report.h"
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
    if (!session.json) session.out << kHome;
    (void)Status(session, arguments);
    session.out << std::flush;
    std::this_thread::sleep_for(std::chrono::duration<double>(arguments.watch_s));
    if (!session.out) return kExitOk;  // the reader has closed the pipe
  }
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
                   "again every so many seconds (1 where none are said), until Ctrl-C")
      ->expected(0, 1)
      ->default_str("1")
      ->check(Number(0.1, 3600.0));
  status->add_flag("--all", arguments->all_counters, "counters that are 0, too");
}

}  // namespace styled::stylectl
