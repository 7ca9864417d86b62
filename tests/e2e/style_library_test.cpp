// Styles that were made, over real sockets: exchanged, renamed, removed, kept, and a thousand of
// them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "model/clip/clip.h"
#include "tests/e2e/examples.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"

namespace styled::support {
namespace {

using nlohmann::json;
using testing::HasSubstr;

v1::Request LikeOf(const std::string& name, const std::string& performer = "") {
  v1::Request request;
  request.set_performer(performer);
  request.mutable_like()->set_name(name);
  request.mutable_like()->set_clip(WalkBvh(30, 2));
  request.mutable_like()->set_file("walk.bvh");
  request.mutable_like()->set_transition_ms(0);
  return request;
}
v1::Request Export(const std::string& name) {
  v1::Request request;
  request.mutable_export_style()->set_name(name);
  return request;
}
v1::Request Import(const std::string& file, const std::string& name = "", bool replace = false) {
  v1::Request request;
  request.mutable_import_style()->set_file(file);
  request.mutable_import_style()->set_name(name);
  request.mutable_import_style()->set_replace(replace);
  return request;
}
v1::Request Rename(const std::string& name, const std::string& to) {
  v1::Request request;
  request.mutable_rename_style()->set_name(name);
  request.mutable_rename_style()->set_to(to);
  return request;
}
v1::Request Remove(const std::string& name) {
  v1::Request request;
  request.mutable_remove_style()->set_name(name);
  return request;
}

class StyleRequestTest : public testing::Test {
 protected:
  StyleRequestTest() {
    link_.Send(rig_.Body());
    EXPECT_TRUE(subscriber_.WaitForBody());
  }

  v1::Frame NextFrame() {
    const std::size_t before = subscriber_.Frames("styled/").size();
    link_.Send(rig_.Frame());
    EXPECT_TRUE(subscriber_.WaitForFrames(before + 1, "styled/")) << daemon_.Log();
    return subscriber_.Frames("styled/").back();
  }
  void Refuses(const v1::Request& request, v1::Code code, const std::string& reason) {
    const v1::Reply reply = control_.Ask(request);
    EXPECT_EQ(reply.code(), code) << reason;
    EXPECT_THAT(reply.reason(), HasSubstr(reason));
    EXPECT_EQ(StylesOf(daemon_), (std::vector<std::string>{"neutral", "style1", "style2", "style3",
                                                           "mine", "two", "in-preset"}));
  }
  std::string library() const { return folder_ / "styles/"; }
  // A preset needs its style at the start.
  static std::string Presets() { return "[presets]\nmild = { s1 = 0.3 }\n"; }

  TemporaryFolder folder_;
  Daemon daemon_{{"style.library=" + library()}, Presets(), {}, CausalWeights(folder_ / "w")};
  Subscriber subscriber_{daemon_.publish, {"body/rig.a/", "styled/rig.a/rig/"}};
  ControlClient control_{daemon_.control};
  UdpLink link_{daemon_.udp};
  Rig rig_{"a"};
};

TEST_F(StyleRequestTest, AnImpossibleRequestIsRefusedWithTheReason) {
  for (const char* const name : {"mine", "two", "in-preset"}) {
    ASSERT_EQ(control_.Ask(LikeOf(name)).code(), v1::CODE_OK);
  }
  daemon_.Configure(Presets() + "[presets.of-made]\nin-preset = 1.0\n");
  ASSERT_EQ(kill(daemon_.child->pid(), SIGHUP), 0);
  ASSERT_EQ(control_.CounterSoon("config.reloads", 1), 1U) << daemon_.Log();

  for (const auto& [command, request] : {std::pair{"export", Export("nobody")},
                                         {"rename", Rename("nobody", "new")},
                                         {"remove", Remove("nobody")}}) {
    Refuses(request, v1::CODE_UNKNOWN_STYLE,
            std::string(command) +
                ": no style \"nobody\"; those that were made are in-preset mine two");
  }
  for (const auto& [command, request] : {std::pair{"export", Export("s1")},
                                         {"rename", Rename("Style1", "new")},
                                         {"remove", Remove("neutral")}}) {
    Refuses(request, v1::CODE_MALFORMED, std::string(command) + ": \"");
    Refuses(request, v1::CODE_MALFORMED, "is a style of the weights, expected one that was made");
  }
  Refuses(Rename("mine", ""), v1::CODE_MALFORMED, "rename: name \"\": expected 1 to 32 of");
  Refuses(Rename("mine", "a/b"), v1::CODE_MALFORMED, "name \"a/b\": expected 1 to 32 of");
  Refuses(Rename("mine", "-x"), v1::CODE_MALFORMED, "name \"-x\": begins with - as an option does");
  Refuses(Rename("mine", "Panic"), v1::CODE_MALFORMED,
          "name \"Panic\": is a word of stylectl and OSC with another meaning");
  Refuses(Rename("mine", "mine"), v1::CODE_MALFORMED, "name \"mine\": is already its name");
  Refuses(Rename("mine", "TWO"), v1::CODE_MALFORMED, "another style that was made has it");
  Refuses(Rename("mine", "mild"), v1::CODE_MALFORMED, "name \"mild\": a preset has it");
  Refuses(Rename("mine", "S2"), v1::CODE_MALFORMED, "a style of the weights has it, \"style2\"");
  for (const auto& request : {Rename("in-preset", "new"), Remove("in-preset")}) {
    Refuses(request, v1::CODE_MALFORMED,
            "\"in-preset\": preset of-made of the configuration names it");
  }

  const v1::Reply exported = control_.Ask(Export("MINE"));
  ASSERT_EQ(exported.code(), v1::CODE_OK) << exported.reason();
  EXPECT_EQ(exported.style_file().name(), "mine");
  const json file = json::parse(exported.style_file().file());
  const auto with = [&file](const char* key, const json& value) {
    json other = file;
    other[key] = value;
    return other.dump();
  };
  Refuses(Import(""), v1::CODE_MALFORMED,
          "import: the file: expected a JSON object with \"format\": \"styled style 1\"");
  Refuses(Import("[1, 2]"), v1::CODE_MALFORMED, "expected a JSON object");
  Refuses(Import(std::string(200'000, '[')), v1::CODE_MALFORMED, "expected a JSON object");
  Refuses(Import(with("format", "styled style 9")), v1::CODE_MALFORMED, "\"styled style 1\"");
  Refuses(Import(with("weights", "crc32c:00000000")), v1::CODE_MALFORMED,
          "was made with other weights, crc32c:00000000; expected " +
              file["weights"].get<std::string>());
  Refuses(Import(with("weights", 7)), v1::CODE_MALFORMED, "other weights, unnamed; expected crc");
  Refuses(Import(with("code", "all")), v1::CODE_MALFORMED, "\"code\" with numbers");
  Refuses(Import(with("code", {1, "b"})), v1::CODE_MALFORMED, "\"code\" with numbers");
  Refuses(Import(with("code", {1, 2}), "new"), v1::CODE_MALFORMED,
          "import: code: found 2 numbers, expected as many as");
  Refuses(Import(with("code", json(std::vector<double>(64, 1e300))), "new"), v1::CODE_MALFORMED,
          "import: code: expected finite numbers, not huge ones");
  Refuses(Import(with("name", 7)), v1::CODE_MALFORMED, "expected \"name\"");
  Refuses(Import(with("name", "../../etc/x")), v1::CODE_MALFORMED,
          "name \"../../etc/x\": expected 1 to 32 of");
  Refuses(Import(file.dump()), v1::CODE_MALFORMED,
          "name \"mine\": a style that was made has it; expected another name, or replace");
  Refuses(Import(file.dump(), "style3", true), v1::CODE_MALFORMED, "a style of the weights has it");
  Refuses(Import(file.dump() + std::string(1U << 20U, ' ')), v1::CODE_MALFORMED,
          "bytes, expected at most 1048576");
}

TEST_F(StyleRequestTest, AFileGoesOutAndComesInAgain) {
  NextFrame();
  const v1::Reply made = control_.Ask(LikeOf("mine", "rig.a"));
  ASSERT_EQ(made.code(), v1::CODE_OK) << made.reason();
  const std::string file = control_.Ask(Export("mine")).style_file().file();
  EXPECT_EQ(file, ReadText(library() + "mine.json"));
  const v1::Reply copy = control_.Ask(Import(file, "copy"));
  ASSERT_EQ(copy.code(), v1::CODE_OK) << copy.reason();
  EXPECT_EQ(copy.like().name(), "copy");
  EXPECT_THAT(copy.like().code(), testing::ElementsAreArray(made.like().code()));
  EXPECT_EQ(copy.like().distance(), made.like().distance());
  EXPECT_TRUE(std::filesystem::exists(library() + "copy.json"));
  EXPECT_FALSE(std::filesystem::exists(library() + "copy.bvh")) << "the example did not come along";

  // Another code for the style that is shown, as written by a program that refines styles: no jump.
  // Other keys of its file are not kept: a daemon that kept everything wrote files that grew with
  // each import.
  json refined = json::parse(file);
  for (auto& number : refined["code"]) number = 0.5 * number.get<double>();
  refined["refined_s"] = 60;
  ASSERT_EQ(control_.SetStyle("rig.a", "mine", 1, 1000).code(), v1::CODE_OK);
  const v1::Reply replaced = control_.Ask(Import(refined.dump(), "", true));
  ASSERT_EQ(replaced.code(), v1::CODE_OK) << replaced.reason();
  const v1::Frame frame = NextFrame();
  EXPECT_EQ(frame.flags() & v1::FLAG_NEW_SESSION, 0U);
  EXPECT_EQ(frame.styles_size(), 2) << "one fades to the other";
  EXPECT_THAT(control_.Ask(Export("mine")).style_file().file(),
              testing::Not(HasSubstr("refined_s")));
  EXPECT_TRUE(std::filesystem::exists(library() + "mine.bvh")) << "the same example";
  EXPECT_THAT(StylesOf(daemon_),
              testing::ElementsAre("neutral", "style1", "style2", "style3", "copy", "mine"));
}

TEST_F(StyleRequestTest, APerformerInARenamedStyleContinues) {
  NextFrame();
  ASSERT_EQ(control_.Ask(LikeOf("mine", "rig.a")).code(), v1::CODE_OK);
  ASSERT_EQ(NextFrame().styles(0).style(), "mine");
  const v1::Reply renamed = control_.Ask(Rename("Mine", "yours"));
  ASSERT_EQ(renamed.code(), v1::CODE_OK) << renamed.reason();
  ASSERT_EQ(renamed.applied_size(), 1);
  EXPECT_EQ(renamed.applied(0).performer(), "rig.a");
  const v1::Frame frame = NextFrame();
  ASSERT_EQ(frame.styles_size(), 1);
  EXPECT_EQ(frame.styles(0).style(), "yours");
  EXPECT_EQ(frame.styles(0).weight(), 1);
  EXPECT_EQ(frame.flags() & (v1::FLAG_NEW_SESSION | v1::FLAG_FADING), 0U);
  EXPECT_EQ(control_.Performer("rig.a").look().mix(0).style(), "yours");
  for (const char* const extension : {".json", ".bvh"}) {
    EXPECT_TRUE(std::filesystem::exists(library() + "yours" + extension)) << extension;
    EXPECT_FALSE(std::filesystem::exists(library() + "mine" + extension)) << extension;
  }
  EXPECT_EQ(json::parse(ReadText(library() + "yours.json"))["name"], "yours");
  EXPECT_EQ(control_.SetStyle("rig.a", "mine").code(), v1::CODE_UNKNOWN_STYLE);
  ASSERT_EQ(daemon_.Stop(), 0);
  daemon_.Start();
  EXPECT_THAT(StylesOf(daemon_),
              testing::ElementsAre("neutral", "style1", "style2", "style3", "yours"));
}

TEST_F(StyleRequestTest, APerformerInARemovedStyleFadesToBypass) {
  NextFrame();
  ASSERT_EQ(control_.Ask(LikeOf("mine", "rig.a")).code(), v1::CODE_OK);
  ASSERT_EQ(control_.SetStyle("rig.a", "mine", 1, 500).code(), v1::CODE_OK);
  NextFrame();
  const v1::Reply removed = control_.Ask(Remove("mine"));
  ASSERT_EQ(removed.code(), v1::CODE_OK) << removed.reason();
  ASSERT_EQ(removed.applied_size(), 1);
  const v1::Frame frame = NextFrame();
  EXPECT_EQ(frame.flags() & v1::FLAG_NEW_SESSION, 0U);
  EXPECT_NE(frame.flags() & v1::FLAG_FADING, 0U) << "no jump";
  for (int i = 0; i < 80; ++i) NextFrame();
  EXPECT_NE(NextFrame().flags() & v1::FLAG_BYPASS, 0U);
  EXPECT_EQ(control_.Performer("rig.a").look().mix_size(), 0);
  EXPECT_THAT(StylesOf(daemon_), testing::ElementsAre("neutral", "style1", "style2", "style3"));
  EXPECT_FALSE(std::filesystem::exists(library() + "mine.json"));
  EXPECT_FALSE(std::filesystem::exists(library() + "mine.bvh"));
  // A style of this name that is made later is another style: no performer gets it without a
  // request.
  ASSERT_EQ(control_.Ask(LikeOf("mine")).code(), v1::CODE_OK);
  EXPECT_NE(NextFrame().flags() & v1::FLAG_BYPASS, 0U);
}

// Full disks and folders without permission look like this to the daemon.
TEST_F(StyleRequestTest, AFolderThatCannotBeWrittenChangesNothing) {
  NextFrame();
  ASSERT_EQ(control_.Ask(LikeOf("mine", "rig.a")).code(), v1::CODE_OK);
  const std::string file = control_.Ask(Export("mine")).style_file().file();
  std::filesystem::create_directories(library() + "new.json.new");
  const auto not_kept = [&](const v1::Request& request, const std::string& reason) {
    const v1::Reply reply = control_.Ask(request);
    EXPECT_EQ(reply.code(), v1::CODE_NOT_KEPT);
    EXPECT_THAT(reply.reason(), HasSubstr(reason));
    EXPECT_THAT(reply.reason(), HasSubstr("; nothing was changed"));
    EXPECT_THAT(StylesOf(daemon_),
                testing::ElementsAre("neutral", "style1", "style2", "style3", "mine"));
    EXPECT_EQ(NextFrame().styles(0).style(), "mine");
    EXPECT_EQ(ReadText(library() + "mine.json"), file);
  };
  not_kept(Import(file, "new"), "new.json: cannot be written: Is a directory");
  not_kept(Rename("mine", "new"), "new.json: cannot be written: Is a directory");
  std::filesystem::remove(library() + "mine.json");
  std::filesystem::create_directories(library() + "mine.json/full");
  const v1::Reply reply = control_.Ask(Remove("mine"));
  EXPECT_EQ(reply.code(), v1::CODE_NOT_KEPT);
  EXPECT_THAT(reply.reason(), HasSubstr("mine.json: cannot be removed: "));
  EXPECT_THAT(StylesOf(daemon_), testing::Contains("mine"));
}

TEST_F(StyleRequestTest, TheExampleIsKeptAsTheCanonicalBody) {
  ASSERT_EQ(control_.Ask(LikeOf("mine")).code(), v1::CODE_OK);
  const auto clip = clip::ReadBvh(library() + "mine.bvh");
  ASSERT_TRUE(clip.ok()) << clip.status().message();
  EXPECT_EQ(clip.value().skeleton.joint_count(), body::kJointCount);
  EXPECT_EQ(clip.value().rate_hz, 30);
  EXPECT_NEAR(static_cast<double>(clip.value().frames.size()), 60, 1);
  EXPECT_NEAR(clip.value().frames[0].translations[0].y(), 0.9F, 0.15F) << "metres";
  // It gives the style again.
  v1::Request again = LikeOf("again");
  again.mutable_like()->set_clip(ReadText(library() + "mine.bvh"));
  const v1::Reply reply = control_.Ask(again);
  const json file = json::parse(ReadText(library() + "mine.json"));
  for (int i = 0; i < reply.like().code_size(); ++i) {
    EXPECT_NEAR(reply.like().code(i), file["code"][static_cast<std::size_t>(i)].get<float>(), 1e-3);
  }
  // A style of a code has no example; that of the style before it goes.
  v1::Request code = LikeOf("mine");
  code.mutable_like()->clear_clip();
  *code.mutable_like()->mutable_code() = reply.like().code();
  ASSERT_EQ(control_.Ask(code).code(), v1::CODE_OK);
  EXPECT_FALSE(std::filesystem::exists(library() + "mine.bvh"));
}

TEST_F(StyleRequestTest, AListSaysWhereStylesComeFrom) {
  ASSERT_EQ(control_.Ask(LikeOf("mine")).code(), v1::CODE_OK);
  v1::Request request;
  request.mutable_list();
  const v1::ListReply list = control_.Ask(request).list();
  ASSERT_EQ(list.styles_size(), 5);
  EXPECT_FALSE(list.styles(1).made());
  EXPECT_TRUE(list.styles(1).varies());
  const v1::StyleInfo& mine = list.styles(4);
  EXPECT_TRUE(mine.made());
  EXPECT_TRUE(mine.varies());
  EXPECT_EQ(mine.source(), "walk.bvh");
  EXPECT_THAT(mine.nearest(), HasSubstr("style"));
  EXPECT_GT(mine.distance(), 0);
}

TEST_F(StyleRequestTest, APreviewWalksOnTheSpotAndLoops) {
  ASSERT_EQ(control_.Ask(LikeOf("mine")).code(), v1::CODE_OK);
  v1::Request request;
  for (const char* const style : {"neutral", "s2", "mine"}) {
    request.mutable_preview()->set_style(style);
    const v1::Reply reply = control_.Ask(request);
    ASSERT_EQ(reply.code(), v1::CODE_OK) << style << ": " << reply.reason();
    const v1::PreviewReply& preview = reply.preview();
    EXPECT_NEAR(preview.rate_hz(), 15, 0.5);
    ASSERT_EQ(preview.joints(), 21U);
    ASSERT_EQ(preview.positions_mm_size() % 63, 0);
    const int frames = preview.positions_mm_size() / 63;
    EXPECT_NEAR(frames / preview.rate_hz(), 2.2, 0.3) << "two strides";
    const auto at = [&](int frame, int value) {
      return preview.positions_mm((frame + frames) % frames * 63 + value);
    };
    int inside = 0, over = 0;  // the largest step within, and over the end
    for (int frame = 0; frame < frames; ++frame) {
      EXPECT_LT(std::abs(at(frame, 0)), 200) << "hips";
      EXPECT_LT(std::abs(at(frame, 2)), 200) << "hips";
      for (int value = 0; value < 63; ++value) {
        const int step = std::abs(at(frame, value) - at(frame - 1, value));
        (frame == 0 ? over : inside) = std::max(frame == 0 ? over : inside, step);
      }
    }
    EXPECT_LE(over, inside) << style;
    const v1::Reply again = control_.Ask(request);
    EXPECT_EQ(again.preview().SerializeAsString(), preview.SerializeAsString());
  }
  request.mutable_preview()->set_style("nobody");
  const v1::Reply unknown = control_.Ask(request);
  EXPECT_EQ(unknown.code(), v1::CODE_UNKNOWN_STYLE);
  EXPECT_EQ(unknown.reason(), "preview: no style \"nobody\"; see list");
}

TEST(StyleLibraryLess, WithoutALibraryItIsForTheRunningDaemonOnly) {
  const TemporaryFolder folder;
  Daemon daemon({}, "", {}, CausalWeights(folder / "w"));
  ControlClient control(daemon.control);
  ASSERT_EQ(control.Ask(LikeOf("mine")).code(), v1::CODE_OK);
  const std::string file = control.Ask(Export("mine")).style_file().file();
  EXPECT_EQ(control.Ask(Import(file, "two")).code(), v1::CODE_OK);
  EXPECT_EQ(control.Ask(Rename("two", "three")).code(), v1::CODE_OK);
  EXPECT_EQ(control.Ask(Remove("mine")).code(), v1::CODE_OK);
  EXPECT_THAT(StylesOf(daemon),
              testing::ElementsAre("neutral", "style1", "style2", "style3", "three"));
  ASSERT_EQ(daemon.Stop(), 0);
  daemon.Start();
  EXPECT_EQ(StylesOf(daemon).size(), 4U);
}

TEST(StyleLibrary, AThousandStyles) {
  const TemporaryFolder folder;
  const std::string library = folder / "styles", weights = CausalWeights(folder / "w");
  Daemon daemon({"style.library=" + library}, "", {}, weights);
  ControlClient control(daemon.control);
  ASSERT_EQ(control.Ask(LikeOf("mine")).code(), v1::CODE_OK);
  json file = json::parse(ReadText(library + "/mine.json"));
  ASSERT_EQ(daemon.Stop(), 0);
  for (int i = 1; i < 1024; ++i) {
    file["name"] = "style-" + std::to_string(1000 + i);
    file["code"][0] = 0.001 * i;
    WriteText(library + "/" + file["name"].get<std::string>() + ".json", file.dump());
  }
  const auto begin = std::chrono::steady_clock::now();
  daemon.Start();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  std::printf("the daemon started in %.2f s\n", took.count());
  EXPECT_EQ(StylesOf(daemon).size(), 4U + 1024);

  const Subscriber subscriber(daemon.publish, {"body/rig.a/", "styled/rig.a/rig/"});
  UdpLink link(daemon.udp);
  Rig rig("a");
  link.Send(rig.Body());
  ASSERT_TRUE(subscriber.WaitForBody());
  ControlClient after(daemon.control);
  EXPECT_EQ(after.SetStyle("rig.a", "style-2023", 1, 0).code(), v1::CODE_OK);
  link.Send(rig.Frame());
  ASSERT_TRUE(subscriber.WaitForFrames(1, "styled/"));
  EXPECT_EQ(subscriber.Frames("styled/").back().styles(0).style(), "style-2023");
  EXPECT_LT(after.SetStyle("rig.a", "nobody").reason().size(), 1000U);
  // There is no room for another name, but a style of an existing name can be replaced, however
  // often.
  for (int i = 0; i < 80; ++i) {
    const v1::Reply reply = after.Ask(LikeOf("style-1001"));
    ASSERT_EQ(reply.code(), v1::CODE_OK) << i << ": " << reply.reason();
  }
  EXPECT_EQ(after.Ask(LikeOf("one-more")).code(), v1::CODE_BUSY);
  EXPECT_EQ(after.Ask(LikeOf("one-more")).reason(),
            "like: there are 1024 made styles already, which is the maximum");
  ASSERT_EQ(after.Ask(Remove("style-1500")).code(), v1::CODE_OK);
  EXPECT_EQ(after.Ask(LikeOf("one-more")).code(), v1::CODE_OK);
  EXPECT_EQ(StylesOf(daemon).size(), 4U + 1024);
}

TEST(StyleLibrary, StylesSurviveARestartAndGoWithTheirFiles) {
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
  // A file that is not a style, or belongs to other weights, is left out with the reason; the
  // daemon starts.
  std::string other = text;
  other.replace(other.find("crc32c:", other.find("\"weights\"")), 15, "crc32c:00000000");
  other.replace(other.find("\"two\""), 5, "\"other\"");
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

// New weights, or a package that brings them, must not cost a stage its styles.
TEST(StyleLibrary, StylesOfOtherWeightsAreMadeAgainFromTheirExamples) {
  const TemporaryFolder folder;
  const std::string library = folder / "styles", weights = CausalWeights(folder / "w");
  Daemon daemon({"style.library=" + library}, "", {}, weights);
  const v1::Reply first = ControlClient(daemon.control).Ask(LikeOf("mine"));
  ASSERT_EQ(first.code(), v1::CODE_OK) << first.reason();
  const std::string text = ReadText(library + "/mine.json");
  const auto with_other_weights = [&](const std::string& name, double added_s) {
    json file = json::parse(text);
    file["name"] = name;
    file["weights"] = "crc32c:00000000";
    file["code"] = {1, 2, 3};
    file["seconds"] = json::parse(text)["seconds"].get<double>() + added_s;
    WriteText(library + "/" + name + ".json", file.dump());
    std::filesystem::copy(library + "/mine.bvh", library + "/" + name + ".bvh");
  };
  with_other_weights("again", 0);
  with_other_weights("sum", 5);
  with_other_weights("changed", 0);
  WriteText(library + "/changed.bvh", ReadText(library + "/changed.bvh") + "\n");
  const std::string before = ReadText(library + "/again.json");
  ASSERT_EQ(daemon.Stop(), 0);
  daemon.Start();
  EXPECT_THAT(StylesOf(daemon), testing::ElementsAre("neutral", "style1", "style2", "style3",
                                                     "again", "mine", "sum"));
  EXPECT_THAT(daemon.Log(),
              HasSubstr("again.json: was made with other weights, crc32c:00000000, and is made "
                        "again from its example. "));
  EXPECT_THAT(daemon.Log(), HasSubstr("from its example, the last that was added to it."));
  EXPECT_THAT(daemon.Log(),
              HasSubstr("changed.json: was made with other weights, crc32c:00000000; expected "));
  EXPECT_EQ(ReadText(library + "/again.json"), before) << "the other weights find theirs again";
  // The same style as of the weights that are running, within the digits of a kept example.
  ControlClient control(daemon.control);
  const json again = json::parse(control.Ask(Export("again")).style_file().file());
  ASSERT_EQ(again["code"].size(), static_cast<std::size_t>(first.like().code_size()));
  EXPECT_NEAR(again["distance"].get<double>(), static_cast<double>(first.like().distance()), 0.02);
  EXPECT_EQ(again["licence"], "CC0-1.0");
}

TEST(StyleLibrary, AFolderThatCannotBeWrittenIsSaidAndTheStyleWorks) {
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

}  // namespace
}  // namespace styled::support
