#include "clients/rec/tap.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <zmq.hpp>

#include "model/base/terminal_text.h"
#include "proto/recording/writer.h"
#include "proto/styled/v1/frame.pb.h"
#include "proto/styled/v1/stats.pb.h"

namespace styled::rec {
namespace {

using recording::MonotonicNow_ns;

constexpr std::int64_t kLongestWait_ns = 100'000'000;
// messages: about 20 s of twelve performers while the disk is busy.
constexpr int kQueue = 100'000;  // messages: some 20 s of a dozen performers while the disk is busy
constexpr int kBatch = 256;      // messages between two reads of the clock
constexpr std::int64_t kMaxMessage = 1 << 20;

// Counts the frames missing in each topic.
class Gaps {
 public:
  // Returns nothing for a frame that was already received: both daemons of a pair send it.
  std::optional<std::uint64_t> Look(const std::string& topic, const std::string& payload) {
    const bool one = topic.starts_with("styled/") || topic.starts_with("source/");
    if (!one || !frame_.ParseFromString(payload)) {
      return 0;
    }
    Last& last = last_[topic];
    const bool same = last.epoch == frame_.epoch();
    if (same && frame_.sequence() <= last.sequence) return std::nullopt;
    const std::uint64_t missed = same ? frame_.sequence() - last.sequence - 1 : 0;
    last = {frame_.epoch(), frame_.sequence()};
    return missed;
  }

 private:
  struct Last {
    std::uint64_t epoch = 0, sequence = 0;
  };
  std::map<std::string, Last> last_;
  styled::v1::Frame frame_;
};

}  // namespace

struct Tap::Impl {
  TapOptions options;
  TapCounts counts;
  zmq::context_t context{1};
  zmq::socket_t socket;
  zmq::message_t part;
  std::string connecting;  // endpoint being connected
  recording::Record record;
  Gaps gaps;
  styled::v1::Stats stats;
  std::set<std::string> there;  // performers, from the statistics

  void Open();
  void Wait(const recording::FileWriter& writer);
  bool Read();
  Status Drain(recording::FileWriter& writer);
  bool Counts(const recording::Published& published);
  std::string Missing() const;
};

void Tap::Impl::Open() {
  socket = zmq::socket_t(context, zmq::socket_type::sub);
  socket.set(zmq::sockopt::linger, 0);
  socket.set(zmq::sockopt::rcvhwm, kQueue);
  socket.set(zmq::sockopt::maxmsgsize, kMaxMessage);
  socket.set(zmq::sockopt::reconnect_ivl, 100);
  socket.set(zmq::sockopt::reconnect_ivl_max, 1000);
  socket.set(zmq::sockopt::handshake_ivl, 1000);
  if (options.curve) {
    socket.set(zmq::sockopt::curve_serverkey, options.curve->server_key);
    socket.set(zmq::sockopt::curve_publickey, options.curve->public_key);
    socket.set(zmq::sockopt::curve_secretkey, options.curve->secret_key);
  }
  for (const auto& topic : options.topics) socket.set(zmq::sockopt::subscribe, topic);
  if (options.topics.empty()) {
    for (const char* topic : {"styled/", "source/", "body/", "stats/"}) {
      socket.set(zmq::sockopt::subscribe, topic);
    }
  }
  for (const auto& endpoint : options.endpoints) {
    connecting = endpoint;
    socket.connect(endpoint);
  }
}

// Waits until a message arrives or the writer has work.
void Tap::Impl::Wait(const recording::FileWriter& writer) {
  const std::int64_t wait_ns =
      std::clamp<std::int64_t>(writer.NextDeadline_ns() - MonotonicNow_ns(), 0, kLongestWait_ns);
  try {
    zmq::pollitem_t item{socket.handle(), 0, ZMQ_POLLIN, 0};
    zmq::poll(&item, 1, std::chrono::milliseconds((wait_ns + 999'999) / 1'000'000));
  } catch (const zmq::error_t&) {  // interrupted by a signal
  }
}

// Reads the next message of two parts into `record`; false if none is waiting.
bool Tap::Impl::Read() {
  try {
    while (socket.recv(part, zmq::recv_flags::dontwait)) {
      auto& published = *record.mutable_published();
      published.set_topic(part.data(), part.size());
      int parts = 1;
      while (socket.get(zmq::sockopt::rcvmore) && socket.recv(part, zmq::recv_flags::none)) {
        if (++parts == 2) published.set_payload(part.data(), part.size());
      }
      if (parts == 2) return true;
      ++counts.odd;
    }
  } catch (const zmq::error_t&) {  // interrupted by a signal
  }
  return false;
}

// Whether the message is to be kept.
bool Tap::Impl::Counts(const recording::Published& published) {
  const auto missed = gaps.Look(published.topic(), published.payload());
  if (!missed) return false;
  counts.missed += *missed;
  ++counts.messages;
  if (published.topic() != "stats/") return true;
  ++counts.statistics;
  if (options.performer.empty() || !stats.ParseFromString(published.payload())) return true;
  there.clear();
  for (const auto& performer : stats.performers()) there.insert(performer.performer());
  return true;
}

// Describes the messages that should have arrived by now, as a sentence; "" if they have.
std::string Tap::Impl::Missing() const {
  std::string from;
  for (const auto& endpoint : options.endpoints) from += (from.empty() ? "" : ", ") + endpoint;
  if (counts.messages == 0) {
    return "nothing has arrived from " + from + " for 3 s; is styled running there?";
  }
  if (options.performer.empty() || counts.messages > counts.statistics) return "";
  return "nothing of " + options.performer + " has arrived from " + from + " for 3 s; ";
}

Status Tap::Impl::Drain(recording::FileWriter& writer) {
  for (int i = 0; i < kBatch && Read(); ++i) {
    const std::int64_t now_ns = MonotonicNow_ns();
    record.set_time_ns(now_ns);
    if (!Counts(record.published())) continue;
    Status status = writer.Add(record, now_ns);
    if (!status.ok()) return status;
  }
  return writer.Poll(MonotonicNow_ns());
}

Tap::Tap(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Tap::~Tap() = default;
const TapCounts& Tap::counts() const { return impl_->counts; }

Result<std::unique_ptr<Tap>> Tap::Connect(const TapOptions& options) {
  auto impl = std::make_unique<Impl>();
  impl->options = options;
  if (options.curve) {
    auto complete = client::Complete(*options.curve);
    if (!complete.ok()) return complete.status();
    impl->options.curve = std::move(complete.value());
  }
  try {
    impl->Open();
  } catch (const zmq::error_t& error) {
    return Status::Error("--from " + impl->connecting + ": " + error.what() +
                         "; expected e.g. tcp://127.0.0.1:7001 or ipc://PATH");
  }
  return std::unique_ptr<Tap>(new Tap(std::move(impl)));
}

Status Tap::Run(recording::FileWriter& writer, const std::atomic<bool>& stop, std::ostream& err) {
  recording::PreferThisThread();
  const std::int64_t begin_ns = MonotonicNow_ns();
  const auto over = [&] {
    const double seconds = static_cast<double>(MonotonicNow_ns() - begin_ns) * 1e-9;
    return impl_->options.seconds > 0 && seconds >= impl_->options.seconds;
  };
  Status status = Status::Ok();
  bool heard = false, judged = false;
  const auto judge = [&] {
    const double seconds = static_cast<double>(MonotonicNow_ns() - begin_ns) * 1e-9;
    if (judged || seconds < kPatience_s) return;
    judged = true;
    const std::string missing = impl_->Missing();
    if (missing.empty()) return;
    err << "stylerec: " << missing << (heard ? ListPerformers() : "") << "\n" << std::flush;
  };
  while (status.ok() && !stop && !over()) {
    impl_->Wait(writer);
    status = impl_->Drain(writer);
    if (!heard && impl_->counts.messages > 0) err << "stylerec: recording\n" << std::flush;
    heard = impl_->counts.messages > 0;
    judge();
  }
  judge();
  if (status.ok()) status = impl_->Drain(writer);  // messages that arrived before the end
  const Status flushed = writer.Flush();
  return status.ok() ? flushed : status;
}

std::string Tap::ListPerformers() const {
  if (impl_->there.empty()) return "no performer is present";
  std::string list;
  for (const auto& id : impl_->there) list += (list.empty() ? "" : ", ") + ForTerminal(id);
  return "there " + std::string(impl_->there.size() == 1 ? "is " : "are ") + list;
}

std::vector<std::string> TopicsOf(const std::string& performer) {
  return {"styled/" + performer + "/", "source/" + performer + "/", "body/" + performer + "/",
          "stats/"};
}

}  // namespace styled::rec
