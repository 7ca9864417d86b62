#include "clients/nats/cli.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/support/temporary_folder.h"

namespace styled::stylenats {
namespace {

using testing::HasSubstr;

struct Outcome {
  int code;
  std::string out, err;
};

Outcome RunWith(const std::vector<std::string>& arguments) {
  std::ostringstream out, err;
  const std::atomic<bool> stop = false;
  const int code = Run(arguments, stop, out, err);
  return {code, out.str(), err.str()};
}

std::string Write(const std::string& file, const std::string& text, mode_t mode) {
  std::ofstream(file) << text;
  chmod(file.c_str(), mode);
  return file;
}

TEST(NatsCli, RefusesEachBadArgument) {
  const struct {
    std::vector<std::string> arguments;
    const char* says;
  } rows[] = {
      {{}, "--site"},
      {{"--site", ""}, "--site ''"},
      {{"--site", std::string(65, 'x')}, "1 to 64 bytes"},
      {{"--site", "s", "--no-such"}, "--no-such"},
      {{"--site", "s", "--nats", "127.0.0.1:4222"}, "expected nats://HOST:PORT"},
      {{"--site", "s", "--nats", "nats://u:p@h:4222"}, "--nats-login FILE"},
      {{"--site", "s", "--nats-login", "/nonexistent"}, "--nats-login /nonexistent"},
      {{"--site", "s", "--nats-creds", "/nonexistent"}, "--nats-creds /nonexistent"},
      {{"--site", "s", "--nats-ca", "/nonexistent"}, "--nats-ca /nonexistent"},
      {{"--site", "s", "--publish", "x"}, "cannot connect to x"},
      {{"--site", "s", "--control", "x"}, "'x'"},
      {{"--site", "s", "--stats-every", "nan"}, "nan"},
      {{"--site", "s", "--stats-every", "-1"}, "-1"},
      {{"--site", "s", "--key", "/nonexistent"}, "--key"},
  };
  for (const auto& row : rows) {
    const Outcome outcome = RunWith(row.arguments);
    EXPECT_EQ(outcome.code, kExitUsage) << row.says;
    EXPECT_THAT(outcome.err, HasSubstr(row.says));
    EXPECT_THAT(outcome.err, HasSubstr("stylenats --help"));
  }
}

TEST(NatsCli, RefusesALoginThatIsNone) {
  const support::TemporaryFolder folder;
  const auto refused = [](const std::string& file) {
    const Outcome outcome = RunWith({"--site", "s", "--nats-login", file});
    EXPECT_EQ(outcome.code, kExitUsage);
    return outcome.err;
  };
  EXPECT_THAT(refused(Write(folder / "open", "bridge\nsecret\n", 0644)), HasSubstr("chmod 600"));
  EXPECT_THAT(refused(Write(folder / "one", "bridge\n", 0600)), HasSubstr("expected two lines"));
  EXPECT_THAT(refused(Write(folder / "none", "", 0600)), HasSubstr("expected two lines"));
  const std::string good = Write(folder / "good", "bridge\nsecret\n", 0600);
  const std::string creds = Write(folder / "creds", "", 0600);
  const Outcome both = RunWith({"--site", "s", "--nats-login", good, "--nats-creds", creds});
  EXPECT_EQ(both.code, kExitUsage);
  EXPECT_THAT(both.err, HasSubstr("expected one of them"));
  EXPECT_EQ(both.err.find("secret"), std::string::npos);
}

TEST(NatsCli, WithoutBrokerAndDaemonItWaitsAndSaysSoOnce) {
  const Outcome outcome =
      RunWith({"--site", "hall.1", "--nats", "nats://127.0.0.1:1", "--publish", "tcp://127.0.0.1:1",
               "--control", "tcp://127.0.0.1:1", "--seconds", "1.5"});
  EXPECT_EQ(outcome.code, kExitOk) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("commands at styledctl.hall=2E1"));
  const std::string absent = "no broker answers at nats://127.0.0.1:1";
  const std::size_t first = outcome.err.find(absent);
  ASSERT_NE(first, std::string::npos) << outcome.err;
  EXPECT_EQ(outcome.err.find(absent, first + 1), std::string::npos) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("no daemon answers at tcp://127.0.0.1:1"));
  EXPECT_EQ(outcome.out, "") << "no counter changed";
}

}  // namespace
}  // namespace styled::stylenats
