#pragma once

#include <sys/types.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/temporary_folder.h"

namespace styled::support {

// A child process of a test, with its stderr in a file. The destructor kills it.
class Child {
 public:
  // `environment` is added to the test's environment and overrides variables of the same name.
  // Aborts if the program cannot be started.
  Child(const std::vector<std::string>& arguments, const std::string& stderr_file,
        const std::map<std::string, std::string>& environment = {});
  ~Child();
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  void Signal(int signal) const;
  // The exit code, or 128 + signal if a signal ended the process; empty if it still runs after
  // `seconds`.
  std::optional<int> Wait(double seconds);
  bool Running() { return !Wait(0).has_value(); }
  pid_t pid() const { return pid_; }

 private:
  pid_t pid_;
  std::optional<int> exit_;
};

std::string ReadText(const std::string& file);  // "" if there is no file
void WriteText(const std::string& file, const std::string& text);

}  // namespace styled::support
