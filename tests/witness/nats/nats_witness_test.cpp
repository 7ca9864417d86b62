// What stylenats publishes, by the NATS project's own JavaScript client: subject, headers, the
// daemon's bytes, and the body in the KV bucket.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

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

TEST(NatsWitness, ReadsFramesHeadersAndTheBucket) {
  if (!HasNatsServer()) GTEST_SKIP() << "skipped, no nats-server (Debian: nats-server)";
  if (!HasClient()) GTEST_SKIP() << "skipped, no node, or npm could not fetch nats";
  NatsServers servers;
  servers.StartHub();
  servers.StartLeaf();
  Daemon daemon;
  const Subscriber sent(daemon.publish, {"styled/rig.a/canonical/", "body/"});
  const Stylenats bridge(daemon, servers.leaf_port);
  const Walker walker(daemon);
  NatsUser viewer(servers.hub_port, "viewer");
  ASSERT_TRUE(viewer.WaitForKey(kKey, 30)) << bridge.Log() << servers.Log();
  TemporaryFolder folder;
  Child node(
      {"/bin/sh", "-c",
       "cd '" CLIENT_FOLDER "' && exec node client.mjs " + servers.hub_port + " '" + kSubject +
           "' " + std::to_string(kFrames) + " '" + kKey + "' > '" + (folder / "out.txt") + "'"},
      folder / "stderr.txt", {{"VIEWER", "viewerword"}});
  ASSERT_EQ(node.Wait(60).value_or(-1), 0) << ReadText(folder / "stderr.txt");
  Sleep(0.3);  // `sent` has its own socket and thread

  std::map<std::string, std::vector<json>> printed;
  std::istringstream lines(ReadText(folder / "out.txt"));
  for (std::string what, rest; lines >> what && std::getline(lines, rest);) {
    printed[what].push_back(json::parse(rest));
  }
  std::map<std::uint64_t, std::string> frames;
  for (const Message& message : sent.Messages("styled/rig.a/canonical/")) {
    v1::Frame frame;
    ASSERT_TRUE(frame.ParseFromString(message.payload));
    frames[frame.sequence()] = message.payload;
  }
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
  EXPECT_TRUE(std::any_of(bodies.begin(), bodies.end(), [&value](const Message& message) {
    return message.payload == value;
  }));
}

}  // namespace
}  // namespace styled::support
