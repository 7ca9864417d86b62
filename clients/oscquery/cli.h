#pragma once

#include <atomic>
#include <ostream>
#include <string>
#include <vector>

namespace styled::oscquery {

enum ExitCode : int {
  kExitOk = 0,
  kExitFailed = 1,   // --list: no mDNS; otherwise an endpoint that is invalid; the reason on `err`
  kExitUsage = 2,    // the command line is invalid
  kExitNothing = 3,  // --list: no receiver was found
};

// Runs styleoscquery inside the calling process; `arguments` are those after argv[0]. Runs until
// `stop` is set, with --list until the list is printed to `out`. Pinned by
// tests/unit/oscquery/cli_test.cpp and tests/witness/oscquery.
int Run(std::vector<std::string> arguments, const std::atomic<bool>& stop, std::ostream& out,
        std::ostream& err);

}  // namespace styled::oscquery
