// Styles that are measured from a walk or made by hand, over real sockets, with the shipped weights
// open.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <set>
#include <thread>

#include "model/net/shipped_weights.h"
#include "proto/rigs/vmc/osc.h"
#include "tests/e2e/examples.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"
#include "tests/support/temporary_folder.h"

namespace styled::support {
namespace {

using testing::Contains;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* kEnds = "without a library (style.library) it ends with the daemon";

class DesignTest : public testing::Test {
 protected:
  DesignTest() {
    link_.Send(rig_.Body());
    EXPECT_TRUE(subscriber_.WaitForBody());
  }

  static v1::Request Design(const std::string& performer,
                            const std::map<std::string, float>& sliders,
                            const std::string& name = "") {
    v1::Request request;
    request.set_performer(performer);
    request.mutable_like()->set_name(name);
    auto& design = *request.mutable_like()->mutable_design();
    design.mutable_sliders()->insert(sliders.begin(), sliders.end());
    return request;
  }
  static v1::Request Like(const std::string& name, const std::string& clip) {
    v1::Request request;
    request.mutable_like()->set_name(name);
    request.mutable_like()->set_clip(clip);
    request.mutable_like()->set_file("clip.bvh");
    return request;
  }
  v1::StyleInfo InfoOf(const std::string& name) { return InfoOf(name, control_); }
  static v1::StyleInfo InfoOf(const std::string& name, ControlClient& control) {
    v1::Request request;
    request.mutable_list();
    const v1::Reply reply = control.Ask(request);
    for (const auto& style : reply.list().styles()) {
      if (style.name() == name) return style;
    }
    return {};
  }
  v1::Frame NextFrame() {
    const std::size_t before = subscriber_.Frames("styled/").size();
    link_.Send(rig_.Frame());
    EXPECT_TRUE(subscriber_.WaitForFrames(before + 1, "styled/")) << daemon_.Log();
    return subscriber_.Frames("styled/").back();
  }

  std::string LibraryFile() const { return folder_ / "styles/by-hand-rig-a.json"; }
  // 0 while there is no such file; each write makes a new file.
  ino_t LibraryInode() const {
    struct stat of {};
    return stat(LibraryFile().c_str(), &of) == 0 ? of.st_ino : 0;
  }

  static bool Eventually(const std::function<bool()>& done) {
    for (int tries = 0; tries < 600; ++tries) {
      if (done()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return false;
  }

  TemporaryFolder folder_;
  Daemon daemon_{{"osc.listen=\"127.0.0.1:0\"", "style.library=" + (folder_ / "styles")},
                 "",
                 {},
                 net::FindWeights("open").value().string()};
  Subscriber subscriber_{daemon_.publish, {"body/rig.a/", "styled/rig.a/rig/"}};
  ControlClient control_{daemon_.control};
  UdpLink link_{daemon_.udp};
  Rig rig_{"a"};
};

TEST_F(DesignTest, TheListHasSlidersDesignsAndWhoIsToBeCredited) {
  v1::Request request;
  request.mutable_list();
  const v1::ListReply list = control_.Ask(request).list();
  ASSERT_GT(list.sliders_size(), 15);
  EXPECT_EQ(list.sliders(0).name(), "stoop");
  EXPECT_EQ(list.sliders(0).unit(), "degrees");
  ASSERT_EQ(list.designs_size(), 6);
  EXPECT_EQ(list.designs(0).name(), "sneaky");
  EXPECT_EQ(list.designs(0).sliders().at("stoop"), 28);
  EXPECT_EQ(InfoOf("angry").credit(), "The 100STYLE Dataset - Ian Mason");
  EXPECT_EQ(InfoOf("angry").licence(), "CC BY 4.0");
  EXPECT_TRUE(InfoOf("angry").designable());
}

TEST_F(DesignTest, AWalkIsMeasuredAndTheReplySaysWhatWasFound) {
  const v1::Reply walk = control_.Ask(Like("mine", WalkBvh(60, 6)));
  ASSERT_EQ(walk.code(), v1::CODE_OK) << walk.reason();
  EXPECT_THAT(walk.like().found(), Contains(HasSubstr("walk: ")));
  EXPECT_THAT(walk.like().weak(), IsEmpty());
  const v1::Reply shorter = control_.Ask(Like("short", WalkBvh(60, 2.2)));
  EXPECT_THAT(shorter.like().weak(), Contains(HasSubstr("show 3 s")));
  const v1::Reply wave = control_.Ask(Like("wave", MotionBvh(synthetic::Motion::kWaveLeft, 60, 1)));
  ASSERT_EQ(wave.code(), v1::CODE_OK) << wave.reason();
  EXPECT_THAT(wave.like().weak(), Contains(HasSubstr("a posture only")));
}

// The first second of a walk, and something else, beside a network that takes any motion.
TEST(DesignWithGraph, AnExampleWithoutAGaitIsSaidToHaveNone) {
  const auto weights = [](const char* name) { return net::FindWeights(name).value().string(); };
  const Daemon daemon({"model.examples=" + weights("graph"), "model.gaits=" + weights("open")}, "",
                      {}, weights("v2"));
  ControlClient control(daemon.control);
  const auto like = [&control](const std::string& clip, const std::string& network) {
    v1::Request request;
    request.mutable_like()->set_name("mine");
    request.mutable_like()->set_clip(clip);
    request.mutable_like()->set_network(network);
    const v1::Reply made = control.Ask(request);
    EXPECT_EQ(made.code(), v1::CODE_OK) << made.reason();
    return made.like();
  };
  const v1::LikeReply second = like(WalkBvh(60, 1), "");
  EXPECT_THAT(second.found(), Contains(HasSubstr("no walk and no run")));
  EXPECT_THAT(second.weak(), Contains(HasSubstr("only 1 s; show 3 s or more")));
  const v1::LikeReply wave = like(MotionBvh(synthetic::Motion::kWaveLeft, 60, 6), "");
  EXPECT_THAT(wave.found(), Contains(HasSubstr("no walk and no run")));
  EXPECT_THAT(wave.weak(), testing::ElementsAre(kEnds));
  EXPECT_THAT(like(WalkBvh(60, 6), "").found(), Contains(HasSubstr("walk: ")));
  EXPECT_THAT(like(WalkBvh(60, 6), "graph").found(), IsEmpty()) << "it does not look for one";

  v1::Request wrong;
  wrong.mutable_like()->set_name("mine");
  wrong.mutable_like()->set_clip(WalkBvh(60, 6));
  wrong.mutable_like()->set_network("v2");
  EXPECT_THAT(control.Ask(wrong).reason(), EndsWith("those that do are graph open"));
}

// As `stylize` reads them: any zero pose, and text with a row less than it says.
TEST_F(DesignTest, AnExampleIsBoundWhereverItsArmsAreInItsZeroPose) {
  const v1::Reply straight = control_.Ask(Like("straight", WalkBvh(60, 6)));
  std::string text = HangingWalkBvh(60, 6);
  const std::size_t frames = text.find("Frames: 360");
  ASSERT_NE(frames, std::string::npos);
  text.replace(frames, 11, "Frames:361");
  const v1::Reply hanging = control_.Ask(Like("hanging", text));
  ASSERT_EQ(hanging.code(), v1::CODE_OK) << hanging.reason();
  EXPECT_THAT(hanging.like().weak(), Contains(HasSubstr("360 rows where Frames: says 361")));
  ASSERT_EQ(hanging.like().code_size(), straight.like().code_size());
  double apart = 0, size = 0;
  for (int i = 0; i < straight.like().code_size(); ++i) {
    apart += std::pow(hanging.like().code(i) - straight.like().code(i), 2);
    size += std::pow(straight.like().code(i), 2);
  }
  EXPECT_LT(apart, 1e-3 * size);
}

TEST_F(DesignTest, AnotherExampleIsAddedToAStyle) {
  ASSERT_EQ(control_.Ask(Like("mine", WalkBvh(60, 6))).code(), v1::CODE_OK);
  v1::Request run = Like("mine", MotionBvh(synthetic::Motion::kRun, 60, 6));
  run.mutable_like()->set_add(true);
  const v1::Reply both = control_.Ask(run);
  ASSERT_EQ(both.code(), v1::CODE_OK) << both.reason();
  EXPECT_THAT(both.like().found(), Contains(HasSubstr("walk: ")));
  EXPECT_THAT(both.like().found(), Contains(HasSubstr("run: ")));
  EXPECT_NEAR(both.like().seconds(), 12, 0.2);
  run.mutable_like()->set_name("nobody");
  EXPECT_EQ(control_.Ask(run).code(), v1::CODE_UNKNOWN_STYLE);
}

TEST_F(DesignTest, AStyleByHandChangesInPlace) {
  NextFrame();
  const v1::Reply made = control_.Ask(Design("rig.a", {{"stoop", 28}, {"energy", 0.6F}}));
  ASSERT_EQ(made.code(), v1::CODE_OK) << made.reason();
  EXPECT_EQ(made.like().name(), "by-hand-rig-a");
  for (int i = 0; i < 10; ++i) NextFrame();
  EXPECT_EQ(NextFrame().styles(0).style(), "by-hand-rig-a");
  const v1::Reply moved = control_.Ask(Design("rig.a", {{"stoop", 35}}));
  ASSERT_EQ(moved.code(), v1::CODE_OK) << moved.reason();
  const v1::Frame frame = NextFrame();
  ASSERT_EQ(frame.styles_size(), 1) << "no fade from the slider's last place";
  EXPECT_EQ(frame.flags() & v1::FLAG_NEW_SESSION, 0U);
  const v1::StyleInfo info = InfoOf("by-hand-rig-a");
  EXPECT_FLOAT_EQ(info.sliders().at("stoop"), 35);
  EXPECT_FLOAT_EQ(info.sliders().at("energy"), 0.6F) << "what is not named keeps its value";
  EXPECT_TRUE(info.made());
}

// A disk need not keep up with a hand, and a full one is named once.
TEST_F(DesignTest, ASliderIsKeptWhereItRests) {
  std::set<ino_t> written;
  for (int place = 1; place <= 50; ++place) {
    const float stoop = static_cast<float>(place);
    ASSERT_EQ(control_.Ask(Design("rig.a", {{"stoop", stoop}})).code(), v1::CODE_OK);
    written.insert(LibraryInode());
  }
  EXPECT_LT(written.size(), 10U) << "in 50 places";
  EXPECT_TRUE(Eventually([this] {
    return ReadText(LibraryFile()).find("by-hand-rig-a") != std::string::npos;
  })) << daemon_.Log();
}

TEST_F(DesignTest, AFirstDesignIsKeptAtOnce) {
  ASSERT_EQ(control_.Ask(Design("rig.a", {{"stoop", 33}})).code(), v1::CODE_OK);
  EXPECT_NE(LibraryInode(), 0U);
}

TEST_F(DesignTest, ASliderThatMovesAtTheEndIsKept) {
  ASSERT_EQ(control_.Ask(Design("rig.a", {{"stoop", 33}})).code(), v1::CODE_OK);
  ASSERT_EQ(daemon_.Stop(), 0);
  daemon_.Start();
  ControlClient control(daemon_.control);
  const v1::StyleInfo kept = InfoOf("by-hand-rig-a", control);
  ASSERT_TRUE(kept.sliders().contains("stoop")) << daemon_.Log();
  EXPECT_FLOAT_EQ(kept.sliders().at("stoop"), 33);
}

TEST_F(DesignTest, AFullDiskIsNotNamedAtEachPlace) {
  std::filesystem::create_directories(LibraryFile() + "/full");  // cannot be replaced
  EXPECT_THAT(control_.Ask(Design("rig.a", {{"stoop", 1}})).like().weak(),
              Contains(HasSubstr("not in the library: it will not survive a restart")));
  for (int place = 2; place <= 20; ++place) {
    const float stoop = static_cast<float>(place);
    ASSERT_EQ(control_.Ask(Design("rig.a", {{"stoop", stoop}})).code(), v1::CODE_OK);
  }
  EXPECT_TRUE(Eventually(
      [this] { return daemon_.Log().find("will not survive a restart") != std::string::npos; }));
  const std::string log = daemon_.Log(), line = "will not survive a restart";
  int lines = 0;
  for (std::size_t at = log.find(line); at != std::string::npos; at = log.find(line, at + 1)) {
    ++lines;
  }
  EXPECT_LT(lines, 5) << log;
}

TEST_F(DesignTest, ADesignBeginsWithAPresetOrAnotherStyle) {
  v1::Request sneaky = Design("", {{"stoop", 40}}, "mine");
  sneaky.mutable_like()->mutable_design()->set_preset("sneaky");
  ASSERT_EQ(control_.Ask(sneaky).code(), v1::CODE_OK);
  EXPECT_FLOAT_EQ(InfoOf("mine").sliders().at("stoop"), 40);
  EXPECT_FLOAT_EQ(InfoOf("mine").sliders().at("crouch"), 26);
  v1::Request angry = Design("", {{"elbows", 20}}, "angrier");
  angry.mutable_like()->mutable_design()->set_from("angry");
  const v1::Reply reply = control_.Ask(angry);
  ASSERT_EQ(reply.code(), v1::CODE_OK) << reply.reason();
  EXPECT_EQ(reply.like().nearest(), "angry");
  EXPECT_EQ(InfoOf("angrier").source(), "angry, by hand");
}

TEST_F(DesignTest, WhatIsWrongIsNamed) {
  EXPECT_THAT(control_.Ask(Design("rig.a", {{"stop", 1}})).reason(),
              HasSubstr("slider \"stop\": expected one of stoop"));
  EXPECT_THAT(control_.Ask(Design("rig.a", {{"stoop", 99}})).reason(),
              HasSubstr("stoop: found 99, expected -30 to 60 degrees"));
  v1::Request preset = Design("rig.a", {});
  preset.mutable_like()->mutable_design()->set_preset("sneeky");
  EXPECT_THAT(control_.Ask(preset).reason(), HasSubstr("expected one of neutral sneaky"));
  v1::Request from = Design("rig.a", {}, "mine");
  from.mutable_like()->mutable_design()->set_from("nobody");
  EXPECT_EQ(control_.Ask(from).code(), v1::CODE_UNKNOWN_STYLE);
  v1::Request both = Design("rig.a", {{"stoop", 1}}, "mine");
  both.mutable_like()->set_clip("x");
  EXPECT_THAT(control_.Ask(both).reason(), HasSubstr("expected one of clip, code, learn_s, vary"));
  EXPECT_EQ(InfoOf("mine").name(), "") << "nothing was made";
}

// Hundreds of messages in a moment: the last value of each fader counts.
TEST_F(DesignTest, FadersOverOscArriveAtTheirLastValue) {
  NextFrame();
  const int fd = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  const std::size_t colon = daemon_.osc.rfind(':');
  inet_pton(AF_INET, daemon_.osc.substr(0, colon).c_str(), &to.sin_addr);
  to.sin_port = htons(static_cast<std::uint16_t>(std::stoi(daemon_.osc.substr(colon + 1))));
  ASSERT_EQ(connect(fd, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
  const auto fader = [fd](const std::string& slider, float value) {
    std::array<std::byte, 256> bytes;
    vmc::osc::Writer writer(bytes);
    writer.BeginMessage("/styled/rig.a/design/" + slider, "f");
    writer.Float(value);
    writer.EndMessage();
    ASSERT_EQ(send(fd, bytes.data(), writer.size(), 0), static_cast<ssize_t>(writer.size()));
  };
  for (int i = 1; i <= 200; ++i) {
    fader("stoop", 0.2F * static_cast<float>(i));
    fader("crouch", 0.1F * static_cast<float>(i));
    if (i % 20 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  v1::StyleInfo info;
  for (int tries = 0; tries < 200; ++tries) {
    NextFrame();
    info = InfoOf("by-hand-rig-a");
    const auto& sliders = info.sliders();
    if (sliders.contains("stoop") && sliders.at("stoop") == 40 && sliders.contains("crouch") &&
        sliders.at("crouch") == 20) {
      break;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  close(fd);
  EXPECT_FLOAT_EQ(info.sliders().at("stoop"), 40);
  EXPECT_FLOAT_EQ(info.sliders().at("crouch"), 20);
  EXPECT_EQ(control_.CounterSoon("control.busy", 0), 0U);
}

}  // namespace
}  // namespace styled::support
