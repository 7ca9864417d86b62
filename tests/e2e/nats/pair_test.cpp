// The two daemons of a pair, each with a stylenats, are one site: commands have one answer, and
// frames continue in the same numbers when the leader is killed.
#include <gtest/gtest.h>
#include <signal.h>

#include <set>

#include "tests/e2e/nats/stage.h"

namespace styled::support {
namespace {

class NatsPairTest : public OnNatsServers {
 protected:
  std::string Standby(int own) const {
    const std::string name = "ipc://" + (folder_ / "journal");
    return "[standby]\naddress = \"" + name + std::to_string(own) + "\"\npeer = \"" + name +
           std::to_string(1 - own) + "\"\nfirst = " + (own == 0 ? "true" : "false") + "\n";
  }
  static v1::StandbyState State(const Daemon& daemon) {
    return ControlClient(daemon.control).Status().stats().standby();
  }
  TemporaryFolder folder_;
};

TEST_F(NatsPairTest, OneAnswerAndFramesThatGoOnWhenTheLeaderIsKilled) {
  Daemon leader({}, Standby(0)), standby({}, Standby(1));
  const Stylenats leaders("bridge", servers_.leaf_port, leader.publish, leader.control,
                          {"--domain", "hub"}),
      standbys("bridge", servers_.leaf_port, standby.publish, standby.control, {"--domain", "hub"});
  const std::string subject = "styled.hall.rig=2Ea.rig";
  NatsUser operator_(servers_.hub_port, "operator", "styled.>");
  const std::jthread rig([&](const std::stop_token& stop) {
    const UdpLink one(leader.udp), other(standby.udp);
    Rig walker("a");
    auto next = std::chrono::steady_clock::now();
    for (int i = 0; !stop.stop_requested(); ++i) {
      const Bytes body = i % 60 == 0 ? walker.Body() : Bytes();
      const Bytes frame = walker.Frame();
      for (const UdpLink* const link : {&one, &other}) {
        if (!body.empty()) link->Send(body);
        link->Send(frame);
      }
      next += std::chrono::nanoseconds(1'000'000'000 / 120);
      std::this_thread::sleep_until(next);
    }
  });
  ASSERT_TRUE(operator_.WaitFor(60, subject, 20)) << leaders.Log() << standbys.Log();
  ASSERT_TRUE(WaitUntil([&] { return State(standby).ready(); }, 20)) << standby.Log();

  v1::Request set;
  set.set_id(5);
  set.set_performer("rig.a");
  auto& mix = *set.mutable_set()->add_mix();
  mix.set_style("style2");
  mix.set_weight(1);
  for (int i = 0; i < 5; ++i) {  // the standby's bridge has five chances to answer first
    const auto reply = operator_.Ask(set);
    ASSERT_TRUE(reply.has_value());
    EXPECT_EQ(reply->code(), v1::CODE_OK) << reply->reason();
    v1::Request status;
    status.mutable_status();
    const auto shown = operator_.Ask(status);
    ASSERT_TRUE(shown.has_value());
    EXPECT_EQ(shown->status().stats().standby().role(), "leading");
  }

  leader.child->Signal(SIGKILL);
  ASSERT_TRUE(WaitUntil([&] { return State(standby).role() == "leading"; }, 20)) << standby.Log();
  const std::size_t before = operator_.Size(subject);
  ASSERT_TRUE(operator_.WaitFor(before + 120, subject, 20)) << standbys.Log();
  std::set<std::uint64_t> epochs, sequences;
  for (const Heard& frame : operator_.All(subject)) {
    epochs.insert(frame.epoch);
    sequences.insert(frame.sequence);
  }
  EXPECT_EQ(epochs.size(), 1U);
  // Of what was held back for 0.1 s the newest came.
  const std::uint64_t span = *sequences.rbegin() - *sequences.begin() + 1;
  EXPECT_GE(sequences.size() + 40, span);
  v1::Frame last;
  ASSERT_TRUE(last.ParseFromString(operator_.All(subject).back().payload));
  ASSERT_EQ(last.styles_size(), 1);
  EXPECT_EQ(last.styles(0).style(), "style2");
  const auto reply = operator_.Ask(set);
  ASSERT_TRUE(reply.has_value()) << "the standby's bridge answers now";
  EXPECT_EQ(reply->code(), v1::CODE_OK) << reply->reason();
}

}  // namespace
}  // namespace styled::support
