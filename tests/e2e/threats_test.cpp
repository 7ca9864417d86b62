// The claims of daemon/security/README.md about attackers that security_test.cpp does not cover:
// real daemon, real sockets.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <mutex>
#include <thread>

#include "proto/keys/key_folder.h"
#include "tests/support/daemon.h"
#include "tests/support/frozen_thread.h"
#include "tests/support/rig.h"

namespace styled::support {
namespace {

const std::vector<std::string> kTopics{"body/", "styled/rig.a/rig/"};

// Starts a daemon that must refuse; returns its exit code and output.
std::pair<int, std::string> Refused(const std::vector<std::string>& settings) {
  const TemporaryFolder folder;
  WriteRandomWeights(folder / "weights.safetensors");
  std::vector<std::string> arguments{Binary(), "--weights", folder / "weights.safetensors"};
  for (const char* const own :
       {"source.0.listen=\"127.0.0.1:0\"", "source.1.listen=\"127.0.0.1:0\"",
        "publish.address=tcp://127.0.0.1:0", "control.address=tcp://127.0.0.1:0"}) {
    arguments.insert(arguments.end(), {"--set", own});
  }
  for (const std::string& setting : settings) arguments.insert(arguments.end(), {"--set", setting});
  Child child(arguments, folder / "said.txt");
  const auto code = child.Wait(10);
  return {code.value_or(-1), ReadText(folder / "said.txt")};
}

// A Unix socket bound to `path`. The destructor closes it, but leaves the file.
class Bound {
 public:
  explicit Bound(const std::string& path) : fd_(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(bind(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(listen(fd_, 1), 0);
  }
  ~Bound() { close(fd_); }
  Bound(const Bound&) = delete;
  Bound& operator=(const Bound&) = delete;

 private:
  int fd_;
};

TEST(ThreatsTest, AnOrdinaryFileAtAnIpcPathIsKeptAndTheDaemonDoesNotStart) {
  const TemporaryFolder folder;
  const std::string path = folder / "precious";
  for (const std::string key : {"publish.address", "control.address"}) {
    WriteText(path, "precious");
    const auto [code, said] = Refused({key + "=ipc://" + path});
    EXPECT_EQ(code, 1) << said;
    EXPECT_NE(
        said.find(key + ": ipc://" + path + ": there is an ordinary file; expected a free path"),
        std::string::npos)
        << said;
    EXPECT_EQ(ReadText(path), "precious");
    EXPECT_FALSE(std::filesystem::exists(path + ".lock"));
  }
}

TEST(ThreatsTest, AnotherProgramsSocketIsLeftAloneAndADeadOneIsReplaced) {
  const TemporaryFolder folder;
  const std::string path = folder / "control";
  {
    const Bound other(path);
    const auto [code, said] = Refused({"control.address=ipc://" + path});
    EXPECT_EQ(code, 1) << said;
    EXPECT_NE(said.find("in use by another program; expected a free path"), std::string::npos)
        << said;
    EXPECT_TRUE(std::filesystem::is_socket(path));
  }
  ASSERT_TRUE(std::filesystem::is_socket(path)) << "left behind";
  const Daemon daemon({"control.address=ipc://" + path});
  ControlClient control(daemon.control);
  EXPECT_EQ(control.SetStyle("rig.a", "style1").code(), v1::CODE_OK);
}

// Relays one connection to a daemon and stores what passes.
class Wire {
 public:
  explicit Wire(const std::string& to) : to_(to), listener_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    EXPECT_EQ(bind(listener_, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(listen(listener_, 4), 0);
    getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
    endpoint = "tcp://127.0.0.1:" + std::to_string(ntohs(address.sin_port));
    thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
  }
  ~Wire() {
    thread_.request_stop();
    thread_.join();
    close(listener_);
  }
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;

  bool Saw(const std::string& text) {
    const std::lock_guard lock(mutex_);
    return seen_.find(text) != std::string::npos;
  }
  std::string endpoint;

 private:
  void Run(const std::stop_token& stop) {
    int client = -1, daemon = -1;
    while (!stop.stop_requested()) {
      pollfd items[3] = {{listener_, POLLIN, 0}, {client, POLLIN, 0}, {daemon, POLLIN, 0}};
      poll(items, 3, 20);
      if (items[0].revents != 0 && client < 0) {
        client = accept(listener_, nullptr, nullptr);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        address.sin_port =
            htons(static_cast<std::uint16_t>(std::stoi(to_.substr(to_.rfind(':') + 1))));
        daemon = socket(AF_INET, SOCK_STREAM, 0);
        EXPECT_EQ(connect(daemon, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
        continue;
      }
      if (items[1].revents != 0) Pass(client, daemon);
      if (items[2].revents != 0) Pass(daemon, client);
    }
    close(client);
    close(daemon);
  }
  void Pass(int& from, int to) {
    std::array<char, 65536> bytes{};
    const auto size = recv(from, bytes.data(), bytes.size(), 0);
    if (size <= 0) {
      shutdown(to, SHUT_RDWR);
      from = -1;
      return;
    }
    (void)send(to, bytes.data(), static_cast<std::size_t>(size), MSG_NOSIGNAL);
    const std::lock_guard lock(mutex_);
    seen_.append(bytes.data(), static_cast<std::size_t>(size));
  }

  std::string to_, seen_;
  int listener_;
  std::mutex mutex_;
  std::jthread thread_;
};

// A performer's name is part of the subscription, the topic and the message.
TEST(ThreatsTest, AnEavesdropperSeesNoMotionWhereKeysAreRequired) {
  const auto name_is_seen = [](const std::string& publish, const CurveKeys& keys,
                               const Daemon& daemon) {
    Wire wire(publish);
    Subscriber subscriber(wire.endpoint, {"body/", "styled/rig.wanda/rig/"}, keys);
    const UdpLink link(daemon.udp);
    Rig rig("wanda");
    link.Send(rig.Body());
    EXPECT_TRUE(subscriber.WaitForBody());
    Paced(30, 120, [&](int) { link.Send(rig.Frame()); });
    EXPECT_TRUE(subscriber.WaitForFrames(30, "styled/"));
    return wire.Saw("wanda");
  };
  const Daemon open;
  EXPECT_TRUE(name_is_seen(open.publish, {}, open)) << "so the wire is listened to";
  const TemporaryFolder folder;
  const Daemon guarded({"security.keys=" + (folder / "keys"), "publish.address=tcp://0.0.0.0:0"});
  const auto pair = keys::MakePair().value();
  ASSERT_TRUE(
      keys::Allow(folder / "keys", {"anna", pair.public_key, keys::Role::kSubscriber}).ok());
  EXPECT_FALSE(name_is_seen(guarded.publish, {guarded.server_key, pair.public_key, pair.secret_key},
                            guarded));
}

TEST(ThreatsTest, AMessageBeyondItsLimitCutsOffWhoSentItAndNobodyElse) {
  Daemon daemon;
  Subscriber good(daemon.publish, kTopics);
  ControlClient control(daemon.control);
  const UdpLink link(daemon.udp);
  Rig rig("a");
  link.Send(rig.Body());
  ASSERT_TRUE(good.WaitForBody());
  // A subscription is limited to 1 KiB: the shorter of the two is served, the longer one never.
  Subscriber bad(daemon.publish, {"body/", std::string(1100, 'x')});
  EXPECT_FALSE(bad.WaitForBody(2));
  Subscriber other(daemon.publish, {"body/", std::string(900, 'x')});
  ControlClient huge(daemon.control);
  huge.SetPatience(1);
  EXPECT_EQ(huge.AskRaw({std::string((9 << 20) + 100, 'x')}).reason(), "no reply");
  EXPECT_EQ(control.AskRaw({std::string(1 << 19, 'x')}).code(), v1::CODE_TOO_LARGE);
  Paced(60, 120, [&](int i) {
    if (i % 20 == 0) link.Send(rig.Body());
    link.Send(rig.Frame());
  });
  EXPECT_TRUE(other.WaitForBody());
  EXPECT_TRUE(good.WaitForFrames(60, "styled/"));
  EXPECT_EQ(control.SetStyle("rig.a", "style1").code(), v1::CODE_OK);
}

int OpenDescriptors(pid_t pid) {
  int count = 0;
  for ([[maybe_unused]] const auto& entry :
       std::filesystem::directory_iterator("/proc/" + std::to_string(pid) + "/fd")) {
    ++count;
  }
  return count;
}

TEST(ThreatsTest, WithItsDescriptorsUsedUpTheShowGoesOnAndItRecovers) {
  Daemon daemon;
  Subscriber good(daemon.publish, kTopics);
  const UdpLink link(daemon.udp);
  Rig rig("a");
  link.Send(rig.Body());
  ASSERT_TRUE(good.WaitForBody());
  const pid_t pid = daemon.child->pid();
  const auto few = static_cast<rlim_t>(OpenDescriptors(pid)) + 10;
  const rlimit limit{few, few};
  ASSERT_EQ(prlimit(pid, RLIMIT_NOFILE, &limit, nullptr), 0);
  {
    std::vector<std::unique_ptr<TcpLink>> crowd;
    Paced(240, 120, [&](int i) {
      link.Send(rig.Frame());
      if (i % 4 == 0) crowd.push_back(std::make_unique<TcpLink>(daemon.publish.substr(6)));
    });
    EXPECT_TRUE(good.WaitForFrames(240, "styled/")) << "who was there before loses nothing";
  }
  Subscriber late(daemon.publish, kTopics);
  for (int i = 0; i < 500 && !late.WaitForBody(0.02); ++i) link.Send(rig.Body());
  EXPECT_TRUE(late.WaitForBody(0)) << "once the crowd is gone, others get in";
  ControlClient control(daemon.control);
  EXPECT_EQ(control.SetStyle("rig.a", "style1").code(), v1::CODE_OK);
}

TEST(ThreatsTest, BeyondThirtyTwoRequestsThatWaitAnOperatorIsToldSo) {
  const Daemon daemon;
  ControlClient control(daemon.control);
  ASSERT_EQ(control.SetStyle("rig.a", "style1").code(), v1::CODE_OK);
  {
    const FrozenThread hung(daemon.child->pid(), "pipeline");
    if (!hung.frozen()) GTEST_SKIP() << "skipped: " << hung.error();
    control.SetPatience(0.02);
    int waiting = 0;
    v1::Reply reply = control.SetStyle("rig.a", "style2");
    while (reply.reason() == "no reply" && waiting < 64) {
      ++waiting;
      reply = control.SetStyle("rig.a", "style2");
    }
    EXPECT_EQ(reply.code(), v1::CODE_BUSY);
    EXPECT_EQ(reply.reason(), "too many requests are waiting; try again");
    EXPECT_GE(waiting, 32);
  }
  ControlClient after(daemon.control);
  EXPECT_EQ(after.SetStyle("rig.a", "style3").code(), v1::CODE_OK);
}

TEST(ThreatsTest, ARecordingGetsTheModeThatTheUmaskLeaves) {
  const TemporaryFolder folder;
  const mode_t before = umask(0027);
  Daemon daemon({}, "[record]\nfile = '" + (folder / "take.styrec") + "'\n");
  umask(before);
  const UdpLink link(daemon.udp);
  Rig rig("a");
  link.Send(rig.Body());
  Paced(10, 120, [&](int) { link.Send(rig.Frame()); });
  EXPECT_EQ(daemon.Stop(), 0);
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    if (entry.path().extension() != ".styrec") continue;
    struct stat about {};
    ASSERT_EQ(stat(entry.path().c_str(), &about), 0);
    EXPECT_EQ(about.st_mode & 0777U, 0640U) << entry.path();
    ++files;
  }
  EXPECT_EQ(files, 1);
}

}  // namespace
}  // namespace styled::support
