// Datagrams that a delayed pipeline reads late do not count as a silence of the sender.
#include <gtest/gtest.h>

#include <chrono>
#include <thread>
#include <vector>

#include "daemon/runtime/clock.h"
#include "daemon/runtime/counters.h"
#include "daemon/source/udp.h"
#include "tests/support/rig.h"

namespace styled::source {
namespace {

// A rig of many datagrams a frame, whose end is a silence, as in VMC with single messages.
class EndsWithSilence final : public Translator {
 public:
  static constexpr std::int64_t kSilence_ns = 5 * runtime::kMillisecond_ns;
  explicit EndsWithSilence(std::vector<int>& frames) : frames_(frames) {}

  void Handle(std::span<const std::byte> /*datagram*/, const Peer& /*peer*/, std::int64_t now_ns,
              Outbox& /*out*/) override {
    ++open_;
    last_ns_ = now_ns;
  }
  void Tick(std::int64_t now_ns, Outbox& /*out*/) override {
    if (now_ns < NextDeadline_ns()) return;
    frames_.push_back(open_);
    open_ = 0;
  }
  std::int64_t NextDeadline_ns() const override {
    return open_ == 0 ? kNever : last_ns_ + kSilence_ns;
  }

 private:
  std::vector<int>& frames_;  // datagrams of each
  int open_ = 0;
  std::int64_t last_ns_ = 0;
};

class Nobody final : public Receiver {
  void OnFrames(int, std::span<const SourceFrame>, bool) override {}
};

TEST(LateReadingTest, AFrameThatFillsMoreThanABatchIsNotCut) {
  std::vector<int> frames;
  runtime::SystemClock clock;
  runtime::Counters counters;
  config::Source config;
  config.listen = "127.0.0.1:0";
  auto made = MakeUdp(config, 0, clock, counters, std::make_unique<EndsWithSilence>(frames));
  ASSERT_TRUE(made.ok()) << made.status().message();
  Transport& transport = *made.value();
  const support::UdpLink link(transport.endpoint());
  Nobody nobody;
  constexpr int kDatagrams = 3 * static_cast<int>(kBatch) + 5;
  const auto work_for = [&](std::chrono::milliseconds time) {
    const auto end = std::chrono::steady_clock::now() + time;
    while (std::chrono::steady_clock::now() < end) transport.DoWork(nobody);
  };
  // The sender may be interrupted, too: then the frame has a silence. Not ten times.
  std::vector<int> seen;
  for (int tries = 0; tries < 10; ++tries) {
    frames.clear();
    for (int i = 0; i < kDatagrams; ++i) link.Send(support::Bytes(10));
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    work_for(std::chrono::milliseconds(20));
    if (frames == std::vector<int>{kDatagrams}) return;
    seen.insert(seen.end(), frames.begin(), frames.end());
  }
  FAIL() << "frames of " << testing::PrintToString(seen) << " datagrams, expected one of "
         << kDatagrams;
}

}  // namespace
}  // namespace styled::source
