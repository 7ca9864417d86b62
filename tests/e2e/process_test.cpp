#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>

#include "tests/support/daemon.h"
#include "tests/support/rig.h"
#include "tests/unit/net/erd/random_weights.h"

namespace styled::support {
namespace {

bool LogSays(const Daemon& daemon, const std::string& text, double seconds = 5) {
  for (double waited = 0; waited < seconds; waited += 0.02) {
    if (daemon.Log().find(text) != std::string::npos) return true;
    Sleep(0.02);
  }
  return false;
}

struct Outcome {
  int code;
  std::string text;
};

Outcome RunStyled(const TemporaryFolder& folder, const std::vector<std::string>& arguments,
                  const std::map<std::string, std::string>& environment = {}) {
  std::vector<std::string> all{Binary()};
  all.insert(all.end(), arguments.begin(), arguments.end());
  const std::string log = folder / ("log" + std::to_string(arguments.size()) + ".txt");
  Child child(all, log, environment);
  const int code = child.Wait(10).value_or(-1);
  return {code, ReadText(log)};
}

TEST(ProcessTest, StopsCleanlyOnSigtermAndOnSigint) {
  for (const int signal : {SIGTERM, SIGINT}) {
    Daemon daemon;
    const UdpLink link(daemon.udp);
    Rig rig("a");
    link.Send(rig.Body());
    for (int i = 0; i < 10; ++i) link.Send(rig.Frame());
    daemon.child->Signal(signal);
    EXPECT_EQ(daemon.child->Wait(5).value_or(-1), 0) << daemon.Log();
  }
}

// No user can make a file in /proc, not even root.
TEST(ProcessTest, AStateFolderThatCannotBeWrittenIsToldAtTheStart) {
  const Daemon daemon({"state.dir=/proc"});
  EXPECT_TRUE(LogSays(daemon, "state.dir: /proc: cannot be written: ")) << daemon.Log();
}

TEST(ProcessTest, SighupTakesOverAGoodConfigurationAndFramesGoOn) {
  Daemon daemon({}, "[presets]\nmild = { s1 = 0.3 }\n");
  Subscriber subscriber(daemon.publish, {"body/", "styled/rig.a/rig/"});
  ControlClient control(daemon.control);
  const UdpLink link(daemon.udp);
  Rig rig("a");
  link.Send(rig.Body());
  ASSERT_TRUE(subscriber.WaitForBody());
  Paced(120, 120, [&](int i) {
    link.Send(rig.Frame());
    if (i == 40) {
      daemon.Configure("[presets]\nwild = { s2 = 1.2 }\n");
      daemon.child->Signal(SIGHUP);
    }
  });
  ASSERT_TRUE(LogSays(daemon, "reloaded:"));
  v1::Request list;
  list.mutable_list();
  const auto presets = control.Ask(list).list();
  ASSERT_EQ(presets.presets_size(), 1);
  EXPECT_EQ(presets.presets(0).name(), "wild");
  ASSERT_TRUE(subscriber.WaitForFrames(120, "styled/"));
  EXPECT_EQ(control.Counter("config.reloads"), 1U);

  // Weights with other styles.
  WriteRandomWeights(daemon.folder / "weights.safetensors", 3, 2);
  daemon.child->Signal(SIGHUP);
  ASSERT_EQ(control.CounterSoon("config.reloads", 2), 2U) << daemon.Log();
  EXPECT_EQ(control.Ask(list).list().styles_size(), 3);
  Paced(60, 120, [&](int) { link.Send(rig.Frame()); });
  ASSERT_TRUE(subscriber.WaitForFrames(180, "styled/"));
}

TEST(ProcessTest, SighupChangesThePrecisionOfTheWeights) {
  Daemon daemon;
  ControlClient control(daemon.control);
  EXPECT_TRUE(LogSays(daemon, "weights.safetensors in int8")) << daemon.Log();
  daemon.Configure("[model]\nprecision = \"float32\"\n");
  daemon.child->Signal(SIGHUP);
  EXPECT_TRUE(LogSays(daemon, "reloaded: weights weights.safetensors")) << daemon.Log();
  EXPECT_EQ(daemon.Log().find("reloaded: weights weights.safetensors in"), std::string::npos);
  EXPECT_EQ(control.CounterSoon("config.reloads", 1), 1U);
}

TEST(ProcessTest, SighupWithABadConfigurationKeepsTheRunningOneAndSaysWhy) {
  Daemon daemon({}, "[presets]\nmild = { s1 = 0.3 }\n");
  ControlClient control(daemon.control);
  daemon.Configure("[presets]\nmild = { nostyle = 0.3 }\n");
  daemon.child->Signal(SIGHUP);
  EXPECT_TRUE(LogSays(daemon, "no style \"nostyle\""));
  daemon.Configure("[performers]\nstale_mss = 3\n");
  daemon.child->Signal(SIGHUP);
  EXPECT_TRUE(LogSays(daemon, "unknown key, nearest is \"stale_ms\""));
  WriteText(daemon.folder / "weights.safetensors", "no weights");
  daemon.Configure("");
  daemon.child->Signal(SIGHUP);
  EXPECT_EQ(control.CounterSoon("config.reloads_refused", 3), 3U) << daemon.Log();
  EXPECT_EQ(control.Counter("config.reloads"), 0U);
  v1::Request list;
  list.mutable_list();
  EXPECT_EQ(control.Ask(list).list().presets_size(), 1);
  EXPECT_EQ(control.SetStyle("rig.a", "style4").code(), v1::CODE_OK);
}

// The file is well-formed and its values are finite, but every output is NaN.
void WriteWildWeights(const std::string& file, const std::string& tensor) {
  erd::WeightsFile weights = erd::RandomWeights(5, 1);
  for (float& value : weights.tensor(tensor).values) value *= 1e30F;
  WriteWeights(file, weights);
}

TEST(ProcessTest, WildWeightsAreRefusedAtTheStart) {
  const TemporaryFolder folder;
  const std::string weights = folder / "wild.safetensors";
  for (const char* const tensor : {"head.rotation.weight", "feature.deviation"}) {
    WriteWildWeights(weights, tensor);
    WriteText(folder / "styled.toml",
              "[[source]]\nname = \"rig\"\ntype = \"udp\"\nlisten = \"127.0.0.1:0\"\n");
    const Outcome outcome =
        RunStyled(folder, {"--config", folder / "styled.toml", "--weights", weights, "--set",
                           "publish.address=tcp://127.0.0.1:0", "--set",
                           "control.address=tcp://127.0.0.1:0"});
    EXPECT_EQ(outcome.code, 1);
    EXPECT_NE(outcome.text.find(weights + ": the trial run"), std::string::npos) << outcome.text;
    EXPECT_NE(outcome.text.find("expected a rotation of length 1, found nan"), std::string::npos)
        << outcome.text;
  }
}

TEST(ProcessTest, WildWeightsOnSighupAreRefusedAndTheRunningOnesGoOnStyling) {
  Daemon daemon;
  Subscriber subscriber(daemon.publish, {"body/", "styled/rig.a/rig/"});
  ControlClient control(daemon.control);
  const UdpLink link(daemon.udp);
  Rig rig("a");
  link.Send(rig.Body());
  ASSERT_TRUE(subscriber.WaitForBody());
  Paced(10, 120, [&](int) { link.Send(rig.Frame()); });
  ASSERT_EQ(control.SetStyle("rig.a", "style2").code(), v1::CODE_OK);
  WriteWildWeights(daemon.folder / "weights.safetensors", "head.rotation.weight");
  Paced(120, 120, [&](int i) {
    link.Send(rig.Frame());
    if (i == 20) daemon.child->Signal(SIGHUP);
  });
  EXPECT_TRUE(LogSays(daemon, "reload refused"));
  EXPECT_TRUE(LogSays(daemon, "weights.safetensors: the trial run")) << daemon.Log();
  EXPECT_EQ(control.CounterSoon("config.reloads_refused", 1), 1U) << daemon.Log();
  EXPECT_EQ(control.Counter("config.reloads"), 0U);
  Paced(60, 120, [&](int) { link.Send(rig.Frame()); });
  ASSERT_TRUE(subscriber.WaitForFrames(190, "styled/"));
  const auto frames = subscriber.Frames("styled/");
  for (const v1::Frame& frame : frames) {
    EXPECT_EQ(frame.flags() & v1::FLAG_FAILED, 0U);
    for (const float value : frame.rotations()) ASSERT_TRUE(std::isfinite(value));
  }
  ASSERT_EQ(frames.back().styles_size(), 1);
  EXPECT_EQ(frames.back().styles(0).style(), "style2");
}

// Weights whose defect a trial cannot detect: they produce invalid poses only when the performer's
// hips are high.
TEST(ProcessTest, AnInvalidPoseIsNeverPublishedButFlaggedAndCounted) {
  const TemporaryFolder folder;
  WriteWeights(folder / "sleeping.safetensors", erd::SleepingWeights(5, 1));
  Daemon daemon({}, "", {}, folder / "sleeping.safetensors");
  Subscriber subscriber(daemon.publish, {"body/", "styled/", "source/"});
  ControlClient control(daemon.control);
  const UdpLink link(daemon.udp);
  Rig rig("a");
  link.Send(rig.Body());
  ASSERT_TRUE(subscriber.WaitForBody());
  link.Send(rig.Frame());
  ASSERT_EQ(control.SetStyle("rig.a", "style2").code(), v1::CODE_OK);
  Paced(180, 120, [&](int i) {
    const bool high = i >= 60 && i < 120;
    link.Send(rig.Frame([high](v1::SourceFrame& frame) {
      if (high) frame.set_root_position(1, 1.3F);
    }));
  });
  ASSERT_TRUE(subscriber.WaitForFrames(181, "styled/rig.a/rig/"));
  EXPECT_EQ(control.CounterSoon("stylist.failed", 60), 60U) << daemon.Log();
  EXPECT_TRUE(LogSays(daemon, "stylist.failed: ")) << daemon.Log();
  int failed = 0;
  for (const v1::Frame& frame : subscriber.Frames("")) {
    for (int joint = 0; 4 * joint < frame.rotations_size(); ++joint) {
      float length2 = 0;
      for (int i = 0; i < 4; ++i) {
        length2 += frame.rotations(4 * joint + i) * frame.rotations(4 * joint + i);
      }
      ASSERT_NEAR(length2, 1, 2e-3) << frame.sequence();
    }
    for (const float value : frame.root_position()) ASSERT_TRUE(std::isfinite(value));
    if ((frame.flags() & v1::FLAG_FAILED) == 0) continue;
    ++failed;
    EXPECT_NE(frame.flags() & v1::FLAG_BYPASS, 0U);
    EXPECT_EQ(frame.styles_size(), 0);
  }
  EXPECT_EQ(failed, 3 * 60) << "rig, canonical, source";
  const auto styled = subscriber.Frames("styled/rig.a/rig/");
  EXPECT_EQ(styled.back().flags(), v1::FLAG_NONE) << "styled again";
}

// "A bad reload changes nothing", whatever replaces the file.
TEST(ProcessTest, SighupWithAnyFileChangesNothing) {
  Daemon daemon({}, "[presets]\nmild = { s1 = 0.3 }\n");
  ControlClient control(daemon.control);
  const std::string file = daemon.folder / "styled.toml";
  const std::string good = ReadText(file);
  ASSERT_NE(good, "");
  std::string key = "a", brackets;
  for (int i = 0; i < 200000; ++i) {
    key += ".a";
    brackets += "[";
  }
  const auto put = [&](const std::string& text) {
    std::filesystem::remove(file);
    WriteText(file, text);
  };
  const std::vector<std::pair<std::function<void()>, std::string>> cases{
      {[&] { put("\n" + key + " = 1\n"); }, ":2: nested too deep"},
      {[&] { put("[" + key + "]\n"); }, ":1: nested too deep"},
      {[&] { put("x = {" + key + " = 1}\n"); }, ":1: nested too deep"},
      {[&] { put("x = " + brackets + "\n"); }, ":1: nested too deep"},
      {[&] { put(std::string(5, '\0')); }, file},
      {[&] { put("a = \"\xFF\xFE\"\n"); }, file},
      {[&] { put(std::string((1 << 20) + 1, '#')); }, "larger than the limit of 1 MiB"},
      {[&] { std::filesystem::remove(file); }, "No such file"},
      {[&] { ASSERT_EQ(mkfifo(file.c_str(), 0600), 0); }, "is a pipe"},
      {[&] {
         std::filesystem::remove(file);
         ASSERT_EQ(symlink("/dev/zero", file.c_str()), 0);
       },
       "is a device"},
      {[&] {
         std::filesystem::remove(file);
         std::filesystem::create_directory(file);
       },
       "is a folder"}};
  std::uint64_t refused = 0;
  for (const auto& [prepare, said] : cases) {
    prepare();
    daemon.child->Signal(SIGHUP);
    ++refused;
    ASSERT_TRUE(LogSays(daemon, said) && daemon.child->Running()) << said << daemon.Log();
    ASSERT_EQ(control.CounterSoon("config.reloads_refused", refused), refused) << said;
  }
  v1::Request list;
  list.mutable_list();
  EXPECT_EQ(control.Ask(list).list().presets_size(), 1);
  std::filesystem::remove(file);
  put(good);
  daemon.child->Signal(SIGHUP);
  EXPECT_EQ(control.CounterSoon("config.reloads", 1), 1U) << daemon.Log();
}

TEST(ProcessTest, APresetIsNotNamedLikeAStyle) {
  TemporaryFolder folder;
  const std::string weights = folder / "weights.safetensors", file = folder / "stage.toml";
  WriteRandomWeights(weights);
  const auto check = [&](const std::string& preset) {
    WriteText(file, "[presets]\n\n" + preset + " = { s1 = 0.3 }\n");
    return RunStyled(folder, {"--weights", weights, "--check-config", file});
  };
  EXPECT_EQ(check("mild").code, 0);
  Outcome outcome = check("style2");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.text.find(file + ":3: presets.style2: \"style2\" is a style's name; expected "
                                     "another"),
            std::string::npos)
      << outcome.text;
  outcome = check("S1");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.text.find(file + ":3: presets.S1: \"S1\" is a style's name too, an alias of "
                                     "\"style1\"; expected another"),
            std::string::npos)
      << outcome.text;
}

TEST(ProcessTest, APortInUseIsSaidClearly) {
  Daemon daemon;
  TemporaryFolder folder;
  const std::vector<std::string> common{"--weights", daemon.folder / "weights.safetensors"};
  const auto with = [&](std::vector<std::string> settings) {
    settings.insert(settings.begin(), common.begin(), common.end());
    return RunStyled(folder, settings);
  };
  Outcome outcome = with({"--set", "source.0.listen=" + daemon.udp});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.text.find("source.0.listen: udp " + daemon.udp + ": in use"), std::string::npos)
      << outcome.text;
  outcome = with({"--set", "source.0.listen=127.0.0.1:0", "--set", "source.1.listen=127.0.0.1:0",
                  "--set", "publish.address=" + daemon.publish});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.text.find("publish.address: " + daemon.publish + ": in use"), std::string::npos)
      << outcome.text;
}

TEST(ProcessTest, ALockFileThatCannotBeWrittenIsSaidWithItsReason) {
  TemporaryFolder folder;
  const std::string weights = folder / "weights.safetensors", path = folder / "publish";
  WriteRandomWeights(weights);
  std::filesystem::create_directory(path + ".lock");
  const Outcome outcome =
      RunStyled(folder, {"--weights", weights, "--set", "source.0.listen=127.0.0.1:0", "--set",
                         "source.1.listen=127.0.0.1:0", "--set", "publish.address=ipc://" + path});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.text.find("cannot write its lock file " + path + ".lock: Is a directory"),
            std::string::npos)
      << outcome.text;
}

// As from an unset shell variable: the user did not ask for a running daemon.
TEST(ProcessTest, AFileWithoutANameEndsWithTwoAndStartsNoDaemon) {
  TemporaryFolder folder;
  for (const std::string name : {"--config", "--check-config", "--replay"}) {
    std::vector<std::string> arguments{name, ""};
    // If it were not refused, the daemon would still not start: these weights do not exist.
    arguments.insert(arguments.end(), {"--weights", folder / "none"});
    if (name == "--replay") arguments.insert(arguments.end(), {"--replay-to", folder / "to"});
    const Outcome outcome = RunStyled(folder, arguments);
    EXPECT_EQ(outcome.code, 2) << name;
    EXPECT_NE(outcome.text.find("styled: " + name + ": found an empty name, expected a file"),
              std::string::npos)
        << outcome.text;
  }
}

TEST(ProcessTest, BadArgumentsAndConfigurationsEndWithTwoAndTheReason) {
  TemporaryFolder folder;
  const std::string file = folder / "bad.toml";
  WriteText(file, "[publish]\naddress = \"tcp://127.0.0.1:7001\"\nhigh_water_marc = 3\n");
  Outcome outcome = RunStyled(folder, {"--check-config", file});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.text.find(file + ":3: publish.high_water_marc: unknown key, nearest is "
                                     "\"high_water_mark\""),
            std::string::npos)
      << outcome.text;
  WriteText(file, "[publish]\nhigh_water_mark = 10\n");
  const std::string weights = folder / "weights.safetensors";
  WriteRandomWeights(weights);
  EXPECT_EQ(RunStyled(folder, {"--check-config", file, "--weights", weights}).code, 0);
  const std::string natnet =
      "[[source]]\nname = \"a\"\ntype = \"natnet\"\nserver = \"127.0.0.1\"\n"
      "interface = \"no-such-if0\"\n";
  WriteText(file, natnet);
  outcome = RunStyled(folder, {"--check-config", file, "--weights", weights});
  EXPECT_EQ(outcome.code, 0) << "it may come later";
  EXPECT_NE(outcome.text.find("warning: source.0.interface: \"no-such-if0\""), std::string::npos)
      << outcome.text;
  WriteText(file, "[record]\nfile = \"" + weights + "/takes/%F.styrec\"\n");
  outcome = RunStyled(folder, {"--check-config", file, "--weights", weights});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.text.find("record.file: "), std::string::npos) << outcome.text;
  WriteText(file, "[presets]\nmild = { nostyle = 0.3 }\n");
  outcome = RunStyled(folder, {"--weights", weights, "--check-config", file});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.text.find(file + ":2: presets.mild: no style \"nostyle\""), std::string::npos)
      << outcome.text;
  WriteText(file, "");
  outcome =
      RunStyled(folder, {"--check-config", file}, {{"STYLED_PUBLISH_HIGH_WATER_MARK", "lots"}});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.text.find("STYLED_PUBLISH_HIGH_WATER_MARK: publish.high_water_mark: expected a "
                              "whole number from 1 to 100000"),
            std::string::npos)
      << outcome.text;
  EXPECT_EQ(RunStyled(folder, {"--no-such-option"}).code, 2);
  outcome = RunStyled(folder, {"--set", "publish.address=tcp://0.0.0.0:7001"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.text.find("not authenticated"), std::string::npos) << outcome.text;
  outcome = RunStyled(folder, {"--weights", folder / "none.safetensors"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.text.find("none.safetensors"), std::string::npos) << outcome.text;
}

TEST(ProcessTest, TroubleIsLoggedOnceASecondWithACount) {
  Daemon daemon;
  const UdpLink link(daemon.udp);
  Paced(200, 200, [&](int) { link.Send(Bytes(10, std::byte{1})); });
  EXPECT_TRUE(LogSays(daemon, "source.too_short:", 3));
  Sleep(1.2);
  const std::string log = daemon.Log();
  int lines = 0;
  for (std::size_t at = log.find("source.too_short:"); at != std::string::npos;
       at = log.find("source.too_short:", at + 1)) {
    ++lines;
  }
  EXPECT_LE(lines, 4);
  EXPECT_NE(log.find("200 in all"), std::string::npos) << log;
}

}  // namespace
}  // namespace styled::support
