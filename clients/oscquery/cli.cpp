#include "clients/oscquery/cli.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cmath>

#include "clients/cpp/key_options.h"
#include "clients/oscquery/find.h"
#include "clients/oscquery/herald.h"
#include "model/base/text.h"
#include "model/base/version.h"

namespace styled::oscquery {
namespace {

constexpr std::chrono::milliseconds kStopPoll(100);
// With the longest name of a source it fits into a DNS label, which has 63 bytes.
constexpr std::size_t kMostNameBytes = 24;

struct Arguments {
  Options options;
  client::KeyOptions keys;
  bool list = false;
  double wait_s = 3;
};

std::string NameError(const std::string& name) {
  const bool plain = std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '-' || c == '_';
  });
  if (plain && !name.empty() && name.size() <= kMostNameBytes) return "";
  return "'" + Printable(name, 80) + "' is not a name; expected 1 to 24 of [A-Za-z0-9_-]";
}

void Declare(CLI::App& app, Arguments& a) {
  app.set_version_flag("--version", VersionText("styleoscquery"));
  app.add_option("--control", a.options.control, "the daemon's control socket")
      ->envname("STYLED_CONTROL")
      ->capture_default_str();
  client::Declare(app, a.keys);
  app.add_option("--name", a.options.name, "a source can be found as NAME-SOURCE")
      ->check(NameError)
      ->capture_default_str();
  app.add_flag("--list", a.list,
               "print the programs of the network that receive OSC, and end; no daemon is needed");
  app.add_option("--wait", a.wait_s, "with --list: seconds to wait for answers, at most")
      ->check(CLI::Range(0.1, 60.0))
      ->capture_default_str();
  app.footer(
      "Exit codes: 0, 1 failed, 2 usage, 3 with --list when nothing was found.\n"
      "Examples:\n"
      "  styleoscquery\n"
      "  styleoscquery --list");
}

// The receiver's purpose, in words: by the addresses that are known to us, else by the first
// parts of its own.
std::string Purpose(const Receiver& receiver) {
  if (!receiver.trouble.empty()) return receiver.trouble;
  std::string text;
  const auto add = [&text](const std::string& word) { text += (text.empty() ? "" : ", ") + word; };
  if (HasPath(receiver, "/VMC/Ext")) add("VMC");
  if (HasPath(receiver, "/tracking/trackers")) add("VRChat's trackers");
  if (HasPath(receiver, "/tracking/vrsystem")) add("VRChat's head and wrists");
  if (HasPath(receiver, "/avatar")) add("avatar parameters");
  if (!text.empty()) return text;
  std::vector<std::string> parts;
  for (const std::string& address : receiver.addresses) {
    const std::string part = address.substr(0, address.find('/', 1));
    if (std::find(parts.begin(), parts.end(), part) == parts.end()) parts.push_back(part);
  }
  if (parts.size() > 4) parts.resize(4);
  for (const std::string& part : parts) add(Printable(part, 40));
  return text.empty() ? "nothing that can be written" : text;
}

int List(const Arguments& a, std::ostream& out, std::ostream& err) {
  const auto receivers = FindReceivers(std::chrono::milliseconds(std::llround(1e3 * a.wait_s)));
  if (!receivers.ok()) {
    err << "styleoscquery: " << receivers.status().message() << "\n";
    return kExitFailed;
  }
  struct Row {
    std::string name, place, purpose;
  };
  std::vector<Row> rows{{"NAME", "OSC", "TAKES"}};
  for (const Receiver& r : receivers.value()) {
    const std::string place = r.port == 0 ? "-" : r.address + ":" + std::to_string(r.port);
    rows.push_back({Printable(r.name, 63), place, Purpose(r)});
  }
  if (rows.size() == 1) {
    err << "styleoscquery: no program in the network announces that it receives OSC\n";
    return kExitNothing;
  }
  std::size_t name = 0, place = 0;
  for (const Row& row : rows) {
    name = std::max(name, row.name.size());
    place = std::max(place, row.place.size());
  }
  for (Row& row : rows) {
    row.name.resize(name, ' ');
    row.place.resize(place, ' ');
    out << row.name << "  " << row.place << "  " << row.purpose << "\n";
  }
  return kExitOk;
}

}  // namespace

int Run(std::vector<std::string> arguments, const std::atomic<bool>& stop, std::ostream& out,
        std::ostream& err) {
  Arguments a;
  CLI::App app{"styleoscquery: lets VRChat and VMC programs find styled's sources, by OSCQuery",
               "styleoscquery"};
  Declare(app, a);
  const auto fail = [&err](const std::string& text, int code) {
    err << "styleoscquery: " << text
        << (code == kExitUsage ? "\n  see styleoscquery --help\n" : "\n");
    return code;
  };
  std::reverse(arguments.begin(), arguments.end());  // what CLI11 takes
  try {
    app.parse(arguments);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error, out, err), kExitOk;
    return fail(error.what(), kExitUsage);
  }
  if (std::isnan(a.wait_s)) return fail("--wait is nan; expected a number", kExitUsage);
  if (a.list) return List(a, out, err);
  const Status local = CheckLocal(a.options.control);
  if (!local.ok()) return fail(local.message(), kExitUsage);
  auto curve = client::ReadKeys(a.keys);
  if (!curve.ok()) return fail(curve.status().message(), kExitUsage);
  a.options.curve = std::move(curve.value());
  boost::asio::io_context io(1);
  const auto herald = Herald::Start(io, a.options, out, err);
  if (!herald.ok()) return fail(herald.status().message(), kExitFailed);
  while (!stop) io.run_for(kStopPoll);
  return kExitOk;
}

}  // namespace styled::oscquery
