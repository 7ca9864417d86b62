#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "daemon/standby/standby.h"
#include "tests/support/fake_pipeline.h"

// A pair of daemons, each of which can take over, without sockets, threads and sleeps.
namespace styled::support {

// A wire between two nodes that a test can cut. Messages in the cut are lost, as in ZeroMQ's queue.
struct Wire {
  std::deque<std::string> to_a, to_b;
  bool a_asked = false, b_asked = false;
  int a_subscriptions = 0;  // of other programs, at a
  bool cut = false;
  // As libzmq does, the reader cuts the wire when a larger message arrives.
  std::size_t max_bytes = standby::kMaxMessageBytes;
  int lose = 0;                                 // number of messages to lose
  std::function<void(const std::string&)> spy;  // sees messages to b
  std::function<void(const std::string&)> spy_on_b;
  std::function<void(v1::Journal&)> change;  // changes messages to b
};

class WireEnd final : public standby::Channel {
 public:
  WireEnd(Wire& wire, bool is_a) : wire_(wire), is_a_(is_a) {}
  void Send(std::span<const std::byte> message) noexcept override {
    if (message.size() > wire_.max_bytes) wire_.cut = true;
    if (wire_.cut || (wire_.lose > 0 && wire_.lose-- > 0)) return;
    std::string sent(reinterpret_cast<const char*>(message.data()), message.size());
    if (const auto& spy = is_a_ ? wire_.spy : wire_.spy_on_b) spy(sent);
    if (v1::Journal entry; is_a_ && wire_.change && entry.ParseFromString(sent)) {
      wire_.change(entry);
      sent = entry.SerializeAsString();
    }
    (is_a_ ? wire_.to_b : wire_.to_a).push_back(std::move(sent));
  }
  bool Receive(std::string& message) override {
    auto& inbox = is_a_ ? wire_.to_a : wire_.to_b;
    if (inbox.empty()) return false;
    message = std::move(inbox.front());
    inbox.pop_front();
    return true;
  }
  std::size_t max_bytes() const override { return wire_.max_bytes; }
  Subscription NextSubscription() override {
    if (std::exchange(is_a_ ? wire_.a_asked : wire_.b_asked, false)) return Subscription::kBegan;
    if (!is_a_ || wire_.a_subscriptions == 0) return Subscription::kNone;
    --wire_.a_subscriptions;
    return Subscription::kBegan;
  }
  void Ask() override {
    if (!wire_.cut) (is_a_ ? wire_.b_asked : wire_.a_asked) = true;
  }

 private:
  Wire& wire_;
  bool is_a_;
};

// A source whose datagrams the test gives.
class GivenTransport final : public source::Transport {
 public:
  explicit GivenTransport(runtime::Counters& counters) : decoder_(0, counters) {}
  int DoWork(source::Receiver& receiver) override {
    if (waiting.empty()) return 0;
    std::vector<std::span<const std::byte>> spans;
    for (std::size_t i = 0; i < waiting.size() && i < source::kBatch; ++i) {
      spans.emplace_back(waiting[i]);
    }
    const std::vector<source::Machine> machines(spans.size(), machine);
    decoder_.HandOn(spans, machines, receiver);
    const auto count = static_cast<std::ptrdiff_t>(spans.size());
    waiting.erase(waiting.begin(), waiting.begin() + count);
    return static_cast<int>(count);
  }
  int fd() const override { return -1; }
  const std::string& endpoint() const override { return endpoint_; }
  std::uint64_t received() const override { return 0; }

  std::deque<Bytes> waiting;
  source::Machine machine{};

 private:
  source::NativeDecoder decoder_;
  std::string endpoint_ = "given";
};

// One of the two daemons.
class Node {
 public:
  Node(Wire& wire, bool is_a, std::uint64_t id, std::int64_t start_ns,
       std::shared_ptr<const pipeline::RuntimeConfig> config, const std::string& subscription,
       bool first = false)
      : Node(wire, is_a, id, start_ns, std::move(config), std::vector{subscription}, first) {}
  Node(Wire& wire, bool is_a, std::uint64_t id, std::int64_t start_ns,
       std::shared_ptr<const pipeline::RuntimeConfig> config,
       const std::vector<std::string>& subscriptions, bool first = false,
       config::Standby settings = {}) {
    clock.now_ns = start_ns;
    settings.peer = "the other";
    settings.first = first;
    standby = std::make_unique<standby::Standby>(std::make_unique<WireEnd>(wire, is_a), settings,
                                                 id, publisher, clock);
    auto transport = std::make_unique<GivenTransport>(counters);
    rig = transport.get();
    std::vector<std::unique_ptr<source::Transport>> transports;
    transports.push_back(std::move(transport));
    pipeline::Dependencies to{standby->clock(), counters, standby->publisher(), mailboxes};
    to.standby = standby.get();
    pipeline_ = std::make_unique<pipeline::Pipeline>(
        to, std::vector<std::string>{"rig"}, std::move(transports), std::move(config), id, 100);
    for (const auto& subscription : subscriptions) {
      publisher.events.push_back({true, subscription});
    }
  }

  // One turn; returns how much it did.
  int Step() { return pipeline_->DoWork(); }
  void Work() {
    while (pipeline_->DoWork() > 0) {
    }
  }
  v1::Reply Ask(const v1::Request& request) {
    auto exchange = std::make_unique<pipeline::Exchange>();
    exchange->request = request;
    EXPECT_TRUE(mailboxes.commands.Push(std::move(exchange)));
    Work();
    EXPECT_TRUE(mailboxes.replies.Pop(exchange));
    return exchange == nullptr ? v1::Reply() : exchange->reply;
  }
  v1::StandbyState State() {
    v1::Request request;
    request.mutable_status();
    return Ask(request).status().stats().standby();
  }
  std::vector<std::string> Lines() {
    std::vector<std::string> lines;
    pipeline::Event event;
    while (mailboxes.events.Pop(event)) lines.push_back(event.text);
    return lines;
  }

  FakeClock clock;
  runtime::Counters counters;
  FakePublisher publisher;
  pipeline::Mailboxes mailboxes;
  std::unique_ptr<standby::Standby> standby;
  GivenTransport* rig = nullptr;

 private:
  std::unique_ptr<pipeline::Pipeline> pipeline_;
};

}  // namespace styled::support
