#include "clients/oscquery/answers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "clients/oscquery/tree.h"

namespace styled::oscquery {
namespace {

using nlohmann::json;

Description Stage() { return {"styled-stage", TreeOf(MethodsOf("vmc"), "stage"), 39540}; }

Answer Get(std::string_view target) { return AnswerTo(target, Stage(), "192.168.1.20"); }

TEST(OscQueryAnswers, RefuseEachBadTarget) {
  const std::vector<std::pair<std::string, unsigned>> cases{
      {"", 400},
      {"VMC", 400},
      {"*", 400},
      {"http://192.168.1.20/", 400},
      {"/VMC/Ext/Bonn", 404},
      {"/VMC/Ext/T/more", 404},
      {"/../../etc/passwd", 404},
      {std::string("/VMC\0/Ext", 9), 404},
      {"/%56MC", 404},
      {"/" + std::string(100000, 'a'), 404},
      {"/?NONSENSE", 400},
      {"/?host_info", 400},
      {"/?VALUE&HOST_INFO", 400},
      {"/VMC/Ext/T?VALUE", 204},  // write-only
      {"/VMC?TYPE", 204},
      {"/VMC/Ext/T?CONTENTS", 204},
  };
  for (const auto& [target, status] : cases) {
    const Answer answer = Get(target);
    EXPECT_EQ(answer.status, status) << target.substr(0, 80);
    EXPECT_EQ(answer.text.empty(), status == 204);
  }
}

TEST(OscQueryAnswers, TellHowTheSourceIsReached) {
  for (const char* target : {"/?HOST_INFO", "/VMC?HOST_INFO", "/?HOST_INFO#x"}) {
    const Answer answer = Get(target);
    ASSERT_EQ(answer.status, 200U);
    const json info = json::parse(answer.text);
    EXPECT_EQ(info["NAME"], "styled-stage");
    EXPECT_EQ(info["OSC_IP"], "192.168.1.20");
    EXPECT_EQ(info["OSC_PORT"], 39540);
    EXPECT_EQ(info["OSC_TRANSPORT"], "UDP");
    EXPECT_EQ(info["EXTENSIONS"]["ACCESS"], true);
  }
}

TEST(OscQueryAnswers, AreNodesAndTheirAttributes) {
  EXPECT_EQ(json::parse(Get("/").text), Stage().tree);
  EXPECT_EQ(json::parse(Get("/?").text), Stage().tree);
  const json bone = json::parse(Get("/VMC/Ext/Bone/Pos").text);
  EXPECT_EQ(bone["FULL_PATH"], "/VMC/Ext/Bone/Pos");
  EXPECT_EQ(json::parse(Get("/VMC/Ext/Bone/Pos/").text), bone);
  EXPECT_EQ(Get("/VMC/Ext/Bone/Pos?TYPE").text, R"({"TYPE":"sfffffff"})");
  EXPECT_EQ(Get("/VMC/Ext/Bone/Pos?ACCESS").text, R"({"ACCESS":2})");
  EXPECT_EQ(Get("/VMC?FULL_PATH").text, R"({"FULL_PATH":"/VMC"})");
  EXPECT_EQ(json::parse(Get("/VMC/Ext/Bone?CONTENTS").text)["CONTENTS"]["Pos"], bone);
}

}  // namespace
}  // namespace styled::oscquery
