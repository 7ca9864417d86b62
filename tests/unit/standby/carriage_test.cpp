// The performer's neutral in a pair: learned before the standby came, calibrated while it follows,
// and in force when it takes over.
#include <gtest/gtest.h>

#include "model/net/weights_file.h"
#include "tests/unit/standby/pair_test.h"

namespace styled::support {
namespace {

std::shared_ptr<pipeline::RuntimeConfig> WithReference() {
  auto config = MakeConfig();
  erd::WeightsFile weights = erd::RandomWeights(5, 3);
  neutral::Reference reference;
  reference.walking.rotations[body::kSpine] = body::Exp(body::Vec3(0.2F, 0, 0));
  reference.standing = reference.running = reference.walking;
  weights.metadata["version"] = net::kWeightsVersion;
  weights.metadata["reference"] = net::AsJson(reference);
  config->network = erd::StylizerOf(weights);
  return config;
}

class CarriageTest : public PairTest {
 protected:
  CarriageTest() {
    rig_ = Rig("a", 9);  // that stands
    config_ = WithReference();
    a_ = std::make_unique<Node>(wire_, true, 5, 1'000'000'000'000, config_, kTopics);
    Turn(1200);
  }
  static void Calibrate(Node& node, float seconds) {
    v1::Request request;
    request.set_performer("rig.a");
    request.mutable_calibrate()->set_neutral(true);
    request.mutable_calibrate()->set_seconds(seconds);
    const v1::Reply reply = node.Ask(request);
    EXPECT_EQ(reply.code(), v1::CODE_OK) << reply.reason();
  }
  static v1::NeutralStats Told(Node& node) {
    v1::Request request;
    request.mutable_status();
    const v1::Stats stats = node.Ask(request).status().stats();
    return stats.performers_size() == 1 ? stats.performers(0).neutral() : v1::NeutralStats();
  }
};

TEST_F(CarriageTest, ALateStandbyHasTheLearnedNeutral) {
  Begin();
  Wear(*a_, "style1", 0);
  Frames(200);
  ASSERT_GT(Told(*a_).learned(), 0.5F);
  StartB();
  Frames(100);
  EXPECT_TRUE(b_->State().ready()) << b_->State().why_not();
  EXPECT_EQ(Told(*b_).learned(), Told(*a_).learned());
  EXPECT_GT(b_->State().compared(), 80U);
  EXPECT_EQ(b_->State().different(), 0U);
}

TEST_F(CarriageTest, ARunningCalibrationEndsAtTheStandbyThatTookOver) {
  Alone witness(*this);
  Node& alone = witness.node;
  const auto send = [&](const Bytes& datagram) { witness.Send(datagram); };
  StartB();
  send(rig_.Body());
  for (Node* const node : {a_.get(), &alone}) Wear(*node, "style1", 0);
  for (int i = 0; i < 60; ++i) send(rig_.Frame());
  for (Node* const node : {a_.get(), &alone}) Calibrate(*node, 2);
  for (int i = 0; i < 60; ++i) send(rig_.Frame());
  ASSERT_GT(Told(*b_).calibrates_s(), 0.5F) << "it is under way";
  EXPECT_EQ(b_->State().different(), 0U);
  const auto left_behind = std::move(a_->publisher.frames);
  a_.reset();  // kill -9
  for (int i = 0; i < 300; ++i) send(rig_.Frame());
  EXPECT_EQ(b_->State().role(), "leading");
  EXPECT_TRUE(Told(*b_).calibrated());
  std::map<std::uint64_t, v1::Frame> seen;
  for (const auto& frame : left_behind) seen.emplace(frame.sequence(), frame);
  for (const auto& frame : b_->publisher.frames) seen.emplace(frame.sequence(), frame);
  ASSERT_EQ(seen.size(), alone.publisher.frames.size());
  for (const v1::Frame& whole : alone.publisher.frames) {
    const auto& frame = seen.at(whole.sequence());
    ASSERT_EQ(std::vector<float>(frame.rotations().begin(), frame.rotations().end()),
              std::vector<float>(whole.rotations().begin(), whole.rotations().end()))
        << whole.sequence();
  }
}

// The control of the others: who forgets what was learned moves otherwise.
TEST_F(CarriageTest, TheLearnedNeutralAffectsThePoses) {
  Begin();
  Wear(*a_, "style1", 0);
  Frames(200);
  StartB();
  Frames(20);
  ASSERT_EQ(b_->State().different(), 0U);
  wire_.change = [](v1::Journal& entry) { entry.clear_request(); };
  v1::Request forget;
  forget.set_performer("rig.a");
  forget.mutable_calibrate()->set_neutral(true);
  forget.mutable_calibrate()->set_clear(true);
  ASSERT_EQ(a_->Ask(forget).code(), v1::CODE_OK);
  Frames(100);
  EXPECT_GT(b_->State().different(), 50U);
}

}  // namespace
}  // namespace styled::support
