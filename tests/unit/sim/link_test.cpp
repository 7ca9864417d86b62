#include "sim/player/link.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <string>
#include <thread>

namespace styled::player {
namespace {

// A UDP socket on loopback, at a port of the system's choice.
class Receiver {
 public:
  explicit Receiver(std::uint16_t port = 0) : fd_(socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    inet_pton(AF_INET, "127.0.0.1", &address.sin_addr);
    socklen_t size = sizeof address;
    EXPECT_EQ(bind(fd_, reinterpret_cast<sockaddr*>(&address), size), 0);
    getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size);
    this->port = ntohs(address.sin_port);
  }
  ~Receiver() { close(fd_); }
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;

  // How many datagrams come until none has for a second, or there are `wanted`.
  int Count(int wanted) const {
    int count = 0;
    pollfd waiting{fd_, POLLIN, 0};
    std::array<char, 64> bytes{};
    while (count < wanted && poll(&waiting, 1, 1000) > 0) {
      if (recv(fd_, bytes.data(), bytes.size(), 0) > 0) ++count;
    }
    return count;
  }

  std::uint16_t port = 0;

 private:
  int fd_;
};

TEST(Link, ADeadUdpPortIsNoticedAndEveryDatagramLeavesAllTheSame) {
  std::uint16_t port = 0;
  {
    const Receiver gone;
    port = gone.port;
  }
  auto link = Connect("udp://127.0.0.1:" + std::to_string(port), 0);
  ASSERT_TRUE(link.ok());
  const std::array<std::byte, 5> datagram{};
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(link.value()->Send(datagram).ok()) << i;
  // The kernel reports it at once, or a little later.
  for (int i = 0; i < 1000 && link.value()->refused() < 50; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_EQ(link.value()->refused(), 50U);
  // One that comes later gets all that is sent from then on: no error takes a datagram's place.
  const Receiver late(port);
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(link.value()->Send(datagram).ok()) << i;
  EXPECT_EQ(late.Count(50), 50);
  EXPECT_EQ(link.value()->refused(), 50U);
}

TEST(Link, AServerOfTheNewestSendsToThatOneAlone) {
  for (const Audience audience : {Audience::kAllWhoSpeak, Audience::kNewest}) {
    std::string bound;
    auto server = Listen("udp://127.0.0.1:0", &bound, audience);
    ASSERT_TRUE(server.ok());
    const std::array<std::byte, 5> datagram{};
    std::array<std::byte, 64> got{};
    std::array<std::unique_ptr<Link>, 2> clients;
    for (auto& client : clients) {
      client = std::move(Connect(bound, 0).value());
      ASSERT_TRUE(client->Send(datagram).ok());
      while (server.value()->Receive(got) == 0) std::this_thread::yield();
    }
    ASSERT_TRUE(server.value()->Send(datagram).ok());
    while (clients[1]->Receive(got) == 0) std::this_thread::yield();
    // Loopback keeps the order: what was sent to the first client is there by now.
    EXPECT_EQ(clients[0]->Receive(got) > 0, audience == Audience::kAllWhoSpeak);
  }
}

class Flaky final : public Link {
 public:
  Status Send(std::span<const std::byte> datagram) override {
    if (fails) return Status::Error("no route");
    sent += static_cast<int>(datagram.size());
    return Status::Ok();
  }
  bool fails = false;
  int sent = 0;
};

TEST(Link, OneOfSeveralTargetsThatFailsIsToldOnceAndTheOthersGetAll) {
  auto first = std::make_unique<Flaky>(), second = std::make_unique<Flaky>();
  Flaky &a = *first, &b = *second;
  std::vector<std::string> told;
  std::vector<NamedLink> links;
  links.push_back({"udp://a:1", std::move(first)});
  links.push_back({"udp://b:2", std::move(second)});
  const auto all = ToAll(std::move(links), [&told](const std::string& url, const std::string& why) {
    told.push_back(url + " " + why);
  });
  const std::array<std::byte, 1> datagram{};
  a.fails = true;
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(all->Send(datagram).ok());
  EXPECT_EQ(b.sent, 3);
  EXPECT_EQ(told, (std::vector<std::string>{"udp://a:1 no route"}));
  a.fails = false;
  EXPECT_TRUE(all->Send(datagram).ok());
  a.fails = b.fails = true;
  const Status none = all->Send(datagram);
  EXPECT_FALSE(none.ok());
  EXPECT_EQ(none.message(), "udp://b:2: no route");
  EXPECT_EQ(told.size(), 3U) << "again, after it had sent in between";
}

// A TCP socket on loopback that one peer connects to.
class Listener {
 public:
  explicit Listener(std::uint16_t port) : fd_(socket(AF_INET, SOCK_STREAM, 0)) {
    const int on = 1;
    setsockopt(fd_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    inet_pton(AF_INET, "127.0.0.1", &address.sin_addr);
    socklen_t size = sizeof address;
    EXPECT_EQ(bind(fd_, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(listen(fd_, 1), 0);
    getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size);
    this->port = ntohs(address.sin_port);
  }
  ~Listener() {
    close(peer_);
    close(fd_);
  }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  void Accept() { peer_ = accept(fd_, nullptr, nullptr); }
  int Byte() const {
    char byte = 0;
    return recv(peer_, &byte, 1, 0) == 1 ? byte : -1;
  }
  std::uint16_t port = 0;

 private:
  int fd_, peer_ = -1;
};

TEST(Link, ATcpTargetThatIsLostGetsRecordsAgainOnceItIsBack) {
  auto target = std::make_unique<Listener>(0);
  const std::uint16_t port = target->port;
  const auto link = Connect("tcp://127.0.0.1:" + std::to_string(port), 1000);
  ASSERT_TRUE(link.ok());
  const std::array<std::byte, 1> before{std::byte{1}}, gone{std::byte{2}}, back{std::byte{3}};
  target->Accept();
  ASSERT_TRUE(link.value()->Send(before).ok());
  EXPECT_EQ(target->Byte(), 1);
  target.reset();
  Status lost = Status::Ok();
  for (int i = 0; i < 100 && lost.ok(); ++i) {
    lost = link.value()->Send(gone);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ASSERT_FALSE(lost.ok());
  EXPECT_EQ(lost.message().find("sending by TCP: "), 0U) << lost.message();
  EXPECT_EQ(link.value()->Send(gone).message(), lost.message()) << "until it is back";
  target = std::make_unique<Listener>(port);
  Status sent = lost;
  for (int i = 0; i < 1000 && !sent.ok(); ++i) {
    sent = link.value()->Send(back);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ASSERT_TRUE(sent.ok()) << sent.message();
  target->Accept();
  EXPECT_EQ(target->Byte(), 3) << "nothing of what was sent meanwhile";
}

}  // namespace
}  // namespace styled::player
