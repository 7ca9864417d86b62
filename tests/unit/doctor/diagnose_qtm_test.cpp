// Qualisys' way.
#include "tests/unit/doctor/facts.h"

namespace styled::doctor::testing {
namespace {

class QtmDiagnoseTest : public ::testing::Test {
 protected:
  QtmDiagnoseTest() {
    machine_.NoDaemon();
    QtmAnswers& answers = machine_.Configured("qtm", "192.0.2.7:22223").qtm.emplace();
    answers.server = {"192.0.2.7", 22223};
    answers.connected = answers.greeted = answers.skeletons_answered = true;
    answers.minor = 25;
    answers.skeletons = 1;
    answers.frames = answers.seen_frames = 30;
  }
  QtmAnswers& answers() { return *machine_.facts.sources.front().qtm; }
  Finding Found() {
    const auto findings = machine_.Findings();
    EXPECT_EQ(findings.at(0).code, "no_daemon");
    return findings.size() > 1 ? findings[1] : Finding();
  }
  bool Says(const std::string& text, const std::string& part) const {
    return text.find(part) != std::string::npos;
  }
  Machine machine_;
};

TEST_F(QtmDiagnoseTest, AStreamOfSkeletonsIsWell) { EXPECT_EQ(Found().code, ""); }

TEST_F(QtmDiagnoseTest, AServerThatIsNotNamedIsAskedFor) {
  answers() = QtmAnswers();
  answers().error = "server: \":22223\" is not an IPv4 address";
  EXPECT_EQ(Found().code, "qtm_no_server");
}

TEST_F(QtmDiagnoseTest, OneThatCannotBeReachedIsSaidWithWhatToDo) {
  answers() = QtmAnswers{.server = {"192.0.2.7", 22223}, .refused = "Connection refused"};
  EXPECT_EQ(Found().code, "qtm_no_connection");
  EXPECT_EQ(Found().why, "Connection refused.");
  EXPECT_TRUE(Says(Found().change, "TCP port 22223 pass. Does ping 192.0.2.7 work?"));
  answers().refused.clear();
  EXPECT_EQ(Found().why, "The connection is not answered.");
}

TEST_F(QtmDiagnoseTest, AnotherProgramAndAFullOneAreToldApart) {
  answers() = QtmAnswers{.server = {"192.0.2.7", 22223}, .connected = true, .text = "SSH-2.0"};
  EXPECT_EQ(Found().code, "qtm_no_greeting");
  EXPECT_EQ(Found().why, "It sent: SSH-2.0");
  answers().text = "Connection refused. Max number of clients reached.";
  EXPECT_EQ(Found().code, "qtm_full");
  answers().text.clear();
  EXPECT_EQ(Found().why, "It sent nothing.");
}

TEST_F(QtmDiagnoseTest, VersionSkeletonsAndMeasurementAreFollowedInOrder) {
  answers().seen_frames = 0;
  EXPECT_EQ(Found().code, "no_skeleton");
  EXPECT_TRUE(Says(Found().what, "sees no skeleton"));
  answers().frames = 0;
  EXPECT_EQ(Found().code, "nothing_arrives");
  EXPECT_EQ(Found().why, "None arrived in 3 s.");
  answers().no_measurement = true;
  EXPECT_EQ(Found().why, "It reports that there is no data.");
  answers().skeletons = 0;
  EXPECT_EQ(Found().code, "no_skeleton");
  EXPECT_TRUE(Says(Found().what, "has no skeleton"));
  answers().minor = 0;
  EXPECT_EQ(Found().code, "unusable_version");
}

TEST_F(QtmDiagnoseTest, ADaemonThatDoesNotHaveItIsSaidAndNotThatItsAddressIsAnother) {
  machine_.facts.daemon.state = DaemonFacts::State::kAnswers;
  EXPECT_EQ(machine_.First().code, "source_not_in_daemon");
}

}  // namespace
}  // namespace styled::doctor::testing
