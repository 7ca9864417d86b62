#include <gtest/gtest.h>

#include <cmath>

#include "clients/stylemon/meter.h"
#include "clients/stylemon/monitor.h"
#include "clients/stylemon/screen.h"
#include "tests/unit/clients/fake_daemon.h"

namespace styled::stylemon {
namespace {

using client::FakeDaemon;
using std::chrono::milliseconds;

constexpr std::int64_t kMs = 1'000'000;

std::string Screen(const View& view, int columns = 100, int rows = 30, bool utf8 = true) {
  Canvas canvas(columns, rows, utf8);
  DrawScreen(view, canvas);
  std::string out;
  for (int row = 0; row < rows; ++row) out += canvas.RowText(row) + "\n";
  return out;
}

View Walking() {
  static const v1::Body body = client::HumanoidBody("rig.anna", v1::OUTPUT_RIG, 3);
  View view;
  view.publisher = "tcp://127.0.0.1:7001";
  view.link = Link::kThere;
  view.performers = {{"rig.anna", true, "old 1.00"}, {"rig.ben", false, ""}};
  view.selected = 0;
  view.styles = {"old", "proud"};
  for (Figure* figure : {&view.input, &view.styled}) {
    figure->here = true;
    figure->anatomy = std::make_shared<const Anatomy>(Analyse(body));
    figure->frame = client::HumanoidFrame(body, body::Pose(), 42);
    EXPECT_EQ(WorldTransforms(body, figure->frame, figure->joints), client::FrameError::kNone);
  }
  auto& style = *view.styled.frame.add_styles();
  style.set_style("old");
  style.set_weight(0.8F);
  view.styled.frame.set_contacts(1);
  view.styled.frame.set_flags(v1::FLAG_FADING | v1::FLAG_CONCEALED);
  view.height = 1.75F;
  view.reading.frames = 600;
  view.reading.rate_hz = 120;
  view.reading.dropped = 3;
  return view;
}

TEST(Screen, ShowsNineStylesAtATimeAndSaysHowToReachTheOthers) {
  View view = Walking();
  EXPECT_EQ(Screen(view).find("n more"), std::string::npos);
  view.styles.clear();
  for (int i = 1; i <= 12; ++i) view.styles.push_back("s" + std::to_string(i));
  const std::string first = Screen(view);
  EXPECT_NE(first.find("9 s9  n more  0 bypass"), std::string::npos) << first;
  EXPECT_EQ(first.find("s10"), std::string::npos);
  view.first_style = 9;
  const std::string second = Screen(view);
  EXPECT_NE(second.find("1 s10  2 s11  3 s12  n more"), std::string::npos) << second;
}

TEST(Meter, KnowsRatePercentilesAndDrops) {
  Meter meter(5.0);
  const Meter::Reading none = meter.Read(0);
  EXPECT_EQ(none.rate_hz, 0);
  EXPECT_TRUE(std::isnan(none.daemon_p50_ms));
  for (int i = 1; i <= 100; ++i) meter.Add(i * 10 * kMs, i * kMs, 2 * i * kMs, i == 50 ? 7 : 0);
  const Meter::Reading reading = meter.Read(1000 * kMs);
  EXPECT_EQ(reading.frames, 100);
  EXPECT_NEAR(reading.rate_hz, 100, 0.01);
  EXPECT_DOUBLE_EQ(reading.daemon_p50_ms, 50);
  EXPECT_DOUBLE_EQ(reading.daemon_p99_ms, 99);
  EXPECT_DOUBLE_EQ(reading.end_p99_ms, 198);
  EXPECT_EQ(reading.dropped, 7U);
}

TEST(Meter, ForgetsWhatIsOldAndSlowsWhenTheStreamStops) {
  Meter meter(1.0);
  for (int i = 0; i < 10'000; ++i) meter.Add(i * kMs, kMs, kMs, 0);
  EXPECT_NEAR(meter.Read(9'999 * kMs).rate_hz, 1000, 2);
  EXPECT_LT(meter.Read(10'700 * kMs).rate_hz, 400);
  EXPECT_EQ(meter.Read(12'000 * kMs).frames, 0);
  EXPECT_EQ(meter.Read(12'000 * kMs).rate_hz, 0);
}

TEST(Screen, ShowsFiguresListNumbersAndKeys) {
  const std::string screen = Screen(Walking());
  for (const char* text :
       {"connected", "▸ rig.anna", "rig.ben", "silent", "input", "styled: old 0.80", "120.0 Hz",
        "dropped 3", "contacts L-", "flags concealed fading", "1 old  2 proud", "q quit"}) {
    EXPECT_NE(screen.find(text), std::string::npos) << text << "\n" << screen;
  }
}

TEST(Screen, WithoutUtf8IsAllAscii) {
  for (const char c : Screen(Walking(), 100, 30, false)) {
    EXPECT_TRUE(c == '\n' || (c >= 32 && c < 127));
  }
}

TEST(Screen, AnySizeIsDrawnWithoutHarm) {
  View view = Walking();
  for (int columns = 0; columns < 130; columns += 3) {
    for (int rows = 0; rows < 50; rows += 2) {
      Screen(view, columns, rows);
      Screen(View(), columns, rows, false);
    }
  }
  for (int i = 0; i < 200; ++i) view.performers.push_back({"rig.p" + std::to_string(i), true, ""});
  view.selected = 150;
  EXPECT_NE(Screen(view).find("▸ rig.p148"), std::string::npos) << "scrolled to the selected one";
}

TEST(Trouble, SaysWhatIsMissingAndWhatToDo) {
  View view = Walking();
  EXPECT_EQ(Trouble(view), "");
  EXPECT_NE(StatusLine(view).find("rig.anna #42  120.0 Hz"), std::string::npos);
  view.styled.age_s = 4;
  EXPECT_EQ(Trouble(view), "rig.anna silent for 4 s");
  view.link = Link::kLost;
  view.link_s = 3;
  EXPECT_NE(Trouble(view).find("daemon away for 3 s: reconnecting"), std::string::npos);
  EXPECT_NE(Screen(view).find("daemon away for 3 s"), std::string::npos);
  view = View();
  view.publisher = "tcp://here:1";
  EXPECT_NE(StatusLine(view).find("tcp://here:1: is styled running?"), std::string::npos);
  view.link = Link::kThere;
  EXPECT_NE(Trouble(view).find("no performer yet"), std::string::npos);
}

TEST(Flags, HaveNamesAndUnknownOnesAreIgnored) {
  EXPECT_EQ(FlagNames(0), "");
  EXPECT_EQ(FlagNames(1023),
            "concealed stale late out-of-domain held bypass new-session fading failed backwards");
  EXPECT_EQ(FlagNames(1U << 20U), "");
}

// A daemon with one performer who is published until `until` is true or two seconds are over.
class MonitorTest : public testing::Test {
 protected:
  std::mutex mutex_;
  std::vector<v1::Request> requests_;
  FakeDaemon daemon_{[this](const v1::Request& request) {
    v1::Reply reply;
    if (request.has_list()) {
      auto& neutral = *reply.mutable_list()->add_styles();
      neutral.set_name("neutral");
      neutral.set_neutral(true);
      reply.mutable_list()->add_styles()->set_name("old");
    } else {
      const std::scoped_lock lock(mutex_);
      requests_.push_back(request);
    }
    return reply;
  }};
  v1::Body body_ = client::HumanoidBody("rig.a", v1::OUTPUT_RIG, 3);
  std::uint64_t sequence_ = 0;

  std::unique_ptr<Monitor> Start() {
    MonitorOptions options;
    options.publisher = daemon_.publisher();
    options.control = daemon_.control();
    auto monitor = Monitor::Start(options);
    EXPECT_TRUE(monitor.ok());
    return std::move(monitor.value());
  }
  void Publish() {
    v1::Frame frame = client::HumanoidFrame(body_, body::Pose(), ++sequence_);
    frame.set_receive_time_ns(1000);
    frame.set_publish_time_ns(1000 + 250'000);
    daemon_.Publish("source/rig.a/", frame);
    daemon_.Publish("styled/rig.a/rig/", frame);
  }
  template <typename Condition>
  bool Until(Monitor& monitor, Condition condition) {
    for (int i = 0; i < 200; ++i) {
      Publish();
      monitor.Listen(milliseconds(10));
      if (condition(monitor.view())) return true;
    }
    return false;
  }
  bool Requested(const std::function<bool(const v1::Request&)>& condition) {
    for (int i = 0; i < 200; ++i) {
      {
        const std::scoped_lock lock(mutex_);
        if (std::any_of(requests_.begin(), requests_.end(), condition)) return true;
      }
      std::this_thread::sleep_for(milliseconds(10));
    }
    return false;
  }
};

TEST_F(MonitorTest, FindsThePerformerAndDrawsBothFigures) {
  auto monitor = Start();
  daemon_.AddBody(body_);
  ASSERT_TRUE(Until(*monitor, [](const View& view) {
    return view.input.here && view.styled.here && view.reading.frames > 5;
  }));
  const View& view = monitor->view();
  EXPECT_EQ(view.link, Link::kThere);
  ASSERT_EQ(view.selected, 0);
  EXPECT_EQ(view.performers[0].performer, "rig.a");
  EXPECT_NEAR(view.reading.daemon_p50_ms, 0.25, 1e-9);
  EXPECT_EQ(view.reading.dropped, 0U);
  EXPECT_EQ(Trouble(view), "");
  EXPECT_EQ(view.floor, 0.0F);
  sequence_ += 10;  // lost on the way
  ASSERT_TRUE(Until(*monitor, [](const View& now) { return now.reading.dropped > 0; }));
  EXPECT_EQ(monitor->view().reading.dropped, 10U);
  EXPECT_GT(monitor->frames(), 5U);
}

TEST_F(MonitorTest, KeysReachTheControlSocket) {
  auto monitor = Start();
  daemon_.AddBody(body_);
  ASSERT_TRUE(Until(*monitor, [](const View& view) {
    return view.styled.here && view.styles == std::vector<std::string>{"old"};
  }));
  monitor->PressStyle(1);
  EXPECT_TRUE(Requested([](const v1::Request& request) {
    return request.performer() == "rig.a" && request.set().mix_size() == 1 &&
           request.set().mix(0).style() == "old" && !request.set().has_strength();
  }));
  monitor->PressStyle(2);  // there is none
  monitor->Press(Key::kWeaker);
  EXPECT_TRUE(Requested([](const v1::Request& request) {
    return request.set().has_strength() && std::abs(request.set().strength() - 0.9F) < 1e-6F;
  }));
  monitor->Press(Key::kClear);
  EXPECT_TRUE(Requested([](const v1::Request& request) { return request.set().clear(); }));
  EXPECT_EQ(requests_.size(), 3U);
}

TEST_F(MonitorTest, APausedPictureStandsStillAndDropsAreStillCounted) {
  auto monitor = Start();
  daemon_.AddBody(body_);
  ASSERT_TRUE(Until(*monitor, [](const View& view) { return view.styled.here; }));
  monitor->Press(Key::kPause);
  const std::uint64_t shown = monitor->view().styled.frame.sequence();
  sequence_ += 5;
  ASSERT_TRUE(Until(*monitor, [](const View& view) { return view.reading.dropped == 5; }));
  EXPECT_EQ(monitor->view().styled.frame.sequence(), shown);
  monitor->Press(Key::kPause);
  EXPECT_TRUE(
      Until(*monitor, [&](const View& view) { return view.styled.frame.sequence() > shown; }));
}

TEST(MonitorWithout, ADaemonSaysSo) {
  MonitorOptions options;
  options.publisher = "tcp://127.0.0.1:9";
  options.control = "tcp://127.0.0.1:9";
  auto monitor = Monitor::Start(options);
  ASSERT_TRUE(monitor.ok());
  monitor.value()->Listen(milliseconds(20));
  EXPECT_NE(StatusLine(monitor.value()->view()).find("is styled running?"), std::string::npos);
  // Soon it knows why.
  const auto says_why = [&monitor] {
    return StatusLine(monitor.value()->view()).find("no program listens there") !=
           std::string::npos;
  };
  for (int i = 0; i < 500 && !says_why(); ++i) monitor.value()->Listen(milliseconds(20));
  EXPECT_TRUE(says_why()) << StatusLine(monitor.value()->view());
  options.performer = "nodot";
  EXPECT_FALSE(Monitor::Start(options).ok());
  options = {};
  options.publisher = "nonsense";
  EXPECT_FALSE(Monitor::Start(options).ok());
}

}  // namespace
}  // namespace styled::stylemon
