// A style from an example, over real sockets: all clients see it, and no performer's motion jumps.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <thread>

#include "tests/e2e/examples.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"

namespace styled::support {
namespace {

using testing::HasSubstr;

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
  EXPECT_GE(reply.like().code_size(), 64);
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
}

TEST_F(LikeTest, AnInvalidExampleIsRefusedWithTheReason) {
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
          "like: expected one of clip, code, learn_s, vary and design, found 0 of them");
  refuses(Like("rig.a", "", walk), v1::CODE_MALFORMED,
          "like: name \"\": expected 1 to 32 of A-Z a-z 0-9 _ -");
  refuses(Like("rig.a", "--clip", walk), v1::CODE_MALFORMED,
          "like: name \"--clip\": begins with - as an option does");
  refuses(Like("rig.a", "bypass", walk), v1::CODE_MALFORMED,
          "like: name \"bypass\": is a word of stylectl and OSC with another meaning");
  refuses(Like("rig.a", "S2", walk), v1::CODE_MALFORMED,
          "like: name \"S2\": a style of the weights has it, \"style2\"");
  refuses(Like("rig.a", "mild", walk), v1::CODE_MALFORMED, "like: name \"mild\": a preset has it");
  refuses(Like("rig.a", "mine", WalkBvh(30, 0.2)), v1::CODE_MALFORMED,
          "frames at 30 Hz, expected at least 8");
  v1::Request strange = Like("rig.a", "mine", walk);
  strange.mutable_like()->set_rig("octopus");
  refuses(strange, v1::CODE_MALFORMED, "octopus");
  v1::Request code = Like("rig.a", "mine", "");
  code.mutable_like()->add_code(1);
  refuses(code, v1::CODE_MALFORMED,
          "like: code: found 1 numbers, expected as many as these weights' codes have, 64 or");
  code.mutable_like()->mutable_code()->Resize(64, std::numeric_limits<float>::infinity());
  refuses(code, v1::CODE_MALFORMED, "like: code: expected finite numbers, not huge ones");
  code.mutable_like()->clear_code();
  code.mutable_like()->mutable_code()->Resize(64, 3e38F);
  refuses(code, v1::CODE_MALFORMED, "like: code: expected finite numbers, not huge ones");
  EXPECT_EQ(Styles().size(), 4U);
  // An unknown performer: the style is made, and the reply names the error.
  const v1::Reply unknown = control_.Ask(Like("nosource.a", "mine", walk));
  EXPECT_EQ(unknown.code(), v1::CODE_UNKNOWN_PERFORMER);
  NextFrame();
}

TEST_F(LikeTest, OfALongExampleTheFirstMinuteIsTaken) {
  const v1::Reply whole = control_.Ask(Like("", "minute", WalkBvh(30, 60 + 1.0 / 30)));
  ASSERT_EQ(whole.code(), v1::CODE_OK) << whole.reason();
  EXPECT_THAT(whole.like().weak(),
              testing::ElementsAre("without a library (style.library) it ends with the daemon"));
  const v1::Reply cut = control_.Ask(Like("", "cut", WalkBvh(30, 62)));
  ASSERT_EQ(cut.code(), v1::CODE_OK) << cut.reason();
  EXPECT_THAT(cut.like().weak(), testing::Contains("the file: only its first 60 s are read"));
  EXPECT_EQ(cut.like().seconds(), 60.0F);
  EXPECT_THAT(cut.like().code(), testing::ElementsAreArray(whole.like().code()));
}

TEST_F(LikeTest, APerformerShowsTheStyle) {
  // Frames arrive all the while; the reply arrives after the second and a half that was requested.
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

  // A client that stops an example gets a reply, and so does one that never started any.
  std::jthread stops([&] {
    Sleep(0.5);
    more = false;
  });
  const v1::Reply stopped = control_.Ask(request);
  EXPECT_EQ(stopped.code(), v1::CODE_NOT_READY);
  EXPECT_THAT(stopped.reason(), HasSubstr("like: the performer's frames stopped or restarted "));
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

TEST_F(LikeTest, AMeasuredExampleIsNoStyle) {
  NextFrame();
  v1::Request request = Like("rig.a", "", WalkBvh(60, 2));
  request.mutable_like()->set_measure(true);
  const v1::Reply measured = control_.Ask(request);
  ASSERT_EQ(measured.code(), v1::CODE_OK) << measured.reason();
  EXPECT_EQ(measured.applied_size(), 0);
  EXPECT_THAT(Styles(), testing::ElementsAre("neutral", "style1", "style2", "style3"));
  EXPECT_EQ(NextFrame().styles_size(), 0);
  const v1::Reply made = control_.Ask(Like("rig.a", "mine", WalkBvh(60, 2)));
  EXPECT_EQ(measured.like().distance(), made.like().distance());
  EXPECT_EQ(measured.like().nearest(), made.like().nearest());
  EXPECT_THAT(measured.like().code(), testing::ElementsAreArray(made.like().code()));
}

TEST_F(LikeTest, ANeutralExampleCountsByItsDifferenceOnly) {
  const auto measure = [&](v1::Request request) {
    request.mutable_like()->set_measure(true);
    return control_.Ask(request);
  };
  v1::Request neutral = Like("", "", "");
  neutral.mutable_like()->mutable_vary()->set_style("neutral");
  neutral.mutable_like()->mutable_vary()->set_amount(0);
  v1::Request other = neutral;
  other.mutable_like()->mutable_vary()->set_style("style2");
  const auto of_neutral = measure(neutral).like().code(), of_other = measure(other).like().code();
  ASSERT_EQ(of_neutral.size(), of_other.size());
  v1::Request request = Like("", "mine", WalkBvh(60, 2));
  const auto plain = measure(request).like().code();

  // An example like its neutral one is neutral.
  *request.mutable_like()->mutable_neutral_code() = plain;
  const v1::Reply same = control_.Ask(request);
  ASSERT_EQ(same.code(), v1::CODE_OK) << same.reason();
  EXPECT_EQ(same.like().nearest(), "neutral");
  EXPECT_NEAR(same.like().distance(), 0, 1e-3);
  // One whose neutral example is the network's neutral style is what it is.
  *request.mutable_like()->mutable_neutral_code() = of_neutral;
  const v1::Reply unchanged = control_.Ask(request);
  ASSERT_GE(unchanged.like().code_size(), plain.size());
  for (int i = 0; i < plain.size(); ++i) EXPECT_NEAR(unchanged.like().code(i), plain[i], 1e-5);
  // style + (code - neutral_code), of codes, too.
  request.mutable_like()->clear_clip();
  *request.mutable_like()->mutable_code() = of_other;
  *request.mutable_like()->mutable_neutral_code() = of_neutral;
  const v1::Reply code = control_.Ask(request);
  ASSERT_EQ(code.code(), v1::CODE_OK) << code.reason();
  for (int i = 0; i < of_other.size(); ++i) EXPECT_NEAR(code.like().code(i), of_other[i], 1e-5);

  request.mutable_like()->mutable_neutral_code()->RemoveLast();
  EXPECT_THAT(control_.Ask(request).reason(),
              HasSubstr("like: neutral_code: found 63 numbers, expected as many as"));
  request.mutable_like()->mutable_neutral_code()->Add(std::nanf(""));
  EXPECT_THAT(control_.Ask(request).reason(),
              HasSubstr("like: neutral_code: expected finite numbers"));
  neutral.mutable_like()->set_name("mine");
  *neutral.mutable_like()->mutable_neutral_code() = of_neutral;
  EXPECT_THAT(control_.Ask(neutral).reason(), HasSubstr("neutral_code: found it with vary"));
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
      "like: the weights of family \"style-erd\" have no style encoder; in the configuration "
      "model.gaits = \"open\" adds one for walks and runs, model.examples = \"graph\" one for all "
      "motion");
}

// As a user who trained a network meets it: the shipped weights open are beside it, and make the
// styles.
TEST(LikeWithoutExamples, WithOpenBesideThemStylesAreMadeOfExamples) {
  Daemon daemon({"model.gaits="});
  ControlClient control(daemon.control);
  v1::Request request;
  request.mutable_like()->set_name("mine");
  request.mutable_like()->set_clip(WalkBvh(120, 8));
  const v1::Reply liked = control.Ask(request);
  ASSERT_EQ(liked.code(), v1::CODE_OK) << liked.reason();
  request.Clear();
  request.mutable_list();
  std::map<std::string, v1::StyleInfo> styles;
  const v1::Reply listed = control.Ask(request);
  for (const v1::StyleInfo& style : listed.list().styles()) styles[style.name()] = style;
  EXPECT_TRUE(styles.contains("style1") && styles.contains("zombie"));
  EXPECT_TRUE(styles["mine"].made());
}

}  // namespace
}  // namespace styled::support
