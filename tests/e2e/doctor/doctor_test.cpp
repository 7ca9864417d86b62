// "Connected, but nothing arrives": each failure is set up with the real programs, and the doctor
// must name it. If the kernel permits a network namespace, other tests on this machine are not
// audible; otherwise the doctor listens on its own sockets only.
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/e2e/doctor/stage.h"
#include "tests/support/daemon.h"

namespace styled::support {
namespace {

using testing::AnyOf;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kRate_hz = 60;

// A rig's own datagrams: its body, then frames, and the body again once per second.
std::function<Bytes()> Performer(bool with_body) {
  auto rig = std::make_shared<Rig>("anna");
  rig->period_ns = static_cast<std::uint64_t>(1e9 / kRate_hz);
  auto count = std::make_shared<int>(0);
  return [=] { return (*count)++ % 60 == 0 && with_body ? rig->Body() : rig->Frame(); };
}

TEST_F(DoctorTest, BadOptionsAreRefused) {
  EXPECT_EQ(Doctor({"--config", "/nowhere/styled.toml"}).code, 2);
  EXPECT_EQ(Doctor({"--listen", "suit=1"}).code, 2);
  EXPECT_EQ(Doctor({"--source", "nobody"}).code, 2);
  EXPECT_EQ(Doctor({"--seconds", "nan"}).code, 2);
}

TEST_F(DoctorTest, WithoutDaemonAndSenderBothAreSaid) {
  const Report report = Doctor({"--config", Config("mvn", Local(FreePort()))});
  // Other tests run daemons on the same machine.
  EXPECT_THAT(report.problems, AnyOf(ElementsAre("no_daemon", "nothing_arrives"),
                                     ElementsAre("wrong_control_endpoint", "nothing_arrives")));
  EXPECT_TRUE(!own_network || report.problems.at(0) == "no_daemon");
  EXPECT_THAT(report.Of("nothing_arrives", "change"), HasSubstr("Network Streamer"));
}

TEST_F(DoctorTest, APortThatAnotherProgramHoldsIsNamedWithItsProcess) {
  const int holder = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  socklen_t size = sizeof address;
  ASSERT_EQ(bind(holder, reinterpret_cast<sockaddr*>(&address), size), 0);
  getsockname(holder, reinterpret_cast<sockaddr*>(&address), &size);
  const std::string place = Local(ntohs(address.sin_port));
  const Report report = Doctor({"--config", Config("mvn", place)});
  EXPECT_THAT(report.problems, testing::Contains("port_taken"));
  EXPECT_THAT(report.Of("port_taken", "what"), HasSubstr("(pid " + std::to_string(getpid()) + ")"));
  EXPECT_THAT(report.Of("port_taken", "what"), HasSubstr(place));
  close(holder);
}

TEST_F(DoctorTest, AnotherFormatOnThePortIsNamed) {
  const std::string place = Local(FreePort());
  Play("vmc", place);
  const Report report = Doctor({"--config", Config("mvn", place)});
  EXPECT_THAT(report.problems, testing::Contains("wrong_format"));
  EXPECT_THAT(report.Of("wrong_format", "what"), HasSubstr("VMC arrives at " + place));
  EXPECT_THAT(report.Of("wrong_format", "change"), HasSubstr("type = \"vmc\""));
}

TEST_F(DoctorTest, TheFormatOnAnotherPortIsFound) {
  const std::string place = Local(FreePort()), other = Local(FreePort());
  Play("mvn", other);
  const Report report = Doctor({"--config", Config("mvn", place), "--listen", "mvn=" + other});
  EXPECT_THAT(report.problems, testing::Contains("wrong_port"));
  EXPECT_THAT(report.Of("wrong_port", "what"), HasSubstr("Xsens MVN arrives at " + other));
  EXPECT_THAT(report.Of("wrong_port", "what"), HasSubstr(place));
}

// Trackers send nothing else before a server replies.
TEST_F(DoctorTest, TrackersThatSeekAServerAreNamedAndNoProblem) {
  const std::string place = Local(FreePort());
  Play("slimevr", place);
  const Report report = Doctor({"--config", Config("slimevr", place)});
  EXPECT_EQ(report.problems.size(), 1U) << report.text << " no daemon, that is";
  EXPECT_EQ(report.json["traffic"].at(0)["format"], "slimevr");
}

TEST_F(DoctorTest, FramesWithoutASkeletonAreNamedThoughTheDaemonHoldsThePort) {
  const Daemon daemon;
  const Streaming rig(daemon.udp, kRate_hz, Performer(false));
  const Report report = Doctor({"--endpoint", daemon.control, "--source", "rig"});
  EXPECT_THAT(report.problems, ElementsAre("no_skeleton"));
  EXPECT_EQ(report.Of("no_skeleton", "source"), "rig");
}

TEST_F(DoctorTest, DamagedDatagramsAreNamedThoughTheDaemonHoldsThePort) {
  const Daemon daemon;
  const Streaming rig(daemon.udp, kRate_hz, [whole = Performer(true)] {
    Bytes bytes = whole();
    bytes[bytes.size() / 2] ^= std::byte{0x10};
    return bytes;
  });
  const Report report = Doctor({"--endpoint", daemon.control, "--source", "rig"});
  EXPECT_THAT(report.problems, ElementsAre("damaged"));
  EXPECT_EQ(report.Of("damaged", "source"), "rig");
}

TEST_F(DoctorTest, AnotherFormatIsNamedThoughTheDaemonHoldsThePort) {
  const Daemon daemon;
  Play("mocopi", daemon.udp);
  const Report counted = Doctor({"--endpoint", daemon.control, "--source", "rig"});
  EXPECT_THAT(counted.problems, ElementsAre("wrong_format"));
  EXPECT_THAT(counted.Of("wrong_format", "change"), HasSubstr("With sudo"));
  if (!own_network) GTEST_SKIP() << "no network of its own: the interfaces are not looked at";
  const Report seen = Doctor({"--endpoint", daemon.control, "--source", "rig"}, true);
  EXPECT_THAT(seen.problems, ElementsAre("wrong_format"));
  EXPECT_THAT(seen.Of("wrong_format", "what"), HasSubstr("Sony mocopi arrives at " + daemon.udp));
}

TEST_F(DoctorTest, ADaemonWithAnotherControlAddressIsFound) {
  const Daemon daemon;
  const Streaming rig(daemon.udp, kRate_hz, Performer(true));
  const Report report = Doctor({"--config", Config("mvn", Local(FreePort()))});
  EXPECT_EQ(report.problems.at(0), "wrong_control_endpoint");
  if (!own_network) return;
  const std::string why = report.Of("wrong_control_endpoint", "why");
  EXPECT_THAT(why, HasSubstr("styled (pid " + std::to_string(daemon.child->pid()) + ")"));
  EXPECT_THAT(why, HasSubstr(daemon.control.substr(std::string("tcp://").size())));
}

TEST_F(DoctorTest, ASourceThatTheDaemonWasNotStartedWithIsNamed) {
  const Daemon daemon;
  const std::string place = Local(FreePort());
  const Report report =
      Doctor({"--endpoint", daemon.control, "--config", Config("mvn", place), "--source", "suit"});
  EXPECT_THAT(report.problems, ElementsAre("source_not_in_daemon"));
}

TEST_F(DoctorTest, ANatNetServerThatDoesNotAnswerIsNamed) {
  const std::string server = Local(FreePort());
  const Report report =
      Doctor({"--config", Config("natnet", "0.0.0.0:0", "server = \"" + server + "\"")});
  EXPECT_THAT(report.problems, testing::Contains("natnet_no_answer"));
  EXPECT_THAT(report.Of("natnet_no_answer", "what"), HasSubstr(server));
}

TEST_F(DoctorTest, ANatNetServerThatDoesNotAnswerARunningDaemonIsNamed) {
  const std::string server = Local(FreePort());
  const std::string source = "[[source]]\nname = \"suit\"\ntype = \"natnet\"\n";
  const Daemon daemon({}, source + "server = \"" + server + "\"\n");
  const Report alone = Doctor({"--endpoint", daemon.control, "--source", "suit"});
  EXPECT_THAT(alone.problems, ElementsAre("nothing_arrives"));
  EXPECT_THAT(alone.Of("nothing_arrives", "what"), HasSubstr("NatNet server at " + server));
  const Report all = Doctor({"--endpoint", daemon.control});
  EXPECT_THAT(all.text, HasSubstr("Nothing arrives for suit"));
  const std::string config = Config("natnet", "0.0.0.0:0", "server = \"" + server + "\"");
  const Report told =
      Doctor({"--endpoint", daemon.control, "--source", "suit", "--config", config});
  EXPECT_THAT(told.problems, ElementsAre("natnet_no_answer"));
  EXPECT_THAT(told.Of("natnet_no_answer", "what"), HasSubstr(server));
}

// No daemon, or one of another test, which has another control endpoint.
const auto kNotAsked = AnyOf("no_daemon", "wrong_control_endpoint");

TEST_F(DoctorTest, AQtmThatCannotBeReachedIsNamedWithWhatToDo) {
  const std::string server = Local(FreePort());
  const Daemon daemon({},
                      "[[source]]\nname = \"suit\"\ntype = \"qtm\"\nserver = \"" + server + "\"\n");
  const Report report = Doctor({"--endpoint", daemon.control, "--source", "suit"});
  EXPECT_THAT(report.problems, ElementsAre("qtm_no_connection"));
  EXPECT_THAT(report.Of("qtm_no_connection", "what"), HasSubstr("cannot be reached at " + server));
  EXPECT_THAT(report.Of("qtm_no_connection", "why"), HasSubstr("Connection refused"));
  const Report file = Doctor({"--config", Config("qtm", "", "server = \"" + server + "\"")});
  EXPECT_THAT(file.problems, ElementsAre(kNotAsked, "qtm_no_connection"));
}

TEST_F(DoctorTest, AQtmThatStreamsIsFollowedToItsFrames) {
  const std::string server = Local(FreePort());
  Play("qtm", "tcp://" + server);
  const Report report = Doctor({"--config", Config("qtm", "", "server = \"" + server + "\"")});
  EXPECT_THAT(report.problems, ElementsAre(kNotAsked)) << report.text;
  const std::string full = Local(FreePort());
  Play("qtm", "tcp://" + full, {"--quirk", "full"});
  const Report refused = Doctor({"--config", Config("qtm", "", "server = \"" + full + "\"")});
  EXPECT_THAT(refused.problems, ElementsAre(kNotAsked, "qtm_full")) << refused.text;
}

TEST_F(DoctorTest, WhereFramesGoThroughAllIsWell) {
  const Daemon daemon;
  const Streaming rig(daemon.udp, kRate_hz, Performer(true));
  const Subscriber subscriber(daemon.publish, {"styled/"});
  ASSERT_TRUE(subscriber.WaitForFrames(10));
  EXPECT_EQ(ControlClient(daemon.control).SetStyle("rig.anna", "s1").code(), v1::CODE_OK);
  const Report report = Doctor({"--endpoint", daemon.control, "--source", "rig"});
  EXPECT_EQ(report.code, 0);
  for (const auto& finding : report.json["findings"]) {
    // Where nothing disciplines the clock; and of a machine that is busy with other tests.
    EXPECT_THAT(finding["code"], AnyOf("clock_free", "over_budget"));
  }
  const auto& source = report.json["sources"].at(0);
  EXPECT_EQ(source["listen"], daemon.udp);
  EXPECT_GT(source["received"], kRate_hz / 2);
  EXPECT_EQ(report.json["performers"].at(0)["performer"], "rig.anna");
  EXPECT_EQ(report.json["performers"].at(0)["live"], true);
}

TEST_F(DoctorTest, AReceiveBufferThatIsTooSmallIsNamed) {
  const Daemon daemon({"source.0.receive_buffer_bytes=4096"});
  const Streaming rig(daemon.udp, 2 * kRate_hz, Performer(true));
  // The daemon repeatedly sleeps for longer than the socket's buffer lasts.
  const std::jthread sleeper([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      daemon.child->Signal(SIGSTOP);
      Sleep(0.15);
      daemon.child->Signal(SIGCONT);
      Sleep(0.05);
    }
  });
  const Report report = Doctor({"--endpoint", daemon.control, "--source", "rig"});
  EXPECT_EQ(report.Of("kernel_drops", "severity"), "warning");
  EXPECT_EQ(report.Of("kernel_drops", "source"), "rig");
  EXPECT_GT(report.json["sources"].at(0)["kernel_drops"], 0);
}

class DoctorInWordsTest : public DoctorTest {
 protected:
  std::string Says(const Daemon& daemon, const std::string& seconds) const {
    const std::string out = folder_ / "report.txt";
    Child child({"/bin/sh", "-c",
                 std::string("exec ") + STYLECTL_BINARY + " --endpoint " + daemon.control +
                     " doctor --source rig --seconds " + seconds + " --no-capture > '" + out + "'"},
                folder_ / "stderr.txt");
    EXPECT_EQ(child.Wait(60).value_or(-1), 0);
    return ReadText(out);
  }
};

TEST_F(DoctorInWordsTest, AllIsWell) {
  const Daemon daemon;
  const Streaming rig(daemon.udp, kRate_hz, Performer(true));
  const std::string said = Says(daemon, "1");
  EXPECT_THAT(said, AnyOf(HasSubstr("All is well"), HasSubstr("left later than a period")));
  EXPECT_THAT(said, HasSubstr("NOTE     No client has subscribed"));
  EXPECT_THAT(ReadText(folder_ / "stderr.txt"), HasSubstr("listening for 1 s"));
}

TEST_F(DoctorInWordsTest, WithTwoSendersOfOnePerformerNotAllIsWell) {
  const Daemon daemon;
  const Streaming first(daemon.udp, kRate_hz, Performer(true));
  auto other = std::make_shared<Rig>("anna", 8);
  auto count = std::make_shared<int>(0);
  // Rarely, so that most datagrams are valid: a warning, not a problem.
  const Streaming second(daemon.udp, kRate_hz / 6,
                         [=] { return (*count)++ % 10 == 0 ? other->Body() : other->Frame(); });
  const std::string said = Says(daemon, "2");
  EXPECT_THAT(said, HasSubstr("WARNING"));
  EXPECT_THAT(said, HasSubstr("two senders send the same performer"));
  EXPECT_THAT(said, HasSubstr("Frames arrive and are published, except for 1 warning."));
  EXPECT_THAT(said, testing::Not(HasSubstr("All is well")));
}

}  // namespace
}  // namespace styled::support
