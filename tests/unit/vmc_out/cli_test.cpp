#include "clients/vmc/cli.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <sstream>

namespace styled::stylevmc {
namespace {

using testing::HasSubstr;

struct Outcome {
  int code;
  std::string out, err;
};

Outcome RunWith(std::vector<std::string> arguments) {
  std::ostringstream out, err;
  const std::atomic<bool> stop{false};
  const int code = Run(std::move(arguments), stop, out, err);
  return {code, out.str(), err.str()};
}

TEST(StylevmcCli, RefusesEachBadOptionWithAReason) {
  const std::string to = "127.0.0.1:39539";
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{}, "expected --to HOST:PORT or --find NAME"},
      {{"--to", "nonsense"}, "expected [PERFORMER=]HOST:PORT"},
      {{"--to", to, "--performer", "anna"}, "is not SOURCE.NAME"},
      {{"--to", to, "--rate", "0"}, "--rate"},
      {{"--to", to, "--rate", "nan"}, "expected a number"},
      {{"--to", to, "--root", "feet"}, "--root"},
      {{"--to", to, "--statistics", "-1"}, "--statistics"},
      {{"--to", to, "--nonsense"}, "--nonsense"},
  };
  for (const auto& [arguments, reason] : cases) {
    const Outcome outcome = RunWith(arguments);
    EXPECT_EQ(outcome.code, kExitUsage) << reason;
    EXPECT_THAT(outcome.err, HasSubstr(reason));
    EXPECT_THAT(outcome.err, HasSubstr("see stylevmc --help"));
  }
}

TEST(StylevmcCli, FailsWhereAHostOrAnEndpointCannotBe) {
  const Outcome host = RunWith({"--to", "no-such-host.invalid:39539"});
  EXPECT_EQ(host.code, kExitFailed);
  EXPECT_THAT(host.err, HasSubstr("no-such-host.invalid"));
  const Outcome endpoint = RunWith({"--to", "127.0.0.1:39539", "--publish", "nonsense"});
  EXPECT_EQ(endpoint.code, kExitFailed);
  EXPECT_THAT(endpoint.err, HasSubstr("cannot connect to nonsense"));
}

TEST(StylevmcCli, WithoutMdnsFindFails) {
  setenv("DBUS_SYSTEM_BUS_ADDRESS", "unix:path=/nonexistent/styled-test-bus", 1);
  const Outcome outcome = RunWith({"--find", "VRChat"});
  unsetenv("DBUS_SYSTEM_BUS_ADDRESS");
  EXPECT_EQ(outcome.code, kExitFailed);
  EXPECT_THAT(outcome.err, HasSubstr("--find: "));
  EXPECT_THAT(outcome.err, HasSubstr("avahi"));
}

TEST(StylevmcCli, AMissingDaemonIsReported) {
  const Outcome outcome =
      RunWith({"--to", "127.0.0.1:39539", "--publish", "ipc:///tmp/styled-nobody", "--seconds",
               "0.2", "--statistics", "0.1"});
  EXPECT_EQ(outcome.code, kExitNothing);
  EXPECT_THAT(outcome.out, HasSubstr("nobody yet -> 127.0.0.1:39539: 0.0 frames/s"));
  EXPECT_THAT(outcome.out, HasSubstr("no daemon answers"));
}

TEST(StylevmcCli, ExplainsItself) {
  EXPECT_EQ(RunWith({"--help"}).code, kExitOk);
  EXPECT_THAT(RunWith({"--help"}).out, HasSubstr("--performer"));
  EXPECT_THAT(RunWith({"--version"}).out, HasSubstr("stylevmc "));
}

}  // namespace
}  // namespace styled::stylevmc
