// How the clock is watched, with a ptp4l that the test plays.
#include "daemon/runtime/clock_watch.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <vector>

#include "tests/support/temporary_folder.h"

namespace styled::runtime {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

// Answers questions in its domain, as a clock with two ports.
class Ptp4l {
 public:
  Ptp4l(const std::string& file, std::uint8_t domain) : domain_(domain) {
    fd_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0);
    sockaddr_un own{};
    own.sun_family = AF_UNIX;
    std::strcpy(own.sun_path, file.c_str());
    std::filesystem::remove(file);
    EXPECT_EQ(bind(fd_, reinterpret_cast<const sockaddr*>(&own), sizeof own), 0);
  }
  ~Ptp4l() { close(fd_); }
  Ptp4l(const Ptp4l&) = delete;
  Ptp4l& operator=(const Ptp4l&) = delete;

  // Returns how many questions came.
  int Answer() {
    int questions = 0;
    std::array<std::byte, 200> question;
    sockaddr_un from{};
    socklen_t size = sizeof from;
    while (recvfrom(fd_, question.data(), question.size(), 0, reinterpret_cast<sockaddr*>(&from),
                    &size) == 54) {
      ++questions;
      if (question[4] == std::byte{domain_}) {
        for (const int port : {1, 2}) Reply(question, port, from, size);
      }
      size = sizeof from;
    }
    return questions;
  }
  std::array<std::uint8_t, 2> ports{6, 9};  // MASTER, SLAVE
  std::uint8_t leader = 7;                  // last byte of the identity

 private:
  void Reply(const std::array<std::byte, 200>& question, int port, const sockaddr_un& to,
             socklen_t to_size) const {
    const int id = std::to_integer<int>(question[53]);
    if (id != 4 && port > 1) return;
    std::vector<std::byte> reply(question.begin(), question.begin() + 54);
    reply.resize(54 + 40);
    reply[46] = std::byte{2};
    reply[51] = std::byte{42};
    if (id == 1) reply[54 + 1] = std::byte{3};
    if (id == 2) {
      for (int i = 0; i < 7; ++i) reply[static_cast<std::size_t>(54 + 24 + i)] = std::byte{1};
      reply[54 + 31] = std::byte{leader};
    }
    if (id == 4) {
      reply[54 + 9] = static_cast<std::byte>(port);
      reply[54 + 10] = std::byte{ports[static_cast<std::size_t>(port - 1)]};
    }
    (void)sendto(fd_, reply.data(), reply.size(), 0, reinterpret_cast<const sockaddr*>(&to),
                 to_size);
  }
  int fd_ = -1;
  std::uint8_t domain_;
};

struct ClockWatchTest : testing::Test {
  // Seconds until the watch knows the clock, at most 40.
  int Wait(Ptp4l& ptp4l) {
    for (int second = 0; second < 40; ++second) {
      watch.Update(now_ns += kSecond);
      (void)ptp4l.Answer();
      if (watch.discipline().ptp) return second;
    }
    return -1;
  }
  support::TemporaryFolder folder;
  const std::string file = folder / "ptp4l";
  ClockWatch watch{file};
  std::int64_t now_ns = 0;
};

TEST_F(ClockWatchTest, OnlyTheKernelIsQueriedWithoutPtp4l) {
  for (int i = 0; i < 3; ++i) watch.Update(now_ns += kSecond);
  EXPECT_FALSE(watch.discipline().ptp);
  if (watch.discipline().known) EXPECT_GE(watch.discipline().max_error_s, 0);
}

TEST_F(ClockWatchTest, TheUsualDomainsAreFoundAtOnceAndAnyWithin20Seconds) {
  for (const auto& [domain, seconds] : {std::pair{0, 3}, {127, 3}, {24, 6}, {126, 20}}) {
    Ptp4l ptp4l(file, static_cast<std::uint8_t>(domain));
    const int waited = Wait(ptp4l);
    EXPECT_TRUE(waited >= 0 && waited <= seconds) << domain << " after " << waited;
    ASSERT_TRUE(watch.discipline().ptp);
    const PtpClock& ptp = *watch.discipline().ptp;
    EXPECT_EQ(ptp.domain, domain);
    EXPECT_EQ(ptp.port, ptp::PortState::kSlave) << "of two ports the one that follows";
    EXPECT_EQ(ptp::Text(ptp.parent.leader), "010101.0101.010107");
    EXPECT_EQ(ptp.current.steps_removed, 3);
    watch.Update(now_ns += kSecond);       // the last answers
    watch.Update(now_ns += 60 * kSecond);  // gone, and another one comes
    EXPECT_FALSE(watch.discipline().ptp);
  }
}

TEST_F(ClockWatchTest, ChangedAndRemovedClocksAreSeen) {
  {
    Ptp4l ptp4l(file, 0);
    ASSERT_GE(Wait(ptp4l), 0);
    ptp4l.ports = {6, 6};
    ptp4l.leader = 9;
    for (int i = 0; i < 2; ++i) {
      watch.Update(now_ns += kSecond);
      EXPECT_EQ(ptp4l.Answer(), 4) << "questions a second";
    }
    watch.Update(now_ns += kSecond);
    EXPECT_EQ(watch.discipline().ptp->port, ptp::PortState::kMaster);
    EXPECT_EQ(ptp::Text(watch.discipline().ptp->parent.leader), "010101.0101.010109");
    for (int i = 0; i < 4; ++i) watch.Update(now_ns += kSecond);  // it hangs
    EXPECT_FALSE(watch.discipline().ptp);
    for (int i = 0; i < 10; ++i) watch.Update(now_ns += kSecond);  // its queue is full
  }
  watch.Update(now_ns += kSecond);
  Ptp4l again(file, 0);
  EXPECT_GE(Wait(again), 0);
}

}  // namespace
}  // namespace styled::runtime
