// explain: the fates of a performer's frames, and their causes.
#include <algorithm>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "clients/stylectl/cli.h"
#include "clients/stylectl/commands.h"
#include "model/tools/number.h"
#include "proto/styled/explain.h"

namespace styled::stylectl {
namespace {

constexpr std::uint32_t kMost = 1024;  // as many as the daemon keeps
constexpr std::chrono::milliseconds kPause{500};

struct ExplainArguments {
  std::string performer;
  std::uint64_t sequence = 0;
  std::uint32_t last = 120;
  bool follow = false;
};

nlohmann::json FateJson(const v1::FrameFate& fate) {
  const auto& reason = fate.reason();
  nlohmann::json object{{"sequence", fate.sequence()},
                        {"source_sequence", fate.source_sequence()},
                        {"body", fate.is_body()},
                        {"fate", fate.fate() == v1::FATE_STYLED        ? "published"
                                 : fate.fate() == v1::FATE_PASSED_OVER ? "passed over"
                                 : fate.is_body() && reason.empty()    ? "taken"
                                                                       : "refused"},
                        {"reason", reason},
                        {"arrival_ns", fate.arrival_ns()},
                        {"lateness_ms", fate.lateness_ms()},
                        {"latency_ms", fate.latency_ms()},
                        {"lost", fate.lost()},
                        {"flags", fate.flags()},
                        {"text", fate.text()}};
  if (fate.limb_weights_size() > 0) {
    object["limb_weights"] =
        std::vector<float>(fate.limb_weights().begin(), fate.limb_weights().end());
  }
  return object;
}

void Print(Session& session, const v1::ExplainReply& reply) {
  if (!session.json) {
    session.out << ExplainLines(
        std::vector<v1::FrameFate>(reply.frames().begin(), reply.frames().end()));
    return;
  }
  nlohmann::json object{{"ok", true}, {"frames", nlohmann::json::array()}};
  for (const v1::FrameFate& fate : reply.frames()) object["frames"].push_back(FateJson(fate));
  session.out << object.dump() << "\n";
}

int Explain(Session& session, const ExplainArguments& arguments) {
  v1::Explain request;
  if (arguments.sequence != 0) {
    request.set_sequence(arguments.sequence);
  } else {
    request.set_last(arguments.follow ? 1 : arguments.last);
  }
  v1::ExplainReply reply;
  client::CallStatus status = session.control().Explain(arguments.performer, request, &reply);
  while (status.ok()) {
    Print(session, reply);
    if (!arguments.follow) return kExitOk;
    session.out << std::flush;
    if (!session.out) return kExitOk;  // the reader has closed the pipe
    std::this_thread::sleep_for(kPause);
    request.Clear();
    request.set_after_ns(reply.now_ns());
    reply.Clear();
    status = session.control().Explain(arguments.performer, request, &reply);
  }
  return session.Fail(status);
}

}  // namespace

void DeclareExplain(Session& session) {
  const auto arguments = std::make_shared<ExplainArguments>();
  CLI::App* explain = session.AddOnline("explain", "the fate of a performer's frames, and why",
                                        [&session, arguments] {
                                          arguments->performer = session.performer;
                                          return Explain(session, *arguments);
                                        });
  session.AddPerformer(explain, true, false);
  CLI::Option* sequence = explain->add_option("SEQUENCE", arguments->sequence,
                                              "the frame with this number, as subscribers get it");
  CLI::Option* last =
      explain->add_option("--last", arguments->last, "number of newest frames, up to 1024")
          ->check(CLI::Range(std::uint32_t{1}, kMost))
          ->capture_default_str()
          ->excludes(sequence);
  explain->add_flag("--follow", arguments->follow, "continue with new frames, until Ctrl-C")
      ->excludes(sequence)
      ->excludes(last);
}

}  // namespace styled::stylectl
