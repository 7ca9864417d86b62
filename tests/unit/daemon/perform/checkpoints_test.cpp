// A checkpoint of one daemon's performer is restored by another daemon: the motion continues there,
// bit for bit. A checkpoint that cannot be restored changes nothing.
#include "daemon/perform/checkpoints.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "model/base/crc32c.h"
#include "model/clip/glb_write.h"
#include "model/feet/legs.h"
#include "tests/support/fake_pipeline.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/net/erd/random_weights.h"

namespace styled::pipeline {
namespace {

using support::FakePipeline;

// A running daemon's pipeline and its clock.
struct Stage {
  explicit Stage(const std::shared_ptr<RuntimeConfig>& config, std::int64_t uptime_ms = 0)
      : pipeline(config, "styled/rig.a/rig/") {
    pipeline.publisher.events.push_back({true, "styled/rig.a/canonical/"});
    pipeline.publisher.events.push_back({true, "styled/rig.a/stage/"});
    pipeline.publisher.events.push_back({true, "styled/rig.b/rig/"});
    pipeline.Work();
    pipeline.Pass(uptime_ms);
  }
  void Deliver(const support::Bytes& datagram) {
    pipeline.Deliver({datagram});
    clock_ns += 8'333'333;
    pipeline.clock.now_ns += 8'333'333;
    pipeline.Work();
  }
  // The frames since the last call, without what belongs to the daemon: its clock, and its number
  // where it has had the performer before.
  std::vector<std::string> Published() {
    std::vector<std::string> bytes;
    for (v1::Frame& frame : pipeline.publisher.frames) {
      frame.clear_sequence();
      frame.clear_receive_time_ns();
      frame.clear_publish_time_ns();
      frame.clear_wall_time_ns();
      bytes.push_back(frame.SerializeAsString());
    }
    pipeline.publisher.frames.clear();
    return bytes;
  }
  v1::Reply Accept(const std::string& performer = "rig.a") {
    v1::Request request;
    request.set_id(5);
    request.set_performer(performer);
    request.mutable_take_checkpoint();
    return pipeline.Ask(request);
  }
  v1::Reply Restore(const v1::Checkpoint& checkpoint, const std::string& performer = "") {
    v1::Request request;
    request.set_id(6);
    request.set_performer(performer);
    *request.mutable_restore_checkpoint()->mutable_checkpoint() = checkpoint;
    return pipeline.Ask(request);
  }
  void Set(const std::function<void(v1::Look&)>& change, const std::string& performer = "rig.a") {
    v1::Request request;
    request.set_performer(performer);
    change(*request.mutable_set());
    const v1::Reply reply = pipeline.Ask(request);
    ASSERT_EQ(reply.code(), v1::CODE_OK) << reply.reason();
  }
  void Wear(int style, float weight, float transition_ms) {
    Set([&](v1::Look& look) {
      auto& mix = *look.add_mix();
      mix.set_style(network->model().styles[static_cast<std::size_t>(style)].name);
      mix.set_weight(weight);
      look.set_transition_ms(transition_ms);
    });
  }
  FakePipeline pipeline;
  std::shared_ptr<const net::Stylizer> network;
  std::int64_t clock_ns = 0;
};

// Gives the checkpoint this state, with a checksum that is right.
void Seal(v1::Checkpoint& checkpoint, std::string state) {
  const std::uint32_t crc = Crc32c(std::as_bytes(std::span(state)));
  for (int bit = 0; bit < 32; bit += 8) state.push_back(static_cast<char>(crc >> bit & 0xffU));
  checkpoint.set_state(std::move(state));
}

struct CheckpointsTest : testing::Test {
  CheckpointsTest() {
    config->network = erd::RandomStylizer(5, 1);
    config->weights_name = "random.safetensors";
    config->weights_crc = 0x1234;
    config->stylist.limb_gate = false;  // of random weights little is shown
    config->smoothing = {{.rest_hz = 3}};
    // An avatar of half the performer's size.
    clip::Motion half;
    half.skeleton = feet::HumanoidBinding().skeleton();
    for (rig::Vec3& offset : half.skeleton.offsets) offset /= 2;
    half.metres_per_unit = 1;
    half.times_s = {0};
    half.frames = {rig::RigPose(half.skeleton)};
    const std::string file = folder / "half.glb";
    EXPECT_TRUE(clip::WriteGlb(half, file).ok());
    auto output = ReadRetargetOutput({.name = "stage", .avatar = file, .place = "test"});
    EXPECT_TRUE(output.ok()) << output.status().message();
    if (output.ok()) config->outputs = {output.value()};
  }
  std::unique_ptr<Stage> Start(std::int64_t uptime_ms = 0) const {
    auto stage = std::make_unique<Stage>(config, uptime_ms);
    stage->network = config->network;
    return stage;
  }
  // The same datagrams for all, with a limb that is not tracked now and then.
  std::vector<support::Bytes> Show(int frames, std::uint64_t session = 7) const {
    support::Rig rig("a", session);
    std::vector<support::Bytes> show{rig.Body()};
    for (int i = 0; i < frames; ++i) {
      show.push_back(i % 50 < 45 ? rig.Frame() : rig.Frame([](v1::SourceFrame& frame) {
        frame.set_rotations(20, std::numeric_limits<float>::quiet_NaN());
      }));
    }
    return show;
  }

  const support::TemporaryFolder folder;
  const std::shared_ptr<RuntimeConfig> config = std::make_shared<RuntimeConfig>();
};

TEST_F(CheckpointsTest, AnotherDaemonContinuesBitForBit) {
  const auto show = Show(240);
  const auto first = Start();
  std::map<int, std::unique_ptr<Stage>> others;
  for (int i = 0; i < 240; ++i) {
    const auto direct = [i](Stage& stage) {
      if (i == 40) stage.Wear(2, 1, 400);
      if (i == 130) stage.Wear(4, 0.7F, 300);
    };
    direct(*first);
    first->Deliver(show[static_cast<std::size_t>(i)]);
    const auto expected = first->Published();
    for (auto& [at, other] : others) {
      direct(*other);
      other->Deliver(show[static_cast<std::size_t>(i)]);
      ASSERT_TRUE(other->Published() == expected) << i << ", restored after " << at;
    }
    if (i % 37 != 10) continue;
    const v1::Reply taken = first->Accept();
    ASSERT_EQ(taken.code(), v1::CODE_OK) << taken.reason();
    EXPECT_EQ(taken.id(), 5U);
    auto other = Start(5'000 + i);  // its clock has nothing to do with the first one's
    const bool met = others.size() % 2 == 1;
    for (int past = 0; met && past < 60; ++past) {  // the performer was here, elsewhere in the show
      other->Deliver(show[static_cast<std::size_t>(past == 0 ? 0 : past + 100)]);
    }
    const v1::Reply restored = other->Restore(taken.checkpoint());
    ASSERT_EQ(restored.code(), v1::CODE_OK) << restored.reason();
    ASSERT_EQ(restored.applied_size(), 1);
    EXPECT_EQ(restored.applied(0).performer(), "rig.a");
    EXPECT_EQ(restored.applied(0).first_sequence(),
              std::max<std::uint64_t>(taken.checkpoint().sequence(), met ? 60 : 0));
    (void)other->Published();
    EXPECT_TRUE(other->Accept().checkpoint().state() == taken.checkpoint().state()) << i;
    others.emplace(i, std::move(other));
  }
  EXPECT_EQ(others.size(), 7U);
}

TEST_F(CheckpointsTest, AStateReplacesAPresentPerformer) {
  const auto show = Show(200);
  const auto first = Start(), second = Start(70);
  for (int i = 0; i < 200; ++i) {
    const auto& datagram = show[static_cast<std::size_t>(i)];
    if (i == 20) first->Wear(3, 1, 100);
    first->Deliver(datagram);
    second->Deliver(datagram);  // it has seen the same, but in no style
    const auto one = first->Published(), other = second->Published();
    if (i == 100) {
      const v1::Reply taken = first->Accept();
      const v1::Reply restored = second->Restore(taken.checkpoint());
      ASSERT_EQ(restored.code(), v1::CODE_OK) << restored.reason();
    }
    if (i > 60) EXPECT_EQ(one == other, i > 100) << i;
  }
}

TEST_F(CheckpointsTest, AStateIsRestoredUnderAnotherName) {
  const auto first = Start(), second = Start();
  const auto show = Show(90);
  for (int i = 0; i < 60; ++i) first->Deliver(show[static_cast<std::size_t>(i)]);
  const v1::Checkpoint checkpoint = first->Accept().checkpoint();
  ASSERT_EQ(second->Restore(checkpoint, "rig.b").code(), v1::CODE_OK);
  support::Rig rig("b");
  rig.sequence = 60;
  rig.time_ns += 59 * rig.period_ns;
  second->Deliver(rig.Frame());
  const auto& frames = second->pipeline.publisher.frames;
  ASSERT_FALSE(frames.empty()) << "the body came with the checkpoint";
  EXPECT_EQ(frames.back().performer(), "rig.b");
  EXPECT_EQ(frames.back().flags() & v1::FLAG_NEW_SESSION, 0U);
}

// A refusal gives the reason and changes nothing: the frames are the same as without the request.
TEST_F(CheckpointsTest, ARefusedCheckpointChangesNothing) {
  const auto first = Start(), second = Start();
  const auto show = Show(160);
  const auto both = [&](int from, int to) {
    for (int i = from; i < to; ++i) {
      first->Deliver(show[static_cast<std::size_t>(i)]);
      second->Deliver(show[static_cast<std::size_t>(i)]);
      ASSERT_TRUE(first->Published() == second->Published()) << i;
    }
  };
  first->Set([](v1::Look& look) { look.set_strength(0.9F); }, "rig.a");
  second->Set([](v1::Look& look) { look.set_strength(0.9F); }, "rig.a");
  both(0, 30);
  first->Wear(2, 1, 500);
  second->Wear(2, 1, 500);
  both(30, 50);
  const v1::Checkpoint good = second->Accept().checkpoint();
  const std::vector<std::pair<std::string, std::function<void(v1::Checkpoint&)>>> bad{
      {"version 0, expected 4", [](v1::Checkpoint& c) { c.Clear(); }},
      {"version 3, expected 4", [](v1::Checkpoint& c) { c.set_version(3); }},
      {"weights random.safetensors", [](v1::Checkpoint& c) { c.set_weights_crc(1); }},
      {"styles", [](v1::Checkpoint& c) { c.add_styles("pirate"); }},
      {"[[output]]", [](v1::Checkpoint& c) { c.add_outputs("hero"); }},
      {"strength", [](v1::Checkpoint& c) { c.mutable_look()->set_strength(1e30F); }},
      {"rest pose", [](v1::Checkpoint& c) { c.mutable_rest()->add_rotations(1); }},
      {"rest pose",
       [](v1::Checkpoint& c) {
         for (int i = 0; i < 4; ++i) c.mutable_rest()->add_canonical_from_source(1e30F);
       }},
      {"joint", [](v1::Checkpoint& c) { c.mutable_body()->Clear(); }},
      {"sequence", [](v1::Checkpoint& c) { c.set_sequence(0); }},
      {"sequence", [](v1::Checkpoint& c) { c.set_sequence(~std::uint64_t{0}); }},
      {"damaged", [](v1::Checkpoint& c) { c.mutable_state()->at(c.state().size() / 2) ^= 1; }},
      {"[stylist]", [](v1::Checkpoint& c) { Seal(c, c.state().substr(0, c.state().size() - 5)); }},
      {"state", [](v1::Checkpoint& c) { c.clear_state(); }},
      {"state", [](v1::Checkpoint& c) { c.mutable_state()->pop_back(); }},
      {"state", [](v1::Checkpoint& c) { c.mutable_state()->push_back('x'); }},
      {"state", [](v1::Checkpoint& c) { c.mutable_state()->assign(c.state().size(), '\xff'); }},
  };
  for (const auto& [why, spoil] : bad) {
    v1::Checkpoint checkpoint = good;
    spoil(checkpoint);
    const v1::Reply reply = second->Restore(checkpoint, "rig.a");
    EXPECT_EQ(reply.code(), v1::CODE_MALFORMED) << why;
    EXPECT_NE(reply.reason().find(why), std::string::npos) << reply.reason();
    EXPECT_EQ(reply.applied_size(), 0);
    EXPECT_EQ(second->Restore(checkpoint, "rig.new").code(), v1::CODE_MALFORMED) << why;
  }
  EXPECT_EQ(second->Accept("rig.new").code(), v1::CODE_UNKNOWN_PERFORMER);
  both(50, 160);
}

// A sender that can compute the checksum can send any state: it is refused, or the performer is
// styled within bounds and recovers after a reset.
TEST_F(CheckpointsTest, DamagedStatesHaveNoEffect) {
  const auto show = Show(80);
  const auto first = Start();
  for (int i = 0; i < 60; ++i) first->Deliver(show[static_cast<std::size_t>(i)]);
  const v1::Checkpoint good = first->Accept().checkpoint();
  const std::string state = good.state().substr(0, good.state().size() - 4);
  std::mt19937 random(1);
  int refused = 0;
  constexpr int kTries = 200;
  for (int attempt = 0; attempt < kTries; ++attempt) {
    std::string spoilt = state;
    // The session's numbers come first, the network's floats are most of the rest.
    const std::size_t reach = attempt % 2 == 0 ? 200 : spoilt.size();
    for (int i = 0; i < 6; ++i) spoilt[random() % reach] = static_cast<char>(random());
    v1::Checkpoint checkpoint = good;
    Seal(checkpoint, spoilt);
    const auto other = Start();
    if (other->Restore(checkpoint).code() != v1::CODE_OK) {
      ++refused;
      continue;
    }
    v1::Request reset;
    reset.set_performer("rig.a");
    reset.mutable_reset();
    for (int i = 60; i < 80; ++i) {
      if (i == 70) ASSERT_EQ(other->pipeline.Ask(reset).code(), v1::CODE_OK);
      other->Deliver(show[static_cast<std::size_t>(i)]);
    }
    for (const v1::Frame& frame : other->pipeline.publisher.frames) {
      for (const float number : frame.rotations()) ASSERT_TRUE(std::isfinite(number)) << attempt;
    }
  }
  EXPECT_GT(refused, kTries / 10);
  EXPECT_LT(refused, kTries);
}

TEST_F(CheckpointsTest, InvalidNamesAreRefused) {
  const auto stage = Start();
  stage->Deliver(Show(1)[0]);
  const v1::Checkpoint good = stage->Accept().checkpoint();
  for (const char* name : {"*", "a", "usb.a", "rig.", "rig.\n"}) {
    EXPECT_EQ(stage->Accept(name).code(), v1::CODE_UNKNOWN_PERFORMER) << name;
    const v1::Reply reply = stage->Restore(good, name);
    EXPECT_EQ(reply.code(), v1::CODE_UNKNOWN_PERFORMER) << name;
    EXPECT_NE(reply.reason().find("expected SOURCE.NAME"), std::string::npos) << reply.reason();
  }
  EXPECT_EQ(stage->Accept("rig.b").code(), v1::CODE_UNKNOWN_PERFORMER);
}

TEST_F(CheckpointsTest, AFullTableIsReported) {
  config->performers.max_performers = 1;
  const auto stage = Start();
  for (const auto& datagram : Show(3)) stage->Deliver(datagram);
  const v1::Checkpoint good = stage->Accept().checkpoint();
  const v1::Reply reply = stage->Restore(good, "rig.b");
  EXPECT_EQ(reply.code(), v1::CODE_BUSY) << reply.reason();
  EXPECT_EQ(stage->Restore(good).code(), v1::CODE_OK) << "in their own place";
}

}  // namespace
}  // namespace styled::pipeline
