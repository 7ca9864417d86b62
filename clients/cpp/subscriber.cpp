#include "clients/cpp/subscriber.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>
#include <zmq.hpp>

#include "clients/cpp/links.h"
#include "clients/cpp/reach.h"
#include "clients/cpp/transforms.h"

namespace styled::client {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr std::int64_t kMaxMessageBytes = 1 << 20;  // a body with 1024 long names fits
// Limit of messages per ReceiveLatest.
constexpr int kMaxDrain = 10'000;  // messages that one ReceiveLatest reads at most
// Later than usual by this: newer frames are still queued.
constexpr std::int64_t kStale_ns = 50'000'000;
// A connection that was lost meanwhile is restored by then.
constexpr milliseconds kLongestCatchUp(500);
constexpr std::size_t kMaxPerformers = 4096;
// Per performer: for its outputs, and for their previous bodies.
constexpr std::size_t kMaxBodies = 64;
constexpr std::string_view kBodyTopic = "body/";
constexpr std::string_view kStatisticsTopic = "stats/";

struct StreamTopic {
  Stream stream;
  std::string_view prefix, suffix, bundle;
  v1::Output output;
};
constexpr std::array<StreamTopic, 3> kStreamTopics{{
    {Stream::kStyledRig, "styled/", "/rig/", "frames/rig/", v1::OUTPUT_RIG},
    {Stream::kStyledCanonical, "styled/", "/canonical/", "frames/canonical/", v1::OUTPUT_CANONICAL},
    {Stream::kSource, "source/", "/", "frames/source/", v1::OUTPUT_RIG},
}};

std::string Topic(const StreamTopic& row, std::string_view performer) {
  return std::string(row.prefix).append(performer).append(row.suffix);
}

// Whether `text` is a valid part of a performer's id, or name of an [[output]].
bool IsName(std::string_view text) {
  const auto fits = [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  };
  return !text.empty() && text.size() <= 32 && std::all_of(text.begin(), text.end(), fits);
}

bool IsAvatar(std::string_view name) {
  return IsName(name) && name != "rig" && name != "canonical";
}

// The id between prefix and suffix, or "" if `topic` has another form.
std::string_view PerformerOf(std::string_view topic, std::string_view prefix,
                             std::string_view suffix) {
  if (topic.size() <= prefix.size() + suffix.size() || !topic.starts_with(prefix) ||
      !topic.ends_with(suffix)) {
    return {};
  }
  topic.remove_prefix(prefix.size());
  topic.remove_suffix(suffix.size());
  return IsPerformerId(topic) ? topic : std::string_view();
}

// Performer and stream of a frame's topic; views into the topic. `performer` is empty for other
// topics.
struct Origin {
  std::string_view performer, avatar;
  Stream stream = Stream::kAvatar;
  v1::Output output = v1::OUTPUT_AVATAR;
};

Origin OriginOf(std::string_view topic) {
  for (const StreamTopic& row : kStreamTopics) {
    const std::string_view performer = PerformerOf(topic, row.prefix, row.suffix);
    if (!performer.empty()) return {performer, {}, row.stream, row.output};
  }
  constexpr std::string_view kPrefix = "styled/";
  const std::size_t slash = topic.find('/', std::min(topic.size(), kPrefix.size()));
  if (slash == std::string_view::npos || !topic.ends_with('/')) return {};
  const std::string_view avatar = topic.substr(slash + 1, topic.size() - slash - 2);
  const std::string_view performer = PerformerOf(topic.substr(0, slash + 1), kPrefix, "/");
  return IsName(avatar) ? Origin{performer, avatar} : Origin{};
}

// How much longer than usual a frame was in transit, compared with the shortest transit of the last
// two to four seconds. Only differences are used, so the clocks of two machines need not agree.
class Lag {
 public:
  std::int64_t Measure(std::uint64_t published_ns, std::int64_t now_ns) {
    const std::int64_t way_ns = now_ns - static_cast<std::int64_t>(published_ns);
    if (!started_ || now_ns - turned_ns_ >= kTurn_ns) {
      // After a longer silence, the last known shortest transit remains valid.
      previous_ns_ = started_ ? current_ns_ : way_ns;
      current_ns_ = way_ns;
      turned_ns_ = now_ns;
      started_ = true;
    }
    current_ns_ = std::min(current_ns_, way_ns);
    return way_ns - std::min(previous_ns_, current_ns_);
  }

 private:
  static constexpr std::int64_t kTurn_ns = 2'000'000'000;
  bool started_ = false;
  std::int64_t previous_ns_ = 0, current_ns_ = 0, turned_ns_ = 0;
};

struct StreamState {
  bool started = false;
  std::uint64_t epoch = 0, sequence = 0;
  std::shared_ptr<const v1::Body> body;
  Lag lag;
};

}  // namespace

bool IsPerformerId(std::string_view id) noexcept {
  const std::size_t dot = id.find('.');
  return dot != std::string_view::npos && IsName(id.substr(0, dot)) && IsName(id.substr(dot + 1));
}

struct Subscriber::Impl {
  SubscriberOptions options;
  zmq::context_t context{1};
  zmq::socket_t socket;
  Links links;
  zmq::message_t topic, payload;
  // The bundle that was read last, the first of its frames that was not accepted yet, and its
  // stream. Null: the last message was not a bundle.
  v1::Frames frames;
  int next_frame = 0;
  const StreamTopic* bundle = nullptr;
  SubscriberCounters counters;
  std::map<std::string, StreamState, std::less<>> streams;  // by topic
  std::map<std::string, std::vector<std::shared_ptr<const v1::Body>>, std::less<>> bodies;
  std::string bundled_topic;  // of a bundle's frame: its topic outside the bundle
  std::map<std::string, std::size_t, std::less<>> newest;  // ReceiveLatest: topic to index in `out`
  std::string last_topic;                                  // of the last accepted frame
  std::int64_t lag_ns = 0;                                 // of the last accepted frame
  std::vector<std::int64_t> lags_ns;                       // ReceiveLatest: of each update in `out`
  v1::Body scratch_body;

  void Open();
  void SubscribeTo(std::string_view performer);
  void SubscribeToAvatar(std::string_view performer, std::string_view avatar);
  // Into topic and payload, or the next frame of a bundle; false if nothing is waiting.
  bool ReadMessage();
  bool Wait(Clock::time_point deadline);
  bool Accept(Update& out);
  bool AcceptFrame(const Origin& origin, std::string_view name, Update& out);
  bool AcceptBundled(Update& out);
  bool AcceptParsed(const Origin& origin, std::string_view name, Update& out);
  bool AcceptBody(std::string_view performer, Update& out);
  void FindBody(const Origin& origin, StreamState& state, const v1::Frame& frame);
};

void Subscriber::Impl::Open() {
  socket = zmq::socket_t(context, zmq::socket_type::sub);
  socket.set(zmq::sockopt::linger, 0);
  socket.set(zmq::sockopt::rcvhwm, options.queue_messages);
  socket.set(zmq::sockopt::maxmsgsize, kMaxMessageBytes);
  socket.set(zmq::sockopt::reconnect_ivl, 100);
  socket.set(zmq::sockopt::reconnect_ivl_max, 1000);
  socket.set(zmq::sockopt::handshake_ivl, 1000);
  socket.set(zmq::sockopt::heartbeat_ivl, 1000);  // also detects an unplugged cable
  socket.set(zmq::sockopt::heartbeat_timeout, 3000);
  if (options.curve) {
    socket.set(zmq::sockopt::curve_serverkey, options.curve->server_key);
    socket.set(zmq::sockopt::curve_publickey, options.curve->public_key);
    socket.set(zmq::sockopt::curve_secretkey, options.curve->secret_key);
  }
  links.Watch(context, socket, options.endpoints);
  if (options.performer.empty()) {
    // Finds the performers; then each one's own topics.
    socket.set(zmq::sockopt::subscribe, kBodyTopic);
    for (const StreamTopic& row : kStreamTopics) {
      if (options.bundled && std::ranges::count(options.streams, row.stream) > 0) {
        socket.set(zmq::sockopt::subscribe, row.bundle);
      }
    }
  } else {
    SubscribeTo(options.performer);
  }
  if (options.statistics) socket.set(zmq::sockopt::subscribe, kStatisticsTopic);
  for (const std::string& endpoint : options.endpoints) {
    if (endpoint.find('[') != std::string::npos) socket.set(zmq::sockopt::ipv6, true);
    socket.connect(endpoint);
  }
}

void Subscriber::Impl::SubscribeTo(std::string_view performer) {
  if (!options.performer.empty()) {
    socket.set(zmq::sockopt::subscribe, std::string(kBodyTopic).append(performer).append("/"));
  }
  for (const StreamTopic& row : kStreamTopics) {
    if (!options.bundled && std::ranges::count(options.streams, row.stream) > 0) {
      socket.set(zmq::sockopt::subscribe, Topic(row, performer));
    }
  }
  for (const std::string& avatar : options.avatars) SubscribeToAvatar(performer, avatar);
}

void Subscriber::Impl::SubscribeToAvatar(std::string_view performer, std::string_view avatar) {
  std::string name("styled/");
  name.append(performer).append("/").append(avatar).append("/");
  socket.set(zmq::sockopt::subscribe, name);
}

bool Subscriber::Impl::Wait(Clock::time_point deadline) {
  zmq::pollitem_t item{socket.handle(), 0, ZMQ_POLLIN, 0};
  try {
    for (;;) {
      links.RenewDead();
      const auto left = std::chrono::ceil<milliseconds>(deadline - Clock::now());
      if (zmq::poll(&item, 1, std::clamp(left, milliseconds(0), Links::kLook)) > 0) return true;
      if (left <= Links::kLook) return false;
    }
  } catch (const zmq::error_t&) {
    return false;  // interrupted by a signal
  }
}

bool Subscriber::Impl::ReadMessage() {
  if (bundle != nullptr && next_frame < frames.frames_size()) return true;
  try {
    for (;;) {
      if (!socket.recv(topic, zmq::recv_flags::dontwait)) return false;
      int parts = 1;
      while (socket.get(zmq::sockopt::rcvmore)) {  // the parts of a message arrive together
        zmq::message_t& part = parts == 1 ? payload : topic;
        if (!socket.recv(part, zmq::recv_flags::none)) break;
        ++parts;
      }
      if (parts != 2) {
        ++counters.malformed;
        continue;
      }
      const std::string_view name(static_cast<const char*>(topic.data()), topic.size());
      const auto row = std::ranges::find(kStreamTopics, name, &StreamTopic::bundle);
      bundle = row == kStreamTopics.end() ? nullptr : &*row;
      if (bundle == nullptr) return true;
      next_frame = 0;
      if (!frames.ParseFromArray(payload.data(), static_cast<int>(payload.size()))) {
        ++counters.malformed;
        frames.Clear();
      }
      if (frames.frames_size() > 0) return true;
    }
  } catch (const zmq::error_t&) {
    return false;
  }
}

bool Subscriber::Impl::Accept(Update& out) {
  if (bundle != nullptr) return AcceptBundled(out);
  const std::string_view name(static_cast<const char*>(topic.data()), topic.size());
  if (options.keep_bytes) {
    out.bytes.assign(static_cast<const char*>(payload.data()), payload.size());
  }
  if (name == kStatisticsTopic) {
    if (!out.statistics.ParseFromArray(payload.data(), static_cast<int>(payload.size()))) {
      ++counters.malformed;
      return false;
    }
    // For a pair with a standby, the leader's count.
    if (options.endpoints.size() > 1 && out.statistics.standby().role() == "following") {
      return false;
    }
    out.kind = Update::Kind::kStatistics;
    return true;
  }
  if (const std::string_view performer = PerformerOf(name, kBodyTopic, "/"); !performer.empty()) {
    return AcceptBody(performer, out);
  }
  const Origin origin = OriginOf(name);
  if (!origin.performer.empty()) return AcceptFrame(origin, name, out);
  ++counters.malformed;
  return false;
}

bool Subscriber::Impl::AcceptBody(std::string_view performer, Update& out) {
  v1::Body& body = scratch_body;
  if (!body.ParseFromArray(payload.data(), static_cast<int>(payload.size())) ||
      body.performer() != performer || Validate(body) != BodyError::kNone ||
      (bodies.size() >= kMaxPerformers && !bodies.contains(performer))) {
    ++counters.malformed;
    return false;
  }
  auto known = bodies.find(performer);
  if (known == bodies.end()) {
    known = bodies.emplace(std::string(performer), 0).first;
    if (options.performer.empty()) SubscribeTo(performer);
  }
  bool new_avatar = IsAvatar(body.output_name()) && options.every_avatar &&
                    std::find(options.avatars.begin(), options.avatars.end(), body.output_name()) ==
                        options.avatars.end();
  for (const auto& other : known->second) {
    if (other->output_name() == body.output_name()) new_avatar = false;
    if (other->hash() == body.hash() && other->output() == body.output() &&
        other->output_name() == body.output_name()) {
      ++counters.replayed_bodies;
      return false;
    }
  }
  if (new_avatar) SubscribeToAvatar(performer, body.output_name());
  if (known->second.size() >= kMaxBodies) known->second.erase(known->second.begin());
  known->second.push_back(std::make_shared<const v1::Body>(body));
  ++counters.bodies;
  out.kind = Update::Kind::kBody;
  out.body = known->second.back();
  return true;
}

void Subscriber::Impl::FindBody(const Origin& origin, StreamState& state, const v1::Frame& frame) {
  if (state.body && state.body->hash() == frame.body_hash()) return;
  state.body.reset();
  const auto known = bodies.find(origin.performer);
  if (known == bodies.end()) return;
  for (const auto& body : known->second) {
    if (body->hash() == frame.body_hash() && body->output() == frame.output() &&
        body->output_name() == origin.avatar) {
      state.body = body;
    }
  }
}

bool Subscriber::Impl::AcceptFrame(const Origin& origin, std::string_view name, Update& out) {
  const v1::Frame& frame = out.frame;
  if (!out.frame.ParseFromArray(payload.data(), static_cast<int>(payload.size())) ||
      frame.performer() != origin.performer || frame.output() != origin.output) {
    ++counters.malformed;
    return false;
  }
  return AcceptParsed(origin, name, out);
}

// As if the frame had arrived on its own topic.
bool Subscriber::Impl::AcceptBundled(Update& out) {
  const v1::Frame& frame = out.frame;
  out.frame.Swap(frames.mutable_frames(next_frame++));
  if (options.keep_bytes) out.bytes = frame.SerializeAsString();
  if (!IsPerformerId(frame.performer()) || frame.output() != bundle->output) {
    ++counters.malformed;
    return false;
  }
  bundled_topic.assign(bundle->prefix).append(frame.performer()).append(bundle->suffix);
  return AcceptParsed({frame.performer(), {}, bundle->stream, bundle->output}, bundled_topic, out);
}

bool Subscriber::Impl::AcceptParsed(const Origin& origin, std::string_view name, Update& out) {
  const v1::Frame& frame = out.frame;
  auto found = streams.find(name);
  if (found == streams.end()) {
    if (streams.size() >= (3 + options.avatars.size()) * kMaxPerformers) return false;
    found = streams.emplace(std::string(name), StreamState()).first;
  }
  StreamState& state = found->second;
  const bool same_epoch = state.started && frame.epoch() == state.epoch;
  if (same_epoch && frame.sequence() <= state.sequence) {
    ++counters.repeated_frames;
    return false;
  }
  FindBody(origin, state, frame);
  if (state.body && Validate(frame, *state.body) != FrameError::kNone) {
    ++counters.malformed;
    return false;
  }
  out.kind = Update::Kind::kFrame;
  out.stream = origin.stream;
  out.avatar.assign(origin.avatar);
  out.body = state.body;
  out.missed = same_epoch ? frame.sequence() - state.sequence - 1 : 0;
  out.skipped = 0;
  out.new_epoch = state.started && !same_epoch;
  if (!same_epoch) state.lag = Lag();
  lag_ns = state.lag.Measure(frame.publish_time_ns(),
                             Clock::now().time_since_epoch() / std::chrono::nanoseconds(1));
  state.started = true;
  state.epoch = frame.epoch();
  state.sequence = frame.sequence();
  last_topic.assign(name);
  ++counters.frames;
  counters.missed += out.missed;
  counters.epochs += out.new_epoch ? 1 : 0;
  return true;
}

Subscriber::Subscriber(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Subscriber::~Subscriber() = default;

Result<std::unique_ptr<Subscriber>> Subscriber::Connect(const SubscriberOptions& options) {
  if (options.endpoints.empty()) return Status::Error("subscriber: no endpoint given");
  std::vector<std::string> endpoints;
  for (const std::string& list : options.endpoints) {
    for (std::string& endpoint : SplitEndpoints(list)) endpoints.push_back(std::move(endpoint));
  }
  for (const std::string& endpoint : endpoints) {
    if (const Status checked = CheckEndpoint(endpoint); !checked.ok()) {
      return Status::Error("subscriber: " + checked.message());
    }
  }
  if (options.queue_messages < 1) {
    return Status::Error("subscriber: queue_messages is " + std::to_string(options.queue_messages) +
                         ", expected 1 or more");
  }
  if (!options.performer.empty() && !IsPerformerId(options.performer)) {
    return Status::Error("subscriber: performer '" + options.performer +
                         "' is not SOURCE.NAME ([A-Za-z0-9_-]{1,32} each)");
  }
  if (options.bundled && !options.performer.empty()) {
    return Status::Error("subscriber: `bundled` with performer '" + options.performer +
                         "'; expected all performers, or no bundles");
  }
  for (const std::string& avatar : options.avatars) {
    if (IsAvatar(avatar)) continue;
    return Status::Error("subscriber: avatar '" + avatar +
                         "' is not the name of an [[output]] ([A-Za-z0-9_-]{1,32}, not rig, not "
                         "canonical)");
  }
  if (std::find(options.streams.begin(), options.streams.end(), Stream::kAvatar) !=
      options.streams.end()) {
    return Status::Error("subscriber: kAvatar among `streams`; expected its name in `avatars`");
  }
  auto impl = std::make_unique<Impl>();
  impl->options = options;
  impl->options.endpoints = std::move(endpoints);
  if (options.curve) {
    auto curve = Complete(*options.curve);
    if (!curve.ok()) return Status::Error("subscriber: " + curve.status().message());
    impl->options.curve = std::move(curve.value());
  }
  try {
    impl->Open();
  } catch (const zmq::error_t& error) {
    std::string endpoints;
    for (const std::string& endpoint : options.endpoints) endpoints += " " + endpoint;
    return Status::Error("subscriber: cannot connect to" + endpoints + ": " + error.what() +
                         "; expected e.g. " + std::string(kDefaultPublisher) + " or ipc://PATH");
  }
  return std::unique_ptr<Subscriber>(new Subscriber(std::move(impl)));
}

bool Subscriber::Receive(milliseconds timeout, Update& out) {
  const auto deadline = Clock::now() + timeout;
  for (;;) {
    while (impl_->ReadMessage()) {
      if (impl_->Accept(out)) return true;
    }
    if (!impl_->Wait(deadline)) return false;
  }
}

int Subscriber::ReceiveLatest(milliseconds timeout, std::vector<Update>& out) {
  Impl& impl = *impl_;
  impl.newest.clear();
  impl.lags_ns.clear();
  std::size_t count = 0, statistics = 0;
  bool has_statistics = false;
  auto until = Clock::now() + timeout;
  bool catching_up = false;
  for (int read = 0; read < kMaxDrain; ++read) {
    if (!impl.ReadMessage()) {
      if (count > 0) {
        const auto is_stale = [](std::int64_t lag_ns) { return lag_ns > kStale_ns; };
        if (std::none_of(impl.lags_ns.begin(), impl.lags_ns.end(), is_stale)) break;
        // The sockets on the way may hold more messages than this process. The time limit starts
        // now, since the process may have been suspended before.
        if (!std::exchange(catching_up, true)) until = Clock::now() + kLongestCatchUp;
      }
      if (!impl.Wait(until)) break;
      continue;
    }
    if (out.size() == count) out.emplace_back();
    if (!impl.Accept(out[count])) continue;
    const Update& update = out[count];
    std::size_t older = count;
    impl.lags_ns.resize(count + 1);
    impl.lags_ns[count] = update.kind == Update::Kind::kFrame ? impl.lag_ns : 0;
    if (update.kind == Update::Kind::kFrame) {
      older = impl.newest.try_emplace(impl.last_topic, count).first->second;
    } else if (update.kind == Update::Kind::kStatistics) {
      older = std::exchange(has_statistics, true) ? statistics : (statistics = count);
    }
    if (older == count) {
      ++count;
      continue;
    }
    // The newer update takes the slot of the older one. The losses that the older frame reported
    // (missed, skipped) are losses before the newer one, too.
    const Update& superseded = out[older];
    if (update.kind == Update::Kind::kFrame) {
      out[count].missed += superseded.missed;
      out[count].skipped = superseded.skipped + 1;
      out[count].new_epoch = update.new_epoch || superseded.new_epoch;
    }
    std::swap(out[older], out[count]);
    impl.lags_ns[older] = impl.lags_ns[count];
    impl.lags_ns.resize(count);
  }
  out.resize(count);  // drops the last entry if it was rejected or superseded
  return static_cast<int>(count);
}

int Subscriber::connected() { return impl_->links.Count(); }

std::vector<std::string> Subscriber::performers() const {
  std::vector<std::string> names;
  for (const auto& [performer, bodies] : impl_->bodies) names.push_back(performer);
  return names;
}

const SubscriberCounters& Subscriber::counters() const { return impl_->counters; }

}  // namespace styled::client
