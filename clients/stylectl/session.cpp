#include "clients/stylectl/session.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "clients/cpp/subscriber.h"
#include "clients/stylectl/cli.h"
#include "clients/stylectl/key_commands.h"
#include "clients/stylectl/suggest.h"
#include "model/base/version.h"
#include "model/tools/number.h"

namespace styled::stylectl {
Session::Session(std::ostream& out_stream, std::ostream& err_stream, std::ostream& raw_stream)
    : out(out_stream), err(err_stream), raw(raw_stream) {
  app.require_subcommand(0, 1);  // without one, Run reports it after unexpected arguments
  app.set_version_flag("--version", VersionText("stylectl"));
  app.add_option("--endpoint", options.endpoint,
                 "the daemon's control socket; for a pair with a standby both, with a comma")
      ->envname("STYLED_CONTROL")
      ->capture_default_str();
  client::Declare(app, keys_);
  key_folder = KeyArguments().folder;
  app.add_option("--keys", key_folder,
                 "for allow, revoke and keys: the daemon's folder of keys, its security.keys")
      ->envname("STYLED_SECURITY_KEYS")
      ->capture_default_str();
  app.add_option("--timeout", timeout_s_, "seconds to wait for an answer")
      ->check(Number(0.01, 600.0))
      ->capture_default_str();
  app.add_flag("--json", json, "one JSON object on standard output");
  app.footer(
      "Exit codes: 0 done, 1 the daemon refused, 2 usage, 3 no daemon answers.\n"
      "Examples:\n"
      "  stylectl set '*' --style old --strength 0.8\n"
      "  stylectl set rig.anna --mix old=0.6 --mix feminine=0.4 --transition 1000\n"
      "  stylectl clear rig.anna");
}

CLI::App* Session::Add(const std::string& name, const std::string& text, std::function<int()> run) {
  CLI::App* command = app.add_subcommand(name, text);
  command->fallthrough();  // options such as --json may follow the command
  command->callback([this, run = std::move(run)] { run_ = run; });
  return command;
}

CLI::App* Session::AddOnline(const std::string& name, const std::string& text,
                             std::function<int()> run) {
  return Add(name, text, [this, run = std::move(run)] {
    const int code = Connect();
    return code == kExitOk ? run() : code;
  });
}

CLI::App* Session::AddPart(CLI::App* of, const std::string& name, const std::string& text,
                           std::function<int()> run) {
  CLI::App* command = of->add_subcommand(name, text);
  command->fallthrough();
  command->callback([this, run = std::move(run)] { part_ = run; });
  return command;
}

void Session::AddPerformer(CLI::App* command, bool required, bool everyone) {
  command
      ->add_option("PERFORMER", performer,
                   !everyone  ? "SOURCE.NAME"
                   : required ? "SOURCE.NAME, or '*' for everyone"
                              : "SOURCE.NAME; default: everyone")
      ->required(required)
      ->check([everyone](const std::string& id) {
        if ((everyone && id == client::kEveryone) || client::IsPerformerId(id)) {
          return std::string();
        }
        return "'" + id + "' is not SOURCE.NAME ([A-Za-z0-9_-]{1,32} each)" +
               (everyone ? " or '*'" : "");
      });
}

int Session::Run(std::vector<std::string> arguments) {
  const bool folder_given =  // on the command line, not in the environment
      std::any_of(arguments.begin(), arguments.end(), [](const std::string& word) {
        return word == "--keys" || word.starts_with("--keys=");
      });
  std::reverse(arguments.begin(), arguments.end());  // the order that CLI11 wants
  try {
    app.parse(arguments);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error, out, err), kExitOk;
    return Unexpected(error.what());
  }
  if (!run_) return Usage("a command is required; expected one of " + Join(Commands(app)));
  const CLI::App* command = app.get_subcommands().front();
  if (folder_given &&
      std::find(with_key_folder.begin(), with_key_folder.end(), command) == with_key_folder.end()) {
    return Usage(
        "--keys FOLDER is for allow, revoke and keys; a client's own pair of keys is --key");
  }
  return run_();
}

int Session::Connect() {
  auto curve = client::ReadKeys(keys_);
  if (!curve.ok()) return Usage(curve.status().message());
  options.curve = std::move(curve.value());
  options.timeout = std::chrono::milliseconds(static_cast<int>(timeout_s_ * 1000.0));
  auto control = client::Control::Connect(options);
  if (!control.ok()) return Usage(control.status().message());
  control_ = std::move(control.value());
  return kExitOk;
}

std::vector<std::string> Session::Commands(const CLI::App& of) {
  std::vector<std::string> names;
  for (const CLI::App* command : of.get_subcommands({})) names.push_back(command->get_name());
  return names;
}

// Reports a command line that CLI11 refuses. For a misspelt command or option it suggests the
// nearest name.
int Session::Unexpected(const std::string& reason) {
  const auto chosen = app.get_subcommands();
  std::vector<std::string> known;
  const auto add = [&known](const CLI::App& of) {
    for (const CLI::Option* option : of.get_options()) {
      for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
    }
  };
  add(app);
  if (!chosen.empty()) add(*chosen.front());
  for (const std::string& word : app.remaining(true)) {
    const bool option = word.starts_with("--");
    const bool within = !chosen.empty() && chosen.front()->get_subcommands().empty();
    const std::vector<std::string> commands = chosen.empty() ? Commands(app)
                                              : within       ? Commands(*chosen.front())
                                                             : std::vector<std::string>();
    if (!option && (word.starts_with("-") || commands.empty())) continue;
    const std::string name = word.substr(0, word.find('='));
    const std::string near = Nearest(name, option ? known : commands);
    std::string text = "'" + name + "' is no " + (option ? "option" : "command");
    if (!chosen.empty()) text += " of " + chosen.front()->get_name();
    if (!near.empty()) {
      text += "; did you mean '" + near + "'?";
    } else if (!option) {
      text += "; expected one of " + Join(commands);
    }
    return Usage(text);
  }
  return Usage(reason);
}

}  // namespace styled::stylectl
