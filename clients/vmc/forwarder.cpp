#include "clients/vmc/forwarder.h"

#include <algorithm>
#include <utility>

namespace styled::stylevmc {
namespace {

std::int64_t Now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

// Whether `channel` shows `performer`. A channel whose performer is silent, or that has none,
// switches to it.
bool Shows(Channel& channel, const std::string& performer, std::int64_t now_ns,
           std::chrono::nanoseconds patience) {
  const bool free = channel.wanted.empty() &&
                    (channel.current.empty() || now_ns - channel.last_ns > patience.count());
  if (free) channel.current = performer;
  return channel.current == performer;
}

}  // namespace

Result<std::unique_ptr<Forwarder>> Forwarder::Open(const Options& options) {
  std::unique_ptr<Forwarder> forwarder(new Forwarder());
  forwarder->patience_ = options.patience;
  if (Status status = forwarder->OpenTargets(options); !status.ok()) return status;
  client::SubscriberOptions subscription;
  subscription.endpoints = options.publishers;
  subscription.curve = options.curve;
  subscription.streams = {client::Stream::kStyledCanonical};
  // The daemon computes the canonical pose only for performers that have a subscriber for it.
  if (forwarder->channels_.size() == 1) subscription.performer = forwarder->channels_[0].wanted;
  auto subscriber = client::Subscriber::Connect(subscription);
  if (!subscriber.ok()) return subscriber.status();
  forwarder->subscriber_ = std::move(subscriber.value());
  return forwarder;
}

Status Forwarder::OpenTargets(const Options& options) {
  for (const TargetSpec& spec : options.targets) {
    auto target = Target::Open(spec);
    if (!target.ok()) return target.status();
    const std::string& wanted = spec.performer.empty() ? options.performer : spec.performer;
    auto channel = std::find_if(channels_.begin(), channels_.end(),
                                [&](const Channel& known) { return known.wanted == wanted; });
    if (channel == channels_.end()) {
      channels_.push_back({.wanted = wanted,
                           .current = wanted,
                           .targets = {},
                           .counts = {},
                           .puppet = Puppet(options.carrier),
                           .vrchat = {},
                           .cap = RateCap(options.rate_hz),
                           .timeline = {},
                           .body = nullptr});
      channel = channels_.end() - 1;
      if (options.vrchat) channel->vrchat.emplace(*options.vrchat);
    }
    channel->targets.push_back(std::move(target.value()));
  }
  return Status::Ok();
}

void Forwarder::Step(std::chrono::milliseconds timeout) {
  // Latest-wins: sending a backlog as a burst would overrun the applications.
  subscriber_->ReceiveLatest(timeout, updates_);
  const std::int64_t now_ns = Now_ns();
  for (const client::Update& update : updates_) {
    if (update.kind != client::Update::Kind::kFrame) continue;
    for (Channel& channel : channels_) {
      if (!Shows(channel, update.frame.performer(), now_ns, patience_)) continue;
      Forward(update, channel, now_ns);
    }
  }
}

void Forwarder::Forward(const client::Update& update, Channel& channel, std::int64_t now_ns) {
  Counts& counts = channel.counts;
  channel.last_ns = now_ns;
  counts.missed += update.missed;
  counts.thinned += update.skipped;
  if (update.body == nullptr) {
    ++counts.bodiless;
    return;
  }
  if (channel.body != update.body) {
    const Status status =
        channel.vrchat ? channel.vrchat->Bind(*update.body) : channel.puppet.Bind(*update.body);
    channel.body = update.body;
    channel.usable = status.ok();
    if (!status.ok()) counts.last_error = status.message();
  }
  if (!channel.usable) return;
  if (!channel.cap.Admit(update.frame.source_time_ns(), now_ns)) {
    ++counts.thinned;
    return;
  }
  if (channel.vrchat) {
    Send(channel.vrchat->Pack(update.frame, now_ns), channel);
  } else {
    const float time_s = channel.timeline.Seconds(update.frame.source_time_ns(), now_ns);
    Send(channel.puppet.Pose(update.frame, time_s), channel);
  }
  ++counts.frames;
}

void Forwarder::Send(const vmc::Packed& packed, Channel& channel) {
  vmc::Packer packer(packed);
  while (const std::size_t size = packer.Next(buffer_)) {
    Send(std::span(buffer_).first(size), channel);
  }
}

void Forwarder::Send(std::span<const std::byte> datagram, Channel& channel) {
  for (const auto& target : channel.targets) {
    const std::string error = target->Send(datagram);
    if (error.empty()) continue;
    ++channel.counts.failed;
    channel.counts.last_error = "sending to " + target->text() + ": " + error;
  }
}

}  // namespace styled::stylevmc
