#include "clients/oscquery/find.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "clients/oscquery/answers.h"
#include "clients/oscquery/tree.h"

namespace styled::oscquery {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr const char* kHttp = "192.168.1.30";
constexpr const char* kTree =
    R"({"FULL_PATH": "/", "ACCESS": 0, "CONTENTS": {
      "avatar": {"FULL_PATH": "/avatar", "ACCESS": 0, "CONTENTS": {
        "change": {"FULL_PATH": "/avatar/change", "ACCESS": 3, "TYPE": "s"},
        "name": {"FULL_PATH": "/avatar/name", "ACCESS": 1, "TYPE": "s"}}},
      "chatbox": {"FULL_PATH": "/chatbox", "TYPE": "sT"}}})";

Receiver Read(const std::string& host_info, const std::string& tree = kTree) {
  Receiver receiver;
  const Status status = ReadAnswers(host_info, tree, kHttp, 5000, receiver);
  EXPECT_TRUE(status.ok()) << status.message();
  return receiver;
}

TEST(OscQueryFind, RefusesEachBadAnswerWithAReason) {
  const std::string deep = std::string(200000, '[') + std::string(200000, ']');
  const std::vector<std::array<std::string, 3>> cases{{
      {"", kTree, "HOST_INFO is not a JSON object"},
      {"[]", kTree, "HOST_INFO is not a JSON object"},
      {deep, kTree, "HOST_INFO is not a JSON object"},
      {"{}", "", "tree is not a JSON object"},
      {"{}", "nonsense", "tree is not a JSON object"},
      {"{}", "\"\xff\"", "tree is not a JSON object"},
      {R"({"OSC_PORT": 0})", kTree, "OSC_PORT"},
      {R"({"OSC_PORT": 65536})", kTree, "OSC_PORT"},
      {R"({"OSC_PORT": -1})", kTree, "OSC_PORT"},
      {R"({"OSC_PORT": "9000"})", kTree, "OSC_PORT"},
      {R"({"OSC_PORT": 1e30})", kTree, "OSC_PORT"},
      {R"({"OSC_TRANSPORT": "TCP"})", kTree, "expected UDP"},
  }};
  for (const auto& [host_info, tree, reason] : cases) {
    Receiver receiver;
    const Status status = ReadAnswers(host_info, tree, kHttp, 5000, receiver);
    EXPECT_THAT(status.message(), HasSubstr(reason)) << host_info.substr(0, 80);
  }
}

TEST(OscQueryFind, TheServersAddressCountsWhereHostInfoHasNone) {
  for (const char* ip : {"127.0.0.1", "0.0.0.0", "nonsense", "", "::1", "1.2.3"}) {
    const Receiver receiver = Read(R"({"OSC_PORT": 9000, "OSC_IP": ")" + std::string(ip) + "\"}");
    EXPECT_EQ(receiver.address, kHttp) << ip;
    EXPECT_EQ(receiver.port, 9000);
  }
  EXPECT_EQ(Read(R"({"OSC_IP": "192.168.1.31"})").address, "192.168.1.31");
  EXPECT_EQ(Read("{}").port, 5000) << "by the proposal";
  EXPECT_EQ(Read(R"({"OSC_IP": 7, "OSC_TRANSPORT": 7, "NAME": 7})").address, kHttp);
}

TEST(OscQueryFind, ListsTheAddressesThatCanBeWritten) {
  EXPECT_THAT(Read("{}").addresses, ElementsAre("/avatar/change", "/chatbox"));
  // Attributes of other types than the proposal's.
  EXPECT_THAT(Read("{}", R"({"FULL_PATH": 7, "ACCESS": "3", "CONTENTS": [1, {}]})").addresses,
              ElementsAre());
  EXPECT_THAT(
      Read("{}", R"({"CONTENTS": {"a": 7, "b": {"FULL_PATH": "/b", "ACCESS": -1}}})").addresses,
      ElementsAre("/b"));
}

TEST(OscQueryFind, ATreeIsReadToALimitedDepthAndNumber) {
  std::string deep = R"({"FULL_PATH": "/x", "ACCESS": 2})";
  for (int i = 0; i < 20000; ++i) deep = R"({"CONTENTS":{"a":)" + deep + "}}";
  EXPECT_THAT(Read("{}", deep).addresses, ElementsAre());
  std::string wide = R"({"CONTENTS": {)";
  for (int i = 0; i < 10000; ++i) {
    wide += (i == 0 ? "\"" : ",\"") + std::to_string(i) + R"(": {"FULL_PATH": "/", "ACCESS": 2})";
  }
  EXPECT_EQ(Read("{}", wide + "}}").addresses.size(), 4096U);
}

TEST(OscQueryFind, DamagedAnswersEndWithoutHarm) {
  const Description own{"x", TreeOf(MethodsOf("vrchat"), "x"), 9000};
  const std::string info = AnswerTo("/?HOST_INFO", own, "10.0.0.1").text;
  const std::string tree = AnswerTo("/", own, "10.0.0.1").text;
  std::mt19937 random(7);
  int readable = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string texts[2] = {info, tree};
    for (std::string& text : texts) {
      for (int j = i % 4; j > 0; --j) text[random() % text.size()] = static_cast<char>(random());
      if (i % 5 == 0) text.resize(random() % text.size());
    }
    Receiver receiver;
    const Status status = ReadAnswers(texts[0], texts[1], kHttp, 5000, receiver);
    if (status.ok()) {
      ++readable;
      EXPECT_GT(receiver.port, 0);
      EXPECT_LE(receiver.addresses.size(), MethodsOf("vrchat").size() + 12) << "and containers";
    }
  }
  EXPECT_GT(readable, 0);
  EXPECT_LT(readable, 3000);
}

// Our own answers are read by ourselves, too.
TEST(OscQueryFind, ReadsWhatAnswersHave) {
  const Description own{"styled-stage", TreeOf(MethodsOf("vmc"), "x"), 39540};
  const Receiver receiver =
      Read(AnswerTo("/?HOST_INFO", own, "10.0.0.1").text, AnswerTo("/", own, "10.0.0.1").text);
  EXPECT_EQ(receiver.address, "10.0.0.1");
  EXPECT_EQ(receiver.port, 39540);
  EXPECT_TRUE(HasPath(receiver, "/VMC"));
  EXPECT_TRUE(HasPath(receiver, "/VMC/Ext/Bone/Pos"));
  EXPECT_FALSE(HasPath(receiver, "/VM"));
  EXPECT_FALSE(HasPath(receiver, "/tracking"));
}

TEST(OscQueryFind, AReceiverIsChosenByItsNameOrTheBeginningOfIt) {
  std::vector<Receiver> receivers(4);
  receivers[0].name = "VRChat-Client-1A";
  receivers[1].name = "VRChat-Client-1A2B";
  receivers[2].name = "Warudo";
  receivers[3].name = "bad\x1b[31m";
  const auto chosen = [&](const std::string& name) {
    const auto found = Choose(receivers, name);
    return found.ok() ? found.value().name : found.status().message();
  };
  EXPECT_EQ(chosen("war"), "Warudo");
  EXPECT_EQ(chosen("vrchat-client-1a"), "VRChat-Client-1A") << "the whole name";
  EXPECT_THAT(chosen("VRChat"), HasSubstr("several"));
  EXPECT_THAT(chosen("VSeeFace"), HasSubstr("found: VRChat-Client-1A, VRChat-Client-1A2B, Warudo"));
  EXPECT_THAT(chosen("VSeeFace"), Not(HasSubstr("\x1b")));
  receivers.clear();
  EXPECT_THAT(chosen("Warudo"), HasSubstr("found: none"));
}

}  // namespace
}  // namespace styled::oscquery
