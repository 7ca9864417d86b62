// Steps daemon, port, arrival and subscribers.
#include "clients/doctor/counter_words.h"
#include "tests/unit/doctor/facts.h"

namespace styled::doctor::testing {
namespace {

class DiagnoseTest : public ::testing::Test {
 protected:
  Machine machine_;
  Facts& facts_ = machine_.facts;
};

TEST_F(DiagnoseTest, WhereFramesGoThroughNothingIsFound) {
  machine_.InDaemon("mvn", "0.0.0.0:9763", 180);
  machine_.LivePerformer("suit.anna");
  machine_.Grow("publish.subscriptions", 1);
  EXPECT_EQ(machine_.Codes(), "");
}

TEST_F(DiagnoseTest, NoDaemonIsSaidFirstAndWhatArrivesIsNoProblem) {
  machine_.NoDaemon();
  machine_.Configured("mvn", "0.0.0.0:9763");
  facts_.heard = {MvnTo("192.0.2.1:9763")};
  EXPECT_EQ(machine_.Codes(), "problem no_daemon");
  EXPECT_NE(machine_.First().what.find("tcp://127.0.0.1:7002"), std::string::npos);
}

TEST_F(DiagnoseTest, ADaemonThatListensElsewhereIsShown) {
  machine_.NoDaemon();
  machine_.Configured("mvn", "0.0.0.0:9763");
  facts_.heard = {MvnTo("192.0.2.1:9763")};
  facts_.daemon.elsewhere = {{true, {"127.0.0.1", 7102}, 1, 0, 0, 4711, "styled"}};
  EXPECT_EQ(machine_.Codes(), "problem wrong_control_endpoint");
  EXPECT_EQ(machine_.First().why, "styled (pid 4711) listens on TCP 127.0.0.1:7102.");
}

TEST_F(DiagnoseTest, AStrangerAtTheControlPortIsNamed) {
  machine_.NoDaemon();
  machine_.Configured("mvn", "0.0.0.0:9763");
  facts_.heard = {MvnTo("192.0.2.1:9763")};
  facts_.daemon.holder = BoundSocket{true, {"127.0.0.1", 7002}, 1, 0, 0, 99, "python3"};
  EXPECT_EQ(machine_.Codes(), "problem control_taken");
  EXPECT_NE(machine_.First().why.find("python3 (pid 99)"), std::string::npos);
  facts_.daemon.state = DaemonFacts::State::kGarbled;
  EXPECT_EQ(machine_.Codes(), "problem not_a_daemon");
}

TEST_F(DiagnoseTest, ADaemonOnAnotherMachineIsJudgedByCountersOnly) {
  facts_.daemon.remote = true;
  machine_.InDaemon("mvn", "10.0.0.5:9763", 180);
  machine_.Configured("vmc", "0.0.0.0:39539", "face");
  machine_.Grow("pipeline.before_body", 180);
  EXPECT_EQ(machine_.Codes(), "problem no_skeleton suit; note remote_daemon");
}

TEST_F(DiagnoseTest, APortInForeignHandsIsNamedWithItsHolder) {
  machine_.NoDaemon();
  SourceFacts& source = machine_.Configured("mvn", "0.0.0.0:9763");
  source.port->kind = PortState::Kind::kInUse;
  source.holders = {{false, {"0.0.0.0", 9763}, 5, 0, 0, 321, "OtherReceiver"}};
  EXPECT_EQ(machine_.Codes(), "problem no_daemon; problem port_taken suit");
  const std::string what = machine_.Findings()[1].what;
  EXPECT_EQ(what,
            "0.0.0.0:9763/udp, where suit is to listen, is taken by OtherReceiver (pid 321).");
}

TEST_F(DiagnoseTest, AnotherAddressOfTheSamePortIsNotInTheWay) {
  machine_.NoDaemon();
  SourceFacts& source = machine_.Configured("mvn", "127.0.0.1:9763");
  source.port->kind = PortState::Kind::kPartly;
  source.holders = {{false, {"192.0.2.1", 9763}, 5, 0, 0, 321, "OtherReceiver"}};
  facts_.heard = {MvnTo("127.0.0.1:9763")};
  EXPECT_EQ(machine_.Codes(), "problem no_daemon");
}

TEST_F(DiagnoseTest, APortThatTheSystemRefusesIsSaid) {
  machine_.NoDaemon();
  SourceFacts& source = machine_.Configured("mvn", "0.0.0.0:97");
  source.port->kind = PortState::Kind::kRefused;
  source.port->why = "Permission denied";
  EXPECT_EQ(machine_.Codes(), "problem no_daemon; problem port_refused suit");
}

TEST_F(DiagnoseTest, AnAddressOfAnotherMachineCannotBeListenedTo) {
  machine_.NoDaemon();
  machine_.Configured("mvn", "192.0.2.77:9763");
  EXPECT_EQ(machine_.Codes(), "problem no_daemon; problem address_not_here suit");
  EXPECT_NE(machine_.Findings()[1].why.find("192.0.2.1 (eth0)"), std::string::npos);
}

TEST_F(DiagnoseTest, ASourceThatTheRunningDaemonDoesNotHaveIsSaid) {
  machine_.InDaemon("mvn", "0.0.0.0:9763", 180);
  machine_.LivePerformer("suit.anna");
  machine_.Grow("publish.subscriptions", 1);
  machine_.Configured("vmc", "0.0.0.0:39539", "face");
  EXPECT_EQ(machine_.Codes(), "problem source_not_in_daemon face");
}

TEST_F(DiagnoseTest, SilenceIsSaidWithTheAddressesToSendTo) {
  machine_.InDaemon("mvn", "0.0.0.0:9763", 0);
  facts_.firewall = "nft needs root's rights";
  EXPECT_EQ(machine_.Codes(), "problem nothing_arrives suit");
  const std::string change = machine_.First().change;
  for (const char* part :
       {"192.0.2.1 (eth0)", "port 9763 (UDP)", "Network Streamer", "sudo nft list ruleset"}) {
    EXPECT_NE(change.find(part), std::string::npos) << part << ": " << change;
  }
}

TEST_F(DiagnoseTest, ASilentSourceIsNotAProblemWhileItsNamesakeWorks) {
  machine_.InDaemon("udp", "127.0.0.1:7000", 100, "rig");
  machine_.InDaemon("tcp", "127.0.0.1:7000", 0, "rig");
  machine_.LivePerformer("rig.anna");
  machine_.Grow("publish.subscriptions", 1);
  EXPECT_EQ(machine_.Codes(), "");
}

TEST_F(DiagnoseTest, SilenceOfSourcesWithOneNameIsReportedOnce) {
  machine_.InDaemon("udp", "127.0.0.1:7000", 0, "rig");
  machine_.InDaemon("tcp", "127.0.0.1:7000", 0, "rig");
  EXPECT_EQ(machine_.Codes(), "problem nothing_arrives rig/udp");
  EXPECT_NE(machine_.First().what.find("127.0.0.1:7000/udp and 127.0.0.1:7000/tcp"),
            std::string::npos);
}

TEST_F(DiagnoseTest, TheFormatOnAnotherPortIsAWrongPort) {
  machine_.InDaemon("mvn", "0.0.0.0:9763", 0);
  facts_.heard = {MvnTo("192.0.2.1:9764")};
  EXPECT_EQ(machine_.Codes(), "problem wrong_port suit");
  EXPECT_NE(machine_.First().change.find("listen = \"0.0.0.0:9764\""), std::string::npos);
}

// Another source of that format may well be what it is meant for.
TEST_F(DiagnoseTest, DatagramsForAnotherSourceAreNotAWrongPort) {
  machine_.InDaemon("mvn", "0.0.0.0:9763", 0);
  machine_.InDaemon("mvn", "0.0.0.0:9764", 180, "second");
  machine_.LivePerformer("second.ben");
  machine_.Grow("publish.subscriptions", 1);
  facts_.heard = {MvnTo("192.0.2.1:9764")};
  EXPECT_EQ(machine_.Codes(), "problem nothing_arrives suit");
}

TEST_F(DiagnoseTest, TheFormatOverTcpIsAWrongProtocol) {
  machine_.NoDaemon();
  machine_.Configured("mvn", "0.0.0.0:9763");
  facts_.heard = {FlowTo("192.0.2.1:9763", What(Format::kMvn, Verdict::kPose, "quaternions (02)"),
                         180, "eth0", true)};
  EXPECT_EQ(machine_.Codes(), "problem no_daemon; problem wrong_protocol suit");
  EXPECT_NE(machine_.Findings()[1].change.find("type = \"mvn-tcp\""), std::string::npos);
}

TEST_F(DiagnoseTest, ALoopbackSourceDoesNotHearTheNetwork) {
  machine_.InDaemon("mvn", "127.0.0.1:9763", 0);
  facts_.heard = {MvnTo("192.0.2.1:9763")};
  EXPECT_EQ(machine_.Codes(), "problem wrong_address suit");
  EXPECT_NE(machine_.First().change.find("listen = \"0.0.0.0:9763\""), std::string::npos);
  EXPECT_NE(machine_.First().what.find("192.0.2.1:9763/udp"), std::string::npos);
}

TEST_F(DiagnoseTest, DatagramsAtTheInterfaceButNotHereAreDroppedBetween) {
  machine_.NoDaemon();
  machine_.Configured("mvn", "0.0.0.0:9763");
  facts_.capture.clear();
  facts_.seen = {MvnTo("192.0.2.1:9763")};
  EXPECT_EQ(machine_.Codes(), "problem no_daemon; problem firewall_drops suit");
  EXPECT_NE(machine_.Findings()[1].why.find("rp_filter"), std::string::npos);
}

TEST_F(DiagnoseTest, DatagramsAtTheInterfaceButNotAtTheDaemonAreDroppedBetween) {
  machine_.InDaemon("mvn", "0.0.0.0:9763", 0);
  facts_.capture.clear();
  facts_.seen = {MvnTo("192.0.2.1:9763")};
  EXPECT_EQ(machine_.Codes(), "problem firewall_drops suit");
}

TEST_F(DiagnoseTest, ARuleThatDropsThePortIsNamed) {
  machine_.InDaemon("mvn", "0.0.0.0:9763", 0).firewall = {Firewall::Verdict::kDropped,
                                                          "inet filter input: policy drop"};
  EXPECT_EQ(machine_.Codes(), "problem firewall_drops suit");
  EXPECT_EQ(machine_.First().why, "Rule: inet filter input: policy drop.");
  EXPECT_NE(machine_.First().change.find("ufw allow 9763/udp"), std::string::npos);
}

TEST_F(DiagnoseTest, ARuleThatMayDropIsSaidBesideTheSilence) {
  machine_.InDaemon("mvn", "0.0.0.0:9763", 0).firewall = {Firewall::Verdict::kDepends,
                                                          "ip filter ufw: reject"};
  EXPECT_EQ(machine_.Codes(), "problem nothing_arrives suit");
  EXPECT_NE(machine_.First().why.find("ip filter ufw: reject"), std::string::npos);
}

// Loopback, a tunnel: the arriving datagrams contradict the rules.
TEST_F(DiagnoseTest, WhereDatagramsArriveNoFirewallIsBlamed) {
  machine_.InDaemon("mvn", "0.0.0.0:9763", 180).firewall = {Firewall::Verdict::kDropped, "rule"};
  machine_.LivePerformer("suit.anna");
  machine_.Grow("publish.subscriptions", 1);
  EXPECT_EQ(machine_.Codes(), "");
}

TEST_F(DiagnoseTest, AFormatThatNobodyWantsIsOfferedASource) {
  machine_.NoDaemon();
  facts_.sources.emplace_back().expected = AssumedSources()[0];
  facts_.heard = {MvnTo("192.0.2.1:9763")};
  EXPECT_EQ(machine_.Codes(), "problem no_daemon; problem no_source");
  EXPECT_NE(machine_.Findings()[1].change.find("type = \"mvn\"\nlisten = \"0.0.0.0:9763\""),
            std::string::npos);
}

// It may be this machine's own output.
TEST_F(DiagnoseTest, AFormatThatNobodyWantsIsNotSpokenOfWhereAllIsWell) {
  machine_.InDaemon("mvn", "0.0.0.0:9763", 180);
  machine_.LivePerformer("suit.anna");
  machine_.Grow("publish.subscriptions", 1);
  facts_.heard = {FlowTo("127.0.0.1:39539", What(Format::kVmc, Verdict::kPose, "bones"))};
  EXPECT_EQ(machine_.Codes(), "");
}

TEST_F(DiagnoseTest, LossesAreWarnedOfThoughFramesFlow) {
  machine_.InDaemon("mvn", "0.0.0.0:9763", 180);
  machine_.LivePerformer("suit.anna");
  for (const char* counter :
       {"publish.subscriptions", "source.kernel_dropped", "pipeline.lost",
        "pipeline.backlog_dropped", "pipeline.second_sender", "source.takeovers_refused",
        "source.table_full", "source.tcp_refused"}) {
    machine_.Grow(counter, 7);
  }
  EXPECT_EQ(machine_.Codes(),
            "warning kernel_drops; warning lost_on_the_way; warning too_slow; "
            "warning takeover_refused; warning too_many_trackers; warning too_many_connections; "
            "warning second_sender");
  EXPECT_NE(machine_.First().change.find("receive_buffer_bytes"), std::string::npos);
}

TEST_F(DiagnoseTest, TheKernelNamesTheSourceOfDrops) {
  machine_.InDaemon("mvn", "0.0.0.0:9763", 180).drops = 40;
  machine_.LivePerformer("suit.anna");
  machine_.Grow("publish.subscriptions", 1);
  machine_.Grow("source.kernel_dropped", 38);
  EXPECT_EQ(machine_.Codes(), "warning kernel_drops suit");
  EXPECT_NE(machine_.First().what.find("40 datagrams for suit"), std::string::npos);
}

TEST_F(DiagnoseTest, AnUnexplainedCounterIsReportedInTheManualsWords) {
  machine_.InDaemon("mvn", "0.0.0.0:9763", 180);
  machine_.LivePerformer("suit.anna");
  machine_.Grow("publish.subscriptions", 1);
  machine_.Grow("stylist.fading", 200);  // of no trouble
  machine_.Grow("state.writes_failed", 3);
  machine_.Grow("pipeline.reordered", 2);
  machine_.Grow("a.counter_of_a_newer_daemon", 2);
  EXPECT_EQ(machine_.Codes(), "warning counter_grew; note counter_grew");
  EXPECT_EQ(machine_.First().what,
            "state.writes_failed grew by 3: settings that could not be written.");
  EXPECT_EQ(machine_.First().change, "the log gives the reason: disk full, permissions.");
}

TEST_F(DiagnoseTest, TheManualHasWordsForCountersWithoutItsMarks) {
  const CounterWords words = WordsOf("pipeline.duplicate");
  EXPECT_TRUE(words.known && words.trouble);
  EXPECT_FALSE(words.always);
  EXPECT_EQ(words.meaning, "a sequence number received before")
      << "the counters' table, not status's";
  EXPECT_EQ(WordsOf("stylist.failed").change,
            "record it ([record]) and report it; try other weights");
  EXPECT_FALSE(WordsOf("stylist.steps").trouble);
  EXPECT_FALSE(WordsOf("pipeline.invented").known);
}

TEST_F(DiagnoseTest, FramesThatLeaveTooLateAndStylesThatFadeForThemAreWarnedOf) {
  machine_.InDaemon("mvn", "0.0.0.0:9763", 180);
  machine_.LivePerformer("suit.anna");
  machine_.Grow("publish.subscriptions", 1);
  machine_.Grow("pipeline.over_budget_frames", 30);
  machine_.Grow("pipeline.overload_bypassed_frames", 90);
  auto& anna = *machine_.facts.daemon.after.mutable_stats()->mutable_performers(0);
  anna.set_over_budget(30);
  anna.set_published(3000);
  EXPECT_EQ(machine_.Codes(), "warning counter_grew; note over_budget") << "one in a hundred";
  anna.set_published(2999);
  EXPECT_EQ(machine_.Codes(), "warning over_budget; warning counter_grew");
  EXPECT_NE(machine_.First().what.find(": suit.anna 30 of 2999."), std::string::npos);
  anna.set_overload_bypass(true);
  EXPECT_EQ(machine_.Codes(), "warning over_budget; warning overload");
}

TEST_F(DiagnoseTest, ARecordingThatLacksRecordsOrDoesNotRunIsWarnedOf) {
  machine_.InDaemon("mvn", "0.0.0.0:9763", 180);
  machine_.LivePerformer("suit.anna");
  machine_.Grow("publish.subscriptions", 1);
  machine_.Grow("record.failures", 0);
  machine_.Grow("record.lost", 12);
  EXPECT_EQ(machine_.Codes(), "warning recording_incomplete");
  EXPECT_NE(machine_.First().what.find("lacks 12 records"), std::string::npos);
  machine_.facts.daemon.after.mutable_stats()->mutable_counters(2)->set_value(100);
  EXPECT_EQ(machine_.Codes(), "warning recording_incomplete") << "it failed, and is not on";
  machine_.Grow("record.on", 1);
  EXPECT_EQ(machine_.Codes(), "");
}

TEST_F(DiagnoseTest, WithoutSubscriberOrStyleThatIsNoted) {
  machine_.InDaemon("mvn", "0.0.0.0:9763", 180);
  machine_.LivePerformer("suit.anna", "");
  EXPECT_EQ(machine_.Codes(), "note no_subscriber; note bypass");
}

// By USB: there is no port to look at.
TEST_F(DiagnoseTest, ASourceWithoutAPortIsAskedForItsDevice) {
  machine_.InDaemon("slimevr-usb", "usb", 0);
  EXPECT_EQ(machine_.Codes(), "problem nothing_arrives suit");
  EXPECT_NE(machine_.First().change.find("plugged in"), std::string::npos);
  machine_.facts.sources.front().received = 100;
  EXPECT_EQ(machine_.Codes(), "");
}

TEST_F(DiagnoseTest, NoSourceThatReceivesNothingIsWell) {
  for (const char* type :
       {"udp", "tcp", "vmc", "mvn", "mvn-tcp", "mocopi", "natnet", "rokoko", "slimevr"}) {
    Machine machine;
    machine.InDaemon(type, "0.0.0.0:5000", 0);
    EXPECT_EQ(machine.Codes(), "problem nothing_arrives suit") << type;
    // Frames of a moment ago.
    machine.LivePerformer("suit.anna");
    machine.Grow("publish.subscriptions", 1);
    EXPECT_EQ(machine.Codes(), "problem nothing_arrives suit") << type;
    machine.InDaemon("udp", "0.0.0.0:5001", 100);
    EXPECT_EQ(machine.Codes(), "") << type << " beside one of the same name that receives";
  }
}

TEST_F(DiagnoseTest, ASenderIsAskedForTheProtocolOfTheSource) {
  for (const char* type : {"mvn", "mvn-tcp", "udp", "tcp"}) {
    Machine machine;
    const bool stream = machine.InDaemon(type, "0.0.0.0:27002", 0).expected.stream;
    const std::string change = machine.First().change;
    EXPECT_NE(change.find(stream ? "port 27002 (TCP)" : "port 27002 (UDP)"), std::string::npos);
    EXPECT_EQ(change.find(stream ? "UDP" : "TCP"), std::string::npos) << change;
    EXPECT_EQ(change.find(stream ? "udp://" : "tcp://"), std::string::npos) << change;
  }
}

}  // namespace
}  // namespace styled::doctor::testing
