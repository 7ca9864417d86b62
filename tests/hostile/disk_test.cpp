// A disk that does not answer, and a library of a thousand styles: neither the sign of life nor a
// signal waits for them.
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>

#include "tests/e2e/examples.h"
#include "tests/hostile/stage.h"
#include "tests/support/child.h"

namespace styled::hostile {
namespace {

TEST(DiskTest, AHungDiskDelaysNoClient) {
  constexpr double kFsync_s = 4;
  ServiceManager manager;
  const support::TemporaryFolder folder;
  support::Daemon daemon({"state.dir='" + (folder / "state") + "'"}, "",
                         {{"NOTIFY_SOCKET", manager.path()},
                          {"WATCHDOG_USEC", "10000000"},
                          {"LD_PRELOAD", SLOW_DISK},
                          {"STYLED_FSYNC_S", std::to_string(kFsync_s)}});
  support::ControlClient control(daemon.control);
  const auto begin = Clock::now();
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(control.SetStyle("rig.anna", i % 2 == 0 ? "style1" : "style2").code(), v1::CODE_OK);
    support::Sleep(0.2);
  }
  const auto asked = Clock::now();
  daemon.child->Signal(SIGHUP);
  support::Sleep(1.5);
  EXPECT_LT(manager.LongestSilence_s(begin), 1);
  // The files thread is in fsync: the reload waits for it, and nothing else does.
  EXPECT_LT(manager.Until_s("RELOADING=1", asked, 20), 2 * kFsync_s + 1);
  const auto stopped = Clock::now();
  daemon.child->Signal(SIGTERM);
  EXPECT_LT(manager.Until_s("STOPPING=1", stopped, 20), 1) << daemon.Log();
  EXPECT_EQ(daemon.child->Wait(20).value_or(-1), 0) << daemon.Log();
  EXPECT_NE(support::ReadText(folder / "state/performers.toml").find("rig.anna"), std::string::npos)
      << "the last settings were written";
}

TEST(DiskTest, AnEndlessFsyncEndsInAnErrorThatIsTold) {
  const support::TemporaryFolder folder;
  support::Daemon daemon({"state.dir='" + (folder / "state") + "'"}, "",
                         {{"LD_PRELOAD", SLOW_DISK}, {"STYLED_FSYNC_S", "1000"}});
  support::ControlClient control(daemon.control);
  EXPECT_EQ(control.SetStyle("rig.anna", "style1").code(), v1::CODE_OK);
  support::Sleep(0.5);
  daemon.child->Signal(SIGTERM);
  EXPECT_EQ(daemon.child->Wait(30).value_or(-1), 1);
  EXPECT_NE(daemon.Log().find("a disk does not answer: the last settings may be lost"),
            std::string::npos)
      << daemon.Log();
}

TEST(DiskTest, ALibraryOfAThousandStylesKeepsNoSignalWaiting) {
  Stage stage;
  const Loot loot = CollectLoot(stage.daemon(), "rig.victim");
  const std::string name = "\"name\": \"loot\"";
  const std::size_t at = loot.style_file.find(name);
  ASSERT_NE(at, std::string::npos) << loot.style_file.substr(0, 300);
  for (int i = 0; i < 1000; ++i) {
    const std::string style = "s" + std::to_string(i);
    std::string file = loot.style_file;
    file.replace(at, name.size(), "\"name\": \"" + style + "\"");
    support::WriteText(stage.folder() / ("kept0/library/" + style + ".json"), file);
  }
  const Measured measured = stage.Watch([] { support::Sleep(3); });
  EXPECT_LT(measured.silence_s, 1);
  EXPECT_LT(measured.reload_s, 1);
  EXPECT_EQ(measured.received, measured.victim);
  EXPECT_TRUE(measured.one_leads);
  EXPECT_LT(measured.both_lead_s, 2);
  // The files thread reads them for as long as it takes; a busy machine needs more than the 3 s.
  std::size_t styles = 0;
  for (int waited_s = 0; waited_s < 60 && styles < 1000; ++waited_s) {
    if (waited_s > 0) support::Sleep(1);
    styles = support::StylesOf(stage.daemon()).size();
  }
  EXPECT_GE(styles, 1000U) << stage.daemon().Log();
}

}  // namespace
}  // namespace styled::hostile
