#include "clients/nats/bridge.h"

#include <algorithm>
#include <utility>

#include "clients/nats/subject.h"

namespace styled::stylenats {
namespace {

using std::chrono::milliseconds;

// The most messages that one Step passes on, so that its caller is not blocked.
constexpr int kMaxBurst = 1000;

std::string_view StreamName(const client::Update& update) {
  switch (update.stream) {
    case client::Stream::kStyledRig:
      return "rig";
    case client::Stream::kStyledCanonical:
      return "canonical";
    default:
      return update.avatar;
  }
}

std::string StreamName(const v1::Body& body) {
  switch (body.output()) {
    case v1::OUTPUT_RIG:
      return "rig";
    case v1::OUTPUT_CANONICAL:
      return "canonical";
    default:
      return body.output_name();
  }
}

}  // namespace

Status CheckSite(const std::string& site) {
  if (!site.empty() && site.size() <= kMaxSite) return Status::Ok();
  return Status::Error("--site '" + site + "': expected 1 to " + std::to_string(kMaxSite) +
                       " bytes, found " + std::to_string(site.size()));
}

v1::PerformerStats Lasting(const v1::PerformerStats& performer) {
  v1::PerformerStats lasting = performer;
  lasting.clear_sequence();
  lasting.clear_rate_hz();
  lasting.clear_latency_p50_us();
  lasting.clear_latency_p99_us();
  lasting.clear_latency_max_us();
  lasting.clear_latency_p99_minute_us();
  lasting.clear_latency_p99_overall_us();
  lasting.clear_period_ms();
  lasting.clear_over_budget();
  lasting.clear_overload_bypassed();
  lasting.clear_received();
  lasting.clear_published();
  lasting.clear_lost();
  lasting.clear_refused();
  lasting.clear_refused_as();
  lasting.clear_shown();
  lasting.clear_turned_deg();
  lasting.clear_moved();
  lasting.clear_hardly_styled();
  lasting.clear_neutral();
  return lasting;
}

Result<std::unique_ptr<Bridge>> Bridge::Open(const Options& options) {
  if (const Status status = CheckSite(options.site); !status.ok()) return status;
  std::unique_ptr<Bridge> bridge(new Bridge(options.site));
  client::SubscriberOptions subscription;
  subscription.endpoints = {options.publisher};
  subscription.curve = options.curve;
  subscription.streams = {client::Stream::kStyledRig, client::Stream::kStyledCanonical};
  subscription.every_avatar = true;
  subscription.keep_bytes = true;
  subscription.statistics = true;
  auto subscriber = client::Subscriber::Connect(subscription);
  if (!subscriber.ok()) return subscriber.status();
  bridge->subscriber_ = std::move(subscriber.value());
  auto link = Link::Open(options.link);
  if (!link.ok()) return link.status();
  bridge->link_ = std::move(link.value());
  auto commands = Commands::Start(*bridge->link_, options.site, options.control, options.curve);
  if (!commands.ok()) return commands.status();
  bridge->commands_ = std::move(commands.value());
  bridge->store_ = std::make_unique<StateStore>(*bridge->link_, options.domain);
  bridge->sender_ = std::make_unique<Sender>(bridge->queue_, *bridge->link_);
  return bridge;
}

Bridge::~Bridge() = default;

void Bridge::Step(milliseconds timeout) {
  for (int i = 0; i < kMaxBurst; ++i) {
    if (!subscriber_->Receive(i == 0 ? timeout : milliseconds(0), update_)) return;
    switch (update_.kind) {
      case client::Update::Kind::kFrame:
        Pass(update_);
        break;
      case client::Update::Kind::kBody:
        Keep(update_);
        break;
      case client::Update::Kind::kStatistics:
        KeepPerformers(update_.statistics);
        break;
    }
  }
}

void Bridge::Pass(const client::Update& update) {
  const v1::Frame& frame = update.frame;
  const std::string_view stream = StreamName(update);
  if (stream == kAudienceStream) {
    output_refused_ = true;
    return;
  }
  PassBody(update, stream);
  queue_.Push(frame.performer(), stream, update.bytes, frame.epoch(), frame.sequence());
  if (update.stream != client::Stream::kStyledCanonical || !tier_.Picks(frame.performer())) return;
  ++audience_;
  queue_.Push(frame.performer(), kAudienceStream, update.bytes, frame.epoch(), frame.sequence());
}

// A recording must contain the bodies of its frames, because the bucket is in memory and may be
// gone by then.
void Bridge::PassBody(const client::Update& update, std::string_view stream) {
  if (!update.body || !beat_.IsDue(update.frame.performer(), stream, update.body->hash())) return;
  const std::string bytes = update.body->SerializeAsString();
  queue_.PushBody(update.frame.performer(), stream, bytes);
  // A body that returns after another one is not reported again (client::Update::Kind::kBody).
  store_->Put(BodyKey(site_, update.frame.performer(), stream), bytes);
}

void Bridge::Keep(const client::Update& update) {
  const std::string stream = StreamName(*update.body);
  if (stream.empty() || stream == kAudienceStream) return;
  store_->Put(BodyKey(site_, update.body->performer(), stream), update.bytes);
}

void Bridge::KeepPerformers(const v1::Stats& statistics) {
  if (statistics.standby().role() == "following") return;  // the leader's bridge writes them
  std::set<std::string> gone = std::exchange(performers_, {});
  for (const v1::PerformerStats& performer : statistics.performers()) {
    if (!client::IsPerformerId(performer.performer())) continue;
    gone.erase(performer.performer());
    performers_.insert(performer.performer());
    store_->Put(PerformerKey(site_, performer.performer()), Lasting(performer).SerializeAsString());
  }
  for (const std::string& performer : gone) store_->Remove(PerformerKey(site_, performer));
}

void Bridge::Stop(milliseconds patience) {
  const auto end = std::chrono::steady_clock::now() + patience;
  store_->RequestStop();
  sender_->Stop();
  store_->Stop();
  const auto left = std::chrono::ceil<milliseconds>(end - std::chrono::steady_clock::now());
  if (link_->connected()) (void)link_->Flush(std::max(left, milliseconds(50)));
}

Totals Bridge::totals() const {
  const FrameQueue::Counts queue = queue_.counts();
  const Sender::Counts& sender = sender_->counts();
  const client::SubscriberCounters& received = subscriber_->counters();
  Totals t;
  t.sent = sender.frames;
  t.audience = audience_;
  t.bodies = sender.bodies;
  t.replaced = queue.replaced;
  t.refused = queue.refused;
  t.disconnected = sender.disconnected;
  t.too_large = sender.too_large;
  t.failed = sender.failed;
  t.stalled = sender.stalled;
  t.longest_call_us = sender.longest_call_us;
  t.missed = received.missed;
  t.malformed = received.malformed;
  t.written = store_->counts().written;
  t.unwritten = store_->counts().failed;
  t.unkept = store_->counts().refused;
  t.requests = commands_->counts().requests;
  t.unanswered = commands_->counts().unanswered;
  t.unsent_replies = commands_->counts().lost + commands_->counts().too_large;
  return t;
}

bool Bridge::NextRefusedOutput() { return output_refused_ && !std::exchange(refusal_taken_, true); }

}  // namespace styled::stylenats
