#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <map>

#include "daemon/source/rigs/slimevr.h"
#include "model/synthetic/performer.h"
#include "proto/rigs/slimevr/udp.h"
#include "proto/styled/v1/frame.pb.h"
#include "sim/rigs/slimevr.h"
#include "tests/support/native_frames.h"
#include "tests/support/units.h"
#include "tests/unit/slimevr/decode_cases.h"

namespace styled::source {
namespace {

using runtime::Counter;
using slimevr::testing::Bytes;
using ::testing::Contains;
using ::testing::HasSubstr;

using support::kMs;
constexpr std::int64_t kSecond = 1000 * kMs;

int BindAny(sockaddr_in& address) {
  const int fd = socket(AF_INET, SOCK_DGRAM, 0);
  address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  socklen_t size = sizeof address;
  getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size);
  return fd;
}

// A tracker's end: what the translator answers arrives here.
class Board {
 public:
  Board() {
    sockaddr_in address;
    fd_ = BindAny(address);
    peer.id = address.sin_port | 1ULL << 32U;
    std::memcpy(&peer.address, &address, sizeof address);
    peer.address_size = sizeof address;
  }
  ~Board() { close(fd_); }
  Board(const Board&) = delete;
  Board& operator=(const Board&) = delete;

  std::vector<slimevr::Answer> Answers() {
    std::vector<slimevr::Answer> answers;
    for (const Bytes& bytes : Received()) {
      EXPECT_EQ(slimevr::DecodeAnswer(bytes, answers.emplace_back()), slimevr::UdpResult::kOk);
    }
    return answers;
  }
  std::vector<Bytes> Received() {
    std::vector<Bytes> all;
    Bytes bytes(100);
    for (ssize_t size; (size = recv(fd_, bytes.data(), bytes.size(), MSG_DONTWAIT)) >= 0;) {
      all.emplace_back(bytes.begin(), bytes.begin() + size);
    }
    return all;
  }

  Peer peer;

 private:
  int fd_;
};

// The translator with a socket to answer from and a clock that is set by hand.
class Bench final : public Receiver {
 public:
  explicit Bench(const config::Source& config = Config()) : translator_(MakeSlimeVr(config)) {
    sockaddr_in address;
    fd_ = BindAny(address);
  }
  ~Bench() override { close(fd_); }

  static config::Source Config() {
    config::Source config;
    config.name = "stage";
    config.type = "slimevr";
    return config;
  }

  void Handle(const Board& board, std::span<const std::byte> bytes) {
    outbox_.Open(*this, fd_);
    translator_->Handle(bytes, board.peer, now_ns, outbox_);
    outbox_.Close();
  }
  void Handle(const Board& board, std::uint64_t number, const slimevr::Packet& packet) {
    Bytes bytes(slimevr::kMaxUdpSize);
    bytes.resize(slimevr::Encode(number, packet, bytes));
    Handle(board, bytes);
  }
  void Tick() {
    outbox_.Open(*this, fd_);
    translator_->Tick(now_ns, outbox_);
    outbox_.Close();
  }
  Translator& translator() { return *translator_; }
  std::uint64_t Count(Counter counter) const { return counters_.Get(counter); }

  void OnFrames(int, std::span<const SourceFrame> received, bool) override {
    for (const SourceFrame& frame : received) {
      if (frame.is_body) continue;
      session = frame.session;
      frames.push_back(support::AsMessage(frame));
    }
  }
  void OnNote(int, const std::string& text) override { notes.push_back(text); }

  std::int64_t now_ns = kSecond;
  std::vector<v1::SourceFrame> frames;
  std::vector<std::string> notes;
  std::uint64_t session = 0;

 private:
  int fd_ = -1;
  runtime::Counters counters_;
  Outbox outbox_{0, counters_};
  std::unique_ptr<Translator> translator_;
};

slimevr::Handshake Greeting(std::uint8_t last = 1, std::uint32_t protocol = 22) {
  slimevr::Handshake handshake;
  handshake.protocol = protocol;
  handshake.firmware = "0.7.2";
  handshake.mac = {0xA8, 0x48, 0xFA, 0xC0, 0x1D, last};
  return handshake;
}

slimevr::Rotation Upright(std::uint8_t sensor = 0) {
  return {sensor, 1, slimevr::MakeOrientation(1, 0, 0, 1), 0};
}

slimevr::SensorInfo AtHips(std::uint8_t sensor = 0) {
  slimevr::SensorInfo info;
  info.sensor = sensor;
  info.position = 6;
  return info;
}

TEST(SlimeVrTranslator, CountsWhatItCannotRead) {
  Bench bench;
  Board board;
  bench.Handle(board, Bytes(5));
  bench.Handle(board, Bytes());
  EXPECT_EQ(bench.Count(Counter::kSourceMalformed), 2U);
}

TEST(SlimeVrTranslator, DoesNotListenToATrackerThatHasNotGreeted) {
  Bench bench;
  Board board;
  bench.Handle(board, 1, AtHips());
  bench.Handle(board, 2, Upright());
  EXPECT_EQ(bench.Count(Counter::kSourceIgnored), 2U);
  EXPECT_TRUE(board.Received().empty());
  EXPECT_TRUE(bench.notes.empty());
}

// To the byte what SlimeVR's server answers.
TEST(SlimeVrTranslator, AnswersAHandshake) {
  Bench bench;
  Board board;
  bench.Handle(board, slimevr::testing::kHandshake);
  EXPECT_THAT(
      board.Received(),
      ::testing::ElementsAre(slimevr::testing::Hex("03 48 65 79 20 4F 56 52 20 3D 44 20 35")));
}

TEST(SlimeVrTranslator, AcknowledgesSensorsAndTellsItsFeatures) {
  Bench bench;
  Board board;
  bench.Handle(board, 0, Greeting());
  board.Received();
  bench.Handle(board, 1, AtHips(2));
  bench.Handle(board, 2, slimevr::FeatureFlags{});
  EXPECT_THAT(board.Received(),
              ::testing::ElementsAre(slimevr::testing::Hex("00 00 00 0F 02 01"),
                                     slimevr::testing::Join({slimevr::testing::Header("16", "00"),
                                                             slimevr::testing::Hex("03")})));
  EXPECT_THAT(bench.notes, Contains(HasSubstr("A848FAC01D01/2 is worn on hips")));
}

TEST(SlimeVrTranslator, SendsHeartbeatAndPingTwiceASecondUntilATrackerIsSilent) {
  Bench bench;
  Board board;
  EXPECT_EQ(bench.translator().NextDeadline_ns(), Translator::kNever);
  bench.Handle(board, 0, Greeting());
  board.Received();
  int heartbeats = 0, pings = 0;
  for (int i = 0; i < 100; ++i) {
    if (bench.translator().NextDeadline_ns() == Translator::kNever) break;
    bench.now_ns = bench.translator().NextDeadline_ns();
    bench.Tick();
    for (const auto& answer : board.Answers()) {
      heartbeats += std::holds_alternative<slimevr::Heartbeat>(answer) ? 1 : 0;
      pings += std::holds_alternative<slimevr::Ping>(answer) ? 1 : 0;
    }
  }
  EXPECT_EQ(heartbeats, 10) << "5 s, every half second";
  EXPECT_EQ(pings, 10);
  EXPECT_EQ(bench.translator().NextDeadline_ns(), Translator::kNever);
  bench.Handle(board, 5, slimevr::Heartbeat{});
  bench.Tick();
  EXPECT_EQ(board.Received().size(), 0U);
  bench.Handle(board, 0, Greeting());
  EXPECT_NE(bench.translator().NextDeadline_ns(), Translator::kNever);
}

TEST(SlimeVrTranslator, TakesNumbersInOrderOnly) {
  Bench bench;
  Board board;
  bench.Handle(board, 0, Greeting());
  bench.Handle(board, 5, AtHips());
  bench.Handle(board, 5, Upright());
  bench.Handle(board, 4, Upright());
  EXPECT_EQ(bench.Count(Counter::kPipelineDuplicate), 1U);
  EXPECT_EQ(bench.Count(Counter::kPipelineReordered), 1U);
  bench.Handle(board, 0, slimevr::Ping{1});  // comes back as it was sent, with 0
  bench.Handle(board, 4, Upright());
  EXPECT_EQ(bench.Count(Counter::kPipelineReordered), 2U);
  EXPECT_FALSE(bench.translator().Calibrate(Calibration::kFull, bench.now_ns).ok());
  bench.Handle(board, 6, Upright());
  EXPECT_TRUE(bench.translator().Calibrate(Calibration::kFull, bench.now_ns).ok());
}

TEST(SlimeVrTranslator, TellsATrackerSwitchedOnAgainFromOneThatLostTheNetwork) {
  Bench bench;
  Board board, elsewhere;
  bench.Handle(board, 0, Greeting());
  bench.Handle(board, 100, AtHips());
  bench.notes.clear();
  bench.now_ns += 3 * kSecond;
  bench.Handle(elsewhere, 0, Greeting());  // another port
  bench.Handle(elsewhere, 101, Upright());
  EXPECT_TRUE(bench.notes.empty());
  bench.Handle(elsewhere, 0, Greeting());
  bench.Handle(elsewhere, 1, Upright());
  EXPECT_THAT(bench.notes, ::testing::ElementsAre(HasSubstr("switched on again")));
  EXPECT_EQ(bench.Count(Counter::kSourceIgnored), 0U);
  bench.Handle(board, 102, Upright());
  EXPECT_EQ(bench.Count(Counter::kSourceIgnored), 1U) << "where it is no more";
}

TEST(SlimeVrTranslator, GivesAPlaceToAnotherTrackerThatTookIt) {
  Bench bench;
  Board board;
  bench.Handle(board, 0, Greeting(1));
  bench.Handle(board, 100, AtHips());
  bench.now_ns += 3 * kSecond;
  bench.Handle(board, 0, Greeting(2));
  slimevr::SensorInfo info;
  info.position = 1;
  bench.Handle(board, 1, info);
  EXPECT_THAT(bench.notes, Contains(HasSubstr("A848FAC01D02/0 is worn on head")));
}

TEST(SlimeVrTranslator, CountsUnassignedTrackersAndNamesThemOnce) {
  Bench bench;
  Board board;
  bench.Handle(board, 0, Greeting());
  slimevr::SensorInfo info;
  for (std::uint64_t i = 1; i < 10; i += 2) {
    bench.Handle(board, i, info);
    bench.Handle(board, i + 1, Upright());
  }
  EXPECT_EQ(bench.Count(Counter::kSourceIgnored), 5U);
  EXPECT_EQ(bench.notes.size(), 1U);
  EXPECT_THAT(bench.notes[0], HasSubstr("A848FAC01D01/0"));
}

TEST(SlimeVrTranslator, KnowsTheOneSensorOfOldFirmwareByItsTable) {
  config::Source config = Bench::Config();
  config.trackers = {{"A848FAC01D01", "chest"}, {"127.0.0.1", "head"}};
  Bench bench(config);
  Board board, nameless;
  bench.Handle(board, 0, Greeting(1, 8));
  bench.Handle(board, 1, slimevr::LegacyRotation{0, slimevr::MakeOrientation(1, 0, 0, 1)});
  bench.Handle(nameless, 0, slimevr::Handshake{});
  bench.Handle(nameless, 1, slimevr::LegacyRotation{0, slimevr::MakeOrientation(1, 0, 0, 1)});
  EXPECT_EQ(bench.Count(Counter::kSourceIgnored), 0U);
  ASSERT_TRUE(bench.translator().Calibrate(Calibration::kFull, bench.now_ns).ok());
  bench.Tick();
  EXPECT_THAT(bench.notes, Contains(HasSubstr("calibrated chest, head")));
  EXPECT_EQ(bench.frames.size(), 1U);
}

TEST(SlimeVrTranslator, IgnoresCorrectionsOfTheMagnetometer) {
  Bench bench;
  Board board;
  bench.Handle(board, 0, Greeting());
  bench.Handle(board, 1, AtHips());
  slimevr::Rotation correction = Upright();
  correction.kind = 2;
  bench.Handle(board, 2, correction);
  EXPECT_FALSE(bench.translator().Calibrate(Calibration::kFull, bench.now_ns).ok());
}

TEST(SlimeVrTranslator, ResetsWhenATrackersButtonAsksForIt) {
  Bench bench;
  Board board;
  bench.Handle(board, 0, Greeting());
  bench.Handle(board, 1, slimevr::UserAction{slimevr::UserAction::kFullReset});
  EXPECT_THAT(bench.notes, Contains(HasSubstr("no tracker that is assigned")));
  bench.Handle(board, 2, AtHips());
  bench.Handle(board, 3, Upright());
  bench.Handle(board, 4, slimevr::UserAction{slimevr::UserAction::kFullReset});
  bench.Tick();
  EXPECT_THAT(bench.notes, Contains(HasSubstr("calibrated hips")));
  EXPECT_EQ(bench.frames.size(), 1U);
  const std::uint64_t session = bench.session;
  bench.Handle(board, 5, slimevr::UserAction{slimevr::UserAction::kYawReset});
  bench.now_ns += 10 * kMs;
  bench.Tick();
  EXPECT_NE(bench.session, session);
  bench.Handle(board, 6, slimevr::UserAction{slimevr::UserAction::kMountingReset});
  EXPECT_THAT(bench.notes, Contains(HasSubstr("did not turn as a skier's")));
  bench.Handle(board, 7, slimevr::UserAction{slimevr::UserAction::kPause});
  EXPECT_EQ(bench.Count(Counter::kSourceIgnored), 1U);
}

TEST(SlimeVrTranslator, SaysOnceThatATrackerReportsAnError) {
  Bench bench;
  Board board;
  bench.Handle(board, 0, Greeting());
  for (std::uint64_t i = 1; i < 4; ++i) bench.Handle(board, i, slimevr::Error{1, 14});
  EXPECT_THAT(bench.notes, ::testing::ElementsAre(HasSubstr("A848FAC01D01/1 reports error 14")));
}

TEST(SlimeVrTranslator, HasRoomForSixtyFourBoardsAndForNewOnesWhenTheyAreSilent) {
  Bench bench;
  std::vector<std::unique_ptr<Board>> boards;
  for (int i = 0; i < 65; ++i) {
    boards.push_back(std::make_unique<Board>());
    bench.Handle(*boards.back(), 0, Greeting(static_cast<std::uint8_t>(i)));
  }
  EXPECT_EQ(boards[63]->Received().size(), 1U);
  EXPECT_EQ(boards[64]->Received().size(), 0U);
  EXPECT_EQ(bench.Count(Counter::kSourceTableFull), 1U);
  EXPECT_THAT(bench.notes, ::testing::ElementsAre(HasSubstr("room for 64 trackers")));
  bench.now_ns += 6 * kSecond;
  bench.Handle(*boards[64], 0, Greeting(64));
  EXPECT_EQ(boards[64]->Received().size(), 1U);
}

// A board that sends ten times a second and answers pings, as a real one does.
struct Worn {
  Board board;
  std::uint64_t number = 0;
};
void Pass(Bench& bench, std::int64_t ms, const std::vector<Worn*>& worn) {
  for (; ms > 0; ms -= 100) {
    bench.now_ns += 100 * kMs;
    bench.Tick();
    for (Worn* each : worn) {
      for (const auto& answer : each->board.Answers()) {
        const auto* ping = std::get_if<slimevr::Ping>(&answer);
        if (ping != nullptr) bench.Handle(each->board, 0, *ping);
      }
      bench.Handle(each->board, ++each->number, Upright());
    }
  }
}

TEST(SlimeVrTakeover, WhoKnowsTheMacOfALiveTrackerIsRefusedUntilThatIsSilent) {
  Bench bench;
  Worn tracker;
  Board thief;
  bench.Handle(tracker.board, 0, Greeting());
  bench.Handle(tracker.board, ++tracker.number, AtHips());
  Pass(bench, 3000, {&tracker});
  bench.notes.clear();
  for (int i = 0; i < 100; ++i) {
    bench.Handle(thief, 0, Greeting());
    bench.Handle(thief, 1'000'000, Upright());
  }
  EXPECT_TRUE(thief.Received().empty());
  EXPECT_EQ(bench.Count(Counter::kSourceTakeovers), 100U);
  ASSERT_EQ(bench.notes.size(), 1U) << "once a second";
  EXPECT_THAT(bench.notes[0], HasSubstr("A848FAC01D01/0 is live at 127.0.0.1:"));
  const std::uint64_t ignored = bench.Count(Counter::kSourceIgnored);
  Pass(bench, 1000, {&tracker});
  EXPECT_EQ(bench.Count(Counter::kSourceIgnored), ignored) << "the tracker goes on";
  EXPECT_EQ(bench.Count(Counter::kPipelineReordered), 0U);
  bench.Handle(thief, 0, Greeting());
  ASSERT_EQ(bench.notes.size(), 2U);
  EXPECT_THAT(bench.notes[1], HasSubstr("(100 times)"));
  Pass(bench, 2000, {});
  bench.Handle(thief, 0, Greeting());
  EXPECT_TRUE(thief.Received().empty());
  Pass(bench, 100, {});
  bench.Handle(thief, 0, Greeting());
  EXPECT_EQ(thief.Answers().size(), 1U) << "may be the tracker itself, at another address";
}

TEST(SlimeVrTakeover, ATrackerSwitchedOnAgainIsLetInAtItsAddressAtOnce) {
  Bench bench;
  Worn tracker;
  bench.Handle(tracker.board, 0, Greeting());
  bench.Handle(tracker.board, ++tracker.number, AtHips());
  Pass(bench, 1000, {&tracker});
  tracker.board.Received();
  bench.Handle(tracker.board, 0, Greeting());
  EXPECT_EQ(tracker.board.Received().size(), 1U);
  tracker.number = 0;
  Pass(bench, 1000, {&tracker});
  EXPECT_THAT(bench.notes, Contains(HasSubstr("switched on again")));
  EXPECT_EQ(bench.Count(Counter::kSourceTakeovers), 0U);
  EXPECT_EQ(bench.Count(Counter::kPipelineReordered), 0U);
}

TEST(SlimeVrTakeover, AnotherDeviceIsRefusedWhereATrackerIsLive) {
  config::Source config = Bench::Config();
  config.trackers = {{"A848FAC01D01", "hips"}};
  Bench bench(config);
  Worn tracker;
  bench.Handle(tracker.board, 0, Greeting(1));
  bench.Handle(tracker.board, ++tracker.number, AtHips());
  Pass(bench, 3000, {&tracker});
  tracker.board.Received();
  bench.Handle(tracker.board, 0, Greeting(2));  // forged: the address is the tracker's
  EXPECT_TRUE(tracker.board.Received().empty());
  EXPECT_EQ(bench.Count(Counter::kSourceTakeovers), 1U);
  Pass(bench, 1000, {&tracker});
  EXPECT_EQ(bench.Count(Counter::kSourceIgnored), 0U);
}

// A sender that forges its address never sees our ping.
TEST(SlimeVrTakeover, AnAddressThatAnswersNoPingIsHeldForTwoSecondsOnly) {
  Bench bench;
  Board forged;
  Worn tracker;
  bench.Handle(forged, 0, Greeting());
  for (int i = 0; i < 25; ++i) {
    bench.now_ns += 100 * kMs;
    bench.Tick();
    bench.Handle(forged, static_cast<std::uint64_t>(1000 + i), Upright());
    bench.Handle(forged, 0, slimevr::Ping{0});
    bench.Handle(forged, 0, slimevr::Ping{static_cast<std::uint32_t>(i)});
    bench.Handle(forged, 0, Greeting());
    if (i == 10) bench.Handle(tracker.board, 0, Greeting());
  }
  EXPECT_TRUE(tracker.board.Received().empty());
  bench.Handle(tracker.board, 0, Greeting());
  EXPECT_EQ(tracker.board.Answers().size(), 1U);
  for (int i = 0; i < 50; ++i) {
    Pass(bench, 100, {&tracker});
    bench.Handle(forged, 0, Greeting());
  }
  EXPECT_EQ(bench.Count(Counter::kSourceTakeovers), 51U);
}

TEST(SlimeVrTakeover, AWildNumberSilencesATrackerForTwoSecondsOnly) {
  Bench bench;
  Worn tracker;
  bench.Handle(tracker.board, 0, Greeting());
  bench.Handle(tracker.board, ++tracker.number, AtHips());
  bench.Handle(tracker.board, 1ULL << 60U, Upright());
  Pass(bench, 2000, {&tracker});
  EXPECT_EQ(bench.Count(Counter::kPipelineReordered), 20U);
  Pass(bench, 2000, {&tracker});
  EXPECT_EQ(bench.Count(Counter::kPipelineReordered), 20U);
}

TEST(SlimeVrTable, InventedDevicesDoNotLockOutThoseThatTheConfigurationNames) {
  config::Source config = Bench::Config();
  config.trackers = {{"A848FAC01D01", "hips"}, {"A848FAC01D02/0", "chest"}};
  Bench bench(config);
  std::vector<std::unique_ptr<Worn>> invented;
  std::vector<Worn*> live;
  for (int i = 0; i < 256; ++i) {
    live.push_back(invented.emplace_back(std::make_unique<Worn>()).get());
    slimevr::Handshake handshake = Greeting();
    handshake.mac = {2, 0, 0, 0, 1, static_cast<std::uint8_t>(i)};
    bench.Handle(live.back()->board, 0, handshake);
    slimevr::SensorInfo info;
    for (info.sensor = 0; info.sensor < 10; ++info.sensor) {
      bench.Handle(live.back()->board, ++live.back()->number, info);
    }
  }
  EXPECT_EQ(bench.Count(Counter::kSourceTableFull), 256U - 62U);
  EXPECT_THAT(bench.notes, Contains(HasSubstr("room for 64 trackers")).Times(1));
  EXPECT_LT(bench.notes.size(), 70U);
  Pass(bench, 3000, live);
  Worn hips, chest;
  for (std::uint8_t i = 1; Worn * named : {&hips, &chest}) {
    bench.Handle(named->board, 0, Greeting(i++));
    EXPECT_EQ(named->board.Answers().size(), 1U);
    bench.Handle(named->board, ++named->number, slimevr::SensorInfo());
  }
  EXPECT_THAT(bench.notes, Contains(HasSubstr("A848FAC01D01/0 is worn on hips")));
  EXPECT_THAT(bench.notes, Contains(HasSubstr("A848FAC01D02/0 is worn on chest")));
  Pass(bench, 100, {&hips, &chest});
  bench.notes.clear();
  EXPECT_TRUE(bench.translator().Calibrate(Calibration::kFull, bench.now_ns).ok());
  bench.Tick();
  EXPECT_THAT(bench.notes, Contains(HasSubstr("calibrated hips, chest")));
}

TEST(SlimeVrTable, OneDeviceWithManySensorsDoesNotFillItEither) {
  config::Source config = Bench::Config();
  config.trackers = {{"A848FAC01D01", "hips"}};
  Bench bench(config);
  Board strange, chest, hips;
  slimevr::Handshake handshake = Greeting();
  handshake.mac = {2, 0, 0, 0, 1, 1};
  bench.Handle(strange, 0, handshake);
  slimevr::SensorInfo info;
  for (int i = 0; i < 256; ++i) {
    info.sensor = static_cast<std::uint8_t>(i);
    bench.Handle(strange, static_cast<std::uint64_t>(1 + i), info);
  }
  EXPECT_LE(bench.notes.size(), 64U);
  bench.Handle(hips, 0, Greeting(1));
  bench.Handle(hips, 1, slimevr::SensorInfo());
  EXPECT_THAT(bench.notes, Contains(HasSubstr("A848FAC01D01/0 is worn on hips")));
  bench.Handle(chest, 0, Greeting(2));  // not named, says itself where it is worn
  info = slimevr::SensorInfo();
  info.position = 4;
  bench.Handle(chest, 1, info);
  EXPECT_THAT(bench.notes, Contains(HasSubstr("A848FAC01D02/0 is worn on chest")));
}

TEST(SlimeVrTable, AStrangersButtonResetsNobodyWhereTrackersAreNamed) {
  config::Source config = Bench::Config();
  config.trackers = {{"A848FAC01D01", "hips"}};
  Bench bench(config);
  Board hips, stranger;
  bench.Handle(hips, 0, Greeting(1));
  bench.Handle(hips, 1, slimevr::SensorInfo());
  bench.Handle(hips, 2, Upright());
  bench.Handle(stranger, 0, Greeting(2));
  bench.Handle(stranger, 1, slimevr::UserAction{slimevr::UserAction::kFullReset});
  EXPECT_EQ(bench.Count(Counter::kSourceIgnored), 1U);
  bench.Tick();
  EXPECT_THAT(bench.notes, ::testing::Not(Contains(HasSubstr("calibrated hips"))));
  bench.Handle(hips, 3, slimevr::UserAction{slimevr::UserAction::kFullReset});
  bench.Tick();
  EXPECT_THAT(bench.notes, Contains(HasSubstr("calibrated hips")));
}

// Boards of the stand-in, each with a socket and a phase of its own, played on the bench's clock.
class Players {
 public:
  Players(Bench& bench, const std::vector<std::vector<std::string>>& boards) : bench_(bench) {
    synthetic::Options options;
    options.script = synthetic::ParseScript("walk:3,wave-left:2,turn-left:2").value();
    performer_ = std::make_unique<synthetic::Performer>(options);
    for (std::size_t k = 0; k < boards.size(); ++k) {
      auto rig = rigs::MakeSlimeVr({{"sim"}, 100, k + 1, boards[k]});
      EXPECT_TRUE(rig.ok()) << rig.status().message();
      players_.push_back({std::move(rig.value()), std::make_unique<Board>()});
    }
  }

  void Play(int milliseconds) {
    const auto send = [this](const Board& board) {
      return [this, &board](std::span<const std::byte> bytes) { bench_.Handle(board, bytes); };
    };
    for (int i = 0; i < milliseconds; ++i, ++ms_) {
      bench_.now_ns += kMs;
      performer_->Pose(static_cast<double>(ms_) * 1e-3, poses_[bench_.now_ns]);
      for (std::size_t k = 0; k < players_.size(); ++k) {
        auto& [rig, board, index] = players_[k];
        for (const Bytes& bytes : board->Received()) rig->Receive(bytes, send(*board));
        if (ms_ % 10 != static_cast<std::int64_t>(k * 3 % 10)) continue;
        rig->Encode(
            {index, static_cast<double>(index) * 0.01, std::span(&poses_[bench_.now_ns], 1)},
            send(*board));
        ++index;
      }
      bench_.Tick();
    }
  }

  // World rotations of a frame against the performer's, at the time that the frame names.
  float WorstDegrees(const v1::SourceFrame& frame, const std::vector<int>& joints) const {
    const auto truth = poses_.find(static_cast<std::int64_t>(frame.source_time_ns()));
    if (truth == poses_.end()) return 180;
    body::Pose found;
    for (int j = 0; j < body::kJointCount; ++j) {
      const auto& r = frame.rotations();
      found.rotations[static_cast<std::size_t>(j)] =
          body::Quat(r[4 * j + 3], r[4 * j], r[4 * j + 1], r[4 * j + 2]);
    }
    body::WorldPose a, b;
    body::ForwardKinematics(truth->second, a);
    body::ForwardKinematics(found, b);
    float worst = 0;
    for (const int j : joints) {
      const auto at = static_cast<std::size_t>(j);
      worst = std::max(worst, 57.29578F * a.rotations[at].angularDistance(b.rotations[at]));
    }
    return worst;
  }

 private:
  struct Player {
    std::unique_ptr<rigs::Rig> rig;
    std::unique_ptr<Board> board;
    std::uint64_t index = 0;
  };
  Bench& bench_;
  std::unique_ptr<synthetic::Performer> performer_;
  std::vector<Player> players_;
  std::map<std::int64_t, body::Pose> poses_;
  std::int64_t ms_ = 0;
};

const std::vector<int> kWorn{body::kHips,          body::kChest,         body::kHead,
                             body::kLeftUpperArm,  body::kLeftLowerArm,  body::kRightUpperArm,
                             body::kRightLowerArm, body::kLeftUpperLeg,  body::kLeftLowerLeg,
                             body::kLeftFoot,      body::kRightUpperLeg, body::kRightLowerLeg,
                             body::kRightFoot};

std::vector<std::vector<std::string>> OnePerBoard(const std::vector<std::string>& quirks) {
  std::vector<std::vector<std::string>> boards;
  for (const int j : kWorn) {
    boards.push_back(quirks);
    boards.back().emplace_back(body::kHumanoid[static_cast<std::size_t>(j)].name);
  }
  return boards;
}

void ExpectTheMotion(const std::vector<std::vector<std::string>>& boards,
                     const config::Source& config = Bench::Config()) {
  Bench bench(config);
  Players players(bench, boards);
  players.Play(2000);  // both resets and what was before them
  bench.frames.clear();
  players.Play(5000);
  ASSERT_GT(bench.frames.size(), 490U);
  float worst = 0;
  for (const auto& frame : bench.frames)
    worst = std::max(worst, players.WorstDegrees(frame, kWorn));
  EXPECT_LT(worst, 1);
  EXPECT_EQ(bench.Count(Counter::kSourceMalformed), 0U);
  EXPECT_EQ(bench.Count(Counter::kPipelineReordered), 0U);
}

TEST(SlimeVrRoundTrip, OneBoardGivesTheMotionWithinADegree) { ExpectTheMotion({{}}); }

TEST(SlimeVrRoundTrip, BoardsOutOfStepGiveTheMotionWithinADegree) {
  ExpectTheMotion(OnePerBoard({}));
}

TEST(SlimeVrRoundTrip, SensorsWornAnyhowGiveTheMotionWithinADegree) {
  ExpectTheMotion(OnePerBoard({"anyhow"}));
  ExpectTheMotion({{"anyhow", "compact"}});
}

TEST(SlimeVrRoundTrip, UnplacedSensorsAreAssignedByTheTable) {
  config::Source config = Bench::Config();
  for (std::size_t k = 0; k < kWorn.size(); ++k) {
    config.trackers.push_back(
        {rigs::SlimeVrTrackerId(1, k),
         std::string(body::kHumanoid[static_cast<std::size_t>(kWorn[k])].name)});
  }
  ExpectTheMotion({{"unplaced"}}, config);
}

TEST(SlimeVrRoundTrip, APlayerThatGivesUpComesBackByItself) {
  Bench bench;
  Players players(bench, {{}});
  players.Play(2000);
  EXPECT_GT(bench.frames.size(), 50U);
  // The daemon is away for a while: no answers, so the board seeks it again.
  bench.now_ns += 20 * kSecond;
  players.Play(4500);
  bench.frames.clear();
  players.Play(1000);
  EXPECT_GT(bench.frames.size(), 90U);
}

}  // namespace
}  // namespace styled::source
