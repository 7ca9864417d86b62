#pragma once

#include <gtest/gtest.h>

#include <deque>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "daemon/pipeline/pipeline.h"
#include "tests/support/native_frames.h"
#include "tests/support/rig.h"

// The pipeline with a clock that the test controls, without sockets and sleeps.
namespace styled::support {

class FakeClock final : public runtime::Clock {
 public:
  std::int64_t Now_ns() const noexcept override { return now_ns; }
  std::int64_t Wall_ns() const noexcept override { return now_ns + wall_ahead_ns; }
  std::int64_t now_ns = 1'000'000'000'000;
  std::int64_t wall_ahead_ns = 1'700'000'000'000'000'000;
};

// Keeps the published frames and counts everything else.
class FakePublisher final : public publish::Publisher {
 public:
  void Send(std::string_view topic, std::span<const std::byte> payload) noexcept override {
    if (topic.starts_with("body/")) {
      ++bodies;
    } else if (topic == "stats/") {
      ++stats;
    } else if (topic.starts_with("frames/")) {
      bundles.emplace_back(topic, v1::Frames())
          .second.ParseFromArray(payload.data(), static_cast<int>(payload.size()));
    } else {
      frames.emplace_back().ParseFromArray(payload.data(), static_cast<int>(payload.size()));
    }
  }
  bool NextSubscription(publish::SubscriptionEvent& event) override {
    if (events.empty()) return false;
    event = events.front();
    events.pop_front();
    return true;
  }
  int fd() const override { return -1; }

  std::vector<v1::Frame> frames;
  std::vector<std::pair<std::string, v1::Frames>> bundles;  // by topic
  int bodies = 0, stats = 0;
  std::deque<publish::SubscriptionEvent> events;
};

// A pipeline whose first source is named "rig"; the test delivers its datagrams.
class FakePipeline {
 public:
  FakePipeline(std::shared_ptr<const pipeline::RuntimeConfig> config,
               const std::string& subscription, std::vector<std::string> sources = {"rig"},
               runtime::Helpers* helpers = nullptr)
      : pipeline_(std::make_unique<pipeline::Pipeline>(
            pipeline::Dependencies{.clock = clock,
                                   .counters = counters,
                                   .publisher = publisher,
                                   .mailboxes = mailboxes,
                                   .helpers = helpers},
            std::move(sources), std::vector<std::unique_ptr<source::Transport>>(),
            std::move(config), 77, 100)) {
    publisher.events.push_back({true, subscription});
    Work();
  }

  void Work() {
    while (pipeline_->DoWork() > 0) {
    }
  }
  void Deliver(const std::vector<Bytes>& datagrams, const source::Machine& sender = {}) {
    const std::vector<std::span<const std::byte>> spans(datagrams.begin(), datagrams.end());
    const std::vector<source::Machine> senders(datagrams.size(), sender);
    HandOn(spans, senders, counters, *pipeline_);
    Work();
  }
  void Pass(std::int64_t ms) {
    clock.now_ns += ms * 1'000'000;
    Work();
  }
  v1::Reply Ask(const v1::Request& request) {
    auto exchange = std::make_unique<pipeline::Exchange>();
    exchange->request = request;
    EXPECT_TRUE(mailboxes.commands.Push(std::move(exchange)));
    Work();
    EXPECT_TRUE(mailboxes.replies.Pop(exchange));
    return exchange->reply;
  }
  // The performer's row in `stylectl status`; empty if there is none.
  v1::PerformerStats StatsOf(const std::string& id) {
    v1::Request request;
    request.mutable_status();
    const v1::Reply reply = Ask(request);
    for (const auto& row : reply.status().stats().performers()) {
      if (row.performer() == id) return row;
    }
    return {};
  }
  std::uint64_t Count(runtime::Counter counter) const { return counters.Get(counter); }
  // The log lines since the last call.
  std::vector<std::string> Lines() {
    std::vector<std::string> lines;
    pipeline::Event event;
    while (mailboxes.events.Pop(event)) lines.push_back(event.text);
    return lines;
  }
  pipeline::Pipeline& pipeline() { return *pipeline_; }

  FakeClock clock;
  runtime::Counters counters;
  FakePublisher publisher;
  pipeline::Mailboxes mailboxes;

 private:
  std::unique_ptr<pipeline::Pipeline> pipeline_;
};

}  // namespace styled::support
