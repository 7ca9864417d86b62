#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/child.h"
#include "tests/support/rig.h"

namespace styled::support {

// Puts this process, and the children to come, into a network of its own with loopback alone, where
// no other test is heard. False where the kernel does not let it; once per process, before threads.
bool EnterOwnNetwork();
// Whether a command of the shell succeeds.
bool Shell(const std::string& command);

// A UDP port of 127.0.0.1 that nobody had a moment ago.
std::uint16_t FreePort();
std::string Local(std::uint16_t port);  // "127.0.0.1:7000"

// Sends what `make` makes, over and over, until it goes out of scope.
class Streaming {
 public:
  Streaming(const std::string& address, double rate_hz, std::function<Bytes()> make);

 private:
  std::jthread thread_;
};

// A performer on a stage where something is wrong, and the doctor.
class DoctorTest : public testing::Test {
 protected:
  static void SetUpTestSuite();

  struct Report {
    int code = -1;
    std::string text;
    nlohmann::json json;
    std::vector<std::string> problems;  // codes, in order

    // The finding with this code; null where there is none.
    const nlohmann::json& Finding(const std::string& finding) const;
    std::string Of(const std::string& finding, const char* key) const;
  };
  // stylectl doctor --json with these arguments, listening for two seconds.
  Report Doctor(std::vector<std::string> arguments, bool capture = false);
  // A styled.toml of one source, with a control port where nobody is.
  std::string Config(const std::string& type, const std::string& listen,
                     const std::string& keys = "");
  // stylesim as a child, until the test's end.
  void Play(const std::string& as, const std::string& to,
            const std::vector<std::string>& arguments = {});

  static bool own_network;
  TemporaryFolder folder_;

 private:
  std::vector<std::unique_ptr<Child>> players_;
  int runs_ = 0;
};

}  // namespace styled::support
