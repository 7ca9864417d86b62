// The daemon under a service manager, whose socket the test simulates.
#include <gtest/gtest.h>
#include <signal.h>

#include "tests/support/daemon.h"
#include "tests/support/datagrams.h"
#include "tests/support/frozen_thread.h"
#include "tests/support/rig.h"

namespace styled::support {
namespace {

struct Service {
  explicit Service(const std::string& extra = "")
      : daemon({}, extra, {{"NOTIFY_SOCKET", manager.path()}, {"WATCHDOG_USEC", "60000000"}}) {}
  Datagrams manager;
  Daemon daemon;
};

TEST(ServiceTest, SaysReadyOnceSourcesAreOpenAndStoppingAtTheEnd) {
  Service service;
  EXPECT_EQ(service.manager.Next(5), "STATUS=reading the weights");
  EXPECT_EQ(service.manager.Next(5), "READY=1\nSTATUS=ready");
  const UdpLink link(service.daemon.udp);
  Rig rig("a");
  link.Send(rig.Body());
  for (int i = 0; i < 10; ++i) link.Send(rig.Frame());
  EXPECT_TRUE(service.manager.Await("STATUS=1 performers, "));
  service.daemon.child->Signal(SIGTERM);
  EXPECT_TRUE(service.manager.Await("STOPPING=1"));
  EXPECT_EQ(service.daemon.child->Wait(10).value_or(-1), 0);
}

TEST(ServiceTest, WhoCannotStartIsNeverReadyAndSaysWhy) {
  Service running;
  Datagrams manager;
  const TemporaryFolder folder;
  Child child({Binary(), "--weights", running.daemon.folder / "weights.safetensors", "--set",
               "source.0.listen=" + running.daemon.udp},
              folder / "log", {{"NOTIFY_SOCKET", manager.path()}});
  EXPECT_EQ(child.Wait(20).value_or(-1), 1);
  std::string last;
  while (const auto next = manager.Next()) {
    EXPECT_EQ(next->find("READY=1"), std::string::npos);
    last = *next;
  }
  EXPECT_EQ(last,
            "STATUS=source.0.listen: udp " + running.daemon.udp + ": in use (another styled?)");
}

TEST(ServiceTest, AReloadIsBetweenReloadingAndReadyWhateverComesOfIt) {
  Service service("[presets]\nmild = { s1 = 0.3 }\n");
  ASSERT_TRUE(service.manager.Await("READY=1"));
  service.daemon.child->Signal(SIGHUP);
  const auto reloading = service.manager.Await("RELOADING=1");
  ASSERT_TRUE(reloading);
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  const auto at = reloading->find("MONOTONIC_USEC=");
  ASSERT_NE(at, std::string::npos);
  const long long stated_us = std::stoll(reloading->substr(at + 15));
  EXPECT_GT(stated_us, 0);
  EXPECT_LE(stated_us, now.tv_sec * 1'000'000LL + now.tv_nsec / 1000);
  EXPECT_EQ(service.manager.Await("READY=1"), "READY=1\nSTATUS=reloaded");

  service.daemon.Configure("[presets]\nmild = { nostyle = 0.3 }\n");
  service.daemon.child->Signal(SIGHUP);
  ASSERT_TRUE(service.manager.Await("RELOADING=1"));
  const auto ready = service.manager.Await("READY=1");
  ASSERT_TRUE(ready);
  EXPECT_NE(ready->find("STATUS=reload refused: "), std::string::npos) << *ready;
  const auto later = service.manager.Await("frames/s");
  EXPECT_NE(later->find("the last reload was refused: "), std::string::npos) << *later;
}

TEST(ServiceTest, AHungPipelineStarvesTheWatchdogAlthoughTheSupervisorIsWell) {
  Service service;
  ASSERT_TRUE(service.manager.Await("READY=1"));
  ASSERT_TRUE(service.manager.Await("WATCHDOG=1")) << "an idle daemon is a living one";
  {
    const FrozenThread hung(service.daemon.child->pid(), "pipeline");
    if (!hung.frozen()) GTEST_SKIP() << hung.error();
    // The first reports may still cover the time before the freeze.
    ASSERT_TRUE(service.manager.Await("frames/s"));
    ASSERT_TRUE(service.manager.Await("frames/s"));
    for (int seconds = 0; seconds < 3;) {
      const auto next = service.manager.Next(20);
      ASSERT_TRUE(next) << "the supervisor goes on";
      EXPECT_EQ(next->find("WATCHDOG=1"), std::string::npos);
      if (next->find("frames/s") != std::string::npos) ++seconds;
    }
  }
  EXPECT_TRUE(service.manager.Await("WATCHDOG=1")) << "alive again, it is said so";
}

// systemd sends SIGABRT when the watchdog expires.
TEST(ServiceTest, AHungPipelineDoesNotSurviveSigabrt) {
  Service service;
  ASSERT_TRUE(service.manager.Await("READY=1"));
  FrozenThread hung(service.daemon.child->pid(), "pipeline");
  if (!hung.frozen()) GTEST_SKIP() << hung.error();
  service.daemon.child->Signal(SIGABRT);
  hung.AwaitDeath();
  EXPECT_EQ(service.daemon.child->Wait(20).value_or(-1), 128 + SIGABRT);
}

TEST(ServiceTest, StderrThatIsNotTheJournalsIsForPeople) {
  Daemon daemon({}, "", {{"JOURNAL_STREAM", "1:1"}});
  EXPECT_NE(daemon.Log().find(" info styled "), std::string::npos) << daemon.Log();
}

}  // namespace
}  // namespace styled::support
