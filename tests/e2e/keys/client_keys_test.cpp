// stylerec and stylevmc with a daemon that requires keys: with keys they work as usual, without
// keys they receive nothing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "proto/keys/key_folder.h"
#include "proto/recording/reader.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"

namespace styled::support {
namespace {

using testing::HasSubstr;

class ClientKeysTest : public testing::Test {
 protected:
  ClientKeysTest()
      : daemon_({"security.keys=" + (folder_ / "keys"), "publish.address=tcp://0.0.0.0:0",
                 "control.address=tcp://0.0.0.0:0"}),
        link_(daemon_.udp) {
    const auto pair = keys::MakePair().value();
    EXPECT_TRUE(keys::WritePair(folder_ / "own.key", pair).ok());
    const keys::Client client{"own", pair.public_key, keys::Role::kOperator};
    EXPECT_TRUE(keys::Allow(folder_ / "keys", client).ok());
    link_.Send(rig_.Body());
    // A performer that sends until the end of the test.
    performing_ = std::thread([this] {
      while (!over_) Paced(12, 120, [this](int) { link_.Send(rig_.Frame()); });
    });
  }
  ~ClientKeysTest() override {
    over_ = true;
    performing_.join();
  }

  // Returns the exit code; `output_` holds the output.
  int Run(std::vector<std::string> command, bool with_keys) {
    if (with_keys) {
      for (const std::string& word : {std::string("--key"), folder_ / "own.key",
                                      std::string("--server-key"), daemon_.server_key}) {
        command.push_back(word);
      }
    }
    command.insert(command.begin(), {"/bin/sh", "-c", "exec \"$@\" >&2", "sh"});
    const std::string log = folder_ / ("log" + std::to_string(runs_++) + ".txt");
    Child child(command, log);
    const int code = child.Wait(60).value_or(-1);
    output_ = ReadText(log);
    return code;
  }
  // The address to connect to if the daemon binds every interface.
  static std::string Here(const std::string& endpoint) {
    return "tcp://127.0.0.1" + endpoint.substr(endpoint.rfind(':'));
  }

  // Whether a recording contains captured frames of the performer.
  static bool HasFrames(const std::string& file) {
    const auto reader = recording::Reader::Open(file);
    recording::Record record;
    while (reader.ok() && reader.value()->Next(record)) {
      if (record.published().topic().starts_with("source/")) return true;
    }
    return false;
  }

  TemporaryFolder folder_;
  Daemon daemon_;
  UdpLink link_;
  Rig rig_{"sim"};
  std::atomic<bool> over_{false};
  std::thread performing_;
  std::string output_;
  int runs_ = 0;
};

TEST_F(ClientKeysTest, StylerecRecordsAndPlaysWithThem) {
  const auto record = [&](const std::string& file, bool with_keys) {
    return Run({STYLEREC_BINARY, "record", "--from", Here(daemon_.publish), "--seconds", "2", file},
               with_keys);
  };
  // On a busy machine, two seconds may pass before the connection is established.
  std::string file;
  for (int attempt = 0; attempt < 10 && !HasFrames(file); ++attempt) {
    file = folder_ / ("with" + std::to_string(attempt) + ".styrec");
    ASSERT_EQ(record(file, true), 0) << output_;
  }
  ASSERT_TRUE(HasFrames(file)) << output_;
  ASSERT_EQ(record(folder_ / "without.styrec", false), 0) << output_;
  EXPECT_THAT(output_, HasSubstr("messages=0 "));

  Daemon other({"security.keys=" + (folder_ / "keys"), "publish.address=tcp://0.0.0.0:0",
                "control.address=tcp://0.0.0.0:0"});
  const auto play = [&](bool with_keys) {
    return Run({STYLEREC_BINARY, "play", file, "--to", "udp://" + other.udp, "--speed", "max",
                "--control", Here(other.control)},
               with_keys);
  };
  ASSERT_EQ(play(false), 1);
  EXPECT_THAT(output_, HasSubstr("no daemon answers"));
  ASSERT_EQ(play(true), 0) << output_;
}

TEST_F(ClientKeysTest, StylevmcForwardsWithThem) {
  const auto forward = [&](bool with_keys) {
    return Run({STYLEVMC_BINARY, "--to", "127.0.0.1:9", "--publish", Here(daemon_.publish),
                "--seconds", "2"},
               with_keys);
  };
  int code = 3;  // nothing arrived
  for (int attempt = 0; attempt < 10 && code == 3; ++attempt) code = forward(true);
  EXPECT_EQ(code, 0) << output_;
  EXPECT_EQ(forward(false), 3) << output_;
  EXPECT_THAT(output_, HasSubstr("no daemon answers at " + Here(daemon_.publish) +
                                 ": it requires keys, and none were given"));
}

TEST_F(ClientKeysTest, HalfOfThemIsRefusedWithAReason) {
  EXPECT_EQ(Run({STYLEVMC_BINARY, "--to", "127.0.0.1:9", "--key", folder_ / "own.key"}, false), 2);
  EXPECT_THAT(output_, HasSubstr("expected --server-key"));
  EXPECT_EQ(
      Run({STYLEREC_BINARY, "record", "--server-key", daemon_.server_key, folder_ / "a"}, false),
      1);
  EXPECT_THAT(output_, HasSubstr("expected --key FILE"));
  EXPECT_EQ(Run({STYLEREC_BINARY, "record", "--key", folder_ / "none", "--server-key",
                 daemon_.server_key, folder_ / "b"},
                false),
            1);
  EXPECT_THAT(output_, HasSubstr("none"));
}

}  // namespace
}  // namespace styled::support
