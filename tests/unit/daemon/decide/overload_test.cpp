#include "daemon/decide/overload.h"

#include <gtest/gtest.h>

#include <map>

#include "tests/support/fake_pipeline.h"
#include "tests/unit/net/erd/random_weights.h"

namespace styled::pipeline {
namespace {

using decide::Overload;

using runtime::Counter;
using runtime::kMillisecond_ns;
using runtime::kSecond_ns;

// Windows of a tenth of a second, one after the other.
class OverloadTest : public testing::Test {
 protected:
  OverloadTest() { Window(0, 0); }  // the first one begins
  int Window(double load, double late, double styling = 0.8, std::size_t dropped = 0) {
    Overload::Batch batch;
    batch.busy_ns = static_cast<std::int64_t>(load * Overload::kWindow_ns);
    batch.styling_ns = static_cast<std::int64_t>(styling * static_cast<double>(batch.busy_ns));
    batch.sent = 100;
    batch.late = static_cast<std::size_t>(100 * late);
    batch.dropped = dropped;
    overload_.Add(batch);
    now_ns_ += Overload::kWindow_ns;
    const int change = overload_.due(now_ns_) ? overload_.Decide(now_ns_, styled_, relieved_) : 0;
    styled_ -= change;
    relieved_ += change;
    return change;
  }
  // Seconds of room until a style comes back; 100 if none does.
  double Wait() {
    for (int i = 1; i < 1000; ++i) {
      if (Window(0.3, 0) < 0) return 0.1 * i;
    }
    return 100;
  }
  std::int64_t now_ns_ = 1000 * kSecond_ns;
  int styled_ = 16, relieved_ = 0;
  Overload overload_;
};

TEST_F(OverloadTest, AFullWindowAloneChangesNothing) {
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(Window(1, 1), 0);
    EXPECT_EQ(Window(0.5, 0), 0);
  }
}

TEST_F(OverloadTest, LoadWithoutLateFramesLateFramesWithoutLoadAndLoadWithoutStylingChangeNothing) {
  for (int i = 0; i < 20; ++i) EXPECT_EQ(Window(1, 0.05), 0);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(Window(0.5, 0.5), 0);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(Window(1, 1, 0.1), 0);
}

TEST_F(OverloadTest, TheLoadDecidesHowManyAreRelievedEveryFourWindows) {
  std::vector<int> changes;
  for (int i = 0; i < 40; ++i) {
    if (const int change = Window(1, 1); change != 0) changes.push_back(change);
  }
  EXPECT_EQ(changes, (std::vector<int>{5, 4, 3, 2, 1, 1}));
  EXPECT_EQ(styled_, 0);
}

// Half of the frames are dropped, so the time is not full; all of them would need more than there
// is.
TEST_F(OverloadTest, FramesThatAreDroppedCountAsIfTheyWereStyled) {
  EXPECT_EQ(Window(0.8, 1, 0.8, 100), 0);
  EXPECT_EQ(Window(0.8, 1, 0.8, 100), 8) << "at a load of 160 %, half of them";
  EXPECT_NEAR(overload_.load(), 1.6, 1e-6);
}

TEST_F(OverloadTest, StylesReturnOneByOneAfterTwoSecondsOfRoom) {
  Window(1, 1);
  ASSERT_EQ(Window(1, 1), 5);
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(Wait(), 2, 0.11);
  EXPECT_EQ(relieved_, 0);
  EXPECT_EQ(Wait(), 100) << "nobody is left";
}

TEST_F(OverloadTest, NoStyleReturnsWithoutRoomForOneMore) {
  Window(1, 1);
  ASSERT_EQ(Window(1, 1), 5);
  for (int i = 0; i < 300; ++i) EXPECT_EQ(Window(0.7, 0), 0) << "an eleventh more would be 0.76";
  for (int i = 0; i < 300; ++i) EXPECT_EQ(Window(0.5, 0.2), 0) << "late for another reason";
}

// Else styles would go and come every two seconds.
TEST_F(OverloadTest, APerformerRemovedAgainWaitsLongerTheNextTime) {
  Window(1, 1);
  ASSERT_EQ(Window(1, 1), 5);
  EXPECT_NEAR(Wait(), 2, 0.11);
  for (const double wait_s : {4, 8, 16, 32, 64, 64}) {
    Window(1, 1);
    ASSERT_GT(Window(1, 1), 0);
    EXPECT_NEAR(Wait(), wait_s, 0.11);
  }
}

// A network each of whose steps takes time, on a clock of the test's.
class SlowNetwork final : public net::Stylizer {
 public:
  SlowNetwork(std::shared_ptr<const net::Stylizer> inner, support::FakeClock& clock)
      : inner_(std::move(inner)), clock_(clock) {}
  const net::Model& model() const noexcept override { return inner_->model(); }
  std::unique_ptr<net::Stream> MakeStream() const override { return inner_->MakeStream(); }
  void Start(net::Stream& stream) const noexcept override { inner_->Start(stream); }
  void Step(std::span<const net::StepJob> jobs) const noexcept override {
    clock_.now_ns += static_cast<std::int64_t>(jobs.size()) * step_ns;
    inner_->Step(jobs);
  }
  std::int64_t step_ns = 0;

 private:
  std::shared_ptr<const net::Stylizer> inner_;
  support::FakeClock& clock_;
};

// Eight performers at 120 Hz whose datagrams wait, as in a socket, until the pipeline reads them.
class SlowStageTest : public testing::Test {
 protected:
  static constexpr int kPerformers = 8;
  static constexpr std::int64_t kPeriod_ns = kSecond_ns / 120;

  explicit SlowStageTest(bool relieves = true) {
    slow_ = std::make_shared<SlowNetwork>(erd::RandomStylizer(5, 1), clock_);
    auto config = std::make_shared<RuntimeConfig>();
    config->network = slow_;
    config->weights_name = "slow";
    Dependencies dependencies{clock_, counters_, publisher_, mailboxes_};
    dependencies.anticipate = dependencies.prewarm = false;  // the rehearsal would be slow, too
    dependencies.relieves = relieves;
    pipeline_ = std::make_unique<Pipeline>(dependencies, std::vector<std::string>{"rig"},
                                           std::vector<std::unique_ptr<source::Transport>>(),
                                           std::move(config), 77, 100);
    publisher_.events.push_back({true, "styled/"});
    Work();
    for (int i = 0; i < kPerformers; ++i) {
      rigs_.emplace_back("p" + std::to_string(i), 7 + i);
      Deliver({rigs_.back().Body()}, {clock_.now_ns});
    }
    started_ns_ = clock_.now_ns;
  }
  void Work() {
    while (pipeline_->DoWork() > 0) {
    }
  }
  void Deliver(const std::vector<support::Bytes>& datagrams,
               const std::vector<std::int64_t>& arrivals_ns) {
    const std::vector<std::span<const std::byte>> spans(datagrams.begin(), datagrams.end());
    source::NativeDecoder decoder(0, counters_);
    decoder.HandOn(spans, {}, *pipeline_, arrivals_ns);
    Work();
    // As the thread does after each turn that read something.
    clock_.now_ns += 1000;
  }
  // Lets the rigs send for this long.
  void Run(double seconds) {
    const std::int64_t until_ns = clock_.now_ns + static_cast<std::int64_t>(seconds * 1e9);
    while (clock_.now_ns < until_ns) {
      std::vector<support::Bytes> datagrams;
      std::vector<std::int64_t> arrivals_ns;
      for (; datagrams.size() < source::kBatch; ++sent_) {
        const std::int64_t arrival_ns =
            started_ns_ + static_cast<std::int64_t>(sent_ + 1) * kPeriod_ns / kPerformers;
        if (arrival_ns > clock_.now_ns) break;
        datagrams.push_back(rigs_[sent_ % kPerformers].Frame());
        arrivals_ns.push_back(arrival_ns);
      }
      if (datagrams.empty()) {
        clock_.now_ns += kPeriod_ns / kPerformers;
      } else {
        Deliver(datagrams, arrivals_ns);
      }
    }
  }
  v1::Reply Ask(const v1::Request& request) {
    auto exchange = std::make_unique<Exchange>();
    exchange->request = request;
    EXPECT_TRUE(mailboxes_.commands.Push(std::move(exchange)));
    Work();
    EXPECT_TRUE(mailboxes_.replies.Pop(exchange));
    return exchange->reply;
  }
  void SetStyle(const std::string& performer, float weight) {
    v1::Request request;
    request.set_performer(performer);
    auto& mix = *request.mutable_set()->add_mix();
    mix.set_style("style1");
    mix.set_weight(weight);
    ASSERT_EQ(Ask(request).code(), v1::CODE_OK);
  }
  void Pin(const std::string& performer) {
    v1::Request request;
    request.set_performer(performer);
    request.mutable_pin()->set_pinned(true);
    ASSERT_EQ(Ask(request).code(), v1::CODE_OK);
  }
  std::map<std::string, v1::PerformerStats> Stats() {
    v1::Request request;
    request.mutable_status();
    std::map<std::string, v1::PerformerStats> by_name;
    const v1::Reply reply = Ask(request);
    for (const auto& row : reply.status().stats().performers()) by_name[row.performer()] = row;
    return by_name;
  }
  int Relieved() {
    int count = 0;
    for (const auto& [name, row] : Stats()) count += row.overload_bypass() ? 1 : 0;
    return count;
  }
  std::string Lines() {
    std::string lines;
    Event event;
    while (mailboxes_.events.Pop(event)) lines += event.text + "\n";
    return lines;
  }
  std::uint64_t Count(Counter counter) const { return counters_.Get(counter); }

  support::FakeClock clock_;
  runtime::Counters counters_;
  support::FakePublisher publisher_;
  Mailboxes mailboxes_;
  std::shared_ptr<SlowNetwork> slow_;
  std::unique_ptr<Pipeline> pipeline_;
  std::vector<support::Rig> rigs_;
  std::int64_t started_ns_ = 0;
  std::size_t sent_ = 0;
};

TEST_F(SlowStageTest, NoPerformerIsRelievedInOrdinaryOperation) {
  SetStyle("rig.p0", 1);
  slow_->step_ns = kPeriod_ns / 20;  // a load of 40 %
  Run(5);
  EXPECT_EQ(Relieved(), 0);
  EXPECT_EQ(Count(Counter::kPipelineOverBudgetFrames), 0U);
  EXPECT_EQ(Count(Counter::kPipelineOverloadBypassed), 0U);
}

TEST_F(SlowStageTest, TheLadderIsClimbedUntilFramesLeaveInTimeAndComesDownAgain) {
  for (int i = 0; i < kPerformers; ++i) {
    SetStyle("rig.p" + std::to_string(i), 0.1F * static_cast<float>(i + 1));
  }
  Pin("rig.p0");
  Run(1);
  slow_->step_ns = kPeriod_ns / 5;  // eight of them are a load of 160 %
  Run(3);
  const std::uint64_t late = Count(Counter::kPipelineOverBudgetFrames);
  const std::uint64_t dropped = Count(Counter::kPipelineBacklogDropped);
  EXPECT_GT(late, 0U);
  Run(1);
  EXPECT_EQ(Count(Counter::kPipelineOverBudgetFrames), late) << "frames leave in time again";
  EXPECT_EQ(Count(Counter::kPipelineBacklogDropped), dropped);
  const int relieved = Relieved();
  EXPECT_GE(relieved, 4);
  EXPECT_LE(relieved, 6);
  auto stats = Stats();
  EXPECT_FALSE(stats["rig.p0"].overload_bypass()) << "who is pinned comes last";
  EXPECT_FALSE(stats["rig.p7"].overload_bypass()) << "of the others, who shows most";
  EXPECT_TRUE(stats["rig.p1"].overload_bypass());
  EXPECT_GT(stats["rig.p1"].overload_bypassed(), 100U);
  EXPECT_GT(Count(Counter::kPipelineOverloadBypassed), 400U);
  EXPECT_NE(Lines().find("overload: frames leave too late at a load of "), std::string::npos);
  std::map<std::string, v1::Frame> last;
  for (const v1::Frame& frame : publisher_.frames) last[frame.performer()] = frame;
  EXPECT_NE(last["rig.p1"].flags() & v1::FLAG_BYPASS, 0U);
  EXPECT_EQ(last["rig.p7"].flags() & v1::FLAG_BYPASS, 0U);

  slow_->step_ns = kPeriod_ns / 100;
  Run(30);
  EXPECT_EQ(Relieved(), 0);
  EXPECT_NE(Lines().find("comes back"), std::string::npos);
  for (const v1::Frame& frame : publisher_.frames) last[frame.performer()] = frame;
  EXPECT_EQ(last["rig.p1"].flags() & v1::FLAG_BYPASS, 0U);
  ASSERT_EQ(last["rig.p1"].styles_size(), 1);
  EXPECT_FLOAT_EQ(last["rig.p1"].styles(0).weight(), 0.2F) << "the look has stayed as set";
}

TEST_F(SlowStageTest, AStyleThatIsSetMeanwhileIsShownAfterwards) {
  slow_->step_ns = kPeriod_ns / 5;
  Run(3);
  ASSERT_TRUE(Stats()["rig.p7"].overload_bypass());
  SetStyle("rig.p7", 0.5F);
  Run(0.5);
  EXPECT_TRUE(Stats()["rig.p7"].overload_bypass());
  v1::Request explain;
  explain.set_performer("rig.p7");
  explain.mutable_explain();
  EXPECT_NE(Ask(explain).explain().frames(0).text().find(
                "left out because the machine cannot keep up: fewer performers"),
            std::string::npos);
  EXPECT_NE(publisher_.frames.back().flags() & v1::FLAG_BYPASS, 0U);
  slow_->step_ns = 0;
  Run(30);
  std::map<std::string, v1::Frame> last;
  for (const v1::Frame& frame : publisher_.frames) last[frame.performer()] = frame;
  ASSERT_EQ(last["rig.p7"].styles_size(), 1);
}

class SlowStageWithoutReliefTest : public SlowStageTest {
 protected:
  SlowStageWithoutReliefTest() : SlowStageTest(false) {}
};

TEST_F(SlowStageWithoutReliefTest, FramesAreLateAndThenOnlyTheNewestIsSent) {
  slow_->step_ns = kPeriod_ns / 5;
  Run(4);
  EXPECT_EQ(Relieved(), 0);
  EXPECT_GT(Count(Counter::kPipelineOverBudgetFrames), 500U);
  EXPECT_GT(Count(Counter::kPipelineBacklogDropped), 500U);
}

}  // namespace
}  // namespace styled::pipeline
