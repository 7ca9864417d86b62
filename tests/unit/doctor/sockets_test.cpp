#include "clients/doctor/sockets.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>

#include "clients/doctor/listener.h"

namespace styled::doctor {
namespace {

// As a kernel 6.1 wrote them (x86-64: addresses are words in little-endian order).
constexpr std::string_view kUdp =
    "   sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout "
    "inode ref pointer drops            \n"
    " 3458: 0100007F:1B58 00000000:0000 07 00000000:00000300 00:00000000 00000000     0        0 "
    "463354 2 00000000e418ab69 17       \n"
    " 3782: 00000000:2623 00000000:0000 07 00000000:00000000 00:00000000 00000000  1000        0 "
    "465796 2 000000000de1fe1f 0        \n"
    "  bad: 0100007F 00000000:0000 07 0:0 0 0 0 0 1\n"
    " 3783: 0100007F:XYZW 00000000:0000 07 00000000:00000000 00:00000000 00000000  1000        0 "
    "465797 2 000000000de1fe1f 0        \n"
    "short\n";
constexpr std::string_view kUdp6 =
    "  sl  local_address                         remote_address                        st tx_queue "
    "rx_queue tr tm->when retrnsmt   uid  timeout inode ref pointer drops\n"
    "  911: 00000000000000000000000001000000:1B39 00000000000000000000000000000000:0000 07 "
    "00000000:00000000 00:00000000 00000000     0        0 4711 2 0000000000000000 3\n";
constexpr std::string_view kTcp =
    "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout "
    "inode\n"
    "   0: 0100007F:1B5A 00000000:0000 0A 00000000:00000000 00:00000000 00000000     0        0 "
    "4712 1 0000000000000000 100 0 0 10 0\n"
    "   1: 0100007F:1B5A 0100007F:D431 01 00000000:00000000 00:00000000 00000000     0        0 "
    "4713 1 0000000000000000 20 4 30 10 -1\n";

TEST(SocketsTest, RowsThatCannotBeReadAreLeftOut) {
  EXPECT_TRUE(ParseSocketTable("", false).empty());
  EXPECT_TRUE(ParseSocketTable("one line of words alone", false).empty());
  EXPECT_EQ(ParseSocketTable(kUdp, false).size(), 2U);
}

TEST(SocketsTest, UdpRowsHaveAddressQueueAndDrops) {
  const auto rows = ParseSocketTable(kUdp, false);
  EXPECT_EQ(ToString(rows.at(0).local), "127.0.0.1:7000");
  EXPECT_EQ(rows[0].inode, 463354U);
  EXPECT_EQ(rows[0].waiting_bytes, 0x300U);
  EXPECT_EQ(rows[0].drops, 17U);
  EXPECT_EQ(ToString(rows[1].local), "0.0.0.0:9763");
  EXPECT_EQ(ToString(ParseSocketTable(kUdp6, false).at(0).local), "[::1]:6969");
}

TEST(SocketsTest, OfTcpOnlyListenersCount) {
  const auto rows = ParseSocketTable(kTcp, true);
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(ToString(rows[0].local), "127.0.0.1:7002");
  EXPECT_EQ(rows[0].inode, 4712U);
}

TEST(SocketsTest, OursAreFoundWithOurName) {
  const Descriptor fd(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_storage address;
  socklen_t size = ToSocket({"127.0.0.1", 0}, address);
  ASSERT_EQ(bind(fd.get(), reinterpret_cast<sockaddr*>(&address), size), 0);
  getsockname(fd.get(), reinterpret_cast<sockaddr*>(&address), &size);
  const auto sockets = ListSockets();
  const auto ours = std::ranges::find_if(
      sockets, [&](const BoundSocket& s) { return !s.stream && s.local == FromSocket(address); });
  ASSERT_NE(ours, sockets.end());
  EXPECT_EQ(ours->pid, getpid());
  EXPECT_EQ(ours->program, "doctor_test");
  EXPECT_EQ(Holder(*ours), "doctor_test (pid " + std::to_string(getpid()) + ")");
}

TEST(SocketsTest, OfStrangersItIsSaidHowToFindThem) {
  BoundSocket socket;
  socket.local.port = 9763;
  EXPECT_NE(Holder(socket).find("sudo ss -ulpn 'sport = :9763'"), std::string::npos);
}

}  // namespace
}  // namespace styled::doctor
