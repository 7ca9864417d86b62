// The messages of stylenats, read by the NATS project's own JavaScript client: subject, headers,
// the daemon's bytes, and the body in the KV bucket.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "clients/rec/cli.h"
#include "tests/e2e/nats/stage.h"

namespace styled::support {
namespace {

using nlohmann::json;

constexpr const char* kSubject = "styled.hall.rig=2Ea.canonical";
constexpr const char* kKey = "hall.body.rig=2Ea.canonical";
constexpr int kFrames = 30;

bool HasClient() {
  return std::system("command -v node >/dev/null 2>&1") == 0 &&
         std::filesystem::exists(CLIENT_FOLDER "/node_modules/nats");
}

std::string Decode(const std::string& base64) {
  const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned value = 0, bits = 0;
  for (const char c : base64) {
    if (c == '=') break;
    value = value << 6U | static_cast<unsigned>(letters.find(c));
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes += static_cast<char>(value >> bits & 0xFFU);
  }
  return bytes;
}

// The output of a script, lines of a word and JSON, by the word.
std::map<std::string, std::vector<json>> Node(const std::string& script, const std::string& port,
                                              const std::string& arguments) {
  const TemporaryFolder folder;
  Child node({"/bin/sh", "-c",
              "cd '" CLIENT_FOLDER "' && exec node " + script + " " + port + " '" + arguments +
                  "' > '" + (folder / "out.txt") + "'"},
             folder / "stderr.txt", {{"VIEWER", "viewerword"}});
  EXPECT_EQ(node.Wait(60).value_or(-1), 0) << ReadText(folder / "stderr.txt");
  Sleep(0.3);  // the daemon's subscriber has its own socket and thread
  std::map<std::string, std::vector<json>> printed;
  std::istringstream lines(ReadText(folder / "out.txt"));
  for (std::string what, rest; lines >> what && std::getline(lines, rest);) {
    printed[what].push_back(json::parse(rest));
  }
  return printed;
}

std::map<std::uint64_t, std::string> FramesBySequence(const Subscriber& sent) {
  std::map<std::uint64_t, std::string> frames;
  for (const Message& message : sent.Messages("styled/rig.a/canonical/")) {
    v1::Frame frame;
    EXPECT_TRUE(frame.ParseFromString(message.payload));
    frames[frame.sequence()] = message.payload;
  }
  return frames;
}

class NatsWitness : public testing::Test {
 protected:
  void SetUp() override {
    if (!HasNatsServer()) GTEST_SKIP() << "skipped, no nats-server (Debian: nats-server)";
    if (!HasClient()) GTEST_SKIP() << "skipped, no node, or npm could not fetch nats";
  }
};

TEST_F(NatsWitness, ReadsFramesHeadersAndTheBucket) {
  NatsServers servers;
  servers.StartHub();
  servers.StartLeaf();
  Daemon daemon;
  const Subscriber sent(daemon.publish, {"styled/rig.a/canonical/", "body/"});
  const Stylenats bridge(daemon, servers.leaf_port);
  const Walker walker(daemon);
  NatsUser viewer(servers.hub_port, "viewer");
  ASSERT_TRUE(viewer.WaitForKey(kKey, 30)) << bridge.Log() << servers.Log();
  auto printed = Node("client.mjs", servers.hub_port,
                      std::string(kSubject) + "' " + std::to_string(kFrames) + " '" + kKey);
  const auto frames = FramesBySequence(sent);
  ASSERT_EQ(printed["frame"].size(), static_cast<std::size_t>(kFrames));
  std::uint64_t last = 0;
  for (const json& row : printed["frame"]) {
    EXPECT_EQ(row["subject"], kSubject);
    const std::uint64_t sequence = std::stoull(row["sequence"].get<std::string>());
    EXPECT_GT(sequence, last);
    last = sequence;
    ASSERT_TRUE(frames.contains(sequence)) << sequence;
    const std::string payload = Decode(row["payload"].get<std::string>());
    EXPECT_EQ(payload, frames.at(sequence));
    v1::Frame frame;
    ASSERT_TRUE(frame.ParseFromString(payload));
    EXPECT_EQ(row["epoch"], std::to_string(frame.epoch()));
  }
  ASSERT_EQ(printed["value"].size(), 1U);
  const json& row = printed["value"][0];
  EXPECT_EQ(row["key"], kKey);
  EXPECT_EQ(row["operation"], "PUT");
  const std::string value = Decode(row["payload"].get<std::string>());
  const auto bodies = sent.Messages("body/rig.a/");
  EXPECT_TRUE(std::any_of(bodies.begin(), bodies.end(),
                          [&value](const Message& message) { return message.payload == value; }));
}

TEST_F(NatsWitness, ReadsTheRecordingThatStylerecBegan) {
  NatsServers servers;
  servers.StartHub();
  servers.StartLeaf();
  servers.StartRec();
  const TemporaryFolder folder;
  const std::string login = folder / "login";
  WriteText(login, "operator\noperatorword\n");
  std::filesystem::permissions(login, std::filesystem::perms(0600));
  std::ostringstream out, err;
  ASSERT_EQ(rec::Run({"jetstream", "create", "--max-gb", "0.5", "--max-hours", "2", "--nats-login",
                      login, "--nats", "nats://127.0.0.1:" + servers.rec_port},
                     std::atomic<bool>(false), out, err),
            0)
      << err.str();
  Daemon daemon;
  const Subscriber sent(daemon.publish, {"styled/rig.a/canonical/", "body/"});
  const NatsUser viewer(servers.hub_port, "viewer", kSubject);
  const Stylenats bridge(daemon, servers.leaf_port);
  const Walker walker(daemon);
  ASSERT_TRUE(viewer.WaitFor(2 * kFrames, "", 30)) << bridge.Log() << servers.Log();
  auto printed = Node("recording.mjs", servers.rec_port,
                      std::string(kSubject) + "' '" + std::to_string(kFrames));
  ASSERT_EQ(printed["stream"].size(), 1U);
  const json& stream = printed["stream"][0];
  EXPECT_EQ(stream["storage"], "file");
  EXPECT_EQ(stream["discard"], "old");
  EXPECT_EQ(stream["max_bytes"], 500'000'000);
  EXPECT_EQ(stream["max_age"], 7'200'000'000'000);
  EXPECT_EQ(stream["subjects"], json({"styled.*.*.rig", "styled.*.*.rig.body",
                                      "styled.*.*.canonical", "styled.*.*.canonical.body"}));
  const auto frames = FramesBySequence(sent);
  ASSERT_EQ(printed["message"].size(), static_cast<std::size_t>(kFrames));
  std::uint64_t last = 0;
  double time_s = 0;
  for (const json& row : printed["message"]) {
    EXPECT_EQ(row["subject"], kSubject);
    const std::uint64_t sequence = std::stoull(row["sequence"].get<std::string>());
    EXPECT_GT(sequence, last);
    last = sequence;
    EXPECT_GE(row["time"].get<double>(), time_s);
    time_s = row["time"].get<double>();
    ASSERT_TRUE(frames.contains(sequence)) << sequence;
    EXPECT_EQ(Decode(row["payload"].get<std::string>()), frames.at(sequence));
  }
  // A body is recorded with its frames.
  printed = Node("recording.mjs", servers.rec_port, std::string(kSubject) + ".body' '1");
  ASSERT_EQ(printed["message"].size(), 1U);
  const std::string body = Decode(printed["message"][0]["payload"].get<std::string>());
  const auto bodies = sent.Messages("body/rig.a/");
  EXPECT_TRUE(std::any_of(bodies.begin(), bodies.end(),
                          [&body](const Message& message) { return message.payload == body; }));
}

}  // namespace
}  // namespace styled::support
