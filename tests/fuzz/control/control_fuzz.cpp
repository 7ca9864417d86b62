// Fuzzes control requests through the pipeline, with one performer: each request gets a reply, a
// refusal contains a reason, and frames stay finite whatever was set.
#include <google/protobuf/stubs/logging.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>

#include "daemon/pipeline/pipeline.h"
#include "tests/support/native_frames.h"
#include "tests/support/rig.h"
#include "tests/unit/net/erd/random_weights.h"

namespace {

using namespace styled;

void Require(bool condition) {
  if (!condition) std::abort();
}

class StandingClock final : public runtime::Clock {
 public:
  std::int64_t Now_ns() const noexcept override { return now_ns; }
  std::int64_t Wall_ns() const noexcept override { return now_ns; }
  std::int64_t now_ns = runtime::kSecond_ns;
};

class FiniteFrames final : public publish::Publisher {
 public:
  void Send(std::string_view topic, std::span<const std::byte> payload) noexcept override {
    if (!topic.starts_with("styled/")) return;
    Require(frame_.ParseFromArray(payload.data(), static_cast<int>(payload.size())));
    for (const float value : frame_.rotations()) Require(std::isfinite(value));
    ++frames;
  }
  bool NextSubscription(publish::SubscriptionEvent& event) override {
    event = {true, "styled/"};
    return std::exchange(asking_, false);
  }
  int fd() const override { return -1; }
  int frames = 0;

 private:
  v1::Frame frame_;
  bool asking_ = true;
};

// A source without a socket; Daemon delivers its datagrams directly.
class Nothing final : public source::Transport {
 public:
  int DoWork(source::Receiver&) override { return 0; }
  int fd() const override { return -1; }
  const std::string& endpoint() const override { return endpoint_; }
  std::uint64_t received() const override { return 0; }

 private:
  std::string endpoint_;
};

class Daemon {
 public:
  Daemon() {
    std::vector<std::unique_ptr<source::Transport>> transports;
    transports.push_back(std::make_unique<Nothing>());
    auto live = std::make_shared<pipeline::RuntimeConfig>();
    live->network = erd::RandomStylizer(5, 1);
    auto& both = live->presets.emplace_back();
    both.name = "both";
    for (const char* style : {"style1", "style2"}) {
      auto& entry = *both.look.add_mix();
      entry.set_style(style);
      entry.set_weight(0.5F);
    }
    pipeline_ = std::make_unique<pipeline::Pipeline>(
        pipeline::Dependencies{clock_, counters_, publisher_, mailboxes_},
        std::vector<std::string>{"rig"}, std::move(transports), std::move(live), 1, 100);
    Work();
    Deliver(rig_.Body());
  }

  v1::Reply Ask(const v1::Request& request) {
    auto exchange = std::make_unique<pipeline::Exchange>();
    exchange->request = request;
    Require(mailboxes_.commands.Push(std::move(exchange)));
    Work();
    Require(mailboxes_.replies.Pop(exchange));
    std::unique_ptr<std::vector<pipeline::Profile>> kept;
    while (mailboxes_.profiles.Pop(kept)) {
    }
    return exchange->reply;
  }
  void Play(int frames) {
    const int before = publisher_.frames;
    for (int i = 0; i < frames; ++i) Deliver(rig_.Frame());
    Require(publisher_.frames == before + 2 * frames);  // canonical and rig
  }

 private:
  void Deliver(const support::Bytes& bytes) {
    clock_.now_ns += runtime::kSecond_ns / 120;
    const std::span<const std::byte> datagram(bytes);
    support::HandOn({&datagram, 1}, {}, counters_, *pipeline_);
    Work();
  }
  void Work() {
    while (pipeline_->DoWork() > 0) {
    }
    pipeline::Event event;
    while (mailboxes_.events.Pop(event)) {
    }
  }

  StandingClock clock_;
  runtime::Counters counters_;
  FiniteFrames publisher_;
  pipeline::Mailboxes mailboxes_;
  support::Rig rig_{"a"};
  std::unique_ptr<pipeline::Pipeline> pipeline_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  [[maybe_unused]] static auto* const quiet = google::protobuf::SetLogHandler(nullptr);
  v1::Request request;
  if (!request.ParseFromArray(data, static_cast<int>(size))) return 0;
  static Daemon daemon;
  const v1::Reply reply = daemon.Ask(request);
  Require(reply.id() == request.id());
  Require(reply.code() == v1::CODE_OK || !reply.reason().empty());
  daemon.Play(2);
  // Restores the initial state, so that an input always has the same effect.
  v1::Request undo;
  undo.set_performer("*");
  undo.mutable_pin()->set_pinned(false);
  Require(daemon.Ask(undo).code() == v1::CODE_OK);
  undo.mutable_set()->set_clear(true);
  undo.mutable_set()->set_strength(1);
  undo.mutable_set()->set_transition_ms(0);
  undo.mutable_set()->set_absolute(false);
  undo.mutable_set()->add_parts(v1::BODY_PART_ALL);
  undo.mutable_set()->set_input_style("");
  undo.mutable_set()->set_vary(0);
  undo.mutable_set()->set_vary_each(false);
  undo.mutable_set()->set_vary_amount(1);
  undo.mutable_set()->set_drift_s(0);
  Require(daemon.Ask(undo).code() == v1::CODE_OK);
  return 0;
}
