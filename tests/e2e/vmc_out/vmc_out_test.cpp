// Styled frames sent as VMC: a second daemon, which listens like an application, has the same
// poses; and liblo, an independent implementation, reads the same messages.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lo/lo.h>
#include <signal.h>

#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "model/body/pose.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"
#include "tests/support/units.h"
#include "tests/unit/vmc_out/ear.h"

namespace styled::support {
namespace {

using stylevmc::Ear;

constexpr const char* kStyled = "styled/rig.a/canonical/";
constexpr const char* kAvatar = "styled/avatar.avatar/canonical/";

class Stylevmc {
 public:
  explicit Stylevmc(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), STYLEVMC_BINARY);
    child = std::make_unique<Child>(arguments, folder_ / "stderr.txt");
  }
  std::string Log() const { return ReadText(folder_ / "stderr.txt"); }

 private:
  TemporaryFolder folder_;

 public:
  std::unique_ptr<Child> child;
};

// Sends frames until `done` or for 20 s.
bool SendUntil(const UdpLink& link, Rig& rig, const std::function<bool()>& done) {
  for (int i = 0; i < 2400; ++i) {
    if (i % 60 == 0) link.Send(rig.Body());
    link.Send(rig.Frame());
    if (done()) return true;
    Sleep(1.0 / 120);
  }
  return false;
}

body::Quat Rotation(const v1::Frame& frame, int joint) {
  const float* q = frame.rotations().data() + 4 * joint;
  return {q[3], q[0], q[1], q[2]};
}

// The largest angle between two frames' joints, degrees.
float WorstAngle(const v1::Frame& a, const v1::Frame& b) {
  float worst = 0;
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    worst = std::max(worst, kDegrees * Rotation(a, joint).angularDistance(Rotation(b, joint)));
  }
  return worst;
}

struct Comparison {
  int compared = 0;
  float worst_deg = 0, worst_mm = 0;
};

// Both streams contain the rig's clock, the second one from its own zero. The last frame received
// is one of the last sent, which determines the offset.
Comparison Compare(const std::vector<v1::Frame>& sent, const std::vector<v1::Frame>& came) {
  std::uint64_t ahead_ns = 0;
  float nearest_deg = 360;
  for (std::size_t i = sent.size() - std::min<std::size_t>(sent.size(), 30); i < sent.size(); ++i) {
    const float deg = WorstAngle(sent[i], came.back());
    if (deg >= nearest_deg) continue;
    nearest_deg = deg;
    ahead_ns = sent[i].source_time_ns() - came.back().source_time_ns();
  }
  Comparison result;
  for (const v1::Frame& frame : came) {
    for (const v1::Frame& from : sent) {
      const auto apart_ns =
          static_cast<std::int64_t>(from.source_time_ns() - frame.source_time_ns() - ahead_ns);
      if (std::abs(apart_ns) > 2'000'000) continue;
      ++result.compared;
      result.worst_deg = std::max(result.worst_deg, WorstAngle(from, frame));
      for (int axis = 0; axis < 3; ++axis) {
        const float m = std::abs(from.root_position(axis) - frame.root_position(axis));
        result.worst_mm = std::max(result.worst_mm, 1000 * m);
      }
      break;
    }
  }
  return result;
}

// Plays a styled performer from one daemon into another. `options` are stylevmc's.
void PlayThrough(std::vector<std::string> options) {
  Daemon first;
  Daemon second({}, "[[source]]\nname = \"avatar\"\ntype = \"vmc\"\nlisten = \"127.0.0.1:0\"\n");
  ControlClient control(first.control);
  ASSERT_EQ(control.SetStyle("rig.a", "style1", 1, 0).code(), v1::CODE_OK);
  Subscriber sent(first.publish, {"body/", kStyled}), came(second.publish, {"body/", kAvatar});
  for (const std::string& more :
       {std::string("--publish"), first.publish, std::string("--to"), second.listens.at(2)}) {
    options.push_back(more);
  }
  Stylevmc forwarder(options);
  const UdpLink link(first.udp);
  Rig rig("a");
  ASSERT_TRUE(SendUntil(link, rig, [&] { return !came.Frames(kAvatar).empty(); }))
      << forwarder.Log() << second.Log();
  Paced(240, 120, [&](int) {
    link.Send(rig.Frame([](v1::SourceFrame& frame) {
      auto& expression = *frame.add_expressions();
      expression.set_name("Joy");
      expression.set_value(0.5F);
    }));
  });
  ASSERT_TRUE(came.WaitForFrames(200, kAvatar)) << forwarder.Log();
  // Face expressions are transmitted as well.
  const v1::Frame last = came.Frames(kAvatar).back();
  ASSERT_EQ(last.expressions_size(), 1);
  EXPECT_EQ(last.expressions(0).name(), "Joy");
  EXPECT_EQ(last.expressions(0).value(), 0.5F);
  forwarder.child->Signal(SIGTERM);
  EXPECT_EQ(forwarder.child->Wait(5).value_or(-1), 0);
  EXPECT_EQ(forwarder.Log(), "");
  const auto frames = came.Frames(kAvatar);
  const Comparison result = Compare(sent.Frames(kStyled), frames);
  EXPECT_GE(result.compared, static_cast<int>(frames.size()) - 30);
  EXPECT_LT(result.worst_deg, 0.1F);
  EXPECT_LT(result.worst_mm, 1);
  EXPECT_EQ(frames.back().styles_size(), 0) << "the second daemon adds no style of its own";
  ASSERT_GT(sent.Frames(kStyled).back().styles_size(), 0);
}

TEST(VmcOut, ASecondDaemonHasTheSamePoses) { PlayThrough({}); }

TEST(VmcOut, ASecondDaemonHasTheSamePosesWhereTheRootCarries) { PlayThrough({"--root", "root"}); }

// liblo in the role of the application.
class Liblo {
 public:
  Liblo() : server_(lo_server_new(nullptr, [](int, const char*, const char*) {})) {
    lo_server_enable_queue(server_, 0, 1);
    lo_server_add_method(server_, nullptr, nullptr, &Liblo::OnMessage, this);
  }
  ~Liblo() { lo_server_free(server_); }
  Liblo(const Liblo&) = delete;
  Liblo& operator=(const Liblo&) = delete;

  std::string port() const { return std::to_string(lo_server_get_port(server_)); }
  void Receive() {
    while (lo_server_recv_noblock(server_, 0) > 0) {
    }
  }

  struct Frame {
    std::map<std::string, std::vector<float>> bones;
    std::vector<float> root;
    std::vector<std::string> order;  // addresses
    std::vector<int> ok;
    float time_s = -1;
  };
  std::vector<Frame> frames;  // each ended by T

 private:
  static int OnMessage(const char* path, const char* types, lo_arg** arguments, int count,
                       lo_message /*message*/, void* user) {
    auto& self = *static_cast<Liblo*>(user);
    const std::string address = path;
    self.open_.order.push_back(address + " " + types);
    std::vector<float> floats;
    for (int i = 0; i < count; ++i) {
      if (types[i] == 'f') floats.push_back(arguments[i]->f);
      if (types[i] == 'i') self.open_.ok.push_back(arguments[i]->i);
    }
    if (address == "/VMC/Ext/Bone/Pos") self.open_.bones[&arguments[0]->s] = floats;
    if (address == "/VMC/Ext/Root/Pos") self.open_.root = floats;
    if (address == "/VMC/Ext/T") {
      self.open_.time_s = floats.at(0);
      self.frames.push_back(std::exchange(self.open_, {}));
    }
    return 0;
  }

  lo_server server_;
  Frame open_;
};

TEST(VmcOut, LibloReadsWholeFramesInTheirOrderAtTheRateAsked) {
  Daemon daemon;
  Liblo liblo;
  Stylevmc forwarder({"--publish", daemon.publish, "--to", "localhost:" + liblo.port(), "--rate",
                      "30", "--performer", "rig.a"});
  Subscriber sent(daemon.publish, {"body/", kStyled});
  const UdpLink link(daemon.udp);
  Rig rig("a");
  ASSERT_TRUE(SendUntil(link, rig, [&] {
    liblo.Receive();
    return liblo.frames.size() > 1;
  })) << forwarder.Log();
  Paced(240, 120, [&](int) {
    link.Send(rig.Frame());
    liblo.Receive();
  });
  // The first datagram received may have been the middle of a frame.
  for (std::size_t i = 1; i < liblo.frames.size(); ++i) {
    const auto& frame = liblo.frames[i];
    ASSERT_EQ(frame.bones.size(), 21U);
    EXPECT_TRUE(frame.bones.contains("LeftUpperLeg"));
    EXPECT_EQ(frame.order.front(), "/VMC/Ext/Root/Pos sfffffff");
    ASSERT_GE(frame.order.size(), 3U);
    EXPECT_THAT(std::vector<std::string>(frame.order.end() - 3, frame.order.end()),
                testing::ElementsAre("/VMC/Ext/Blend/Apply ", "/VMC/Ext/OK iiii", "/VMC/Ext/T f"));
    EXPECT_THAT(frame.ok, testing::ElementsAre(1, 3, 0, 1));
    EXPECT_GT(frame.time_s, liblo.frames[i - 1].time_s);
  }
  const float span_s = liblo.frames.back().time_s - liblo.frames[1].time_s;
  EXPECT_LE(static_cast<float>(liblo.frames.size() - 2), 30 * span_s + 2);
  EXPECT_GT(liblo.frames.size(), 20U);
  // Each frame received is a published one, mirrored; matched by the hips only.
  const auto published = sent.Frames(kStyled);
  const auto& hips = liblo.frames.back().bones.at("Hips");
  const auto same = [&](const v1::Frame& frame) {
    const auto& p = frame.root_position();
    const auto& q = frame.rotations();
    return hips == std::vector<float>{-p[0], p[1], p[2], q[0], -q[1], -q[2], q[3]};
  };
  EXPECT_TRUE(std::any_of(published.begin(), published.end(), same));
  EXPECT_EQ(liblo.frames.back().root, (std::vector<float>{0, 0, 0, 0, 0, 0, 1}));
}

TEST(VmcOut, AnApplicationThatIsAwayHarmsNobodyAndMayComeBack) {
  Daemon daemon;
  const std::string port = Ear().port();
  const Ear here;
  Stylevmc forwarder(
      {"--publish", daemon.publish, "--to", "127.0.0.1:" + port, "--to", here.address()});
  const UdpLink link(daemon.udp);
  Rig rig("a");
  int heard = 0;
  EXPECT_TRUE(SendUntil(link, rig, [&] {
    while (!here.Receive(0).empty()) ++heard;
    return heard >= 90;
  })) << forwarder.Log();
  const Ear back(port);
  EXPECT_TRUE(SendUntil(link, rig, [&] { return !back.Receive(0).empty(); })) << forwarder.Log();
  EXPECT_EQ(forwarder.Log(), "stylevmc: no program listens at 127.0.0.1:" + port +
                                 ": is VMC's receiver on in the application, on this port?\n");
}

TEST(VmcOut, ForwardingContinuesWhenTheDaemonIsRestarted) {
  TemporaryFolder folder;
  Daemon daemon({"publish.address=ipc://" + (folder / "publish")});
  const Ear ear;
  Stylevmc forwarder({"--publish", daemon.publish, "--to", ear.address()});
  int heard = 0;
  const auto hears = [&] {
    while (!ear.Receive(0).empty()) ++heard;
    return heard >= 30;
  };
  Rig rig("a");
  EXPECT_TRUE(SendUntil(UdpLink(daemon.udp), rig, hears)) << forwarder.Log();
  EXPECT_EQ(daemon.Stop(), 0);
  daemon.Start();
  while (!ear.Receive(100).empty()) {
  }
  heard = 0;
  Rig again("a", 8);  // its clock starts again, too
  EXPECT_TRUE(SendUntil(UdpLink(daemon.udp), again, hears)) << forwarder.Log();
  EXPECT_TRUE(forwarder.child->Running());
}

TEST(VmcOut, EndsWithAReasonWhereAHostCannotBeFound) {
  Stylevmc forwarder({"--to", "no-such-host.invalid:39539"});
  EXPECT_EQ(forwarder.child->Wait(20).value_or(-1), 1);
  EXPECT_THAT(forwarder.Log(), testing::HasSubstr("no-such-host.invalid:39539: "));
}

TEST(VmcOut, MissingFramesAreReported) {
  Daemon daemon;
  Stylevmc forwarder({"--publish", daemon.publish, "--to", "127.0.0.1:39539", "--seconds", "0.3"});
  EXPECT_EQ(forwarder.child->Wait(20).value_or(-1), 3);
}

}  // namespace
}  // namespace styled::support
