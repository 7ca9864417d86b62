#include "clients/oscquery/cli.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <sstream>
#include <utility>

namespace styled::oscquery {
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

TEST(StyleoscqueryCli, RefusesEachBadOptionWithAReason) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"--name", ""}, "expected 1 to 24 of [A-Za-z0-9_-]"},
      {{"--name", "a b"}, "'a b' is not a name"},
      {{"--name", "a\nb"}, "'a\\nb' is not a name"},
      {{"--name", std::string(25, 'a')}, "is not a name"},
      {{"--list", "--wait", "0"}, "--wait"},
      {{"--list", "--wait", "nan"}, "expected a number"},
      {{"--nonsense"}, "--nonsense"},
      {{"--key", "/no/such/key"}, "expected also --server-key"},
  };
  for (const auto& [arguments, reason] : cases) {
    const Outcome outcome = RunWith(arguments);
    EXPECT_EQ(outcome.code, kExitUsage) << reason;
    EXPECT_THAT(outcome.err, HasSubstr(reason));
    EXPECT_THAT(outcome.err, HasSubstr("see styleoscquery --help"));
  }
}

TEST(StyleoscqueryCli, FailsWhereAnEndpointCannotBe) {
  const Outcome outcome = RunWith({"--control", "nonsense"});
  EXPECT_EQ(outcome.code, kExitFailed);
  EXPECT_THAT(outcome.err, HasSubstr("--control"));
}

TEST(StyleoscqueryCli, WithoutAvahiTheListEndsWithTheCure) {
  setenv("DBUS_SYSTEM_BUS_ADDRESS", "unix:path=/nonexistent/styled-test-bus", 1);
  const Outcome outcome = RunWith({"--list"});
  unsetenv("DBUS_SYSTEM_BUS_ADDRESS");
  EXPECT_EQ(outcome.code, kExitFailed);
  EXPECT_THAT(outcome.err, HasSubstr("avahi-daemon, which speaks mDNS, does not answer"));
  EXPECT_THAT(outcome.err,
              HasSubstr("apt-get install avahi-daemon, then systemctl start avahi-daemon"));
}

}  // namespace
}  // namespace styled::oscquery
