// A style from an example, over real sockets: it is there for all clients, and nobody's motion
// jumps.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <thread>

#include "sim/player/performer_motion.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"
#include "tests/unit/net/stgcn_causal/random_weights.h"

namespace styled::support {
namespace {

using testing::HasSubstr;

std::string CausalWeights(const std::string& file) {
  const std::vector<std::byte> bytes = stgcn_causal::RandomWeights(4, 16, 1).Bytes();
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  return file;
}

// The synthetic performer's walk as the text of a BVH file.
std::string WalkBvh(double rate_hz, double seconds) {
  const TemporaryFolder folder;
  synthetic::Options options;
  options.script = {{synthetic::Motion::kWalk, 60}};
  player::PerformerMotion motion(std::move(options), {}, rate_hz);
  const std::string file = folder / "walk.bvh";
  EXPECT_TRUE(player::WriteMotion(motion, seconds, rate_hz, file).ok());
  return ReadText(file);
}

class LikeTest : public testing::Test {
 protected:
  LikeTest() {
    link_.Send(rig_.Body());
    EXPECT_TRUE(subscriber_.WaitForBody());
  }

  static v1::Request Like(const std::string& performer, const std::string& name,
                          const std::string& clip) {
    v1::Request request;
    request.set_performer(performer);
    request.mutable_like()->set_name(name);
    request.mutable_like()->set_clip(clip);
    request.mutable_like()->set_file("walk.bvh");
    request.mutable_like()->set_transition_ms(0);
    return request;
  }
  std::vector<std::string> Styles() {
    v1::Request request;
    request.mutable_list();
    std::vector<std::string> names;
    const v1::Reply reply = control_.Ask(request);
    for (const auto& style : reply.list().styles()) names.push_back(style.name());
    return names;
  }
  v1::Frame NextFrame() {
    const std::size_t before = subscriber_.Frames("styled/").size();
    link_.Send(rig_.Frame());
    EXPECT_TRUE(subscriber_.WaitForFrames(before + 1, "styled/")) << daemon_.Log();
    return subscriber_.Frames("styled/").back();
  }

  TemporaryFolder folder_;
  Daemon daemon_{{}, "[presets]\nmild = { s1 = 0.3 }\n", {}, CausalWeights(folder_ / "w")};
  Subscriber subscriber_{daemon_.publish, {"body/rig.a/", "styled/rig.a/rig/"}};
  ControlClient control_{daemon_.control};
  UdpLink link_{daemon_.udp};
  Rig rig_{"a"};
};

TEST_F(LikeTest, AnExampleIsAStyleForAllFromTheNextFrameOn) {
  NextFrame();
  const v1::Reply reply = control_.Ask(Like("rig.a", "mine", WalkBvh(60, 2)));
  ASSERT_EQ(reply.code(), v1::CODE_OK) << reply.reason();
  EXPECT_EQ(reply.like().name(), "mine");
  EXPECT_NEAR(reply.like().seconds(), 2, 0.1);
  EXPECT_EQ(reply.like().code_size(), 64);
  EXPECT_THAT(Styles(), testing::Contains(reply.like().nearest()));
  ASSERT_EQ(reply.applied_size(), 1);
  const v1::Frame frame = NextFrame();
  EXPECT_EQ(frame.sequence(), reply.applied(0).first_sequence());
  ASSERT_EQ(frame.styles_size(), 1);
  EXPECT_EQ(frame.styles(0).style(), "mine");
  EXPECT_EQ(frame.flags() & v1::FLAG_NEW_SESSION, 0U) << "the stream goes on";
  EXPECT_THAT(Styles(), testing::ElementsAre("neutral", "style1", "style2", "style3", "mine"));
  // Another client chooses it by its name, in any case.
  ControlClient other(daemon_.control);
  EXPECT_EQ(other.SetStyle("rig.b", "MINE", 0.5F).code(), v1::CODE_OK);
}

TEST_F(LikeTest, ASecondExampleOfANameReplacesTheFirst) {
  NextFrame();
  const std::string walk = WalkBvh(60, 2), longer = WalkBvh(30, 4);
  const v1::Reply first = control_.Ask(Like("rig.a", "mine", walk));
  NextFrame();
  const v1::Reply second = control_.Ask(Like("", "mine", longer));
  ASSERT_EQ(second.code(), v1::CODE_OK) << second.reason();
  EXPECT_EQ(second.applied_size(), 0) << "nobody was named";
  EXPECT_THAT(Styles(), testing::ElementsAre("neutral", "style1", "style2", "style3", "mine"));
  const v1::Frame frame = NextFrame();
  EXPECT_EQ(frame.flags() & v1::FLAG_NEW_SESSION, 0U);
  EXPECT_THAT(frame.styles(frame.styles_size() - 1).style(), "mine");
  // The code in place of the clip gives the same style.
  v1::Request by_code = Like("rig.a", "again", "");
  *by_code.mutable_like()->mutable_code() = first.like().code();
  const v1::Reply again = control_.Ask(by_code);
  ASSERT_EQ(again.code(), v1::CODE_OK) << again.reason();
  EXPECT_EQ(again.like().distance(), first.like().distance());
}

TEST_F(LikeTest, ManyReplacementsNeverRunOutOfRoom) {
  const std::string walk = WalkBvh(30, 1);
  for (int i = 0; i < 80; ++i) {
    const v1::Reply reply = control_.Ask(Like("rig.a", "mine", walk));
    ASSERT_EQ(reply.code(), v1::CODE_OK) << i << ": " << reply.reason();
    if (i % 20 == 0) NextFrame();
  }
  EXPECT_EQ(Styles().size(), 5U);
  for (int i = 5; i < 32; ++i) {
    const v1::Reply reply = control_.Ask(Like("", "style-" + std::to_string(i), walk));
    ASSERT_EQ(reply.code(), v1::CODE_OK) << i << ": " << reply.reason();
  }
  const v1::Reply full = control_.Ask(Like("", "one-more", walk));
  EXPECT_EQ(full.code(), v1::CODE_BUSY);
  EXPECT_EQ(full.reason(), "like: there are 32 styles already, the most that there can be");
}

TEST_F(LikeTest, WhatCannotBeAnExampleIsRefusedWithTheReason) {
  const std::string walk = WalkBvh(30, 2);
  const auto refuses = [&](const v1::Request& request, v1::Code code, const std::string& reason) {
    const v1::Reply reply = control_.Ask(request);
    EXPECT_EQ(reply.code(), code) << reason;
    EXPECT_THAT(reply.reason(), HasSubstr(reason));
    EXPECT_FALSE(reply.has_like());
  };
  refuses(Like("rig.a", "mine", "no motion"), v1::CODE_MALFORMED,
          "like: walk.bvh:1: found \"no\", expected HIERARCHY");
  refuses(Like("rig.a", "mine", ""), v1::CODE_MALFORMED,
          "like: expected one of clip, code, learn_s and vary, found 0 of them");
  refuses(Like("rig.a", "", walk), v1::CODE_MALFORMED,
          "like: name \"\": expected 1 to 32 of A-Z a-z 0-9 _ -");
  refuses(Like("rig.a", "S2", walk), v1::CODE_MALFORMED,
          "like: name \"S2\": a style of the weights has it, \"style2\"");
  refuses(Like("rig.a", "mild", walk), v1::CODE_MALFORMED, "like: name \"mild\": a preset has it");
  refuses(Like("rig.a", "mine", WalkBvh(30, 62)), v1::CODE_MALFORMED,
          "like: walk.bvh: found 61.97 s, expected at most 60");
  refuses(Like("rig.a", "mine", WalkBvh(30, 0.2)), v1::CODE_MALFORMED,
          "frames at 30 Hz, expected at least 8");
  v1::Request strange = Like("rig.a", "mine", walk);
  strange.mutable_like()->set_rig("octopus");
  refuses(strange, v1::CODE_MALFORMED, "octopus");
  v1::Request code = Like("rig.a", "mine", "");
  code.mutable_like()->add_code(1);
  refuses(code, v1::CODE_MALFORMED, "like: code: found 1 numbers, expected 64");
  code.mutable_like()->mutable_code()->Resize(64, std::numeric_limits<float>::infinity());
  refuses(code, v1::CODE_MALFORMED, "like: code: expected finite numbers, not huge ones");
  code.mutable_like()->clear_code();
  code.mutable_like()->mutable_code()->Resize(64, 3e38F);
  refuses(code, v1::CODE_MALFORMED, "like: code: expected finite numbers, not huge ones");
  EXPECT_EQ(Styles().size(), 4U);
  // A performer that nobody knows: the style is made, and the reply says what went wrong.
  const v1::Reply unknown = control_.Ask(Like("nosource.a", "mine", walk));
  EXPECT_EQ(unknown.code(), v1::CODE_UNKNOWN_PERFORMER);
  NextFrame();
}

TEST_F(LikeTest, APerformerShowsTheStyle) {
  // Frames come all the while; the reply comes after the second and a half that was asked for.
  std::atomic<bool> more{true};
  std::thread moving([&] {
    while (more) {
      link_.Send(rig_.Frame());
      Sleep(1.0 / 120);
    }
  });
  ASSERT_TRUE(subscriber_.WaitForFrames(20, "styled/"));
  v1::Request request = Like("rig.a", "mine", "");
  request.mutable_like()->set_learn_s(1.5F);
  const v1::Reply reply = control_.Ask(request);
  ASSERT_EQ(reply.code(), v1::CODE_OK) << reply.reason();
  EXPECT_EQ(reply.like().seconds(), 1.5F);
  EXPECT_THAT(Styles(), testing::Contains("mine"));
  ASSERT_EQ(reply.applied_size(), 1);
  EXPECT_GT(reply.applied(0).first_sequence(), 150U) << "frames of the take";

  // Who stops is told so, and so is who never began.
  std::jthread stops([&] {
    Sleep(0.5);
    more = false;
  });
  const v1::Reply stopped = control_.Ask(request);
  EXPECT_EQ(stopped.code(), v1::CODE_NOT_READY);
  EXPECT_THAT(stopped.reason(), HasSubstr("like: the performer's frames stopped or began anew "));
  moving.join();
  Sleep(0.4);
  const v1::Reply silent = control_.Ask(request);
  EXPECT_EQ(silent.code(), v1::CODE_NOT_READY);
  EXPECT_THAT(silent.reason(), HasSubstr("\"rig.a\": no frame in the last 0.3 s"));
  request.set_performer("rig.nobody");
  EXPECT_EQ(control_.Ask(request).code(), v1::CODE_UNKNOWN_PERFORMER);
  request.mutable_like()->set_learn_s(61);
  EXPECT_THAT(control_.Ask(request).reason(),
              HasSubstr("like: learn_s: found 61, expected 1 to 60 s"));
  request.mutable_like()->set_learn_s(std::nanf(""));
  EXPECT_EQ(control_.Ask(request).code(), v1::CODE_MALFORMED);
}

TEST_F(LikeTest, AVariationIsAStyle) {
  NextFrame();
  v1::Request request = Like("rig.a", "style2-7", "");
  request.mutable_like()->mutable_vary()->set_style("s2");
  request.mutable_like()->mutable_vary()->set_seed(7);
  const v1::Reply first = control_.Ask(request);
  ASSERT_EQ(first.code(), v1::CODE_OK) << first.reason();
  EXPECT_EQ(NextFrame().styles(0).style(), "style2-7");
  const auto code_of = [&](std::uint64_t seed, float amount) {
    request.mutable_like()->mutable_vary()->set_seed(seed);
    request.mutable_like()->mutable_vary()->set_amount(amount);
    const v1::Reply reply = control_.Ask(request);
    return std::vector<float>(reply.like().code().begin(), reply.like().code().end());
  };
  const std::vector<float> seven(first.like().code().begin(), first.like().code().end());
  EXPECT_EQ(code_of(7, 1), seven);
  EXPECT_NE(code_of(8, 1), seven);
  EXPECT_EQ(code_of(7, 0), code_of(8, 0)) << "the style itself";
  request.mutable_like()->mutable_vary()->set_amount(2);
  EXPECT_EQ(control_.Ask(request).code(), v1::CODE_OUT_OF_RANGE);
  request.mutable_like()->mutable_vary()->set_style("style2-7");
  EXPECT_EQ(control_.Ask(request).code(), v1::CODE_UNKNOWN_STYLE) << "only of the weights";
}

TEST_F(LikeTest, AClipMayBeLargerThanOtherRequestsButNotMuch) {
  const std::string walk = WalkBvh(120, 8);
  ASSERT_GT(walk.size(), 64U * 1024);
  EXPECT_EQ(control_.Ask(Like("rig.a", "mine", walk)).code(), v1::CODE_OK);
  const v1::Reply huge =
      control_.Ask(Like("rig.a", "mine", std::string(8U * 1024 * 1024 + 1, ' ')));
  EXPECT_EQ(huge.code(), v1::CODE_TOO_LARGE) << huge.reason();
  v1::Request other;
  other.set_performer(std::string(70'000, 'x'));
  other.mutable_panic();
  EXPECT_EQ(control_.Ask(other).code(), v1::CODE_TOO_LARGE);
}

std::vector<std::string> StylesOf(const Daemon& daemon) {
  ControlClient control(daemon.control);
  v1::Request request;
  request.mutable_list();
  const v1::Reply reply = control.Ask(request);
  std::vector<std::string> names;
  for (const auto& style : reply.list().styles()) names.push_back(style.name());
  return names;
}

TEST(LikeLibrary, StylesSurviveARestartAndGoWithTheirFiles) {
  const TemporaryFolder folder;
  const std::string library = folder / "styles", weights = CausalWeights(folder / "w");
  Daemon daemon({"style.library=" + library}, "", {}, weights);
  v1::Request request;
  request.mutable_like()->set_clip(WalkBvh(30, 2));
  v1::Reply first;
  for (const char* const name : {"one", "two"}) {
    request.mutable_like()->set_name(name);
    request.mutable_like()->set_file("walk.bvh");
    first = ControlClient(daemon.control).Ask(request);
    ASSERT_EQ(first.code(), v1::CODE_OK) << first.reason();
  }
  const std::string text = ReadText(library + "/two.json");
  EXPECT_THAT(text, HasSubstr("\"licence\": \"CC0-1.0\""));
  EXPECT_THAT(text, HasSubstr("\"source\": \"walk.bvh\""));
  // What is no style, or of other weights, is left out with the reason; the daemon starts.
  std::string other = text;
  other.replace(other.find("crc32c:"), 15, "crc32c:00000000");
  WriteText(library + "/other.json", other);
  WriteText(library + "/broken.json", "{");
  WriteText(library + "/renamed.json", text);
  ASSERT_EQ(daemon.Stop(), 0);
  daemon.Start();
  EXPECT_THAT(StylesOf(daemon),
              testing::ElementsAre("neutral", "style1", "style2", "style3", "one", "two"));
  EXPECT_THAT(daemon.Log(), HasSubstr("other.json: was made with other weights, crc32c:00000000"));
  EXPECT_THAT(daemon.Log(), HasSubstr("broken.json: expected a JSON object"));
  EXPECT_THAT(daemon.Log(), HasSubstr("renamed.json: holds the style \"two\""));
  // The same numbers as before the restart.
  request.mutable_like()->set_name("two");
  const v1::Reply again = ControlClient(daemon.control).Ask(request);
  EXPECT_EQ(again.like().distance(), first.like().distance());

  std::filesystem::remove(library + "/one.json");
  ASSERT_EQ(kill(daemon.child->pid(), SIGHUP), 0);
  ControlClient control(daemon.control);
  ASSERT_EQ(control.CounterSoon("config.reloads", 1), 1U) << daemon.Log();
  EXPECT_THAT(StylesOf(daemon),
              testing::ElementsAre("neutral", "style1", "style2", "style3", "two"));
}

TEST(LikeLibrary, AFolderThatCannotBeWrittenIsSaidAndTheStyleWorks) {
  const TemporaryFolder folder;
  const std::string weights = CausalWeights(folder / "w");
  WriteText(folder / "file", "");
  const Daemon daemon({"style.library=" + (folder / "file/styles")}, "", {}, weights);
  v1::Request request;
  request.mutable_like()->set_name("mine");
  request.mutable_like()->set_clip(WalkBvh(30, 2));
  ControlClient control(daemon.control);
  EXPECT_EQ(control.Ask(request).code(), v1::CODE_OK);
  EXPECT_THAT(StylesOf(daemon), testing::Contains("mine"));
  EXPECT_THAT(daemon.Log(), HasSubstr("the style will not survive a restart"));
}

TEST(LikeWithoutExamples, WeightsThatKnowTheirListAloneAreNamed) {
  Daemon daemon;
  ControlClient control(daemon.control);
  v1::Request request;
  request.mutable_like()->set_name("mine");
  request.mutable_like()->set_clip(WalkBvh(30, 2));
  const v1::Reply reply = control.Ask(request);
  EXPECT_EQ(reply.code(), v1::CODE_NO_EXAMPLES);
  EXPECT_EQ(
      reply.reason(),
      "like: the weights of family \"style-erd\" have no style encoder; expected weights that "
      "have one");
}

}  // namespace
}  // namespace styled::support
