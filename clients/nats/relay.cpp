#include "clients/nats/relay.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

#include "clients/cpp/reach.h"
#include "clients/nats/bridge.h"
#include "clients/nats/frame_queue.h"
#include "clients/nats/subject.h"
#include "model/base/descriptor.h"
#include "proto/styled/v1/control.pb.h"
#include "proto/styled/v1/stats.pb.h"

namespace styled::stylenats {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

// Streams of which a frame may wait here: 16 performers with 8 streams each, many times over.
constexpr std::size_t kMaxStreams = 4096;
// Frames of a stream: late messages arrive together, and are passed on together.
constexpr std::size_t kDepth = FrameQueue::Limits().depth;
constexpr std::size_t kMaxValues = 8192;
// The limits of waiting frames, and of values: the same as stylenats'.
constexpr std::size_t kMaxBytes = std::size_t{64} << 20U;
constexpr std::size_t kMaxReplies = 256;
constexpr std::size_t kMaxPending = 64;
constexpr std::int64_t kMaxRequestBytes = std::int64_t{8} << 20U;  // as the daemon reads
// A take of an example may last a minute, then the daemon answers.
constexpr std::chrono::seconds kPatience(90);
constexpr std::chrono::seconds kRepeat(1);

std::string Bytes(natsMsg* message) {
  const int size = natsMsg_GetDataLength(message);
  return size > 0 ? std::string(natsMsg_GetData(message), static_cast<std::size_t>(size)) : "";
}

Status CheckLocal(const std::string& option, const std::string& endpoint) {
  const bool local = endpoint.starts_with("ipc://") || endpoint.starts_with("tcp://127.") ||
                     endpoint.starts_with("tcp://[::1]:");
  if (local) {
    const Status valid = client::CheckEndpoint(endpoint);
    return valid.ok() ? valid : Status::Error(option + " " + valid.message());
  }
  return Status::Error(option + " " + endpoint +
                       ": expected tcp://127.0.0.1:PORT or ipc://PATH, because it has no key");
}

Status Listen(zmq::socket_t& socket, const std::string& option, const std::string& endpoint) {
  try {
    socket.set(zmq::sockopt::linger, 0);
    socket.set(zmq::sockopt::ipv6, endpoint.find('[') != std::string::npos);
    socket.set(zmq::sockopt::maxmsgsize, kMaxRequestBytes);
    socket.bind(endpoint);
    return Status::Ok();
  } catch (const zmq::error_t& error) {
    return Status::Error(option + " " + endpoint + ": " + error.what() +
                         "; does a daemon run there?");
  }
}

}  // namespace

// The data from libnats' threads. Of each stream the newest few frames wait, as in FrameQueue.
struct Relay::Inbox {
  std::mutex mutex;
  Descriptor wake{eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)};
  std::map<std::string, std::deque<std::string>> frames;  // by subject
  std::deque<std::string> order;                          // order of arrival: a subject for each
  std::size_t frame_bytes = 0;
  std::deque<std::pair<std::string, std::optional<std::string>>> values;
  struct Reply {
    std::string subject, bytes;
    bool nobody = false;  // the broker's own: no responder is there
  };
  std::deque<Reply> replies;
  std::uint64_t replaced = 0, odd = 0;

  void Wake() const {
    const std::uint64_t one = 1;
    (void)!write(wake.get(), &one, sizeof one);
  }
  void ClearWake() const {
    std::uint64_t count = 0;
    (void)!read(wake.get(), &count, sizeof count);
  }
  void AddFrame(const std::string& subject, std::string bytes) {
    const std::scoped_lock lock(mutex);
    const auto known = frames.find(subject);
    const bool full = known != frames.end() && known->second.size() >= kDepth;
    const std::size_t freed = full ? known->second.front().size() : 0;
    const bool refused = (known == frames.end() && frames.size() >= kMaxStreams) ||
                         frame_bytes - freed + bytes.size() > kMaxBytes;
    if (full || refused) ++replaced;
    if (refused) return;
    frame_bytes += bytes.size() - freed;
    std::deque<std::string>& waiting = frames[subject];
    waiting.push_back(std::move(bytes));
    if (full) {
      waiting.pop_front();
      return;
    }
    order.push_back(subject);
    Wake();
  }
  void AddOdd() {
    const std::scoped_lock lock(mutex);
    ++odd;
  }
  void AddValue(const std::string& key, const std::string* value) {
    const std::scoped_lock lock(mutex);
    if (values.size() >= kMaxValues) values.pop_front();
    values.emplace_back(key, value == nullptr ? std::nullopt : std::optional(*value));
    Wake();
  }
  void AddReply(natsMsg* message) {
    const std::scoped_lock lock(mutex);
    if (replies.size() >= kMaxReplies) replies.pop_front();
    replies.push_back(
        {natsMsg_GetSubject(message), Bytes(message), natsMsg_IsNoResponders(message)});
    Wake();
  }
};

// A subscription of libnats, whose callbacks may run until it reports their end; the inbox lives
// until then.
struct Relay::Subscription {
  natsSubscription* subscription = nullptr;

  ~Subscription() {
    if (subscription == nullptr) return;
    natsSubscription_Unsubscribe(subscription);
    natsSubscription_Destroy(subscription);
  }
  static void OnFrame(natsConnection* /*connection*/, natsSubscription* /*subscription*/,
                      natsMsg* message, void* closure) {
    // Without this check, a viewer could have JetStream send a value of the bucket to a frame's
    // subject.
    const char* sequence = nullptr;
    const bool frame = natsMsgHeader_Get(message, "Styled-Sequence", &sequence) == NATS_OK;
    auto& inbox = **static_cast<std::shared_ptr<Inbox>*>(closure);
    frame ? inbox.AddFrame(natsMsg_GetSubject(message), Bytes(message)) : inbox.AddOdd();
    natsMsg_Destroy(message);
  }
  static void OnReply(natsConnection* /*connection*/, natsSubscription* /*subscription*/,
                      natsMsg* message, void* closure) {
    (*static_cast<std::shared_ptr<Inbox>*>(closure))->AddReply(message);
    natsMsg_Destroy(message);
  }
  static void OnComplete(void* closure) { delete static_cast<std::shared_ptr<Inbox>*>(closure); }
};

Relay::Relay(const RelayOptions& options)
    : options_(options), demand_(options.site), inbox_(std::make_shared<Inbox>()) {}

// The bucket's thread and the subscriptions end before the connection that they use.
Relay::~Relay() {
  values_.reset();
  subscriptions_.clear();
  replies_.reset();
}

Result<std::unique_ptr<Relay>> Relay::Open(const RelayOptions& options) {
  if (const Status status = CheckSite(options.site); !status.ok()) return status;
  std::unique_ptr<Relay> relay(new Relay(options));
  if (const Status status = relay->Bind(); !status.ok()) return status;
  auto link = Link::Open(options.link);
  if (!link.ok()) return link.status();
  relay->link_ = std::move(link.value());
  relay->reply_to_ = relay->link_->NewInbox() + ".";
  relay->replies_ = relay->Subscribe(relay->reply_to_ + "*");
  relay->values_ = std::make_unique<Values>(
      *relay->link_, options.site, options.domain,
      [to = relay->inbox_](const std::string& key, const std::string* value) {
        to->AddValue(key, value);
      });
  return relay;
}

Status Relay::Bind() {
  for (const auto& [option, endpoint] :
       {std::pair{"--publish", &options_.publish}, {"--control", &options_.control}}) {
    if (Status status = CheckLocal(option, *endpoint); !status.ok()) return status;
  }
  publisher_ = zmq::socket_t(context_, zmq::socket_type::xpub);
  control_ = zmq::socket_t(context_, zmq::socket_type::router);
  // Each subscriber gets the bodies at once, also the second one of a topic.
  publisher_.set(zmq::sockopt::xpub_verbose, true);
  Status status = Listen(publisher_, "--publish", options_.publish);
  return status.ok() ? Listen(control_, "--control", options_.control) : status;
}

// Null if the connection is closed for good, which ends the program.
std::unique_ptr<Relay::Subscription> Relay::Subscribe(const std::string& subject) const {
  auto subscription = std::make_unique<Subscription>();
  auto closure = std::make_unique<std::shared_ptr<Inbox>>(inbox_);
  const bool reply = subject.starts_with(reply_to_);
  const natsStatus status = natsConnection_Subscribe(
      &subscription->subscription, link_->get(), subject.c_str(),
      reply ? Subscription::OnReply : Subscription::OnFrame, closure.get());
  if (status != NATS_OK) return nullptr;
  natsSubscription_SetOnCompleteCB(subscription->subscription, Subscription::OnComplete,
                                   closure.release());
  return subscription;
}

void Relay::Step(milliseconds timeout) {
  std::array<zmq::pollitem_t, 3> items{{{publisher_.handle(), 0, ZMQ_POLLIN, 0},
                                        {control_.handle(), 0, ZMQ_POLLIN, 0},
                                        {nullptr, inbox_->wake.get(), ZMQ_POLLIN, 0}}};
  const auto until_repeat = std::chrono::ceil<milliseconds>(next_repeat_ - Clock::now());
  try {
    zmq::poll(items.data(), items.size(),
              std::clamp(until_repeat, milliseconds(0), std::max(timeout, milliseconds(0))));
    inbox_->ClearWake();
    HandleValues();
    HandleSubscriptions();
    HandleRequests();
    HandleFrames();
    HandleReplies();
    if (Clock::now() >= next_repeat_) Repeat();
  } catch (const zmq::error_t& error) {
    if (error.num() != EINTR) throw;
  }
}

void Relay::HandleSubscriptions() {
  zmq::message_t event;
  bool changed = false;
  std::vector<std::string> added;
  while (publisher_.recv(event, zmq::recv_flags::dontwait)) {
    if (event.size() == 0) continue;
    const std::string_view text = event.to_string_view();
    const std::string_view topic = text.substr(1);
    if (text.front() == 1) {
      changed = demand_.Add(topic) || changed;
      added.emplace_back(topic);
    } else {
      changed = demand_.Remove(topic) || changed;
    }
  }
  if (changed) Follow();
  for (const std::string& topic : added) SendBodies(topic);
}

// Subscribes at the broker to the subjects that are now needed.
void Relay::Follow() {
  const std::set<std::string> wanted = demand_.Subjects();
  std::erase_if(subscriptions_, [&wanted](const auto& s) { return !wanted.contains(s.first); });
  for (const std::string& subject : wanted) {
    if (subscriptions_.contains(subject)) continue;
    if (auto made = Subscribe(subject)) subscriptions_.emplace(subject, std::move(made));
  }
}

void Relay::HandleFrames() {
  std::deque<std::string> order;
  std::map<std::string, std::deque<std::string>> frames;
  {
    const std::scoped_lock lock(inbox_->mutex);
    order.swap(inbox_->order);
    frames.swap(inbox_->frames);
    inbox_->frame_bytes = 0;
  }
  for (const std::string& subject : order) {
    std::deque<std::string>& waiting = frames[subject];
    const std::string frame = std::move(waiting.front());
    waiting.pop_front();
    const std::string topic = TopicOf(subject);
    if (topic.empty()) {
      if (!subject.ends_with(kAudienceStream)) ++totals_.odd;
      continue;
    }
    Send(topic, frame);
    ++totals_.passed;
  }
}

void Relay::HandleValues() {
  decltype(inbox_->values) values;
  {
    const std::scoped_lock lock(inbox_->mutex);
    values.swap(inbox_->values);
  }
  for (auto& [key, value] : values) {
    const auto known = values_of_.find(key);
    const std::size_t freed = known == values_of_.end() ? 0 : known->second.size();
    if (!value) {
      value_bytes_ -= freed;
      values_of_.erase(key);
      continue;
    }
    if ((known == values_of_.end() && values_of_.size() >= kMaxValues) ||
        value_bytes_ - freed + value->size() > kMaxBytes) {
      ++totals_.odd;
      continue;
    }
    const std::string topic = BodyTopicOf(key);
    if (!topic.empty() && (known == values_of_.end() || known->second != *value)) {
      Send(topic, *value);
    }
    value_bytes_ += value->size() - freed;
    values_of_[key] = std::move(*value);
  }
}

void Relay::SendBodies(std::string_view topic) {
  for (const auto& [key, value] : values_of_) {
    const std::string of = BodyTopicOf(key);
    if (!of.empty() && (of.starts_with(topic) || topic.starts_with(of))) Send(of, value);
  }
}

// Once a second, as a daemon does: all bodies, and the performers' known state.
void Relay::Repeat() {
  next_repeat_ = Clock::now() + kRepeat;
  SendBodies("body/");
  if (demand_.IsSubscribed("stats/")) {
    v1::Stats stats;
    for (const auto& [key, value] : values_of_) {
      if (key.find(".performer.") == std::string::npos) continue;
      if (!stats.add_performers()->ParseFromString(value)) {
        stats.mutable_performers()->RemoveLast();
        ++totals_.odd;
      }
    }
    Send("stats/", stats.SerializeAsString());
  }
  std::erase_if(pending_, [this](const auto& waits) {
    if (Clock::now() < waits.second.until) return false;
    ++totals_.unanswered;
    return true;
  });
}

void Relay::Send(std::string_view topic, std::string_view payload) {
  publisher_.send(zmq::buffer(topic), zmq::send_flags::sndmore | zmq::send_flags::dontwait);
  publisher_.send(zmq::buffer(payload), zmq::send_flags::dontwait);
}

void Relay::HandleRequests() {
  zmq::message_t part;
  while (control_.recv(part, zmq::recv_flags::dontwait)) {
    std::vector<std::string> parts{part.to_string()};
    while (part.more() && control_.recv(part, zmq::recv_flags::none)) {
      parts.push_back(part.to_string());
    }
    if (parts.size() < 2) continue;
    const std::string bytes = std::move(parts.back());
    parts.pop_back();
    Ask(std::move(parts), bytes);
  }
}

void Relay::Ask(std::vector<std::string> envelope, const std::string& bytes) {
  ++totals_.requests;
  v1::Request request;
  const std::uint64_t id = request.ParseFromString(bytes) ? request.id() : 0;
  if (!link_->connected()) return Refuse(envelope, id, v1::CODE_BUSY, "no broker is connected");
  if (pending_.size() >= kMaxPending) {
    return Refuse(envelope, id, v1::CODE_BUSY, "too many requests wait for the site's answer");
  }
  const std::uint64_t number = ++asked_;
  const natsStatus status = natsConnection_PublishRequest(
      link_->get(), ControlSubject(options_.site).c_str(),
      (reply_to_ + std::to_string(number)).c_str(), bytes.data(), static_cast<int>(bytes.size()));
  if (status == NATS_MAX_PAYLOAD) {
    return Refuse(
        envelope, id, v1::CODE_TOO_LARGE,
        "the request has " + std::to_string(bytes.size()) + " bytes, the broker accepts " +
            std::to_string(natsConnection_GetMaxPayload(link_->get())) + " (max_payload)");
  }
  if (status != NATS_OK) return Refuse(envelope, id, v1::CODE_BUSY, natsStatus_GetText(status));
  pending_[number] = {std::move(envelope), id, Clock::now() + kPatience};
}

void Relay::HandleReplies() {
  decltype(inbox_->replies) replies;
  {
    const std::scoped_lock lock(inbox_->mutex);
    replies.swap(inbox_->replies);
  }
  for (const Inbox::Reply& reply : replies) {
    std::uint64_t number = 0;
    const std::string_view text = std::string_view(reply.subject).substr(reply_to_.size());
    std::from_chars(text.data(), text.data() + text.size(), number);
    const auto waits = pending_.find(number);
    if (waits == pending_.end()) continue;
    if (reply.nobody) {
      ++totals_.unanswered;
      Refuse(waits->second.envelope, waits->second.id, v1::CODE_BUSY,
             "no reply from " + ControlSubject(options_.site) +
                 ": no stylenats serves that site, or its name is different");
    } else {
      Answer(waits->second.envelope, reply.bytes);
    }
    pending_.erase(waits);
  }
}

void Relay::Answer(const std::vector<std::string>& envelope, const std::string& bytes) {
  for (const std::string& part : envelope) {
    control_.send(zmq::buffer(part), zmq::send_flags::sndmore | zmq::send_flags::dontwait);
  }
  control_.send(zmq::buffer(bytes), zmq::send_flags::dontwait);
}

void Relay::Refuse(const std::vector<std::string>& envelope, std::uint64_t id, v1::Code code,
                   const std::string& reason) {
  v1::Reply reply;
  reply.set_id(id);
  reply.set_code(code);
  reply.set_reason("stylenats: " + reason);
  Answer(envelope, reply.SerializeAsString());
}

RelayTotals Relay::totals() const {
  RelayTotals totals = totals_;
  const std::scoped_lock lock(inbox_->mutex);
  totals.replaced = inbox_->replaced;
  totals.odd += inbox_->odd;
  return totals;
}

}  // namespace styled::stylenats
