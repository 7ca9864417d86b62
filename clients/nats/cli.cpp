#include "clients/nats/cli.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "clients/cpp/key_options.h"
#include "clients/nats/bridge.h"
#include "clients/nats/relay.h"
#include "clients/nats/report.h"
#include "model/base/version.h"

namespace styled::stylenats {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kFlush(1000);  // at the end

struct Arguments {
  Options options;
  client::KeyOptions keys;
  std::string login;
  bool join = false;
  double stats_every_s = 10, seconds = 0;
};

void Declare(CLI::App& app, Arguments& a) {
  app.set_version_flag("--version", VersionText("stylenats"));
  app.add_option("--site", a.options.site,
                 "name of this daemon's site, the first token after styled. in all subjects; one "
                 "stylenats for each")
      ->required();
  app.add_flag("--join", a.join,
               "the other end: publish on this machine, at --publish and --control, the site's "
               "messages from NATS, for programs that read a daemon");
  stylenats::Declare(app,
                     "a broker, nats://HOST:PORT or tls://HOST:PORT: a leaf server that no viewer "
                     "uses; again for more, the first that answers is used",
                     a.options.link, a.login);
  app.add_option("--domain", a.options.domain,
                 "JetStream domain of the bucket 'styled', if it is not the account's own");
  app.add_option("--publish", a.options.publisher,
                 "the daemon's publisher; with --join the address to listen on, local only")
      ->envname("STYLED_PUBLISHER")
      ->capture_default_str();
  app.add_option("--control", a.options.control,
                 "the daemon's control socket; with --join the address to listen on")
      ->envname("STYLED_CONTROL")
      ->capture_default_str();
  client::Declare(app, a.keys);
  app.add_option("--stats-every", a.stats_every_s,
                 "seconds between two lines of counters, printed when they changed; 0: none")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  app.add_option("--seconds", a.seconds, "end by itself; 0: never")->check(CLI::Range(0.0, 1e9));
  app.footer(
      "Exit codes: 0 stopped, 1 the broker refuses the login, 2 usage.\n"
      "Examples:\n"
      "  stylenats --site stage\n"
      "  stylenats --site stage --join --nats nats://hub.example:4222   # then: stylemon\n"
      "  stylenats --site stage --nats nats://127.0.0.1:4223 --nats-login "
      "/etc/styled/nats.login");
}

Status Complete(Arguments& a) {
  if (std::isnan(a.stats_every_s + a.seconds)) {
    return Status::Error("a value is nan; expected a number");
  }
  LinkOptions& link = a.options.link;
  if (const Status status = stylenats::Complete(a.login, link); !status.ok()) return status;
  auto curve = client::ReadKeys(a.keys);
  if (!curve.ok()) return curve.status();
  a.options.curve = std::move(curve.value());
  if (a.join && a.options.curve) {
    return Status::Error("--join reads no daemon: expected no --key and no --server-key");
  }
  link.name = std::string(a.join ? "stylenats --join " : "stylenats ") + a.options.site;
  link.shared_thread = a.join;
  return Status::Ok();
}

Clock::duration Seconds(double seconds) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

bool Over(const Arguments& a, Clock::time_point begin) {
  return a.seconds > 0 && Clock::now() >= begin + Seconds(a.seconds);
}

int Pass(const Arguments& a, Bridge& bridge, const std::atomic<bool>& stop, std::ostream& out,
         std::ostream& err) {
  Report report(a.options, out, err);
  report.PrintStart();
  const auto begin = Clock::now();
  auto next = begin + Seconds(a.stats_every_s);
  bool closed = false;
  while (!stop && !closed && !Over(a, begin)) {
    bridge.Step(milliseconds(50));
    closed = report.PrintNews(bridge);
    if (a.stats_every_s == 0 || Clock::now() < next) continue;
    report.PrintCounters(bridge, bridge.queue());
    next = Clock::now() + Seconds(a.stats_every_s);
  }
  bridge.Stop(kFlush);
  if (a.stats_every_s > 0) report.PrintCounters(bridge, bridge.queue());
  return closed ? kExitFailed : kExitOk;
}

// Prints the changes. Returns true if the broker refuses us for good.
bool PrintNews(const Arguments& a, Relay& relay, std::ostream& err) {
  bool closed = false;
  for (const LinkEvent& event : relay.link().Events()) {
    err << "stylenats: "
        << EventText(event, BrokersText(a.options.link), "; nothing arrives until it is back", "")
        << std::endl;
    closed = closed || event.kind == LinkEvent::Kind::kClosed;
  }
  const std::string error = relay.NextError();
  if (!error.empty()) err << "stylenats: KV: " << error << std::endl;
  return closed;
}

void PrintCounters(const RelayTotals& t, std::size_t subjects, std::ostream& out) {
  out << "stylenats: " << t.passed << " passed of " << subjects << " subjects, " << t.replaced
      << " replaced, " << t.odd << " not understood; " << t.requests << " commands, "
      << t.unanswered << " without an answer" << std::endl;
}

int Join(const Arguments& a, const std::atomic<bool>& stop, std::ostream& out, std::ostream& err) {
  const Options& o = a.options;
  auto opened = Relay::Open({o.publisher, o.control, o.site, o.domain, o.link});
  if (!opened.ok())
    return err << "stylenats: " << opened.status().message() << std::endl, kExitUsage;
  Relay& relay = *opened.value();
  err << "stylenats: " << BrokersText(o.link) << ", site " << o.site << " -> " << o.publisher
      << ", commands from " << o.control << std::endl;
  const auto begin = Clock::now();
  auto next = begin + Seconds(a.stats_every_s);
  std::pair<RelayTotals, std::size_t> shown;
  const auto print = [&] {
    const std::pair now(relay.totals(), relay.subjects());
    if (std::exchange(shown, now) != now) PrintCounters(now.first, now.second, out);
    next = Clock::now() + Seconds(a.stats_every_s);
  };
  bool closed = false;
  while (!stop && !closed && !Over(a, begin)) {
    relay.Step(milliseconds(50));
    closed = PrintNews(a, relay, err);
    if (a.stats_every_s > 0 && Clock::now() >= next) print();
  }
  if (a.stats_every_s > 0) print();
  return closed ? kExitFailed : kExitOk;
}

}  // namespace

int Run(std::vector<std::string> arguments, const std::atomic<bool>& stop, std::ostream& out,
        std::ostream& err) {
  Arguments a;
  CLI::App app{"stylenats: styled performers by NATS to many places, and commands back",
               "stylenats"};
  Declare(app, a);
  const auto fail = [&err](const std::string& text) {
    err << "stylenats: " << text << "\n  see stylenats --help\n";
    return kExitUsage;
  };
  std::reverse(arguments.begin(), arguments.end());  // what CLI11 takes
  try {
    app.parse(arguments);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error, out, err), kExitOk;
    return fail(error.what());
  }
  if (const Status status = Complete(a); !status.ok()) return fail(status.message());
  if (a.join) return Join(a, stop, out, err);
  auto bridge = Bridge::Open(a.options);
  if (!bridge.ok()) return fail(bridge.status().message());
  return Pass(a, *bridge.value(), stop, out, err);
}

}  // namespace styled::stylenats
