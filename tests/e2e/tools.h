#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/child.h"
#include "tests/support/daemon.h"

namespace styled::support {

// Runs the offline programs as a user runs them in a shell.
class ToolsTest : public testing::Test {
 protected:
  // Runs `arguments`; output_ holds its stderr.
  int Run(std::vector<std::string> arguments) {
    const std::string log = folder_ / ("log" + std::to_string(runs_++) + ".txt");
    Child child(arguments, log);
    const int code = child.Wait(60).value_or(-1);
    output_ = ReadText(log);
    return code;
  }
  // Writes a second of the synthetic performer as BVH.
  std::string Walk(const std::string& rate_hz = "30", const std::string& seconds = "1");

  TemporaryFolder folder_;
  std::string output_;

 private:
  int runs_ = 0;
};

}  // namespace styled::support
