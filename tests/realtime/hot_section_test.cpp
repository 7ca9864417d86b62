// The promise of the hot path, on the release binary: between receive and the entry of zmq_send no
// allocation, lock, log or exception. And that the hook would see them.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <sstream>

#include "model/clip/glb_write.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"
#include "tests/unit/livelinkface/decode_cases.h"
#include "tests/unit/net/erd/random_weights.h"
#include "tests/unit/net/stgcn_causal/random_weights.h"

namespace styled::support {
namespace {

struct Report {
  std::map<std::string, unsigned long> counts;
  std::string text;
};

Report ReadReport(const std::string& file) {
  Report report;
  report.text = ReadText(file);
  std::istringstream lines(report.text);
  std::string name;
  unsigned long count = 0;
  while (lines >> name && name != "caller" && lines >> count) report.counts[name] = count;
  return report;
}

// The rig's body with a finger of two joints.
v1::Body WithFinger(const Rig& rig) {
  v1::Body body = rig.MakeBody();
  for (const char* const name : {"leftIndexProximal", "leftIndexIntermediate"}) {
    body.add_parents(body.names_size() == body::kJointCount ? body::kLeftHand : body::kJointCount);
    body.add_names(name);
    for (const float value : {0.03F, 0.0F, 0.0F}) body.add_offsets(value);
  }
  return body;
}

// A sword beside the right hand, which some frames lack, and at times one that has no pose.
void AddProps(int i, v1::SourceFrame& frame) {
  const auto add = [&frame](const std::string& name, float x, float y, float w) {
    v1::Prop& prop = *frame.add_props();
    prop.set_name(name);
    for (const float value : {x, y, 0.0F}) prop.add_position(value);
    for (const float value : {0.0F, 0.0F, 0.0F, w}) prop.add_rotation(value);
  };
  if (i % 50 < 40) add("sword", -0.3F, 0.75F, 1);
  if (i % 31 == 5) add("lost", 1, 1, 0);
  add("a chair with a name that no small string holds", 5, 0, 1);
}

// Writes it as an avatar.
void WriteAvatar(const v1::Body& body, const std::string& file) {
  clip::Motion motion;
  motion.skeleton.names.assign(body.names().begin(), body.names().end());
  motion.skeleton.parents.assign(body.parents().begin(), body.parents().end());
  for (int i = 0; i < body.offsets_size(); i += 3) {
    motion.skeleton.offsets.emplace_back(body.offsets(i), body.offsets(i + 1), body.offsets(i + 2));
  }
  motion.frames = {rig::RigPose(motion.skeleton)};
  const Status written = clip::WriteGlb(motion, file);
  ASSERT_TRUE(written.ok()) << written.message();
}

// A second of all that frames can meet: styles that change, joints that break, frames lost,
// doubled, late and damaged, timecode that comes and goes, weights that make no pose of some of
// them, `threads` that style, several performers with a finger each, a phone for the face of one
// and gloves, which come and go, for the fingers of another, a filter against jitter, props that
// come and go, are held and are wrong, an avatar, all topics subscribed, all of it recorded.
Report Play(const std::string& provoke, int threads = 1) {
  TemporaryFolder folder;
  const std::string file = folder / "report.txt";
  std::map<std::string, std::string> environment{{"LD_PRELOAD", STYLED_HOOK},
                                                 {"STYLED_HOOK_REPORT", file}};
  if (!provoke.empty()) environment["STYLED_HOOK_PROVOKE"] = provoke;
  WriteWeights(folder / "sleeping.safetensors", erd::SleepingWeights(5, 1));
  const v1::Body fingered = WithFinger(Rig("p0"));
  WriteAvatar(fingered, folder / "avatar.glb");
  Daemon daemon({"record.file=" + folder / "take.styrec", "source.1.smooth_hz=3",
                 "realtime.styling_threads=" + std::to_string(threads)},
                "[[source]]\nname = \"phone\"\ntype = \"livelinkface\"\n"
                "listen = \"127.0.0.1:0\"\nmerge_into = \"rig.p0\"\n"
                "[[source]]\nname = \"gloves\"\ntype = \"udp\"\nlisten = \"127.0.0.1:0\"\n"
                "merge_into = \"rig.p1\"\nparts = [\"fingers\", \"face\"]\nsmooth_hz = 3\n"
                "[[output]]\nname = \"hero\"\navatar = \"" +
                    folder / "avatar.glb" + "\"\n",
                environment, folder / "sleeping.safetensors");
  Subscriber subscriber(daemon.publish, {""});
  ControlClient control(daemon.control);
  const UdpLink link(daemon.udp);
  const TcpLink tcp(daemon.tcp);
  const UdpLink phone(daemon.listens.at(2)), gloves_link(daemon.listens.at(3));
  Rig gloves("g", 77);
  gloves_link.Send(gloves.Datagram(native::Kind::kBody, WithFinger(gloves).SerializeAsString()));
  std::vector<Rig> rigs;
  for (int i = 0; i < 4; ++i) rigs.emplace_back("p" + std::to_string(i), 10 + i);
  for (auto& rig : rigs) {
    link.Send(rig.Datagram(native::Kind::kBody, WithFinger(rig).SerializeAsString()));
  }
  Rig over_tcp("t");
  tcp.Send(over_tcp.Body());
  EXPECT_TRUE(subscriber.WaitForBody());
  Paced(provoke.empty() ? 360 : 30, 120, [&](int i) {
    if (i % 60 == 10) (void)control.SetStyle("*", i % 120 == 10 ? "style1" : "style3", 0.9F, 150);
    tcp.Send(over_tcp.Frame());
    if (i < 200) phone.Send(live_link_face::testing::Written(live_link_face::testing::Smile(i)));
    if (i < 120 || i > 300) {
      gloves_link.Send(gloves.Frame([&](v1::SourceFrame& frame) {
        for (int k = 0; k < 8; ++k) frame.add_rotations(k % 4 == 3 ? 0.6F : k % 4 == 2 ? 0.8F : 0);
        if (i % 17 == 5) frame.set_rotations(4 * 21, std::numeric_limits<float>::quiet_NaN());
        frame.add_expressions()->set_name("jawOpen");
      }));
    }
    for (std::size_t r = 0; r < rigs.size(); ++r) {
      Bytes bytes = rigs[r].Frame([&](v1::SourceFrame& frame) {
        for (int k = 0; k < 8; ++k) frame.add_rotations(k % 4 == 3 ? 0.8F : k % 4 == 2 ? 0.6F : 0);
        AddProps(i, frame);
        if (i % 3 == 0) frame.mutable_timecode()->set_frames(7);
        if (i % 17 == 5) frame.set_rotations(12, std::numeric_limits<float>::quiet_NaN());
        if (i % 71 == 70) frame.add_rotations(1);
        if (i % 20 == 19) frame.set_root_position(1, erd::kAwake_m + 0.1F);
      });
      if (i % 23 == 7) continue;
      if (i % 29 == 3) bytes[60] ^= std::byte{1};
      link.Send(bytes);
      if (i % 13 == 2) link.Send(bytes);
    }
  });
  Sleep(0.3);
  EXPECT_GT(control.Counter("record.written"), 100U);
  EXPECT_GE(control.Counter("stylist.failed"), 4U);
  EXPECT_GE(control.Counter("pipeline.props_left_out"), 1U);
  for (const char* const topic : {"styled/rig.p0/canonical/", "styled/rig.p0/hero/"}) {
    const auto frames = subscriber.Frames(topic);
    EXPECT_FALSE(frames.empty()) << topic;
    if (!frames.empty()) {
      EXPECT_EQ(frames.back().rotations_size(), 4 * fingered.names_size()) << topic;
      const bool smiled = std::any_of(frames.begin(), frames.end(), [](const v1::Frame& frame) {
        return frame.expressions_size() > 0;
      });
      EXPECT_TRUE(smiled) << topic;
      const bool armed = std::any_of(frames.begin(), frames.end(), [](const v1::Frame& frame) {
        return frame.props_size() == 2;
      });
      EXPECT_TRUE(armed) << topic;
    }
  }
  EXPECT_EQ(daemon.Stop(), 0) << daemon.Log();
  return ReadReport(file);
}

TEST(HotSectionTest, NothingIsAllocatedLockedLoggedOrThrownBetweenReceiveAndSend) {
  for (const int threads : {1, 3}) {
    const Report report = Play("", threads);
    ASSERT_GT(report.counts.at("sections"), 1000U) << report.text;
    for (const char* const kind : {"malloc", "free", "lock", "write", "throw"}) {
      EXPECT_EQ(report.counts.at(kind), 0U) << kind << ", " << threads << " threads\n"
                                            << report.text;
    }
  }
}

// Three seconds of performers whose styles vary: by number, each their own, and wandering.
Report PlayVaried() {
  TemporaryFolder folder;
  const std::string file = folder / "report.txt";
  const std::vector<std::byte> bytes = stgcn_causal::RandomWeights(5, 16, 1).Bytes();
  std::ofstream(folder / "causal.safetensors", std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  Daemon daemon({}, "", {{"LD_PRELOAD", STYLED_HOOK}, {"STYLED_HOOK_REPORT", file}},
                folder / "causal.safetensors");
  Subscriber subscriber(daemon.publish, {""});
  ControlClient control(daemon.control);
  const UdpLink link(daemon.udp);
  std::vector<Rig> rigs;
  for (int i = 0; i < 4; ++i) rigs.emplace_back("p" + std::to_string(i), 10 + i);
  for (auto& rig : rigs) link.Send(rig.Body());
  EXPECT_TRUE(subscriber.WaitForBody());
  EXPECT_EQ(control.SetStyle("*", "style2", 1, 50).code(), v1::CODE_OK);
  Paced(360, 120, [&](int i) {
    v1::Request request;
    request.set_performer("*");
    request.mutable_set()->set_vary(static_cast<float>(i % 100));
    request.mutable_set()->set_vary_each(i % 60 == 30);
    request.mutable_set()->set_drift_s(i % 90 < 45 ? 0.5F : 0.0F);
    request.mutable_set()->set_mirror(i % 30 == 10);
    if (i % 15 == 10) EXPECT_EQ(control.Ask(request).code(), v1::CODE_OK);
    for (auto& rig : rigs) link.Send(rig.Frame());
  });
  Sleep(0.3);
  EXPECT_EQ(daemon.Stop(), 0) << daemon.Log();
  return ReadReport(file);
}

TEST(HotSectionTest, NorWhileStylesVary) {
  const Report report = PlayVaried();
  ASSERT_GT(report.counts.at("sections"), 300U) << report.text;
  for (const char* const kind : {"malloc", "free", "lock", "write", "throw"}) {
    EXPECT_EQ(report.counts.at(kind), 0U) << kind << "\n" << report.text;
  }
}

TEST(HotSectionTest, TheHookSeesEachOfThemWhenItHappens) {
  for (const std::string kind : {"malloc", "free", "lock", "write", "throw"}) {
    const Report report = Play(kind);
    EXPECT_GE(report.counts.at(kind), report.counts.at("sections")) << kind << "\n" << report.text;
    EXPECT_GT(report.counts.at("sections"), 20U) << kind;
  }
}

}  // namespace
}  // namespace styled::support
