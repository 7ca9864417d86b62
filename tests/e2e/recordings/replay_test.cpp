// `styled --replay`: a recording of several rigs, including those whose output depends on the
// daemon's clock, through the daemon with the recorded times as its clock.
#include <cmath>
#include <map>

#include "model/body/humanoid.h"
#include "tests/e2e/recordings/fixture.h"
#include "tests/unit/net/stgcn_causal/random_weights.h"

namespace styled::support {
namespace {

constexpr const char* kSources = R"(
[[source]]
name = "suit"
type = "mvn"
listen = "127.0.0.1:0"
[[source]]
name = "vtuber"
type = "vmc"
listen = "127.0.0.1:0"
[[source]]
name = "trackers"
type = "slimevr"
listen = "127.0.0.1:0"
)";

// By topic.
using Streams = std::map<std::string, std::vector<v1::Frame>>;

class ReplayTest : public RecordingsTest {
 protected:
  // Records four rigs at once, one of them with faults, with a style that changes in the middle,
  // and then by `request`, if it has a command. Returns what subscribers received.
  Streams Record(const v1::Request& request = {}, const std::string& weights = "") {
    const Daemon daemon({"record.file=" + take_, "style.initial=style2"}, kSources, {}, weights);
    const Subscriber subscriber(daemon.publish, {"styled/", "body/"});
    ControlClient control(daemon.control);
    EXPECT_EQ(control.CounterSoon("publish.subscriptions", 2), 2U);
    std::vector<std::unique_ptr<Child>> sims;
    const std::vector<std::string> rigs{"native", "mvn", "vmc", "slimevr"};
    for (std::size_t i = 0; i < rigs.size(); ++i) {
      std::vector<std::string> arguments{StylesimBinary(),
                                         "--as",
                                         rigs[i],
                                         "--to",
                                         "udp://" + daemon.listens.at(i == 0 ? 0 : i + 1),
                                         "--rate",
                                         "60",
                                         "--seconds",
                                         "3",
                                         "--script",
                                         "walk:1,wave-left:1"};
      if (i == 0) arguments.insert(arguments.end(), {"--faults", "loss=0.02,nan=0.02,seed=3"});
      sims.push_back(std::make_unique<Child>(arguments, folder_ / (rigs[i] + ".txt")));
    }
    EXPECT_TRUE(subscriber.WaitForFrames(60, kStyled));
    EXPECT_EQ(control.SetStyle(kId, "style3", 1, 100).code(), v1::CODE_OK);
    if (request.command_case() != v1::Request::COMMAND_NOT_SET) {
      const v1::Reply reply = control.Ask(request);
      EXPECT_EQ(reply.code(), v1::CODE_OK) << reply.reason();
    }
    for (std::size_t i = 0; i < rigs.size(); ++i) {
      EXPECT_EQ(sims[i]->Wait(60).value_or(-1), 0) << ReadText(folder_ / (rigs[i] + ".txt"));
    }
    EXPECT_TRUE(subscriber.WaitFor(
        [&] {
          return subscriber.Frames("styled/").size() >= 2 * control.Counter("pipeline.frames");
        },
        10));
    Sleep(0.2);
    Streams streams;
    for (const auto& frame : subscriber.Frames("styled/")) {
      streams[frame.performer() + (frame.output() == v1::OUTPUT_RIG ? " rig" : " canonical")]
          .push_back(frame);
    }
    weights_ = folder_ / "weights.safetensors";
    std::filesystem::copy_file(weights.empty() ? daemon.folder / "weights.safetensors" : weights,
                               weights_);
    return streams;
  }

  int Styled(std::vector<std::string> arguments) {
    const std::string log = folder_ / ("styled" + std::to_string(runs_++) + ".txt");
    arguments.insert(arguments.begin(), {"/bin/sh", "-c", R"(exec "$0" "$@" >&2)", Binary()});
    Child styled(arguments, log);
    const int code = styled.Wait(60).value_or(-1);
    output_ = ReadText(log);
    return code;
  }

  Streams Read(const std::string& file) const {
    Streams streams;
    for (const auto& record : ReadAll(file)) {
      if (!record.published().topic().starts_with("styled/")) continue;
      v1::Frame frame;
      EXPECT_TRUE(frame.ParseFromString(record.published().payload()));
      streams[frame.performer() + (frame.output() == v1::OUTPUT_RIG ? " rig" : " canonical")]
          .push_back(frame);
    }
    return streams;
  }

  std::string take_ = folder_ / "take.styrec", weights_;

 private:
  int runs_ = 0;
};

// The recording has the style as numbers: the clip is not needed.
TEST_F(ReplayTest, AStyleOfAnExampleComesOutAsItDid) {
  const std::string weights = folder_ / "causal", clip = folder_ / "walk.bvh";
  const std::vector<std::byte> bytes = stgcn_causal::RandomWeights(4, 16, 1).Bytes();
  WriteText(weights, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  Child sim({StylesimBinary(), "--write", clip, "--seconds", "2"}, folder_ / "sim.txt");
  ASSERT_EQ(sim.Wait(60).value_or(-1), 0);
  v1::Request request;
  request.set_performer("*");
  request.mutable_like()->set_name("mine");
  request.mutable_like()->set_clip(ReadText(clip));
  const Streams live = Record(request, weights);
  ASSERT_EQ(Styled({"--replay", take_, "--replay-to", folder_ / "again.styrec", "--weights",
                    weights_, "--set", "style.initial=style2"}),
            0)
      << output_;
  const Streams again = Read(folder_ / "again.styrec");
  const std::string stream = "suit.sim rig";
  ASSERT_TRUE(again.contains(stream) && live.contains(stream)) << again.begin()->first;
  ExpectSame(Digests(again.at(stream)), Digests(live.at(stream)), stream);
  EXPECT_EQ(live.at(stream).back().styles(0).style(), "mine");
}

TEST_F(ReplayTest, SeveralRigsComeOutAsTheyDidAndTheSameAtEveryRun) {
  const Streams live = Record();
  ASSERT_EQ(live.size(), 8U) << "four performers, two outputs each";
  for (const char* const name : {"one.styrec", "two.styrec"}) {
    ASSERT_EQ(Styled({"--replay", take_, "--replay-to", folder_ / name, "--weights", weights_,
                      "--set", "style.initial=style2"}),
              0)
        << output_;
    EXPECT_NE(output_.find(" pipeline.frames="), std::string::npos) << output_;
    EXPECT_EQ(output_.find("other weights"), std::string::npos) << output_;
  }
  const auto one = ReadAll(folder_ / "one.styrec"), two = ReadAll(folder_ / "two.styrec");
  ASSERT_GT(one.size(), 1000U);
  ASSERT_EQ(one.size(), two.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    ASSERT_EQ(one[i].SerializeAsString(), two[i].SerializeAsString()) << i;
  }
  const Streams found = Read(folder_ / "one.styrec");
  ASSERT_EQ(found.size(), live.size());
  for (const auto& [stream, frames] : live) {
    ASSERT_TRUE(found.contains(stream)) << stream;
    // For trackers, and for VMC frames in several datagrams, the frame's time depends on the
    // daemon's clock.
    const bool exact = stream.starts_with("rig.") || stream.starts_with("suit.");
    if (exact) {
      ExpectSame(Digests(found.at(stream)), Digests(frames), stream);
    } else {
      EXPECT_NEAR(static_cast<double>(found.at(stream).size()), static_cast<double>(frames.size()),
                  5)
          << stream;
    }
  }
  const auto& last = found.at("rig.sim rig").back();
  ASSERT_EQ(last.styles_size(), 1) << "the command is in it";
  EXPECT_EQ(last.styles(0).style(), "style3");
}

// A daemon that stood still for a while skips frames and publishes late ones: a replay decides
// again, as a machine in time would, or performs the decisions of that daemon.
TEST_F(ReplayTest, AsDecidedFramesAreLateAndSkippedAsTheyWere) {
  const std::string topic = "styled/rig.a/canonical/", weights = folder_ / "weights.safetensors";
  std::vector<v1::Frame> live;
  {
    Daemon daemon({"record.file=" + take_, "style.initial=style2", "performers.backlog_ms=100"});
    Subscriber subscriber(daemon.publish, {"body/", topic});
    const UdpLink link(daemon.udp);
    Rig rig("a");
    link.Send(rig.Body());
    ASSERT_TRUE(subscriber.WaitForBody());
    const auto send = [&](int frames) { Paced(frames, 120, [&](int) { link.Send(rig.Frame()); }); };
    send(120);
    daemon.child->Signal(SIGSTOP);
    send(60);
    daemon.child->Signal(SIGCONT);
    send(120);
    ControlClient control(daemon.control);
    Sleep(0.5);  // all frames are through
    ASSERT_GT(control.Counter("pipeline.backlog_dropped"), 0U);
    live = subscriber.Frames(topic);
    std::filesystem::copy_file(daemon.folder / "weights.safetensors", weights);
  }
  const auto replay = [&](const std::string& name, std::vector<std::string> more) {
    std::vector<std::string> arguments{"--replay",  take_,   "--replay-to", folder_ / name,
                                       "--weights", weights, "--set",       "style.initial=style2"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    EXPECT_EQ(Styled(arguments), 0) << output_;
    return Read(folder_ / name).at("rig.a canonical");
  };
  const auto decided = replay("decided.styrec", {"--as-decided"});
  ASSERT_EQ(decided.size(), live.size());
  ExpectSame(Digests(decided), Digests(live), "as decided");
  for (std::size_t i = 0; i < live.size(); ++i) {
    ASSERT_EQ(decided[i].sequence(), live[i].sequence()) << i;
    ASSERT_EQ(decided[i].flags() & v1::FLAG_LATE, live[i].flags() & v1::FLAG_LATE) << i;
  }
  EXPECT_GT(replay("again.styrec", {}).size(), live.size()) << "in time, no frame is skipped";
}

// Gloves that fall silent: held and fading fingers are counted on the performer's clock.
TEST_F(ReplayTest, FingersOfGlovesComeOutAsTheyDid) {
  const std::string topic = "styled/rig.a/canonical/";
  std::vector<v1::Frame> live;
  {
    Daemon daemon({"record.file=" + take_},
                  "[[source]]\nname = \"gloves\"\ntype = \"udp\"\nlisten = \"127.0.0.1:0\"\n"
                  "merge_into = \"rig.a\"\nparts = [\"fingers\"]\n");
    Subscriber subscriber(daemon.publish, {"body/", topic});
    const UdpLink link(daemon.udp), gloves(daemon.listens.at(2));
    Rig rig("a"), glove("g", 11);
    v1::Body hand;
    for (const char* const name : {"leftHand", "leftIndexProximal", "leftIndexIntermediate"}) {
      hand.add_parents(hand.names_size() - 1);
      hand.add_names(name);
      for (const float value : {0.05F, 0.0F, 0.0F}) hand.add_offsets(value);
    }
    hand.set_performer("g");
    link.Send(rig.Body());
    gloves.Send(glove.Datagram(native::Kind::kBody, hand.SerializeAsString()));
    ASSERT_TRUE(subscriber.WaitForBody());
    Paced(240, 120, [&](int i) {
      const float half_rad = 0.01F * static_cast<float>(i);
      if (i < 80) {
        gloves.Send(glove.Frame([&](v1::SourceFrame& frame) {
          frame.clear_rotations();
          for (int joint = 0; joint < 3; ++joint) {
            for (const float value : {0.0F, 0.0F, std::sin(half_rad), std::cos(half_rad)}) {
              frame.add_rotations(value);
            }
          }
        }));
      }
      link.Send(rig.Frame());
    });
    ASSERT_TRUE(subscriber.WaitForFrames(240, topic)) << daemon.Log();
    live = subscriber.Frames(topic);
    weights_ = folder_ / "weights.safetensors";
    std::filesystem::copy_file(daemon.folder / "weights.safetensors", weights_);
    Sleep(0.2);
  }
  ASSERT_EQ(
      Styled({"--replay", take_, "--replay-to", folder_ / "again.styrec", "--weights", weights_}),
      0)
      << output_;
  const Streams again = Read(folder_ / "again.styrec");
  ASSERT_TRUE(again.contains("rig.a canonical"));
  ExpectSame(Digests(again.at("rig.a canonical")), Digests(live), topic);
  // The negative control: fingers that moved, were held, and went back.
  const auto finger = [](const v1::Frame& frame) {
    return frame.rotations(4 * (body::kJointCount + 3) + 2);  // leftIndexProximal, z
  };
  ASSERT_EQ(live.at(79).rotations_size(), 4 * (body::kJointCount + 30));
  EXPECT_GT(std::abs(finger(live.at(79))), 0.3F);
  EXPECT_EQ(finger(live.at(135)), finger(live.at(100))) << "held";
  EXPECT_LT(std::abs(finger(live.at(239))), 1e-6F);
}

TEST_F(ReplayTest, ErrorsAreNamed) {
  {
    Daemon daemon({"record.file=" + take_});
    weights_ = folder_ / "weights.safetensors";
    std::filesystem::copy_file(daemon.folder / "weights.safetensors", weights_);
    const UdpLink link(daemon.udp);
    Rig rig("sim");
    ControlClient control(daemon.control);
    link.Send(rig.Body());
    link.Send(rig.Frame());
    ASSERT_EQ(control.CounterSoon("pipeline.frames", 1), 1U);
    ASSERT_EQ(daemon.Stop(), 0);
  }
  const std::string out = folder_ / "out.styrec";
  EXPECT_EQ(Styled({"--replay", take_}), 2);
  EXPECT_NE(output_.find("--replay-to"), std::string::npos) << output_;
  EXPECT_EQ(Styled({"--replay", folder_ / "none.styrec", "--replay-to", out}), 2);
  EXPECT_NE(output_.find(folder_ / "none.styrec"), std::string::npos) << output_;
  const std::string published = RecordPublished("", "1");
  WriteText(folder_ / "one.toml",
            "[[source]]\nname = \"rig\"\ntype = \"udp\"\nlisten = \"127.0.0.1:0\"\n");
  EXPECT_EQ(Styled({"--replay", published, "--replay-to", out, "--config", folder_ / "one.toml",
                    "--weights", weights_}),
            1);
  EXPECT_NE(output_.find(published + ": found no data from a rig"), std::string::npos) << output_;
  WriteText(folder_ / "other.toml",
            "[[source]]\nname = \"other\"\ntype = \"udp\"\nlisten = \"127.0.0.1:0\"\n");
  EXPECT_EQ(Styled({"--replay", take_, "--replay-to", out, "--config", folder_ / "other.toml",
                    "--weights", weights_}),
            1);
  EXPECT_NE(output_.find("source rig (udp), which is not in the configuration"), std::string::npos)
      << output_;
  EXPECT_EQ(Styled({"--replay", take_, "--replay-to", take_, "--weights", weights_}), 1);
  EXPECT_NE(output_.find(take_), std::string::npos) << output_;
  const std::string others = folder_ / "others.safetensors";
  WriteRandomWeights(others, 5, 7);
  EXPECT_FALSE(std::filesystem::exists(out)) << "of what failed";
  EXPECT_EQ(Styled({"--replay", take_, "--replay-to", out, "--weights", others}), 0) << output_;
  EXPECT_NE(output_.find("recorded with other weights: weights.safetensors"), std::string::npos)
      << output_;
}

}  // namespace
}  // namespace styled::support
