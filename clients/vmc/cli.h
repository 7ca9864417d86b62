#pragma once

#include <atomic>
#include <ostream>
#include <string>
#include <vector>

namespace styled::stylevmc {

enum ExitCode : int {
  kExitOk = 0,       // an error of a host or an endpoint; the reason on `err`
  kExitFailed = 1,   // the command line is invalid
  kExitUsage = 2,    // the command line makes no sense
  kExitNothing = 3,  // with --seconds: no frame was forwarded in that time
};

// Runs stylevmc inside the calling process; `arguments` are those after argv[0]. Runs until `stop`
// is set; statistics go to `out`, errors to `err`. Pinned by tests/unit/vmc_out/cli_test.cpp and
// tests/e2e/vmc_out.
int Run(std::vector<std::string> arguments, const std::atomic<bool>& stop, std::ostream& out,
        std::ostream& err);

}  // namespace styled::stylevmc
