#include "daemon/runtime/notify.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstring>

#include "tests/support/datagrams.h"

namespace styled::runtime {
namespace {

TEST(NotifyTest, EveryMessageIsTheManagersOwn) {
  support::Datagrams manager;
  Notifier notifier(manager.path());
  notifier.SetStatus("reading the weights");
  notifier.Ready("all is open");
  notifier.Reloading(1'234'567'999);
  notifier.Alive();
  notifier.Stopping();
  EXPECT_EQ(manager.Next(), "STATUS=reading the weights");
  EXPECT_EQ(manager.Next(), "READY=1\nSTATUS=all is open");
  EXPECT_EQ(manager.Next(), "RELOADING=1\nMONOTONIC_USEC=1234567\nSTATUS=reloading");
  EXPECT_EQ(manager.Next(), "WATCHDOG=1");
  EXPECT_EQ(manager.Next(), "STOPPING=1\nSTATUS=stopping");
  EXPECT_EQ(manager.Next(), std::nullopt);
}

TEST(NotifyTest, AFilesTextCannotInjectNotifications) {
  support::Datagrams manager;
  Notifier notifier(manager.path());
  notifier.SetStatus("stage.toml:1: \"\nMAINPID=1\nREADY=1\"");
  EXPECT_EQ(manager.Next(), "STATUS=stage.toml:1: \" MAINPID=1 READY=1\"");
}

// READY=1 gets through, whatever a complaint quotes: a datagram that is too long would be lost
// whole.
TEST(NotifyTest, AnEndlessComplaintIsCutShort) {
  support::Datagrams manager;
  Notifier notifier(manager.path());
  notifier.Ready("reload refused: \xFF" + std::string(1 << 20, 'x'));
  const auto got = manager.Next();
  ASSERT_TRUE(got);
  EXPECT_TRUE(got->starts_with("READY=1\nSTATUS=reload refused: \xEF\xBF\xBDxxx"));
  EXPECT_LT(got->size(), 1100U);
}

TEST(NotifyTest, AnAbstractAddressIsReached) {
  const int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  // Bound without a name, a socket gets an unused abstract one.
  ASSERT_EQ(bind(fd, reinterpret_cast<const sockaddr*>(&name), sizeof(sa_family_t)), 0);
  socklen_t length = sizeof name;
  ASSERT_EQ(getsockname(fd, reinterpret_cast<sockaddr*>(&name), &length), 0);
  const std::string given(name.sun_path + 1, length - offsetof(sockaddr_un, sun_path) - 1);
  Notifier("@" + given).Alive();
  std::array<char, 100> got{};
  EXPECT_EQ(recv(fd, got.data(), got.size(), MSG_DONTWAIT), 10);
  EXPECT_STREQ(got.data(), "WATCHDOG=1");
  close(fd);
}

TEST(NotifyTest, WithoutAManagerNothingHappens) {
  for (const std::string address :
       {std::string(), std::string("relative"), std::string("/nowhere/at/all"),
        std::string("@nobody-listens-here"), "/" + std::string(300, 'x')}) {
    Notifier notifier(address);
    const auto begin = std::chrono::steady_clock::now();
    notifier.Ready("ready");
    notifier.Alive();
    // The daemon waits for no manager; for one that does not read, a second.
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(900)) << address;
  }
}

}  // namespace
}  // namespace styled::runtime
