#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "clients/cpp/control.h"
#include "clients/cpp/key_options.h"

namespace styled::stylectl {

// What the commands of stylectl share: the options that may stand before or behind each of them,
// the connection to the daemon, and how results and failures are reported. One thread.
class Session {
 public:
  Session(std::ostream& out, std::ostream& err);

  // Declares a command. `run` is called after the command line was read and returns the exit code.
  CLI::App* Add(const std::string& name, const std::string& text, std::function<int()> run);
  // The same, of a command that needs the daemon: `run` is called with the control socket open.
  CLI::App* AddOnline(const std::string& name, const std::string& text, std::function<int()> run);
  // PERFORMER of a command. `everyone`: '*' is a performer, too.
  void AddPerformer(CLI::App* command, bool required, bool everyone = true);

  // Reads the command line and runs its command.
  int Run(std::vector<std::string> arguments);

  // Opens the control socket; kExitOk, or reports why not.
  int Connect();
  client::Control& control() { return *control_; }

  // Report and return the exit code: of a change, of a refusal or a daemon that does not answer, of
  // a command line that makes no sense.
  int Changed(const client::CallStatus& status, const client::Applied& applied,
              const std::string& what);
  int Fail(const client::CallStatus& status);
  int Usage(const std::string& text);

  std::ostream& out;
  std::ostream& err;
  CLI::App app{"stylectl: ask and steer a running styled daemon", "stylectl"};
  client::ControlOptions options;
  bool json = false;
  std::string key_folder;  // --keys
  // Commands that --keys belongs to.
  std::vector<const CLI::App*> with_key_folder;

  // What the command line names; suggestions for misspelt names start from it.
  std::string performer{client::kEveryone};
  std::vector<std::string> styles;
  std::string preset, cue;
  bool clears = false;  // the performer goes back to what the daemon keeps nothing for

 private:
  struct Hint {
    std::string suggestion;  // the name that was probably meant
    std::string expected;
  };

  std::vector<std::string> Commands() const;
  int Unexpected(const std::string& reason);
  std::string NoteUnseen();
  Hint Explain(const client::CallStatus& status);
  void ExplainStyle(Hint& hint);
  void ExplainPerformer(Hint& hint);

  client::KeyOptions keys_;
  double timeout_s_ = 2.0;
  std::function<int()> run_;  // of the command on the command line
  std::unique_ptr<client::Control> control_;
};

}  // namespace styled::stylectl
