// kill -9 of the recording process, at random moments: the file is readable up to the last 100 ms.
// Ten times each; STYLED_KILLS=50 for more, and then without an exception for a busy machine.
#include <cstdlib>
#include <iostream>
#include <random>
#include <thread>

#include "proto/recording/writer.h"
#include "proto/rigs/native/datagram.h"
#include "tests/e2e/recordings/fixture.h"

namespace styled::support {
namespace {

using recording::MonotonicNow_ns;

constexpr double kMost_ms = 100;
constexpr double kRate_hz = 250;

int Kills() {
  const char* const text = std::getenv("STYLED_KILLS");
  return text == nullptr ? 10 : std::max(1, std::atoi(text));
}

// A rig that sends until it is stopped, and stores the time of each datagram.
class Feed {
 public:
  explicit Feed(const std::string& address)
      : link_(address), thread_([this](const std::stop_token& stop) { Run(stop); }) {}

  // Returns the send time of each datagram, by sequence.
  std::vector<std::int64_t> Stop() {
    thread_.request_stop();
    thread_.join();
    return sent_ns_;
  }

 private:
  void Run(const std::stop_token& stop) {
    Rig rig("sim", std::random_device{}() | 1U);  // with a random session
    const std::int64_t begin_ns = MonotonicNow_ns();
    for (std::int64_t i = 0; !stop.stop_requested(); ++i) {
      const auto due_ns =
          begin_ns + static_cast<std::int64_t>(static_cast<double>(i) * 1e9 / kRate_hz);
      Sleep(static_cast<double>(due_ns - MonotonicNow_ns()) * 1e-9);
      const Bytes bytes = i % 100 == 0 ? rig.Body() : rig.Frame();
      sent_ns_.push_back(MonotonicNow_ns());
      link_.Send(bytes);
    }
  }
  UdpLink link_;
  std::vector<std::int64_t> sent_ns_;
  std::jthread thread_;
};

class KilledTest : public RecordingsTest {
 protected:
  // A process that records to `file` the frames that arrive at `address` or are published.
  struct Recorder {
    std::string address, file;
    Child* child = nullptr;
    std::unique_ptr<Child> own;
    std::unique_ptr<Daemon> daemon;
  };

  void KillAgainAndAgain(const std::function<Recorder(int)>& start) {
    std::mt19937 random(std::random_device{}());
    std::uniform_real_distribution<double> moment_s(0.1, 0.5);
    double worst_ms = 0, sum_ms = 0;
    int beyond = 0;
    for (int i = 0; i < Kills(); ++i) {
      Recorder recorder = start(i);
      Feed feed(recorder.address);
      Sleep(moment_s(random));
      recorder.child->Signal(SIGKILL);
      const std::int64_t killed_ns = MonotonicNow_ns();
      ASSERT_EQ(recorder.child->Wait(10).value_or(-1), 128 + SIGKILL);
      const auto sent_ns = feed.Stop();
      const double lost_ms =
          static_cast<double>(killed_ns - LastKept_ns(recorder.file, sent_ns)) * 1e-6;
      worst_ms = std::max(worst_ms, lost_ms);
      sum_ms += lost_ms;
      beyond += lost_ms > kMost_ms ? 1 : 0;
    }
    std::cout << Kills() << " kills: " << sum_ms / Kills() << " ms lost on average, " << worst_ms
              << " ms at worst\n";
    EXPECT_LE(beyond, std::getenv("STYLED_KILLS") == nullptr ? Kills() / 2 : 0)
        << "of " << Kills() << " lost more than " << kMost_ms << " ms";
  }

  // The send time of the last datagram in the file. No earlier one may be missing.
  std::int64_t LastKept_ns(const std::string& file, const std::vector<std::int64_t>& sent_ns) {
    const auto reader = Reader::Open(file);
    EXPECT_TRUE(reader.ok()) << reader.status().message();
    std::vector<std::uint64_t> sequences;
    Record record;
    while (reader.ok() && reader.value()->Next(record)) {
      native::Datagram datagram;
      v1::Frame frame;
      if (record.has_arrival() &&
          native::Decode(std::as_bytes(std::span(record.arrival().datagram())), datagram) ==
              native::DecodeResult::kOk) {
        sequences.push_back(datagram.sequence);
      } else if (record.published().topic() == "source/rig.sim/" &&
                 frame.ParseFromString(record.published().payload())) {
        sequences.push_back(frame.source_sequence());
      }
    }
    EXPECT_FALSE(sequences.empty());
    if (sequences.empty()) return sent_ns.front();
    const auto& counts = reader.value()->counts();
    EXPECT_EQ(counts.damaged_places + counts.lost_blocks + counts.malformed, 0U);
    for (std::size_t i = 1; i < sequences.size(); ++i) {
      // In a published stream, bodies use sequence numbers but are not frames.
      EXPECT_LE(sequences[i] - sequences[i - 1], 2U) << "after " << sequences[i - 1];
    }
    return sent_ns.at(sequences.back());
  }

  std::string FileOf(int i) const { return folder_ / ("take" + std::to_string(i) + ".styrec"); }
};

TEST_F(KilledTest, StylerecReceiveLosesAtMostTheLast100Ms) {
  KillAgainAndAgain([this](int i) {
    Recorder recorder;
    recorder.file = FileOf(i);
    const std::string log = "receive" + std::to_string(i) + ".txt";
    recorder.own = Start({"receive", "--listen", "udp://127.0.0.1:0", recorder.file}, log);
    recorder.child = recorder.own.get();
    recorder.address = Bound(log, "listening on udp://");
    return recorder;
  });
}

TEST_F(KilledTest, StylerecRecordLosesAtMostTheLast100Ms) {
  const auto daemon = MakeDaemon();
  ControlClient control(daemon->control);
  KillAgainAndAgain([&](int i) {
    Recorder recorder;
    recorder.file = FileOf(i);
    EXPECT_EQ(control.CounterSoon("publish.subscriptions", 0), 0U);
    recorder.own = Start({"record", "--from", daemon->publish, recorder.file}, "record.txt");
    recorder.child = recorder.own.get();
    recorder.address = daemon->udp;
    EXPECT_EQ(control.CounterSoon("publish.subscriptions", 4), 4U);
    return recorder;
  });
}

TEST_F(KilledTest, TheDaemonLosesAtMostTheLast100Ms) {
  KillAgainAndAgain([this](int i) {
    Recorder recorder;
    recorder.file = FileOf(i);
    recorder.daemon =
        std::make_unique<Daemon>(std::vector<std::string>{"record.file=" + recorder.file});
    recorder.child = recorder.daemon->child.get();
    recorder.address = recorder.daemon->udp;
    return recorder;
  });
}

}  // namespace
}  // namespace styled::support
