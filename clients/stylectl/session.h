#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "clients/cpp/control.h"
#include "clients/cpp/key_options.h"

namespace styled::stylectl {

// The state that the commands of stylectl share: options that may precede or follow any command,
// the connection to the daemon, and the reporting of results and failures. One thread.
class Session {
 public:
  // `out` and `err` are clean (model/base/clean_stream.h); `raw`: the same as `out`, for bytes of
  // our own.
  Session(std::ostream& out, std::ostream& err, std::ostream& raw);

  // Declares a command. `run` is called after the command line was parsed and returns the exit
  // code.
  CLI::App* Add(const std::string& name, const std::string& text, std::function<int()> run);
  // The same for a command that needs the daemon: `run` is called after Connect() succeeded.
  CLI::App* AddOnline(const std::string& name, const std::string& text, std::function<int()> run);
  // Declares a command of a command, as `styles export`. `run` is called by RunPart(), for which
  // has_part() tells whether one was chosen.
  CLI::App* AddPart(CLI::App* of, const std::string& name, const std::string& text,
                    std::function<int()> run);
  bool has_part() const { return part_ != nullptr; }
  int RunPart() { return part_(); }
  // Declares the argument PERFORMER of a command. `everyone`: '*' is accepted, too.
  void AddPerformer(CLI::App* command, bool required, bool everyone = true);

  // Parses the command line and runs its command. Returns the exit code.
  int Run(std::vector<std::string> arguments);

  // Opens the control socket. Returns kExitOk, or reports the error and returns its exit code.
  int Connect();
  client::Control& control() { return *control_; }

  // Report a result and return the exit code. Changed: the outcome of a change. Fail: a refusal, or
  // no reply from the daemon. Usage: an invalid command line.
  int Changed(const client::CallStatus& status, const client::Applied& applied,
              const std::string& what);
  int Fail(const client::CallStatus& status);
  int Usage(const std::string& text);
  // The note about a performer that was named and has not been seen; "" if there is none.
  std::string NoteUnseen();

  std::ostream& out;
  std::ostream& err;
  std::ostream& raw;  // a file's bytes, control of the screen; flush `out` first
  CLI::App app{"stylectl: query and control a running styled daemon", "stylectl"};
  client::ControlOptions options;
  bool json = false;
  std::string key_folder;  // --keys
  // Commands that accept --keys.
  std::vector<const CLI::App*> with_key_folder;

  // Names on the command line. Suggestions for misspelt names are chosen relative to them.
  std::string performer{client::kEveryone};
  std::vector<std::string> styles;
  std::string preset, cue;
  // The command resets the performer to bypass, for which the daemon stores nothing.
  bool clears = false;

 private:
  struct Hint {
    std::string suggestion;  // the name that was probably meant
    std::string expected;
  };

  static std::vector<std::string> Commands(const CLI::App& of);
  int Unexpected(const std::string& reason);
  Hint Explain(const client::CallStatus& status);
  void ExplainStyle(Hint& hint);
  void ExplainPerformer(Hint& hint);

  client::KeyOptions keys_;
  double timeout_s_ = 2.0;
  std::function<int()> run_, part_;  // the chosen command, and its part
  std::unique_ptr<client::Control> control_;
};

}  // namespace styled::stylectl
