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

// Moves this process and its future children into a new network namespace with loopback only, where
// other tests are not audible. False if the kernel does not permit it. Call once per process,
// before any thread starts.
bool EnterOwnNetwork();
// Whether a shell command succeeds.
bool Shell(const std::string& command);

// A UDP port of 127.0.0.1 that was free a moment ago.
std::uint16_t FreePort();
std::string Local(std::uint16_t port);  // "127.0.0.1:7000"

// Sends the result of `make` repeatedly until the destructor.
class Streaming {
 public:
  Streaming(const std::string& address, double rate_hz, std::function<Bytes()> make);

 private:
  std::jthread thread_;
};

// Fixture: a performer, a faulty set-up, and the doctor.
class DoctorTest : public testing::Test {
 protected:
  static void SetUpTestSuite();

  struct Report {
    int code = -1;
    std::string text;
    nlohmann::json json;
    std::vector<std::string> problems;  // codes, in order

    // The finding with this code; null if there is none.
    const nlohmann::json& Finding(const std::string& finding) const;
    std::string Of(const std::string& finding, const char* key) const;
  };
  // Runs stylectl doctor --json with these arguments, listening for two seconds.
  Report Doctor(std::vector<std::string> arguments, bool capture = false);
  // A styled.toml with one source, and with a control port where no program listens.
  std::string Config(const std::string& type, const std::string& listen,
                     const std::string& keys = "");
  // Runs stylesim as a child until the test ends.
  void Play(const std::string& as, const std::string& to,
            const std::vector<std::string>& arguments = {});

  static bool own_network;
  TemporaryFolder folder_;

 private:
  std::vector<std::unique_ptr<Child>> players_;
  int runs_ = 0;
};

}  // namespace styled::support
