#include "tests/unit/doctor/facts.h"

namespace styled::doctor {
namespace {

using testing::Machine;

struct PerformersTest : ::testing::Test {
  PerformersTest() {
    machine.InDaemon("udp", "0.0.0.0:7000", 360);
    machine.LivePerformer("suit.b");
  }
  // A row of the status before and after; `refused` and `published` grow by these numbers.
  v1::PerformerStats& Add(const std::string& id, std::uint64_t refused, std::uint64_t published) {
    auto& before = *machine.facts.daemon.before.mutable_stats()->add_performers();
    before.set_performer(id);
    before.set_refused(1000);
    before.set_published(5000);
    auto& after = *machine.facts.daemon.after.mutable_stats()->add_performers();
    after = before;
    after.set_refused(1000 + refused);
    after.set_published(5000 + published);
    after.set_live(published > 0);
    return after;
  }
  std::vector<Finding> Of(const std::string& code) {
    std::vector<Finding> found;
    for (const Finding& finding : machine.Findings()) {
      if (finding.code == code) found.push_back(finding);
    }
    return found;
  }
  Machine machine;
};

TEST_F(PerformersTest, ARefusedPerformerBesideALiveOneIsAProblemWithItsReason) {
  Add("suit.a", 360, 0).set_refused_as("pipeline.far_ahead");
  const auto found = Of("performer_refused");
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].severity, Severity::kProblem);
  EXPECT_NE(found[0].what.find("suit.a: 360 datagrams arrived and no frame left"),
            std::string::npos)
      << found[0].what;
  EXPECT_NE(found[0].what.find("far ahead"), std::string::npos);
}

TEST_F(PerformersTest, AClockThatNothingDisciplinesIsANote) {
  EXPECT_TRUE(Of("clock_free").empty()) << "a daemon that says nothing of it";
  v1::ClockState& clock = *machine.facts.daemon.after.mutable_stats()->mutable_clock();
  ASSERT_EQ(Of("clock_free").size(), 1U);
  EXPECT_EQ(Of("clock_free")[0].severity, Severity::kNote);
  EXPECT_NE(Of("clock_free")[0].change.find("chrony"), std::string::npos);
  clock.set_source(v1::ClockState::SOURCE_PTP);
  EXPECT_NE(Of("clock_free")[0].change.find("phc2sys"), std::string::npos);
  clock.set_locked(true);
  EXPECT_TRUE(Of("clock_free").empty());
}

TEST_F(PerformersTest, AStandbyThatWouldNotGoOnIsWarnedOf) {
  EXPECT_TRUE(Of("standby_alone").empty()) << "a daemon without one";
  v1::StandbyState& standby = *machine.facts.daemon.after.mutable_stats()->mutable_standby();
  standby.set_role("leading");
  ASSERT_EQ(Of("standby_alone").size(), 1U);
  standby.set_heard(true);
  EXPECT_TRUE(Of("standby_alone").empty());
  standby.set_role("following");
  standby.set_why_not("it is of other weights");
  ASSERT_EQ(Of("standby_unready").size(), 1U);
  EXPECT_NE(Of("standby_unready")[0].what.find("other weights"), std::string::npos);
  standby.set_ready(true);
  EXPECT_TRUE(Of("standby_unready").empty());
  standby.add_without_input("suit.a");
  ASSERT_EQ(Of("standby_without_input").size(), 1U);
  EXPECT_NE(Of("standby_without_input")[0].what.find("suit.a"), std::string::npos);
}

TEST_F(PerformersTest, ALeadersStateOfItsPairIsAWarning) {
  v1::StandbyState& standby = *machine.facts.daemon.after.mutable_stats()->mutable_standby();
  standby.set_role("leading");
  standby.set_heard(true);
  for (const char* const code : {"standby_differs", "standby_too_large", "standby_refused"}) {
    EXPECT_TRUE(Of(code).empty()) << code;
  }
  standby.add_differs("model.feet: true here, false there");
  standby.set_too_large("style \"x\": 20000000 bytes");
  standby.set_refused(3);
  standby.set_refused_why("it is not an entry of a journal");
  ASSERT_EQ(Of("standby_differs").size(), 1U);
  EXPECT_NE(Of("standby_differs")[0].what.find("model.feet"), std::string::npos);
  ASSERT_EQ(Of("standby_too_large").size(), 1U);
  EXPECT_NE(Of("standby_too_large")[0].what.find("20000000"), std::string::npos);
  ASSERT_EQ(Of("standby_refused").size(), 1U);
  EXPECT_NE(Of("standby_refused")[0].what.find("3 messages"), std::string::npos);
}

TEST_F(PerformersTest, APerformerWhoLosesMoreThanHalfIsAWarning) {
  Add("suit.a", 300, 60).set_refused_as("pipeline.reordered");
  const auto found = Of("performer_refused");
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].severity, Severity::kWarning);
}

TEST_F(PerformersTest, WhoeverSendsAsAHealthyPerformerIsToldOfAndThePerformerIsNot) {
  Add("suit.a", 600, 180).set_refused_as("pipeline.second_sender");
  EXPECT_TRUE(Of("performer_refused").empty());
  ASSERT_EQ(Of("second_sender").size(), 1U);
  EXPECT_NE(Of("second_sender")[0].what.find("two senders send the same performer"),
            std::string::npos);
}

TEST_F(PerformersTest, AFewRefusedOnesAndOldOnesAreNothing) {
  Add("suit.a", 2, 358);
  Add("suit.c", 0, 0);  // was refused once, is silent now
  EXPECT_TRUE(Of("performer_refused").empty());
}

TEST_F(PerformersTest, TheReasonIsSaidOnceForTheSourceToo) {
  machine.facts.daemon.after.mutable_stats()->clear_performers();
  machine.Grow("pipeline.second_sender", 360);
  Add("suit.a", 360, 0).set_refused_as("pipeline.second_sender");
  EXPECT_EQ(Of("performer_refused").size(), 1U);
  EXPECT_TRUE(Of("second_sender").empty());
  EXPECT_TRUE(Of("no_frames").empty());
}

TEST_F(PerformersTest, AMirroredRigIsWarnedOf) {
  Add("suit.a", 0, 360).set_warning("the toes point backwards");
  ASSERT_EQ(Of("rig_warning").size(), 1U);
  EXPECT_NE(Of("rig_warning")[0].what.find("toes point backwards"), std::string::npos);
}

}  // namespace
}  // namespace styled::doctor
