// One viewer, a link or a full disk has no effect on the others. Counts of raw sockets.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <iostream>

#include "tests/e2e/nats/raw_subscribers.h"
#include "tests/e2e/nats/stage.h"
#include "tests/e2e/nats/tcp_relay.h"

namespace styled::support {
namespace {

using testing::HasSubstr;

constexpr const char* kCanonicals = "styled.hall.*.canonical";
constexpr int kViewers = 3;

// A daemon with two performers whose frames have 16 kB: 4 MB/s on one stream. Subscribers of it,
// and viewers of the hub.
class NatsTroubleTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!HasNatsServer()) GTEST_SKIP() << "skipped, no nats-server (Debian: nats-server)";
  }
  void Start() {
    servers_.StartHub();
    servers_.StartLeaf();
    bridge_ = std::make_unique<Stylenats>(daemon_, servers_.leaf_port);
    local_ = std::make_unique<RawSubscribers>(
        RawOptions{Wire::kZmtp,
                   daemon_.publish.substr(daemon_.publish.rfind(':') + 1),
                   "",
                   {"styled/rig.a/canonical/", "styled/rig.b/canonical/"}});
    viewers_ = std::make_unique<RawSubscribers>(
        RawOptions{Wire::kNats, servers_.hub_port, "viewer", {kCanonicals}, kViewers});
    ASSERT_TRUE(local_->ok()) << local_->error();
    ASSERT_TRUE(viewers_->ok()) << viewers_->error();
    walker_ = std::make_unique<Walker>(daemon_, std::vector<std::string>{"a", "b"}, 15000);
    ASSERT_TRUE(WaitUntil([this] { return viewers_->frames() > 60; }, 30)) << Log();
    local_->Begin();
    viewers_->Begin();
  }
  std::string Log() const { return bridge_->Log() + servers_.Log(); }
  // All that the daemon published came to each of its subscribers.
  void ExpectNothingHappenedHere() {
    const RawResult here = local_->Collect(0.5);
    EXPECT_GT(here.delivered, 100U);
    EXPECT_EQ(here.lost, 0U);
    EXPECT_EQ(here.doubled, 0U);
    EXPECT_EQ(bridge_->Count("missed,"), 0) << bridge_->Counters();
  }
  // All that stylenats sent came to each of the viewers.
  void ExpectNothingHappenedToViewers() {
    const RawResult there = viewers_->Collect();
    EXPECT_GT(there.delivered, 100U * kViewers);
    EXPECT_EQ(there.doubled, 0U);
    EXPECT_EQ(there.delivered % kViewers, 0U) << "the same for each";
    EXPECT_LE(there.lost / kViewers, static_cast<std::uint64_t>(bridge_->Count("replaced,")));
    std::cout << there.delivered << " frames, " << there.lost << " lost, p99 "
              << there.Quantile_ms(0.99) << " ms\n";
  }

  Daemon daemon_;
  NatsServers servers_;
  std::unique_ptr<Stylenats> bridge_;
  std::unique_ptr<RawSubscribers> local_, viewers_;
  std::unique_ptr<Walker> walker_;
};

TEST_F(NatsTroubleTest, AViewerThatStandsStillIsCutAndCountedAndNobodyElseLosesAFrame) {
  Start();
  if (HasFatalFailure()) return;
  const RawSubscribers still(
      {Wire::kNats, servers_.hub_port, "viewer", {"styled.>"}, 1, /*stopped=*/true});
  ASSERT_TRUE(still.ok()) << still.error();
  // Megabytes fit the kernel's buffers before a viewer that does not read is noticed.
  EXPECT_TRUE(WaitUntil(
      [this] { return servers_.Log().find("Slow Consumer Detected") != std::string::npos; }, 20))
      << servers_.Log();
  Sleep(1);
  EXPECT_EQ(viewers_->closed(), 0);
  ExpectNothingHappenedToViewers();
  ExpectNothingHappenedHere();
}

TEST_F(NatsTroubleTest, AfterACutLinkFramesComeAgainAndNothingOldDoes) {
  TcpRelay link(servers_.hub_leaf_port);
  // Or the leaf server learns the hub's own port and goes past the relay.
  servers_.Edit("hub", "listen: 127.0.0.1:" + servers_.hub_leaf_port,
                "listen: 127.0.0.1:" + servers_.hub_leaf_port +
                    "\n  advertise: \"127.0.0.1:" + link.port + "\"");
  servers_.leaf_reaches = link.port;
  Start();
  if (HasFatalFailure()) return;
  for (const auto& [state, seconds] :
       {std::pair{TcpRelay::State::kSilent, 5.0}, std::pair{TcpRelay::State::kClosed, 2.0}}) {
    const int connections = link.connections();
    (void)viewers_->Collect(0);
    viewers_->Begin();
    Sleep(0.3);
    link.Set(state);
    Sleep(0.5);
    const std::uint64_t cut = viewers_->frames();
    Sleep(seconds - 0.5);
    EXPECT_EQ(viewers_->frames(), cut) << "so the link is cut";
    link.Set(TcpRelay::State::kUp);
    ASSERT_TRUE(WaitUntil([&] { return viewers_->frames() > cut + 200; }, 20)) << Log();
    EXPECT_GT(link.connections(), connections) << "through the relay";
    const RawResult there = viewers_->Collect();
    EXPECT_EQ(there.doubled, 0U);
    EXPECT_GT(there.lost, 100U) << "those of the cut";
    // Frames of the cut would be seconds old.
    EXPECT_LT(there.Quantile_ms(1), 1000 * (seconds - 0.5));
    std::cout << there.lost << " lost, the oldest that came " << there.Quantile_ms(1) << " ms\n";
  }
  ExpectNothingHappenedHere();
}

// The bucket is in memory, frames are not stored. (Where a stream in files meets the full disk,
// nats-server 2.9.10 takes no frame from leaf servers any more: styled_nats_bench disk.)
TEST_F(NatsTroubleTest, AFullDiskDisturbsNoFrame) {
  if (!CanMount()) GTEST_SKIP() << "skipped, it may not mount a small file system";
  std::filesystem::create_directories(servers_.Folder());
  servers_.hub_under = OnSmallDisk(servers_.Folder(), true);
  Start();
  if (HasFatalFailure()) return;
  NatsUser viewer(servers_.hub_port, "viewer");
  EXPECT_TRUE(viewer.WaitForKey("hall.body.rig=2Ea.canonical")) << Log();
  Sleep(1);
  ExpectNothingHappenedToViewers();
  ExpectNothingHappenedHere();
}

}  // namespace
}  // namespace styled::support
