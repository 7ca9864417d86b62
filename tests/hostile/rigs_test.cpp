// Each type of source (proto/rigs/types.h) gets input that is not a rig's: noise of every size, its
// own stand-in's frames damaged, connections that never finish, servers that send garbage. The
// properties of stage.h hold. A new type is attacked from its first day: the rows are the table's.
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <random>

#include "proto/rigs/types.h"
#include "tests/hostile/stage.h"
#include "tests/support/child.h"

namespace styled::hostile {
namespace {

constexpr double kNoise_s = 1.5;
constexpr std::size_t kLargestDatagram = 65507;

using support::Bytes;

Bytes Noise(std::mt19937& random, std::size_t most) {
  Bytes bytes(random() % (random() % 4 == 0 ? most : 300) + 1);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
  return bytes;
}

// Stands in for a server that daemons connect to, or ask by UDP: it answers everything with noise.
class NoisyServer {
 public:
  explicit NoisyServer(bool stream)
      : stream_(stream), fd_(socket(AF_INET, stream ? SOCK_STREAM : SOCK_DGRAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    EXPECT_EQ(bind(fd_, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size), 0);
    if (stream) EXPECT_EQ(listen(fd_, 8), 0);
    address_ = "127.0.0.1:" + std::to_string(ntohs(address.sin_port));
    thread_ = std::jthread([this](const std::stop_token& stop) { Answer(stop); });
  }
  ~NoisyServer() {
    thread_.request_stop();
    thread_.join();
    close(fd_);
  }
  const std::string& address() const { return address_; }
  std::uint64_t answered() const { return answered_; }

 private:
  void Answer(const std::stop_token& stop) {
    std::mt19937 random(5);
    std::vector<char> heard(kLargestDatagram);
    while (!stop.stop_requested()) {
      pollfd waiting{fd_, POLLIN, 0};
      if (poll(&waiting, 1, 20) <= 0) continue;
      if (!stream_) {
        sockaddr_in from{};
        socklen_t size = sizeof from;
        recvfrom(fd_, heard.data(), heard.size(), 0, reinterpret_cast<sockaddr*>(&from), &size);
        for (int i = 0; i < 20; ++i) {
          const Bytes noise = Noise(random, kLargestDatagram);
          sendto(fd_, noise.data(), noise.size(), 0, reinterpret_cast<sockaddr*>(&from), size);
        }
        ++answered_;
        continue;
      }
      const int client = accept(fd_, nullptr, nullptr);
      for (int i = 0; i < 50; ++i) {
        const Bytes noise = Noise(random, 100'000);
        send(client, noise.data(), noise.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
      }
      close(client);
      ++answered_;
    }
  }
  bool stream_;
  int fd_;
  std::string address_;
  std::atomic<std::uint64_t> answered_{0};
  std::jthread thread_;
};

// The source of a type, by its name in the configuration.
std::string SourceTable(const rigs::SourceType& type, const std::string& server) {
  std::string table = "[[source]]\nname = \"" + std::string(type.name) + "\"\ntype = \"" +
                      std::string(type.name) + "\"\n";
  if (!type.connects()) table += "listen = \"127.0.0.1:0\"\n";
  if (type.rig->asks_server || !server.empty()) table += "server = \"" + server + "\"\n";
  if (type.rig->face_only) table += "merge_into = \"rig.victim\"\n";
  return table;
}

std::vector<rigs::SourceType> NetworkTypes() {
  std::vector<rigs::SourceType> types;
  for (const auto& type : rigs::kSourceTypes) {
    if (!type.usb) types.push_back(type);
  }
  return types;
}

class RigTest : public testing::TestWithParam<rigs::SourceType> {};

TEST_P(RigTest, HarmsNobody) {
  const rigs::SourceType& type = GetParam();
  std::unique_ptr<NoisyServer> server;
  if (type.rig->takes_server) server = std::make_unique<NoisyServer>(type.stream);
  Stage stage(SourceTable(type, server != nullptr ? server->address() : ""));
  ASSERT_EQ(stage.daemon().listens.size(), 3U) << stage.daemon().Log();
  const std::string address = stage.daemon().listens.back();
  std::uint64_t sent = 0;
  const Measured measured = stage.Watch([&] {
    std::mt19937 random(7);
    std::unique_ptr<support::Child> stand_in;
    if (!type.rig->asks_server && !type.rig->takes_server) {
      stand_in = std::make_unique<support::Child>(
          std::vector<std::string>{STYLESIM_BINARY, "--as", std::string(type.rig->word), "--to",
                                   (type.stream ? "tcp://" : "udp://") + address, "--rate", "120",
                                   "--faults", "corrupt=0.2,truncate=0.2,duplicate=0.1,nan=0.1"},
          stage.folder() / "stand-in.txt");
    }
    std::vector<std::unique_ptr<support::TcpLink>> links;
    const auto begin = Clock::now();
    while (Clock::now() - begin < std::chrono::duration<double>(kNoise_s)) {
      if (type.connects()) {
        support::Sleep(0.05);  // the daemon comes to the server by itself
      } else if (type.stream) {
        // Connections that send a little and stay, and more than there may be.
        links.push_back(std::make_unique<support::TcpLink>(address));
        links.back()->Send(Noise(random, 5000));
        if (links.size() > 200) links.erase(links.begin());
        support::Sleep(0.002);
      } else {
        const support::UdpLink link(address);
        for (int i = 0; i < 50; ++i, ++sent) link.Send(Noise(random, kLargestDatagram));
        support::Sleep(0.002);
      }
    }
  });
  ASSERT_TRUE(measured.alive) << stage.daemon().Log();
  if (server != nullptr && type.rig->asks_server) EXPECT_GT(server->answered(), 0U);
  EXPECT_LT(measured.silence_s, 1) << "no sign of life";
  EXPECT_LT(measured.reload_s, 1) << "SIGHUP was not heard";
  EXPECT_LE(measured.memory, std::int64_t{64} << 20);
  EXPECT_EQ(measured.received, measured.victim) << "frames of the victim";
  EXPECT_TRUE(measured.one_leads);
  EXPECT_LT(measured.both_lead_s, 2);
  std::printf(
      "%llu datagrams: sign of life after %.2f s at most, memory +%.1f MB, victim %llu of %llu\n",
      static_cast<unsigned long long>(sent), measured.silence_s,
      static_cast<double>(measured.memory) / 1e6,
      static_cast<unsigned long long>(measured.received),
      static_cast<unsigned long long>(measured.victim));
}

INSTANTIATE_TEST_SUITE_P(All, RigTest, testing::ValuesIn(NetworkTypes()), [](const auto& row) {
  std::string name(row.param.name);
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

}  // namespace
}  // namespace styled::hostile
