// OptiTrack's way.
#include "tests/unit/doctor/facts.h"

namespace styled::doctor::testing {
namespace {

constexpr const char* kGroup = "239.255.42.99:1511";

class NatNetDiagnoseTest : public ::testing::Test {
 protected:
  NatNetDiagnoseTest() {
    machine_.NoDaemon();
    SourceFacts& source = machine_.Configured("natnet", "");
    source.group_interface = "192.0.2.1";
    NatNetAnswers& answers = source.natnet.emplace();
    answers.server = {"192.0.2.7", 1510};
    answers.answered = answers.model_answered = answers.model_read = true;
    answers.name = "Motive";
    answers.version = {3, 0};
    answers.group = "239.255.42.99";
    answers.skeletons = 1;
    machine_.facts.heard = {Frames("eth0")};
  }
  static Flow Frames(const std::string& interface) {
    return FlowTo(kGroup, What(Format::kNatNet, Verdict::kPose, "frames with skeletons"), 180,
                  interface);
  }
  SourceFacts& source() { return machine_.facts.sources.front(); }
  NatNetAnswers& answers() { return *source().natnet; }
  std::string Code() {
    const auto findings = machine_.Findings();
    EXPECT_EQ(findings.at(0).code, "no_daemon");
    return findings.size() > 1 ? findings[1].code : "";
  }
  Machine machine_;
};

TEST_F(NatNetDiagnoseTest, SkeletonsOnTheRightInterfaceAreWell) { EXPECT_EQ(Code(), ""); }

TEST_F(NatNetDiagnoseTest, AServerThatIsNotNamedIsAskedFor) {
  answers() = NatNetAnswers();
  answers().error = "server: \"\" is not an IPv4 address";
  EXPECT_EQ(Code(), "natnet_no_server");
}

TEST_F(NatNetDiagnoseTest, AServerThatDoesNotAnswerIsSaidWithWhoSendsInstead) {
  answers().answered = false;
  EXPECT_EQ(Code(), "natnet_no_answer");
  EXPECT_NE(machine_.Findings()[1].why.find("NatNet arrives from 192.0.2.9"), std::string::npos);
}

TEST_F(NatNetDiagnoseTest, AnOldVersionCannotBeUsed) {
  answers().version = {2, 5};
  EXPECT_EQ(Code(), "unusable_version");
}

TEST_F(NatNetDiagnoseTest, RigidBodiesAloneAreNoSkeleton) {
  answers().skeletons = 0;
  answers().rigid_bodies = 4;
  EXPECT_EQ(Code(), "no_skeleton");
  EXPECT_NE(machine_.Findings()[1].why.find("4 rigid bodies"), std::string::npos);
}

TEST_F(NatNetDiagnoseTest, AModelThatDoesNotComeOrCannotBeReadIsSaid) {
  answers().model_read = false;
  EXPECT_EQ(Code(), "no_skeleton");
  EXPECT_EQ(machine_.Findings()[1].why, "Its model could not be read.");
  answers().model_answered = false;
  EXPECT_EQ(Code(), "no_skeleton");
  EXPECT_EQ(machine_.Findings()[1].why, "It did not answer the request for its model.");
}

TEST_F(NatNetDiagnoseTest, FramesWithoutSkeletonsAreSaid) {
  machine_.facts.heard = {
      FlowTo(kGroup, What(Format::kNatNet, Verdict::kUseless, "frames without a skeleton"))};
  EXPECT_EQ(Code(), "no_skeleton");
}

TEST_F(NatNetDiagnoseTest, AGroupOnAnotherInterfaceIsSaidWithItsName) {
  machine_.facts.interfaces.push_back({"eth1", 3, true, true, true, false, {"10.0.0.1"}, {}});
  machine_.facts.heard = {Frames("eth1")};
  EXPECT_EQ(Code(), "multicast_elsewhere");
  EXPECT_NE(machine_.Findings()[1].change.find("interface = \"eth1\""), std::string::npos);
}

TEST_F(NatNetDiagnoseTest, AnInterfaceWithoutMulticastIsSaid) {
  machine_.facts.heard.clear();
  machine_.facts.interfaces[1].multicast = false;
  EXPECT_EQ(Code(), "interface_no_multicast");
}

TEST_F(NatNetDiagnoseTest, ASilentGroupIsSaid) {
  machine_.facts.heard.clear();
  EXPECT_EQ(Code(), "nothing_arrives");
  source().firewall = {Firewall::Verdict::kDropped, "inet filter input: drop"};
  EXPECT_EQ(Code(), "firewall_drops");
  EXPECT_NE(machine_.Findings()[1].what.find("1511/udp"), std::string::npos);
}

TEST_F(NatNetDiagnoseTest, AServerOfUnicastMustSendToWhoAsked) {
  machine_.facts.heard.clear();
  answers().multicast = false;
  EXPECT_EQ(Code(), "nothing_arrives");
  answers().frames.Add(What(Format::kNatNet, Verdict::kPose, "frames with skeletons"), 100);
  EXPECT_EQ(Code(), "");
}

TEST_F(NatNetDiagnoseTest, ADaemonThatMakesNoFramesOfItIsSaid) {
  machine_.facts.daemon.state = DaemonFacts::State::kAnswers;
  source().in_daemon = true;
  EXPECT_EQ(machine_.Codes(), "problem no_frames suit");
  machine_.LivePerformer("suit.anna");
  machine_.Grow("publish.subscriptions", 1);
  EXPECT_EQ(machine_.Codes(), "");
}

// As without --config: the daemon does not say which interface it expects the frames by.
TEST_F(NatNetDiagnoseTest, ASilentServerOfADaemonIsNamedThoughItIsNotAsked) {
  machine_.facts = Machine().facts;
  machine_.InDaemon("natnet", "192.0.2.7:1510", 0);
  EXPECT_EQ(machine_.Codes(), "problem nothing_arrives suit");
  EXPECT_NE(machine_.First().what.find("from its NatNet server at 192.0.2.7:1510"),
            std::string::npos);
  EXPECT_NE(machine_.First().change.find("--config"), std::string::npos);
  source().received = 40;
  EXPECT_EQ(machine_.Codes(), "problem no_frames suit");
  machine_.LivePerformer("suit.anna");
  machine_.Grow("publish.subscriptions", 1);
  EXPECT_EQ(machine_.Codes(), "");
}

TEST_F(NatNetDiagnoseTest, ASilentServerOfADaemonsFileIsNamed) {
  machine_.facts.daemon.state = DaemonFacts::State::kAnswers;
  source().in_daemon = true;
  source().received = 0;
  answers().answered = false;
  EXPECT_EQ(machine_.Codes(), "problem natnet_no_answer suit");
}

}  // namespace
}  // namespace styled::doctor::testing
