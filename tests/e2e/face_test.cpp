// A second source that is the face of a performer: a phone beside a suit.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include "sim/rigs/ifacialmocap.h"
#include "sim/rigs/live_link_face.h"
#include "sim/rigs/vmc.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"

namespace styled::support {
namespace {

Bytes Copy(std::span<const std::byte> bytes) { return {bytes.begin(), bytes.end()}; }

// A phone's socket: it answers the sender of the last datagram.
class PhoneSocket {
 public:
  PhoneSocket() : fd_(socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK, 0)) {
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof at;
    EXPECT_EQ(bind(fd_, reinterpret_cast<sockaddr*>(&at), size), 0);
    EXPECT_EQ(getsockname(fd_, reinterpret_cast<sockaddr*>(&at), &size), 0);
    address_ = "127.0.0.1:" + std::to_string(ntohs(at.sin_port));
  }
  ~PhoneSocket() { close(fd_); }
  PhoneSocket(const PhoneSocket&) = delete;
  PhoneSocket& operator=(const PhoneSocket&) = delete;

  const std::string& address() const { return address_; }
  // The datagram that has arrived; empty: none.
  Bytes Receive() {
    Bytes bytes(2048);
    socklen_t size = sizeof peer_;
    const ssize_t got =
        recvfrom(fd_, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&peer_), &size);
    bytes.resize(got < 0 ? 0 : static_cast<std::size_t>(got));
    return bytes;
  }
  void Send(std::span<const std::byte> bytes) const {
    sendto(fd_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&peer_),
           sizeof peer_);
  }

 private:
  int fd_;
  std::string address_;
  sockaddr_in peer_{};
};

float Value(const v1::Frame& frame, std::string_view name) {
  for (const auto& expression : frame.expressions()) {
    if (expression.name() == name) return expression.value();
  }
  return -1;
}

// Streams a second of the performers rig.a and rig.b; `face(i)` may send something before each
// frame.
std::vector<v1::Frame> Stream(Daemon& daemon, Subscriber& subscriber,
                              const std::function<void(int)>& face) {
  const UdpLink link(daemon.udp);
  Rig a("a"), b("b", 9);
  link.Send(a.Body());
  link.Send(b.Body());
  EXPECT_TRUE(subscriber.WaitForBody());
  Paced(120, 120, [&](int i) {
    face(i);
    link.Send(a.Frame());
    link.Send(b.Frame());
  });
  EXPECT_TRUE(subscriber.WaitForFrames(240, "styled/")) << daemon.Log();
  return subscriber.Frames("styled/");
}

int Smiling(const std::vector<v1::Frame>& frames, const std::string& performer,
            std::string_view name) {
  int smiling = 0;
  for (const v1::Frame& frame : frames) {
    if (frame.performer() == performer && Value(frame, name) >= 0) ++smiling;
  }
  return smiling;
}

TEST(FaceTest, APhonesFaceIsItsPerformersAndNobodyElses) {
  Daemon daemon({},
                "[[source]]\nname = \"phone\"\ntype = \"livelinkface\"\n"
                "listen = \"127.0.0.1:0\"\nmerge_into = \"rig.a\"\n");
  Subscriber subscriber(daemon.publish,
                        {"body/", "styled/rig.a/canonical/", "styled/rig.b/canonical/"});
  const UdpLink phone(daemon.listens.at(2));
  auto rig = rigs::MakeLiveLinkFace({});
  const auto frames = Stream(daemon, subscriber, [&](int i) {
    rigs::Frame frame;
    frame.index = static_cast<std::uint64_t>(i);
    frame.time_s = static_cast<double>(i) / 60;
    if (i % 2 == 0) {
      rig.value()->Encode(frame, [&](auto datagram) { phone.Send(Copy(datagram)); });
    }
  });
  EXPECT_GT(Smiling(frames, "rig.a", "jawOpen"), 100);
  EXPECT_EQ(Smiling(frames, "rig.b", "jawOpen"), 0);
  EXPECT_EQ(ControlClient(daemon.control).Counter("pipeline.performers"), 2U);
}

TEST(FaceTest, FacesOfAVmcApplicationNeedNoBones) {
  Daemon daemon({},
                "[[source]]\nname = \"face\"\ntype = \"vmc\"\nlisten = \"127.0.0.1:0\"\n"
                "merge_into = \"rig.b\"\n");
  Subscriber subscriber(daemon.publish,
                        {"body/", "styled/rig.a/canonical/", "styled/rig.b/canonical/"});
  const UdpLink app(daemon.listens.at(2));
  rigs::Options options;
  options.quirks = {"full"};
  auto rig = rigs::MakeVmc(options);
  const body::Pose pose;
  const auto frames = Stream(daemon, subscriber, [&](int i) {
    rigs::Frame frame;
    frame.index = static_cast<std::uint64_t>(i);
    frame.time_s = static_cast<double>(i) / 120;
    frame.poses = {&pose, 1};
    rig.value()->Encode(frame, [&](auto datagram) { app.Send(Copy(datagram)); });
  });
  EXPECT_EQ(Smiling(frames, "rig.a", "Joy"), 0);
  EXPECT_GT(Smiling(frames, "rig.b", "Joy"), 100);
}

// Two performers: the phone's face is on neither, and status and the log say it.
TEST(FaceTest, APhoneWithoutANameIsTheOnlyPerformers) {
  Daemon daemon({},
                "[[source]]\nname = \"phone\"\ntype = \"livelinkface\"\n"
                "listen = \"127.0.0.1:0\"\n");
  Subscriber subscriber(daemon.publish,
                        {"body/", "styled/rig.a/canonical/", "styled/rig.b/canonical/"});
  const UdpLink phone(daemon.listens.at(2));
  auto rig = rigs::MakeLiveLinkFace({});
  std::string stray;
  const auto frames = Stream(daemon, subscriber, [&](int i) {
    rigs::Frame frame;
    frame.index = static_cast<std::uint64_t>(i);
    frame.time_s = static_cast<double>(i) / 60;
    rig.value()->Encode(frame, [&](auto datagram) { phone.Send(Copy(datagram)); });
    if (i != 100) return;
    const v1::StatusReply status = ControlClient(daemon.control).Status();
    for (const auto& source : status.sources()) stray += source.stray();
  });
  EXPECT_EQ(stray, "here are rig.a, rig.b: merge_into must name the one who gets its data");
  EXPECT_EQ(Smiling(frames, "rig.a", "jawOpen") + Smiling(frames, "rig.b", "jawOpen"), 0);
}

// A phone and nothing else; then its battery is empty.
TEST(FaceTest, AFaceAloneIsAPerformerWhoMovesInTheSilence) {
  Daemon daemon({},
                "[[source]]\nname = \"phone\"\ntype = \"livelinkface\"\n"
                "listen = \"127.0.0.1:0\"\nbody = \"standing\"\n");
  Subscriber subscriber(daemon.publish, {"body/", "styled/phone.phone/canonical/"});
  const UdpLink phone(daemon.listens.at(2));
  auto rig = rigs::MakeLiveLinkFace({});
  Paced(60, 60, [&](int i) {
    rigs::Frame frame;
    frame.index = static_cast<std::uint64_t>(i);
    frame.time_s = static_cast<double>(i) / 60;
    rig.value()->Encode(frame, [&](auto datagram) { phone.Send(Copy(datagram)); });
  });
  // A quarter of a second later its body moves by itself, at the phone's rate.
  EXPECT_TRUE(subscriber.WaitForFrames(50 + 60, "styled/")) << daemon.Log();
  int idle = 0;
  for (const v1::Frame& frame : subscriber.Frames("styled/")) {
    EXPECT_EQ(frame.rotations_size(), 4 * 23) << "with eyes";
    idle += (frame.flags() & v1::FLAG_STALE) != 0 ? 1 : 0;
  }
  EXPECT_GE(idle, 50);
  const v1::StatusReply status = ControlClient(daemon.control).Status();
  ASSERT_EQ(status.stats().performers_size(), 1);
  EXPECT_EQ(status.stats().performers(0).performer(), "phone.phone");
  EXPECT_EQ(status.stats().performers(0).look().idle(), 1);
}

// The phone is silent until the daemon asks for it, at the address in `server`.
TEST(FaceTest, APhoneThatMustBeAskedIsAsked) {
  PhoneSocket phone;
  Daemon daemon({},
                "[[source]]\nname = \"phone\"\ntype = \"ifacialmocap\"\n"
                "listen = \"127.0.0.1:0\"\nmerge_into = \"rig.a\"\nexpressions = \"vrm\"\n"
                "server = \"" +
                    phone.address() + "\"\n");
  Subscriber subscriber(daemon.publish,
                        {"body/", "styled/rig.a/canonical/", "styled/rig.b/canonical/"});
  auto rig = rigs::MakeIFacialMocap({});
  const auto frames = Stream(daemon, subscriber, [&](int i) {
    rigs::Frame frame;
    frame.time_s = static_cast<double>(i) / 120;
    if (const Bytes asked = phone.Receive(); !asked.empty()) rig.value()->Receive(asked, {});
    rig.value()->Encode(frame, [&](auto datagram) { phone.Send(datagram); });
  });
  EXPECT_GT(Smiling(frames, "rig.a", "Blink_L"), 100);
  EXPECT_EQ(Smiling(frames, "rig.a", "eyeBlinkLeft"), 0);
}

}  // namespace
}  // namespace styled::support
