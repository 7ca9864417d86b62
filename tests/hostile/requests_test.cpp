// Each request of the table (attacks.h), sent by three clients at once, beside a performer: the
// properties of stage.h hold. Negative controls show that they can fail.
#include <gtest/gtest.h>
#include <signal.h>

#include <thread>

#include "tests/hostile/attacks.h"
#include "tests/hostile/stage.h"

namespace styled::hostile {
namespace {

constexpr double kMostSilence_s = 1;  // a service manager has to wait for longer
constexpr std::int64_t kMemoryFactor = 8, kDiskFactor = 2;
// The memory that any request may use: arenas of the allocator, tables of fixed size.
constexpr std::int64_t kMemorySlack = std::int64_t{32} << 20, kDiskSlack = 256 << 10;
constexpr int kClients = 3;
constexpr double kAttack_s = 1.5;

class RequestTest : public testing::TestWithParam<RequestAttack> {
 protected:
  static void SetUpTestSuite() {
    stage_ = new Stage;
    loot_ = TakeLoot(stage_->daemon(), "rig.victim");
  }
  static void TearDownTestSuite() {
    delete stage_;
    stage_ = nullptr;
  }
  // A daemon that was harmed would falsify the next attack's result.
  void TearDown() override {
    if (!HasFailure()) return;
    TearDownTestSuite();
    SetUpTestSuite();
  }

  static Stage* stage_;
  static Loot loot_;
};
Stage* RequestTest::stage_ = nullptr;
Loot RequestTest::loot_;

TEST_P(RequestTest, HarmsNobody) {
  const v1::Request request = GetParam().make(loot_);
  const auto bytes = static_cast<std::int64_t>(request.ByteSizeLong());
  std::atomic<int> unanswered{0}, answered{0};
  const auto client = [&] {
    support::ControlClient control(stage_->daemon().control);
    control.SetPatience(30);
    const auto begin = Clock::now();
    do {
      const v1::Reply reply = control.Ask(request);
      ++(reply.reason() == "no reply" ? unanswered : answered);
    } while (Clock::now() - begin < std::chrono::duration<double>(kAttack_s));
  };
  const Measured measured = stage_->Watch([&] {
    std::vector<std::thread> clients;
    for (int i = 0; i < kClients; ++i) clients.emplace_back(client);
    for (auto& thread : clients) thread.join();
  });
  ASSERT_TRUE(measured.alive) << stage_->daemon().Log();
  EXPECT_EQ(unanswered, 0);
  EXPECT_GE(answered, kClients);
  EXPECT_LT(measured.silence_s, kMostSilence_s) << "no sign of life";
  EXPECT_LT(measured.reload_s, kMostSilence_s) << "SIGHUP was not heard";
  // Three requests may be under way at once.
  EXPECT_LE(measured.memory, kClients * kMemoryFactor * bytes + kMemorySlack) << bytes;
  EXPECT_LE(measured.disk, kDiskFactor * bytes + kDiskSlack) << bytes;
  EXPECT_EQ(measured.received, measured.victim) << "frames of the victim";
  EXPECT_TRUE(measured.one_leads);
  EXPECT_LT(measured.both_lead_s, 2);
  std::printf(
      "%lld bytes, %d answers: sign of life after %.2f s at most, SIGHUP heard in %.2f s, memory "
      "+%.1f MB, disk +%.1f kB, victim %llu of %llu\n",
      static_cast<long long>(bytes), answered.load(), measured.silence_s, measured.reload_s,
      static_cast<double>(measured.memory) / 1e6, static_cast<double>(measured.disk) / 1e3,
      static_cast<unsigned long long>(measured.received),
      static_cast<unsigned long long>(measured.victim));
}

INSTANTIATE_TEST_SUITE_P(All, RequestTest, testing::ValuesIn(RequestAttacks()),
                         [](const auto& row) { return row.param.command + "_" + row.param.name; });

TEST(StageTest, SeesADaemonThatIsSilentForLonger) {
  Stage stage;
  const Measured measured = stage.Watch([&stage] {
    support::Sleep(0.5);
    stage.daemon().child->Signal(SIGSTOP);
    support::Sleep(kMostSilence_s + 0.3);
    stage.daemon().child->Signal(SIGCONT);
  });
  EXPECT_GT(measured.silence_s, kMostSilence_s);
}

}  // namespace
}  // namespace styled::hostile
