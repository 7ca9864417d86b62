#include "daemon/perform/roster.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <map>
#include <random>
#include <set>

#include "daemon/looks/state_file.h"
#include "daemon/pipeline/pipeline.h"
#include "model/base/text.h"
#include "tests/support/child.h"
#include "tests/support/native_frames.h"
#include "tests/support/rig.h"
#include "tests/unit/net/erd/random_weights.h"

namespace styled::pipeline {
namespace {

using runtime::Counter;
using testing::HasSubstr;
using testing::Not;
constexpr std::int64_t kHour_ns = 3600 * runtime::kSecond_ns;

class StillClock final : public runtime::Clock {
 public:
  std::int64_t Now_ns() const noexcept override { return now_ns; }
  std::int64_t Wall_ns() const noexcept override { return now_ns; }
  std::int64_t now_ns = 1'000'000'000'000;
};

class NoPublisher final : public publish::Publisher {
 public:
  void Send(std::string_view, std::span<const std::byte>) noexcept override {}
  bool NextSubscription(publish::SubscriptionEvent&) override { return false; }
  int fd() const override { return -1; }
};

// Each is found whatever was looked for before, since the search begins behind the last one found.
TEST(RosterFindTest, AllPerformersAreFoundInAnyOrderAndNoOthers) {
  auto config = std::make_shared<RuntimeConfig>();
  config->network = erd::RandomStylizer(2, 1);
  runtime::Counters counters;
  publish::Subscriptions subscriptions(10, counters);
  for (const int count : {0, 1, 2, 3, 16, 17}) {
    Roster roster({"rig", "suit", "rig"}, config, 1, subscriptions, counters);
    for (int i = 0; i < count; ++i) roster.Add(i % 3, "p" + std::to_string(i), 1);
    std::mt19937 random(7);
    for (int round = 0; round < 500; ++round) {
      const int i = static_cast<int>(random() % 20);
      const std::string name = "p" + std::to_string(i);
      Performer* const found = roster.Find(i % 3, name);
      ASSERT_EQ(found != nullptr, i < count) << name << " of " << count;
      if (found != nullptr) {
        EXPECT_EQ(found->name, name);
        // Sources of one name are one.
        EXPECT_EQ(roster.Find(i % 3 == 0 ? 2 : i % 3 == 2 ? 0 : 1, name), found);
        EXPECT_EQ(roster.Find(i % 3 == 1 ? 0 : 1, name), nullptr);
      }
    }
    while (!roster.performers.empty()) {
      roster.Forget(*roster.performers[random() % roster.performers.size()]);
      EXPECT_EQ(roster.Find(0, "nobody"), nullptr);
    }
  }
}

// The performers known to a daemon whose table has room for 8 profiles, 2 of them live.
class RosterTest : public testing::Test {
 protected:
  RosterTest() { Start(); }

  void Start() {
    auto live = std::make_shared<RuntimeConfig>();
    live->network = network_;
    live->performers.max_performers = 2;
    pipeline_ = std::make_unique<Pipeline>(
        Dependencies{clock_, counters_, publisher_, mailboxes_}, std::vector<std::string>{"rig"},
        std::vector<std::unique_ptr<source::Transport>>(), std::move(live), 1, 100);
    Work();
  }
  // As a clean stop, and a start with the same [state].
  void Restart() {
    std::unique_ptr<std::vector<Profile>> kept, newest;
    while (mailboxes_.profiles.Pop(kept)) newest = std::move(kept);
    if (auto unkept = pipeline_->PopUnsaved()) newest = std::move(unkept);
    if (newest != nullptr) {
      ASSERT_TRUE(WriteProfiles(file_, *newest).ok());
    }
    auto read = ReadProfiles(file_);
    ASSERT_TRUE(read.ok()) << read.status().message();
    Start();
    pipeline_->Restore(std::move(read.value()));
    Work();
  }
  void Work() {
    while (pipeline_->DoWork() > 0) {
    }
  }
  void Pass(double hours) {
    clock_.now_ns += static_cast<std::int64_t>(hours * static_cast<double>(kHour_ns));
    Work();
  }
  // A live performer leaves.
  void Silence() { Pass(0.1); }
  void Send(support::Rig& rig, bool frame = true) {
    std::vector<support::Bytes> datagrams{rig.Body()};
    if (frame) datagrams.push_back(rig.Frame());
    const std::vector<std::span<const std::byte>> spans(datagrams.begin(), datagrams.end());
    support::HandOn(spans, {}, counters_, *pipeline_);
    clock_.now_ns += runtime::kSecond_ns;
    Work();
  }
  void Come(const std::string& name) {
    support::Rig rig(name, 7 + comers_++);
    Send(rig);
  }
  v1::Reply Ask(const v1::Request& request) {
    auto exchange = std::make_unique<Exchange>();
    exchange->request = request;
    EXPECT_TRUE(mailboxes_.commands.Push(std::move(exchange)));
    Work();
    EXPECT_TRUE(mailboxes_.replies.Pop(exchange));
    return exchange->reply;
  }
  v1::Reply Set(const std::string& performer, const std::string& style = "style1") {
    v1::Request request;
    request.set_performer(performer);
    auto& mix = *request.mutable_set()->add_mix();
    mix.set_style(style);
    mix.set_weight(1);
    return Ask(request);
  }
  v1::Reply Pin(const std::string& performer) {
    v1::Request request;
    request.set_performer(performer);
    request.mutable_pin()->set_pinned(true);
    return Ask(request);
  }
  // The ids that are known, and the styles that they are set to.
  std::map<std::string, std::string> Known() {
    v1::Request request;
    request.mutable_status();
    std::map<std::string, std::string> known;
    const v1::Reply reply = Ask(request);
    for (const auto& row : reply.status().stats().performers()) {
      known[row.performer()] = row.styles_size() > 0 ? row.styles(0).style() : "";
    }
    return known;
  }
  bool Knows(const std::string& id) { return Known().contains(id); }
  std::string Log() {
    std::string log;
    Event event;
    while (mailboxes_.events.Pop(event)) log += event.text + "\n";
    return log;
  }
  std::uint64_t Count(Counter counter) const { return counters_.Get(counter); }

  std::shared_ptr<const net::Stylizer> network_ = erd::RandomStylizer(5, 1);
  support::TemporaryFolder folder_;
  const std::string file_ = folder_ / "performers.toml";
  StillClock clock_;
  runtime::Counters counters_;
  NoPublisher publisher_;
  Mailboxes mailboxes_;
  std::uint64_t comers_ = 0;
  std::unique_ptr<Pipeline> pipeline_;
};

TEST_F(RosterTest, AnArrivingPerformerReplacesTheOldestNamedOneInAFullTable) {
  for (const char* const name : {"g0", "g1", "g2", "g3", "g4", "g5", "g6", "g7"}) {
    ASSERT_EQ(Set(std::string("rig.") + name).code(), v1::CODE_OK);
  }
  const v1::Reply refused = Set("rig.g8");
  EXPECT_EQ(refused.code(), v1::CODE_BUSY) << "a name takes no place";
  EXPECT_THAT(refused.reason(), HasSubstr("8 performers have settings already"));
  ASSERT_EQ(Pin("rig.g0").code(), v1::CODE_OK);  // named again: g1 is the oldest now
  Come("anna");
  EXPECT_EQ(Count(Counter::kPipelinePerformersRefused), 0U);
  EXPECT_EQ(Count(Counter::kPipelineFrames), 1U);
  EXPECT_EQ(Count(Counter::kPipelineNamesReplaced), 1U);
  EXPECT_THAT(Log(), HasSubstr("rig.g1: only named, its settings were dropped for rig.anna"));
  EXPECT_TRUE(Knows("rig.anna"));
  EXPECT_TRUE(Knows("rig.g0"));
  EXPECT_FALSE(Knows("rig.g1"));
  EXPECT_EQ(Known().size(), 8U);
}

TEST_F(RosterTest, ANamedPerformerWhoArrivesKeepsTheirSettings) {
  ASSERT_EQ(Set("rig.anna", "style2").code(), v1::CODE_OK);
  for (int i = 0; i < 7; ++i) ASSERT_EQ(Set("rig.g" + std::to_string(i)).code(), v1::CODE_OK);
  Come("anna");
  EXPECT_EQ(Known()["rig.anna"], "style2");
  EXPECT_EQ(Count(Counter::kPipelineNamesReplaced), 0U);
}

TEST_F(RosterTest, NamesThatSurvivedARestartAreReplaced) {
  for (int i = 0; i < 8; ++i) ASSERT_EQ(Set("rig.g" + std::to_string(i)).code(), v1::CODE_OK);
  Restart();
  ASSERT_EQ(Known().size(), 8U);
  Come("anna");
  Come("ben");
  EXPECT_EQ(Count(Counter::kPipelinePerformersRefused), 0U);
  EXPECT_TRUE(Knows("rig.anna"));
  EXPECT_TRUE(Knows("rig.ben"));
  EXPECT_EQ(Count(Counter::kPipelineNamesReplaced), 2U);
}

// As when the weights are others: the styles stay in the settings, for when they are here again.
TEST_F(RosterTest, AStyleOfTheLastRunThatIsNotHereIsLogged) {
  ASSERT_EQ(Set("rig.anna", "style4").code(), v1::CODE_OK);
  ASSERT_EQ(Set("rig.ben", "style1").code(), v1::CODE_OK);
  network_ = erd::RandomStylizer(3, 1);
  Restart();
  Pass(1);
  const std::string log = Log();
  EXPECT_THAT(log,
              HasSubstr("rig.anna: its style \"style4\" of the last run is not here any more"));
  EXPECT_THAT(log, Not(HasSubstr("rig.ben")));
  EXPECT_EQ(Known()["rig.anna"], "style4");
}

TEST_F(RosterTest, TheLongestAbsentPerformerIsReplacedAndNoPinnedOne) {
  for (int i = 0; i < 8; ++i) {
    const std::string name = "p" + std::to_string(i);
    Come(name);
    ASSERT_EQ(Set("rig." + name).code(), v1::CODE_OK);
    Pass(1);
  }
  ASSERT_EQ(Pin("rig.p0").code(), v1::CODE_OK);
  Pass(1);
  Come("anna");
  EXPECT_THAT(Log(), HasSubstr("rig.p1: absent for long, its settings were dropped for rig.anna"));
  EXPECT_TRUE(Knows("rig.p0"));
  EXPECT_FALSE(Knows("rig.p1"));
  ASSERT_EQ(Pin("*").code(), v1::CODE_OK);
  Come("ben");
  EXPECT_EQ(Count(Counter::kPipelinePerformersRefused), 1U) << "nobody gives way any more";
  EXPECT_EQ(Known().size(), 8U);
}

TEST_F(RosterTest, ABodyWithoutFramesDoesNotCountAsPresence) {
  ASSERT_EQ(Set("rig.ghost").code(), v1::CODE_OK);
  support::Rig ghost("ghost");
  Send(ghost, false);
  Silence();
  Pass(Roster::kForgetNamed_h);
  EXPECT_FALSE(Knows("rig.ghost"));
}

TEST_F(RosterTest, NamesThatNeverArriveExpireAfterAWeek) {
  ASSERT_EQ(Set("rig.ghost").code(), v1::CODE_OK);
  ASSERT_EQ(Set("rig.anna").code(), v1::CODE_OK);
  Come("anna");
  Silence();
  Pass(Roster::kForgetNamed_h - 1);
  EXPECT_TRUE(Knows("rig.ghost"));
  (void)Log();
  Pass(1);
  EXPECT_FALSE(Knows("rig.ghost"));
  EXPECT_TRUE(Knows("rig.anna")) << "who came is kept";
  EXPECT_EQ(Count(Counter::kPipelineNamesExpired), 1U);
  EXPECT_THAT(Log(), HasSubstr("rig.ghost: named 168 hours ago or more and never seen"));
  Restart();
  EXPECT_FALSE(Knows("rig.ghost"));
  EXPECT_TRUE(Knows("rig.anna"));
}

TEST_F(RosterTest, HoursCountAcrossRestarts) {
  ASSERT_EQ(Set("rig.ghost").code(), v1::CODE_OK);
  for (int day = 0; day < 6; ++day) {
    Pass(24);
    Restart();
    ASSERT_TRUE(Knows("rig.ghost")) << day;
  }
  Pass(24.5);
  EXPECT_FALSE(Knows("rig.ghost"));
  Restart();
  EXPECT_FALSE(Knows("rig.ghost"));
}

TEST_F(RosterTest, APreparedShowSurvivesADayAndARestart) {
  ASSERT_EQ(Set("rig.anna", "style3").code(), v1::CODE_OK);
  Pass(20);
  Restart();
  Pass(20);
  EXPECT_EQ(Known()["rig.anna"], "style3");
  Come("anna");
  EXPECT_EQ(Known()["rig.anna"], "style3");
  // From now on for good, although no client sets anything again.
  Silence();
  Restart();
  Pass(1000);
  Restart();
  EXPECT_EQ(Known()["rig.anna"], "style3");
}

TEST_F(RosterTest, APerformerPresentAtTheEndCountsAsPresent) {
  ASSERT_EQ(Set("rig.anna").code(), v1::CODE_OK);
  Restart();
  support::Rig anna("anna");
  Send(anna);
  Restart();
  Pass(1000);
  EXPECT_TRUE(Knows("rig.anna"));
}

TEST_F(RosterTest, TheWeekRestartsWithASettingByNameAndNotByAll) {
  ASSERT_EQ(Set("rig.a").code(), v1::CODE_OK);
  ASSERT_EQ(Set("rig.b").code(), v1::CODE_OK);
  Pass(100);
  ASSERT_EQ(Set("*", "style2").code(), v1::CODE_OK);
  ASSERT_EQ(Set("rig.b").code(), v1::CODE_OK);
  Pass(100);
  EXPECT_FALSE(Knows("rig.a"));
  EXPECT_TRUE(Knows("rig.b"));
}

// Performers are named, pinned and arrive in any order: a newcomer is admitted as long as fewer
// than two others are on the floor and the table is not full of pinned performers who have been
// there.
TEST_F(RosterTest, AnArrivingPerformerIsAdmittedWhateverIsNamed) {
  std::mt19937 random(3);
  std::set<std::string> pinned;
  for (int step = 0; step < 1500; ++step) {
    const std::string name = "n" + std::to_string(random() % 60);
    switch (random() % 6) {
      case 0:
        if (pinned.size() < 4 && Pin("rig." + name).code() == v1::CODE_OK) pinned.insert(name);
        break;
      case 1:
        Pass(static_cast<double>(random() % 30));
        break;
      case 2:
        Restart();
        break;
      case 3: {
        Silence();
        const std::uint64_t frames = Count(Counter::kPipelineFrames);
        Come(name);
        ASSERT_EQ(Count(Counter::kPipelineFrames), frames + 1) << step;
        ASSERT_TRUE(Knows("rig." + name)) << step;
        break;
      }
      default:
        (void)Set("rig." + name);
    }
    ASSERT_LE(Known().size(), 8U) << step;
  }
  EXPECT_EQ(Count(Counter::kPipelinePerformersRefused), 0U);
  EXPECT_GT(Count(Counter::kPipelineNamesReplaced), 50U);
}

TEST_F(RosterTest, RepliesContainReadableNumbersAndAreUtf8) {
  v1::Request request;
  request.set_performer("rig.a");
  request.mutable_set()->set_strength(2);
  EXPECT_EQ(Ask(request).reason(), "set: strength is 2, expected 0 to 1.5");
  request.mutable_set()->set_strength(1);
  request.mutable_set()->set_transition_ms(70000.5F);
  EXPECT_EQ(Ask(request).reason(), "set: transition_ms is 70000.5, expected 0 to 60000");
  // Cut off at any byte, it would be no UTF-8 with one of these.
  for (int i = 0; i < 3; ++i) {
    std::string name(static_cast<std::size_t>(i), 'x');
    for (int k = 0; k < 60; ++k) name += "\xE5\xA7\x93";
    EXPECT_TRUE(IsUtf8(Set(name).reason()));
    EXPECT_TRUE(IsUtf8(Set("rig.a", name).reason()));
    v1::Request cue;
    cue.mutable_cue()->set_name(name);
    EXPECT_TRUE(IsUtf8(Ask(cue).reason()));
    v1::Request calibrate;
    calibrate.set_performer(name);
    calibrate.mutable_calibrate();
    EXPECT_TRUE(IsUtf8(Ask(calibrate).reason()));
  }
}

TEST_F(RosterTest, TheStateFileIsForTheGroupAtMost) {
  v1::Request request;
  request.set_performer("rig.a");
  request.mutable_set()->set_strength(0.8F);
  ASSERT_EQ(Ask(request).code(), v1::CODE_OK);
  Restart();
  struct stat about {};
  ASSERT_EQ(stat(file_.c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 0007U, 0U);
}

TEST_F(RosterTest, AStateFileCanSetNothingThatARequestCannot) {
  const auto read = ParseProfiles(
      "['rig.a']\nstrength = nan\ntransition_s = 1e30\nabsent_hours = -5\n"
      "mix = [ { style = 'S1', weight = inf }, {}, {}, {}, {}, {}, {} ]\n"
      "rest = { skeleton = 'x', canonical_from_source = [0, 0, 0, 1], rotations = [nan, 0, 0, 1] "
      "}\n"
      "['no id']\nstrength = 1\n['rig.b']\nabsent_hours = 99999999999\n"
      "rest = { skeleton = '1', canonical_from_source = [0, 0, 0, 1], rotations = [0, 0, 0, 1] }\n",
      "state.toml");
  ASSERT_TRUE(read.ok()) << read.status().message();
  ASSERT_EQ(read.value().size(), 2U);
  const Profile& a = read.value()[0];
  EXPECT_EQ(a.look.strength(), 1);
  EXPECT_FLOAT_EQ(a.look.transition_ms(), 100);
  EXPECT_EQ(a.look.mix_size(), 0);
  EXPECT_EQ(a.absent_hours, 0);
  EXPECT_FALSE(a.rest);
  EXPECT_FALSE(a.has_come);
  const Profile& b = read.value()[1];
  EXPECT_TRUE(b.rest);
  EXPECT_TRUE(b.has_come) << "who is calibrated has come";
  EXPECT_EQ(b.absent_hours, 1'000'000);
}

}  // namespace
}  // namespace styled::pipeline
