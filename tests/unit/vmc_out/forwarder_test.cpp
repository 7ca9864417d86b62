#include "clients/vmc/forwarder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "proto/rigs/vmc/assembler.h"
#include "tests/unit/clients/fake_daemon.h"
#include "tests/unit/vmc_out/ear.h"

namespace styled::stylevmc {
namespace {

using client::FakeDaemon;
using client::HumanoidBody;
using client::HumanoidFrame;
using std::chrono::milliseconds;

std::string Topic(const std::string& id) { return "styled/" + id + "/canonical/"; }

class ForwarderTest : public testing::Test {
 protected:
  std::unique_ptr<Forwarder> Open(Options options, const std::vector<std::string>& to) const {
    options.publishers = {daemon_.publisher()};
    for (const auto& text : to) options.targets.push_back(ParseTarget(text).value());
    auto forwarder = Forwarder::Open(options);
    EXPECT_TRUE(forwarder.ok()) << forwarder.status().message();
    return std::move(forwarder.value());
  }
  v1::Body AddPerformer(const std::string& id) {
    v1::Body body = HumanoidBody(id, v1::OUTPUT_CANONICAL, 5);
    daemon_.AddBody(body);
    return body;
  }
  // A frame whose hips are `x` metres to the left, and a step of the forwarder's until it is out.
  void Show(Forwarder& forwarder, const v1::Body& body, float x) {
    body::Pose pose;
    pose.hips_position_m.x() = x;
    auto frame = HumanoidFrame(body, pose, ++sequence_);
    frame.set_source_time_ns(sequence_ * 20'000'000);
    daemon_.Publish(Topic(body.performer()), frame);
    for (int i = 0; i < 20; ++i) forwarder.Step(milliseconds(10));
  }
  void Await(Forwarder& forwarder, const std::string& id) {
    for (int i = 0; i < 200 && !daemon_.Subscribed(Topic(id)); ++i) {
      forwarder.Step(milliseconds(10));
    }
    ASSERT_TRUE(daemon_.Subscribed(Topic(id)));
  }
  // Unity's x of the hips in the next frame at `ear`; NaN where none comes.
  static float NextHips(const Ear& ear, int wait_ms = 1000) {
    for (;;) {
      const auto datagram = ear.Receive(wait_ms);
      if (datagram.empty()) return std::nanf("");
      vmc::osc::Reader reader(datagram);
      vmc::osc::Message bytes;
      while (reader.Next(bytes) == vmc::osc::Reader::Step::kMessage) {
        vmc::Message message;
        if (vmc::Decode(bytes, message) != vmc::DecodeResult::kOk) continue;
        const auto* bone = std::get_if<vmc::Bone>(&message);
        if (bone != nullptr && bone->name == "Hips") return bone->transform.position[0];
      }
    }
  }

  FakeDaemon daemon_;
  std::uint64_t sequence_ = 0;
};

TEST_F(ForwarderTest, SendsEveryTargetTheFirstPerformerThatMoves) {
  const Ear one, two;
  auto forwarder = Open({}, {one.address(), two.address()});
  const auto anna = AddPerformer("rig.anna"), ben = AddPerformer("rig.ben");
  Await(*forwarder, "rig.ben");
  Show(*forwarder, ben, 2);
  Show(*forwarder, anna, 1);
  Show(*forwarder, ben, 3);
  for (const Ear* ear : {&one, &two}) {
    EXPECT_EQ(NextHips(*ear), -2);
    EXPECT_EQ(NextHips(*ear), -3);
    EXPECT_TRUE(std::isnan(NextHips(*ear, 50)));
  }
  ASSERT_EQ(forwarder->channels().size(), 1U);
  EXPECT_EQ(forwarder->channels()[0].current, "rig.ben");
  EXPECT_EQ(forwarder->channels()[0].counts.frames, 2U);
}

TEST_F(ForwarderTest, SendsEachPerformerToItsOwnTargets) {
  const Ear annas, bens, free;
  Options options;
  options.performer = "rig.ben";
  auto forwarder =
      Open(options, {"rig.anna=" + annas.address(), "rig.ben=" + bens.address(), free.address()});
  const auto anna = AddPerformer("rig.anna"), ben = AddPerformer("rig.ben");
  Await(*forwarder, "rig.ben");
  Show(*forwarder, anna, 1);
  Show(*forwarder, ben, 2);
  EXPECT_EQ(NextHips(annas), -1);
  EXPECT_EQ(NextHips(bens), -2);
  EXPECT_EQ(NextHips(free), -2);
  for (const Ear* ear : {&annas, &bens, &free}) EXPECT_TRUE(std::isnan(NextHips(*ear, 50)));
}

TEST_F(ForwarderTest, ShowsAnotherOnceTheOneItShowedIsSilent) {
  const Ear ear;
  Options options;
  options.patience = std::chrono::milliseconds(1);
  auto forwarder = Open(options, {ear.address()});
  const auto anna = AddPerformer("rig.anna"), ben = AddPerformer("rig.ben");
  Await(*forwarder, "rig.ben");
  Show(*forwarder, anna, 1);
  std::this_thread::sleep_for(milliseconds(5));
  Show(*forwarder, ben, 2);
  EXPECT_EQ(NextHips(ear), -1);
  EXPECT_EQ(NextHips(ear), -2);
  EXPECT_EQ(forwarder->channels()[0].current, "rig.ben");
}

// Others' poses are not computed for us.
TEST_F(ForwarderTest, SubscribesToTheOneItIsToShowAlone) {
  const Ear ear;
  auto forwarder = Open({}, {"rig.anna=" + ear.address()});
  AddPerformer("rig.ben");
  AddPerformer("rig.anna");
  Await(*forwarder, "rig.anna");
  EXPECT_FALSE(daemon_.Subscribed(Topic("rig.ben")));
}

TEST_F(ForwarderTest, CountsFramesWithoutABodyAndGoesOnWhenItComes) {
  const Ear ear;
  auto forwarder = Open({}, {"rig.anna=" + ear.address()});
  Await(*forwarder, "rig.anna");
  const v1::Body body = HumanoidBody("rig.anna", v1::OUTPUT_CANONICAL, 5);
  Show(*forwarder, body, 1);
  EXPECT_EQ(forwarder->channels()[0].counts.bodiless, 1U);
  daemon_.AddBody(body);
  Show(*forwarder, body, 2);
  EXPECT_EQ(NextHips(ear), -2);
}

TEST_F(ForwarderTest, AnUnusableBodyIsNamed) {
  const Ear ear;
  auto forwarder = Open({}, {"rig.anna=" + ear.address()});
  Await(*forwarder, "rig.anna");
  v1::Body body = HumanoidBody("rig.anna", v1::OUTPUT_CANONICAL, 5);
  body.set_names(3, "giraffeNeck");
  daemon_.AddBody(body);
  Show(*forwarder, body, 1);
  EXPECT_THAT(forwarder->channels()[0].counts.last_error, testing::HasSubstr("'giraffeNeck'"));
  EXPECT_TRUE(std::isnan(NextHips(ear, 50)));
}

}  // namespace
}  // namespace styled::stylevmc
