// The cost of the daemon's loop, sockets and wait modes without a stylist: each received frame is
// published unchanged, under the topic of a styled frame and at about its size. The reference for
// the wire bench. Usage: styled_echo block|hybrid|busy [cpu [priority]]. It prints its addresses
// and ends at the end of its input.
#include <sys/prctl.h>
#include <unistd.h>
#include <zmq.h>

#include <algorithm>
#include <cstring>
#include <iostream>
#include <string>
#include <thread>
#include <unordered_map>

#include "daemon/decide/anticipation.h"
#include "daemon/pipeline/pipeline_thread.h"
#include "daemon/publish/publisher.h"
#include "daemon/runtime/realtime.h"
#include "daemon/runtime/schedule.h"
#include "daemon/source/source_frame.h"
#include "daemon/source/udp.h"

namespace styled::bench {
namespace {

constexpr std::size_t kMessage = 640;  // about the size of a styled frame with 21 joints

struct Stream {
  std::string topic;
  runtime::Schedule schedule;
  decide::Anticipation anticipation;
  std::int64_t first_ns = -1, elapsed_ns = 0;
};

class Echo final : public pipeline::Worker, public source::Receiver {
 public:
  Echo(source::Transport& transport, publish::Publisher& publisher, runtime::Clock& clock)
      : transport_(transport), publisher_(publisher), clock_(clock) {}

  int DoWork() override {
    const int work = transport_.DoWork(*this);
    const std::int64_t now_ns = clock_.Now_ns();
    for (auto& [name, stream] : streams_) (void)stream.anticipation.Prepare(now_ns);
    publish::SubscriptionEvent event;
    while (publisher_.NextSubscription(event)) continue;
    return work;
  }
  std::int64_t NextDeadline_ns() const override {
    std::int64_t next_ns = decide::Anticipation::kNever;
    for (const auto& [name, stream] : streams_) {
      next_ns = std::min(next_ns, stream.anticipation.prepare_ns());
    }
    return next_ns;
  }
  bool Expects(std::int64_t now_ns) const override {
    return std::any_of(streams_.begin(), streams_.end(), [now_ns](const auto& entry) {
      return entry.second.anticipation.Expects(now_ns);
    });
  }

  void OnFrames(int, std::span<const source::SourceFrame> frames, bool) override {
    for (const source::SourceFrame& frame : frames) {
      if (frame.is_body) continue;
      Stream& stream = streams_[std::string(frame.performer)];
      if (stream.topic.empty()) {
        stream.topic = "styled/rig." + std::string(frame.performer) + "/rig/";
      }
      const auto time_ns = static_cast<std::int64_t>(frame.source_time_ns);
      if (stream.first_ns < 0) stream.first_ns = time_ns;
      const std::int64_t before_ns = stream.elapsed_ns;
      stream.elapsed_ns = time_ns - stream.first_ns;
      (void)stream.schedule.Lateness_ns(stream.elapsed_ns, clock_.Now_ns());
      stream.anticipation.Await(stream.schedule.Due_ns(2 * stream.elapsed_ns - before_ns));
      std::memcpy(message_.data(), &frame.source_time_ns, 8);
      std::memcpy(message_.data() + 8, &frame.sequence, 8);
      std::memcpy(message_.data() + 16, frame.rotations.data(),
                  std::min(frame.rotations.size(), kMessage - 16));
      publisher_.Send(stream.topic, message_);
    }
  }
  void OnNote(int, const std::string&) override {}

 private:
  source::Transport& transport_;
  publish::Publisher& publisher_;
  runtime::Clock& clock_;
  std::unordered_map<std::string, Stream> streams_;
  std::array<std::byte, kMessage> message_{};
};

int Main(const std::string& mode, int cpu, int priority) {
  void* const context = zmq_ctx_new();
  runtime::SystemClock clock;
  runtime::Counters counters;
  config::Source source;
  source.listen = "127.0.0.1:0";
  auto transport = source::MakeUdp(source, 0, clock, counters, nullptr);
  std::string endpoint;
  config::Publish publish;
  publish.address = "tcp://127.0.0.1:*";
  auto publisher = publish::MakeZmqPublisher(context, publish, counters, endpoint);
  if (!transport.ok() || !publisher.ok()) return 1;
  Echo echo(*transport.value(), *publisher.value(), clock);
  runtime::Wakeup wake;
  const std::array fds{publisher.value()->fd(), transport.value()->fd()};
  pipeline::PipelineThread loop(echo, fds, wake, clock,
                                mode == "busy"     ? pipeline::Wait::kBusy
                                : mode == "hybrid" ? pipeline::Wait::kHybrid
                                                   : pipeline::Wait::kBlock);
  std::thread thread([&] {
    prctl(PR_SET_NAME, "pipeline");
    for (const auto& refused : runtime::ApplyScheduling({true, priority, cpu}))
      std::cerr << refused << "\n";
    loop.Run();
  });
  std::cout << transport.value()->endpoint() << " " << endpoint << std::endl;
  char byte = 0;
  while (read(STDIN_FILENO, &byte, 1) > 0) continue;
  loop.Stop();
  thread.join();
  publisher.value().reset();
  zmq_ctx_term(context);
  return 0;
}

}  // namespace
}  // namespace styled::bench

int main(int argc, char** argv) {
  if (argc < 2) {
    std::cerr << "usage: styled_echo block|hybrid|busy [cpu]\n";
    return 2;
  }
  return styled::bench::Main(argv[1], argc > 2 ? std::stoi(argv[2]) : -1,
                             argc > 3 ? std::stoi(argv[3]) : 0);
}
