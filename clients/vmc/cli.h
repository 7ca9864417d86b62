#pragma once

#include <atomic>
#include <ostream>
#include <string>
#include <vector>

namespace styled::stylevmc {

enum ExitCode : int {
  kExitOk = 0,
  kExitFailed = 1,   // a host or an endpoint; the reason on `err`
  kExitUsage = 2,    // the command line makes no sense
  kExitNothing = 3,  // with --seconds: no frame was forwarded in that time
};

// stylevmc without its process: `arguments` as after argv[0]. Runs until `stop` is set; statistics
// go to `out`, errors to `err`. Pinned by tests/unit/vmc_out/cli_test.cpp and tests/e2e/vmc_out.
int Run(std::vector<std::string> arguments, const std::atomic<bool>& stop, std::ostream& out,
        std::ostream& err);

}  // namespace styled::stylevmc
