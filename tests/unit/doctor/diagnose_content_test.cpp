// Steps format to frames.
#include "tests/unit/doctor/facts.h"

namespace styled::doctor::testing {
namespace {

class ContentTest : public ::testing::Test {
 protected:
  // No daemon; a source of `type` where `what` arrives. Codes except for no_daemon.
  std::string CodesOf(const std::string& type, const std::vector<Sniffed>& what) {
    machine_ = Machine();
    machine_.NoDaemon();
    machine_.Configured(type, "0.0.0.0:9763");
    Flow flow = FlowTo("192.0.2.1:9763", what.at(0), 90);
    for (std::size_t i = 1; i < what.size(); ++i) flow.tally.Add(what[i], 90);
    flow.datagrams = flow.tally.Count();
    machine_.facts.heard = {flow};
    const std::string codes = machine_.Codes(), first = "problem no_daemon";
    EXPECT_TRUE(codes.starts_with(first)) << codes;
    return codes.size() > first.size() ? codes.substr(first.size() + 2) : "";
  }
  // A daemon whose source receives 100 datagrams that we cannot see, and this counter grows.
  std::string CodesOfCounter(const std::string& type, const std::string& counter,
                             std::uint64_t by = 100) {
    machine_ = Machine();
    machine_.InDaemon(type, "127.0.0.1:9763", 100);
    machine_.Grow(counter, by);
    return machine_.Codes();
  }
  Machine machine_;
};

TEST_F(ContentTest, AnotherFormatIsNamedWithTheTypeToSet) {
  EXPECT_EQ(CodesOf("mvn", {What(Format::kVmc, Verdict::kPose, "bones")}),
            "problem wrong_format suit");
  const Finding finding = machine_.Findings()[1];
  EXPECT_EQ(finding.what,
            "VMC arrives at 0.0.0.0:9763/udp, but suit is of type \"mvn\" (Xsens MVN).");
  EXPECT_NE(finding.change.find("type = \"vmc\""), std::string::npos);
}

TEST_F(ContentTest, AnUnknownFormatIsDescribed) {
  EXPECT_EQ(CodesOf("mvn", {What(Format::kUnknown, Verdict::kForeign, "text: hello")}),
            "problem unknown_format suit");
  EXPECT_NE(machine_.Findings()[1].why.find("text: hello 90"), std::string::npos);
}

TEST_F(ContentTest, TwoFormatsOnOnePortAreWarnedOf) {
  EXPECT_EQ(CodesOf("mvn", {What(Format::kMvn, Verdict::kPose, "quaternions (02)"),
                            What(Format::kUnknown, Verdict::kForeign, "text: hello")}),
            "warning mixed_formats suit");
}

TEST_F(ContentTest, ASourceOfAnUnknownTypeHasNoFindingAboutItsFormat) {
  EXPECT_EQ(CodesOf("holodeck", {What(Format::kVmc, Verdict::kPose, "bones")}), "");
}

TEST_F(ContentTest, AModeThatCannotBeUsedIsNamed) {
  EXPECT_EQ(CodesOf("mvn", {What(Format::kMvn, Verdict::kUseless, "Unity3D poses (05)"),
                            What(Format::kMvn, Verdict::kTalk, "names (12)")}),
            "problem unusable_mode suit");
  EXPECT_EQ(machine_.Findings()[1].why, "It sends: Unity3D poses (05) 90.");
  EXPECT_NE(machine_.Findings()[1].change.find("Quaternion"), std::string::npos);
}

TEST_F(ContentTest, BesidePosesOtherModesAreWelcome) {
  EXPECT_EQ(CodesOf("mvn", {What(Format::kMvn, Verdict::kUseless, "centre of mass (24)"),
                            What(Format::kMvn, Verdict::kPose, "quaternions (02)")}),
            "");
}

TEST_F(ContentTest, AVersionThatCannotBeUsedIsNamed) {
  EXPECT_EQ(CodesOf("udp", {What(Format::kNative, Verdict::kUseless, "version 9")}),
            "problem unusable_version suit");
  EXPECT_EQ(
      CodesOf("mocopi", {What(Format::kMocopi, Verdict::kUseless, "a version that is not 1")}),
      "problem unusable_version suit");
}

TEST_F(ContentTest, TalkWithoutPosesIsNamed) {
  EXPECT_EQ(CodesOf("vmc", {What(Format::kVmc, Verdict::kTalk, "facial expressions")}),
            "problem no_pose suit");
  EXPECT_EQ(CodesOf("mocopi", {What(Format::kMocopi, Verdict::kSkeleton, "skeleton (skdf)")}),
            "problem no_pose suit");
}

TEST_F(ContentTest, TrackersThatSeekAServerAreWellWhileThereIsNone) {
  const auto seek = What(Format::kSlimeVr, Verdict::kTalk, "trackers seeking a server");
  EXPECT_EQ(CodesOf("slimevr", {seek}), "");
}

TEST_F(ContentTest, MostlyDamagedIsAProblemAndALittleAWarning) {
  const auto bad = What(Format::kNative, Verdict::kDamaged, "bad checksum");
  const auto body = What(Format::kNative, Verdict::kSkeleton, "skeletons");
  const auto good = What(Format::kNative, Verdict::kPose, "frames");
  EXPECT_EQ(CodesOf("udp", {bad}), "problem damaged suit");
  EXPECT_EQ(machine_.Findings()[1].why, "Refused as: bad checksum 90.");
  EXPECT_EQ(CodesOf("udp", {bad, good, body}), "warning damaged suit");
}

TEST_F(ContentTest, FramesWithoutASkeletonNeedTimeToBeSureOf) {
  const auto frames = What(Format::kNative, Verdict::kPose, "frames");
  EXPECT_EQ(CodesOf("udp", {frames}), "problem no_skeleton suit");
  machine_.facts.seconds = 1;  // it comes once a second
  EXPECT_EQ(machine_.Codes(), "problem no_daemon");
  EXPECT_EQ(CodesOf("udp", {frames, What(Format::kNative, Verdict::kSkeleton, "skeletons")}), "");
  EXPECT_EQ(CodesOf("mocopi", {What(Format::kMocopi, Verdict::kPose, "poses (fram)")}), "")
      << "the daemon knows mocopi's skeleton";
}

TEST_F(ContentTest, LargeDatagramsOfWhichOnlyTheBeginningIsSeenAreNotJudged) {
  EXPECT_EQ(CodesOf("rokoko", {What(Format::kRokoko, Verdict::kCut, "large datagrams")}), "");
}

TEST_F(ContentTest, WhereBytesCannotBeSeenTheCountersTell) {
  EXPECT_EQ(CodesOfCounter("udp", "source.bad_magic"), "problem wrong_format suit");
  EXPECT_NE(machine_.First().change.find("With sudo"), std::string::npos);
  EXPECT_EQ(CodesOfCounter("mvn", "source.malformed"), "problem wrong_format suit");
  EXPECT_EQ(CodesOfCounter("udp", "source.malformed"), "problem damaged suit");
  EXPECT_EQ(CodesOfCounter("udp", "source.bad_version"), "problem unusable_version suit");
  for (const char* counter :
       {"source.bad_checksum", "source.too_short", "source.too_long", "source.length_mismatch",
        "source.bad_reserved", "source.bad_kind", "source.no_session"}) {
    EXPECT_EQ(CodesOfCounter("udp", counter), "problem damaged suit") << counter;
  }
}

TEST_F(ContentTest, DatagramsWithoutFramesAreNamedByTheDaemonsReason) {
  const std::vector<std::pair<const char*, const char*>> cases{
      {"pipeline.before_body", "no_skeleton"},
      {"pipeline.bodies_refused", "skeleton_refused"},
      {"pipeline.wrong_body", "skeleton_mismatch"},
      {"pipeline.wrong_size", "skeleton_mismatch"},
      {"pipeline.performers_refused", "too_many_performers"},
      {"pipeline.second_sender", "second_sender"},
      {"source.bad_name", "bad_name"},
      {"pipeline.old_time", "clock_stands"},
      {"source.incomplete", "incomplete"},
      {"source.ignored", "no_pose"}};
  for (const auto& [counter, code] : cases) {
    EXPECT_EQ(CodesOfCounter("udp", counter), "problem " + std::string(code) + " suit") << counter;
  }
}

// The daemon counts all sources together.
TEST_F(ContentTest, AnotherSourcesPossibleFaultIsNotAttributedToThisOne) {
  const std::pair<const char*, const char*> cases[] = {
      {"pipeline.before_body", "problem no_frames suit"},  // which names it
      {"source.bad_magic", "problem no_frames suit; warning counter_grew"}};
  for (const auto& [counter, codes] : cases) {
    machine_ = Machine();
    machine_.InDaemon("udp", "127.0.0.1:9763", 100);
    machine_.InDaemon("udp", "127.0.0.1:9764", 300, "loud");
    machine_.LivePerformer("loud.ben");
    machine_.Grow("publish.subscriptions", 1);
    machine_.Grow(counter, 100);
    EXPECT_EQ(machine_.Codes(), codes) << counter;
  }
  machine_ = Machine();
  machine_.InDaemon("udp", "127.0.0.1:9763", 100);
  machine_.InDaemon("udp", "127.0.0.1:9764", 300, "loud");
  machine_.LivePerformer("loud.ben");
  machine_.Grow("publish.subscriptions", 1);
  machine_.Grow("pipeline.before_body", 100);
  EXPECT_NE(machine_.First().why.find("of this source or of another that receives: "
                                      "pipeline.before_body"),
            std::string::npos)
      << machine_.First().why;
  machine_.facts.sources[1].received = 20;
  EXPECT_EQ(machine_.Codes(), "problem no_skeleton suit") << "80 at least are this one's";
  EXPECT_NE(machine_.First().why.find("grew by 80 while 100"), std::string::npos);
}

TEST_F(ContentTest, TwoPhonesOnOnePortAreToldToTakeTwoSources) {
  SourceFacts& phone = machine_.InDaemon("livelinkface", "0.0.0.0:11111", 360, "phone");
  phone.expected.merge_into = "stage.anna";
  machine_.InDaemon("udp", "127.0.0.1:7000", 360, "stage");
  machine_.LivePerformer("stage.anna");
  machine_.Grow("publish.subscriptions", 1);
  machine_.Grow("pipeline.second_sender", 180);
  const auto smile = What(Format::kLiveLinkFace, Verdict::kPose, "facial expressions");
  machine_.facts.seen = {FlowTo("192.0.2.1:11111", smile), FlowTo("192.0.2.1:11111", smile)};
  machine_.facts.seen.back().from.host = "192.0.2.10";
  EXPECT_EQ(machine_.Codes(), "warning second_sender phone");
  const Finding finding = machine_.First();
  EXPECT_NE(finding.what.find("only the first is shown on stage.anna"), std::string::npos);
  EXPECT_NE(finding.why.find("192.0.2.9, 192.0.2.10"), std::string::npos) << finding.why;
  EXPECT_NE(finding.change.find("own port in listen"), std::string::npos);
}

TEST_F(ContentTest, TheCureForAFaceNamesWhoGetsIt) {
  machine_.InDaemon("udp", "127.0.0.1:7000", 360, "stage");
  machine_.InDaemon("udp", "127.0.0.1:7010", 0, "other");  // otherwise the phone is not mentioned
  machine_.LivePerformer("stage.anna");
  machine_.Grow("publish.subscriptions", 1);
  const auto smile = What(Format::kLiveLinkFace, Verdict::kPose, "facial expressions");
  machine_.facts.seen = {FlowTo("192.0.2.1:11111", smile)};
  const auto findings = machine_.Findings();
  const auto found = std::ranges::find(findings, "no_source", &Finding::code);
  ASSERT_NE(found, findings.end()) << machine_.Codes();
  EXPECT_EQ(found->change.find("merge_into"), std::string::npos) << found->change;
  machine_.LivePerformer("stage.ben");
  const auto of_two = machine_.Findings();
  const auto named = std::ranges::find(of_two, "no_source", &Finding::code);
  ASSERT_NE(named, of_two.end());
  EXPECT_NE(named->change.find("merge_into = \"stage.anna\""), std::string::npos) << named->change;
}

TEST_F(ContentTest, APhoneWhoseFaceNoPerformerGetsIsAProblem) {
  machine_.InDaemon("udp", "127.0.0.1:7000", 360, "stage");
  SourceFacts& phone = machine_.InDaemon("livelinkface", "0.0.0.0:11111", 360, "phone");
  phone.expected.merge_into = "*";
  machine_.LivePerformer("stage.stage");
  machine_.Grow("publish.subscriptions", 1);
  EXPECT_EQ(machine_.Codes(), "");
  phone.stray = "its data are for stage.anna, who is not here; here is stage.stage";
  EXPECT_EQ(machine_.Codes(), "problem not_merged phone");
  EXPECT_NE(machine_.First().why.find("who is not here; here is stage.stage"), std::string::npos);
}

TEST_F(ContentTest, ASenderWithoutABodyIsAdvisedToNameThePerformer) {
  SourceFacts& gloves = machine_.InDaemon("vmc", "0.0.0.0:39540", 100, "gloves");
  EXPECT_EQ(machine_.Codes(), "problem no_frames gloves");
  EXPECT_NE(machine_.First().change.find("merge_into = \"SOURCE.NAME\""), std::string::npos)
      << machine_.First().change;
  gloves.expected.merge_into = "stage.anna";
  EXPECT_EQ(machine_.Codes(), "");
}

TEST_F(ContentTest, ThePhoneThatIsAskedAlreadyIsNotToBeSetAgain) {
  SourceFacts& phone = machine_.InDaemon("ifacialmocap", "0.0.0.0:49983", 0, "phone");
  phone.expected.merge_into = "stage.anna";
  EXPECT_NE(machine_.First().change.find("set `server`"), std::string::npos);
  phone.expected.server = "192.0.2.20";
  EXPECT_EQ(machine_.First().change.find("set `server`"), std::string::npos);
  EXPECT_NE(machine_.First().change.find("asks the phone at 192.0.2.20"), std::string::npos)
      << machine_.First().change;
}

// Once a second, beside many frames.
TEST_F(ContentTest, AFewRefusedSkeletonsAreEnough) {
  EXPECT_EQ(CodesOfCounter("udp", "pipeline.bodies_refused", 3), "problem skeleton_refused suit");
}

// Of a frame that comes in several datagrams one refusal is counted.
TEST_F(ContentTest, AFewFramesThatLackAPartAreEnough) {
  EXPECT_EQ(CodesOfCounter("mvn", "source.incomplete", 20), "problem incomplete suit");
  EXPECT_NE(machine_.First().change.find("only a part of the body"), std::string::npos);
}

TEST_F(ContentTest, APerformerWithLostDatagramsIsNamed) {
  machine_.InDaemon("udp", "127.0.0.1:7000", 100, "rig");
  machine_.LivePerformer("rig.anna");
  machine_.LivePerformer("rig.ben");
  machine_.Grow("publish.subscriptions", 1);
  *machine_.facts.daemon.before.mutable_stats()->mutable_performers() =
      machine_.facts.daemon.after.stats().performers();
  machine_.facts.daemon.after.mutable_stats()->mutable_performers(1)->set_lost(7);
  machine_.Grow("pipeline.lost", 7);
  EXPECT_EQ(machine_.Codes(), "warning lost_on_the_way");
  EXPECT_EQ(machine_.First().what,
            "7 datagrams were lost between the rig and the daemon, of rig.ben.");
}

// The frames are those of the performer that it is merged into.
TEST_F(ContentTest, AFaceNeedsNoPerformerOfItsOwnSource) {
  machine_.InDaemon("livelinkface", "0.0.0.0:11111", 100).expected.merge_into = "*";
  EXPECT_EQ(machine_.Codes(), "");
  machine_ = Machine();
  machine_.InDaemon("ifacialmocap", "0.0.0.0:49983", 100).expected.merge_into = "stage.anna";
  machine_.Grow("source.incomplete", 100);
  EXPECT_EQ(machine_.Codes(), "note counter_grew");
}

TEST_F(ContentTest, AFaceAloneIsAPerformer) {
  EXPECT_EQ(CodesOfCounter("livelinkface", "nothing.at_all"), "problem no_frames suit");
  EXPECT_EQ(CodesOfCounter("ifacialmocap", "source.incomplete"), "problem no_face suit");
  EXPECT_NE(machine_.First().what.find("sees no face"), std::string::npos);
}

TEST_F(ContentTest, WithoutAReasonTheLogIsPointedTo) {
  EXPECT_EQ(CodesOfCounter("mvn", "nothing.at_all"), "problem no_frames suit");
  EXPECT_EQ(CodesOfCounter("slimevr", "nothing.at_all"), "problem needs_reset suit");
}

TEST_F(ContentTest, SeenBytesGoBeforeCounters) {
  machine_.InDaemon("mvn", "0.0.0.0:9763", 100);
  machine_.Grow("source.malformed", 100);
  machine_.facts.seen = {FlowTo("192.0.2.1:9763", What(Format::kVmc, Verdict::kPose, "bones"))};
  EXPECT_EQ(machine_.Codes(), "problem wrong_format suit");
  EXPECT_NE(machine_.First().what.find("VMC arrives"), std::string::npos);
}

}  // namespace
}  // namespace styled::doctor::testing
