#pragma once

#include <atomic>
#include <ostream>
#include <string>
#include <vector>

namespace styled::stylenats {

enum ExitCode : int {
  kExitOk = 0,      // stopped by a signal, or the end of --seconds
  kExitFailed = 1,  // the broker refuses the login for good; the reason is on `err`
  kExitUsage = 2,   // the command line, or a file that it names, is invalid
};

// Runs stylenats inside the calling process; `arguments` are those after argv[0]. Runs until `stop`
// is set; counters go to `out`, events of the connections and errors to `err`. Pinned by
// tests/unit/nats/cli_test.cpp and tests/e2e/nats.
int Run(std::vector<std::string> arguments, const std::atomic<bool>& stop, std::ostream& out,
        std::ostream& err);

}  // namespace styled::stylenats
