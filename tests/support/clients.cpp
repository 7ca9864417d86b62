#include "tests/support/clients.h"

#include <zmq.h>

#include <algorithm>
#include <chrono>

#include "tests/support/rig.h"

namespace styled::support {
namespace {

bool ReceiveParts(void* socket, std::vector<std::string>& parts) {
  parts.clear();
  zmq_msg_t message;
  zmq_msg_init(&message);
  bool more = true;
  while (more) {
    if (zmq_msg_recv(&message, socket, 0) < 0) break;
    parts.emplace_back(static_cast<const char*>(zmq_msg_data(&message)), zmq_msg_size(&message));
    more = zmq_msg_more(&message) != 0;
  }
  zmq_msg_close(&message);
  return !more && !parts.empty();
}

void SetInt(void* socket, int option, int value) {
  zmq_setsockopt(socket, option, &value, sizeof value);
}

void SetKeys(void* socket, const CurveKeys& keys) {
  if (keys.server_key.empty()) return;
  for (const auto& [option, key] : {std::pair{ZMQ_CURVE_SERVERKEY, &keys.server_key},
                                    std::pair{ZMQ_CURVE_PUBLICKEY, &keys.public_key},
                                    std::pair{ZMQ_CURVE_SECRETKEY, &keys.secret_key}}) {
    zmq_setsockopt(socket, option, key->c_str(), key->size() + 1);
  }
}

}  // namespace

Subscriber::Subscriber(const std::string& endpoint, const std::vector<std::string>& topics,
                       const CurveKeys& keys)
    : context_(zmq_ctx_new()), socket_(zmq_socket(context_, ZMQ_SUB)) {
  SetInt(socket_, ZMQ_RCVHWM, 0);
  SetInt(socket_, ZMQ_LINGER, 0);
  SetInt(socket_, ZMQ_RCVTIMEO, 50);
  SetInt(socket_, ZMQ_HANDSHAKE_IVL, 1000);
  SetKeys(socket_, keys);
  for (const auto& topic : topics) {
    zmq_setsockopt(socket_, ZMQ_SUBSCRIBE, topic.data(), topic.size());
  }
  zmq_connect(socket_, endpoint.c_str());
  thread_ = std::thread([this] { Run(); });
}

Subscriber::~Subscriber() {
  stop_ = true;
  thread_.join();
  zmq_close(socket_);
  zmq_ctx_term(context_);
}

void Subscriber::Run() {
  std::vector<std::string> parts;
  while (!stop_) {
    if (!ReceiveParts(socket_, parts) || parts.size() != 2) continue;
    const std::lock_guard lock(mutex_);
    messages_.push_back({parts[0], parts[1]});
  }
}

std::vector<v1::Frame> Subscriber::Frames(const std::string& prefix) const {
  const std::lock_guard lock(mutex_);
  std::vector<v1::Frame> frames;
  for (const auto& message : messages_) {
    if (message.topic.starts_with("body/") || message.topic.starts_with("stats/")) continue;
    if (!message.topic.starts_with(prefix)) continue;
    frames.emplace_back();
    if (!frames.back().ParseFromString(message.payload)) frames.pop_back();
  }
  return frames;
}

std::vector<Message> Subscriber::Messages(const std::string& prefix) const {
  const std::scoped_lock lock(mutex_);
  std::vector<Message> found;
  for (const Message& message : messages_) {
    if (message.topic.starts_with(prefix)) found.push_back(message);
  }
  return found;
}

std::size_t Subscriber::Count(const std::string& prefix) const {
  const std::lock_guard lock(mutex_);
  return static_cast<std::size_t>(
      std::count_if(messages_.begin(), messages_.end(),
                    [&](const Message& message) { return message.topic.starts_with(prefix); }));
}

std::vector<v1::Body> Subscriber::Bodies() const {
  const std::lock_guard lock(mutex_);
  std::vector<v1::Body> bodies;
  for (const auto& message : messages_) {
    if (!message.topic.starts_with("body/")) continue;
    bodies.emplace_back();
    if (!bodies.back().ParseFromString(message.payload)) bodies.pop_back();
  }
  return bodies;
}

std::optional<v1::Stats> Subscriber::LastStats() const {
  const std::lock_guard lock(mutex_);
  for (auto message = messages_.rbegin(); message != messages_.rend(); ++message) {
    v1::Stats stats;
    if (message->topic == "stats/" && stats.ParseFromString(message->payload)) return stats;
  }
  return std::nullopt;
}

bool Subscriber::WaitFor(const std::function<bool()>& done, double seconds) const {
  for (double waited = 0; waited < seconds; waited += 0.01) {
    if (done()) return true;
    Sleep(0.01);
  }
  return done();
}

bool Subscriber::WaitForFrames(std::size_t count, const std::string& prefix, double seconds) const {
  return WaitFor([&] { return Frames(prefix).size() >= count; }, seconds);
}

bool Subscriber::WaitForBody(double seconds) const {
  return WaitFor([this] { return !Bodies().empty(); }, seconds);
}

ControlClient::ControlClient(const std::string& endpoint, const CurveKeys& keys)
    : context_(zmq_ctx_new()), socket_(zmq_socket(context_, ZMQ_DEALER)) {
  SetInt(socket_, ZMQ_LINGER, 0);
  SetInt(socket_, ZMQ_HANDSHAKE_IVL, 1000);
  SetPatience(5);
  SetKeys(socket_, keys);
  zmq_connect(socket_, endpoint.c_str());
}

ControlClient::~ControlClient() {
  zmq_close(socket_);
  zmq_ctx_term(context_);
}

void ControlClient::SetPatience(double seconds) {
  SetInt(socket_, ZMQ_RCVTIMEO, static_cast<int>(seconds * 1000));
  SetInt(socket_, ZMQ_SNDTIMEO,
         static_cast<int>(seconds * 1000));  // a refused connection may have no pipe
}

v1::Reply ControlClient::AskRaw(const std::vector<std::string>& parts) {
  for (std::size_t i = 0; i < parts.size(); ++i) {
    zmq_send(socket_, parts[i].data(), parts[i].size(), i + 1 < parts.size() ? ZMQ_SNDMORE : 0);
  }
  std::vector<std::string> answer;
  v1::Reply reply;
  if (!ReceiveParts(socket_, answer) || !reply.ParseFromString(answer.back())) {
    reply.set_code(v1::CODE_BUSY);
    reply.set_reason("no reply");
  }
  return reply;
}

v1::Reply ControlClient::Ask(v1::Request request) {
  request.set_id(next_id_++);
  return AskRaw({request.SerializeAsString()});
}

v1::Reply ControlClient::SetStyle(const std::string& performer, const std::string& style,
                                  float weight, float transition_ms) {
  v1::Request request;
  request.set_performer(performer);
  auto& mix = *request.mutable_set()->add_mix();
  mix.set_style(style);
  mix.set_weight(weight);
  if (transition_ms >= 0) request.mutable_set()->set_transition_ms(transition_ms);
  return Ask(request);
}

v1::StatusReply ControlClient::Status() {
  v1::Request request;
  request.mutable_status();
  return Ask(request).status();
}

std::uint64_t ControlClient::Counter(const std::string& name) {
  const v1::StatusReply status = Status();
  for (const auto& counter : status.stats().counters()) {
    if (counter.name() == name) return counter.value();
  }
  return ~0ULL;
}

std::uint64_t ControlClient::CounterSoon(const std::string& name, std::uint64_t value) {
  std::uint64_t now = Counter(name);
  for (int i = 0; i < 3000 && now != value; ++i) {
    Sleep(0.01);
    now = Counter(name);
  }
  return now;
}

v1::PerformerStats ControlClient::Performer(const std::string& id) {
  const v1::StatusReply status = Status();
  for (const auto& performer : status.stats().performers()) {
    if (performer.performer() == id) return performer;
  }
  return {};
}

}  // namespace styled::support
