#include "clients/web/hub.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "clients/web/topics.h"
#include "proto/styled/v1/body.pb.h"

namespace styled::web {
namespace {

constexpr std::size_t kMaxBodies = 4096;

bool Has(const std::vector<std::string>& topics, const std::string& topic) {
  return std::find(topics.begin(), topics.end(), topic) != topics.end();
}

MessagePtr Published(std::string key, std::string_view topic, std::string_view payload) {
  return std::make_shared<Message>(Message{std::move(key), Packed(topic, payload), false});
}

}  // namespace

std::string Packed(std::string_view topic, std::string_view payload) {
  std::string bytes;
  bytes.reserve(1 + topic.size() + payload.size());
  bytes += static_cast<char>(topic.size());
  return bytes.append(topic).append(payload);
}

Hub::Hub(std::string endpoint, Upward upward, Counters& counters, Clock::time_point now)
    : endpoint_(std::move(endpoint)),
      upward_(std::move(upward)),
      counters_(counters),
      changed_(now),
      heard_(now) {
  upward_.subscribe(std::string(kStatisticsTopic));
}

std::string Hub::Reason(Clock::time_point now) const {
  if (up_) return "";
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(now - changed_).count();
  return NobodyThere() + " (" + std::to_string(seconds) + " s)";
}

std::string Hub::NobodyThere() const {
  return "no daemon publishes at " + endpoint_ + (obstacle_.empty() ? "" : ": " + obstacle_);
}

MessagePtr Hub::DaemonNotice() const {
  const nlohmann::json notice{{"daemon", {{"up", up_}, {"reason", up_ ? "" : NobodyThere()}}}};
  return std::make_shared<Message>(Message{"daemon", notice.dump(), true});
}

void Hub::Deliver(const Browsers& to, const MessagePtr& message) {
  for (Browser* browser : to) browser->Offer(message);
}

void Hub::SetUp(bool up, Clock::time_point now) {
  if (up == up_) return;
  up_ = up;
  obstacle_.clear();
  changed_ = now;
  if (!up) {
    bodies_.clear();
    last_stats_.reset();
    has_stats_ = false;
  }
  const MessagePtr notice = DaemonNotice();
  for (const auto& [browser, topics] : browsers_) browser->Offer(notice);
}

void Hub::SetObstacle(const std::string& obstacle) {
  if (up_ || obstacle == obstacle_) return;
  obstacle_ = obstacle;
  const MessagePtr notice = DaemonNotice();
  for (const auto& [browser, topics] : browsers_) browser->Offer(notice);
}

void Hub::Tick(Clock::time_point now) {
  if (up_ && now - heard_ > kSilence) SetUp(false, now);
}

void Hub::Join(Browser& browser) {
  browsers_[&browser];
  ++counters_.browsers;
  browser.Offer(DaemonNotice());
}

void Hub::Leave(Browser& browser) {
  const auto known = browsers_.find(&browser);
  if (known == browsers_.end()) return;
  const std::vector<std::string> topics = known->second;
  for (const std::string& topic : topics) Unsubscribe(browser, topic);
  browsers_.erase(&browser);
}

Subscribed Hub::Subscribe(Browser& browser, const std::string& topic) {
  const auto kind = ParseTopic(topic);
  if (!kind) return Subscribed::kNoTopic;
  std::vector<std::string>& topics = browsers_[&browser];
  if (Has(topics, topic)) return Subscribed::kOk;
  const bool is_new = !wanted_.contains(topic);
  if (topics.size() >= kMaxTopics || (is_new && wanted_.size() >= kMaxDistinctTopics)) {
    return Subscribed::kTooMany;
  }
  topics.push_back(topic);
  wanted_[topic].push_back(&browser);
  if (is_new && *kind != TopicKind::kStatistics) upward_.subscribe(topic);
  if (*kind == TopicKind::kStatistics && last_stats_) browser.Offer(last_stats_);
  if (*kind == TopicKind::kBody || *kind == TopicKind::kEveryBody) {
    for (auto body = bodies_.lower_bound(topic);
         body != bodies_.end() && body->first.starts_with(topic); ++body) {
      browser.Offer(body->second.message);
    }
  }
  return Subscribed::kOk;
}

void Hub::Unsubscribe(Browser& browser, const std::string& topic) {
  std::vector<std::string>& topics = browsers_[&browser];
  if (std::erase(topics, topic) == 0) return;
  const auto wanted = wanted_.find(topic);
  std::erase(wanted->second, &browser);
  if (!wanted->second.empty()) return;
  wanted_.erase(wanted);
  if (topic == kStatisticsTopic) return;
  upward_.unsubscribe(topic);
  ForgetBodies(topic);
}

// Without a subscription the hub would miss changes, so it drops the cached bodies.
void Hub::ForgetBodies(std::string_view topic) {
  if (!topic.starts_with(kEveryBodyTopic) || wanted_.contains(kEveryBodyTopic)) return;
  std::erase_if(bodies_, [&](const auto& body) {
    const std::string own = body.first.substr(0, body.first.rfind('/') + 1);
    return body.first.starts_with(topic) && !wanted_.contains(own);
  });
}

void Hub::PublishBody(std::string_view topic, std::string_view payload) {
  v1::Body body;
  if (!body.ParseFromArray(payload.data(), static_cast<int>(payload.size()))) {
    ++counters_.upstream_malformed;
    return;
  }
  // A performer's bodies share one topic; the output is part of the key, so that they do not
  // replace each other.
  std::string key = std::string(topic) + std::to_string(static_cast<int>(body.output()));
  if (bodies_.size() >= kMaxBodies) bodies_.clear();
  CachedBody& cached = bodies_[key];
  if (cached.message && cached.hash == body.hash()) return;
  cached = {body.hash(), Published(key, topic, payload)};
  const MessagePtr message = cached.message;
  if (const auto own = wanted_.find(topic); own != wanted_.end()) Deliver(own->second, message);
  if (const auto all = wanted_.find(kEveryBodyTopic); all != wanted_.end()) {
    Deliver(all->second, message);
  }
}

void Hub::Publish(std::string_view topic, std::string_view payload, Clock::time_point now) {
  ++counters_.upstream_messages;
  const auto kind = ParseTopic(topic);
  if (!kind || *kind == TopicKind::kEveryBody) {
    ++counters_.upstream_malformed;
    return;
  }
  if (*kind == TopicKind::kBody) return PublishBody(topic, payload);
  if (*kind == TopicKind::kStatistics) {
    if (!stats_.ParseFromArray(payload.data(), static_cast<int>(payload.size()))) {
      ++counters_.upstream_malformed;
      return;
    }
    has_stats_ = true;
    heard_ = now;
    SetUp(true, now);
    last_stats_ = Published(std::string(topic), topic, payload);
    const auto wanted = wanted_.find(topic);
    if (wanted != wanted_.end()) Deliver(wanted->second, last_stats_);
    return;
  }
  const auto wanted = wanted_.find(topic);
  if (wanted == wanted_.end()) return;  // unsubscribed while the message was in transit
  Deliver(wanted->second, Published(std::string(topic), topic, payload));
}

}  // namespace styled::web
