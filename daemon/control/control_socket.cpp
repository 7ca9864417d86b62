#include "daemon/control/control_socket.h"

#include <algorithm>
#include <array>
#include <cerrno>

#include "daemon/control/request_size.h"
#include "daemon/looks/refusal.h"
#include "daemon/security/ipc.h"
#include "daemon/styles/style_requests.h"

namespace styled::control {
namespace {

using runtime::Counter;

constexpr int kPerCycle = 16;
constexpr int kMaxInFlight = 32;      // half of the rings' capacity
constexpr std::size_t kMaxParts = 4;  // parts kept of a message; further ones are read and dropped

// A full ring leaves the exchange where it is.
template <typename Ring>
bool PushOrKeep(Ring& ring, std::unique_ptr<pipeline::Exchange>& exchange) {
  return ring.Push(std::move(exchange));
}

}  // namespace

ControlSocket::ControlSocket(runtime::ZmqSocket socket, std::unique_ptr<OscSocket> osc,
                             security::Access* access, pipeline::Mailboxes& mailboxes,
                             runtime::Counters& counters)
    : socket_(std::move(socket)),
      osc_(std::move(osc)),
      access_(access),
      mailboxes_(mailboxes),
      counters_(counters) {
  zmq_msg_init(&message_);
}

ControlSocket::~ControlSocket() { zmq_msg_close(&message_); }

int ControlSocket::DoWork() {
  int work = 0;
  std::unique_ptr<pipeline::Exchange> exchange;
  while (mailboxes_.replies.Pop(exchange)) {
    --in_flight_;
    if (!exchange->osc.empty() && exchange->designs) designing_ = false;
    ++work;
    if (exchange->reply.code() != v1::CODE_OK) counters_.Add(Counter::kControlRefused);
    if (exchange->osc.empty()) {
      Send(exchange->envelope, exchange->reply);
    } else {
      osc_->Answer(*exchange);
    }
  }
  for (int i = 0; i < kPerCycle && Receive(); ++i) {
    ++work;
    counters_.Add(Counter::kControlRequests);
    Handle();
  }
  if (osc_ != nullptr) {
    for (int i = 0; i < kPerCycle && osc_->Receive(); ++i) {
      ++work;
      counters_.Add(Counter::kControlOsc);
      HandleOsc();
    }
  }
  return work + PassDesigns();
}

bool ControlSocket::Receive() {
  parts_.clear();
  part_count_ = 0;
  do {
    if (zmq_msg_recv(&message_, socket_.get(), ZMQ_DONTWAIT) < 0) return false;
    ++part_count_;
    if (parts_.size() >= kMaxParts) continue;
    const auto* data = static_cast<const std::byte*>(zmq_msg_data(&message_));
    parts_.emplace_back(data, data + zmq_msg_size(&message_));
  } while (zmq_msg_more(&message_) != 0);
  return true;
}

void ControlSocket::Handle() {
  auto exchange = std::make_unique<pipeline::Exchange>();
  auto& envelope = exchange->envelope;
  envelope.push_back(parts_.front());  // the peer's identity, prepended by the ROUTER socket
  // A REQ peer sends an empty delimiter before its request, a DEALER may leave it out.
  const bool delimited = part_count_ >= 3 && parts_[1].empty();
  if (delimited) envelope.emplace_back();
  if (part_count_ != envelope.size() + 1) {
    counters_.Add(Counter::kControlMalformed);
    return Refuse(envelope, pipeline::Malformed("request of " +
                                                std::to_string(part_count_ - envelope.size()) +
                                                " parts, expected one"));
  }
  if (const Status status = CheckSender(); !status.ok()) return Refuse(envelope, status);
  const auto& payload = parts_.back();
  const auto refuse_size = [&](const Status& status) {
    counters_.Add(Counter::kControlTooLarge);
    Refuse(envelope, status);
  };
  if (const Status status = CheckSize(payload.size(), true); !status.ok()) {
    return refuse_size(status);
  }
  if (const RequestSize size = SizeOfRequest(payload); size.beside_file > MostBesideFile(size)) {
    const std::string of_bytes =
        size.beside_file < payload.size() ? " bytes beside its file" : " bytes";
    return refuse_size(pipeline::Refused(
        v1::CODE_TOO_LARGE, "request of " + std::to_string(size.beside_file) + of_bytes +
                                ", expected at most " + std::to_string(MostBesideFile(size))));
  }
  if (!exchange->request.ParseFromArray(payload.data(), static_cast<int>(payload.size()))) {
    if (payload.size() > kMaxRequestBytes) return refuse_size(CheckSize(payload.size(), false));
    counters_.Add(Counter::kControlMalformed);
    return Refuse(envelope, pipeline::Malformed("not a styled.v1.Request"));
  }
  const v1::Request& request = exchange->request;
  const Status size = CheckSize(payload.size(), request.has_like() || request.has_import_style() ||
                                                    request.has_restore_checkpoint());
  if (!size.ok()) return refuse_size(size);
  if (!Pass(exchange)) Send(exchange->envelope, exchange->reply);
}

Status ControlSocket::CheckSize(std::size_t bytes, bool has_file) {
  const std::size_t most = has_file ? kMaxFileRequestBytes : kMaxRequestBytes;
  if (bytes <= most) return Status::Ok();
  return pipeline::Refused(
      v1::CODE_TOO_LARGE,
      "request of " + std::to_string(bytes) + " bytes, expected at most " + std::to_string(most));
}

// Checked at each request: a client that was revoked, or lost the operator's role, may still be
// connected.
Status ControlSocket::CheckSender() {
  if (access_ == nullptr) return Status::Ok();
  const char* const key = zmq_msg_gets(&message_, "User-Id");
  const std::string_view known = key == nullptr ? "" : key;
  switch (access_->Judge(known, security::Door::kControl)) {
    case security::Access::Verdict::kAllowed:
      return Status::Ok();
    case security::Access::Verdict::kRole:
      return pipeline::Refused(v1::CODE_UNAUTHORIZED,
                               "this key is a subscriber's; expected an operator's");
    case security::Access::Verdict::kUnknownKey:
      break;
  }
  return pipeline::Refused(v1::CODE_UNAUTHORIZED, "this key is no longer allowed");
}

void ControlSocket::HandleOsc() {
  for (auto& exchange : osc_->Read()) {
    if (exchange->reply.code() != v1::CODE_OK) counters_.Add(Counter::kControlRefused);
    if (exchange->request.like().has_design()) {
      exchange->designs = true;
      Merge(std::move(exchange));
      continue;
    }
    if (exchange->reply.code() == v1::CODE_OK && Pass(exchange)) continue;
    osc_->Answer(*exchange);
  }
}

void ControlSocket::Merge(std::unique_ptr<pipeline::Exchange> design) {
  const auto waiting = std::ranges::find_if(designs_, [&design](const auto& one) {
    return one->request.performer() == design->request.performer();
  });
  if (waiting == designs_.end()) {
    if (designs_.size() < kMaxInFlight) return designs_.push_back(std::move(design));
    Busy(*design, "too many designs are waiting; try again");
    return osc_->Answer(*design);
  }
  const v1::Design& newer = design->request.like().design();
  if (!newer.preset().empty()) {
    *waiting = std::move(design);
    return;
  }
  auto& sliders = *(*waiting)->request.mutable_like()->mutable_design()->mutable_sliders();
  for (const auto& [name, value] : newer.sliders()) sliders[name] = value;
}

// One at a time, so that later values are merged meanwhile, and clients' examples find room.
int ControlSocket::PassDesigns() {
  if (designs_.empty() || designing_ || in_flight_ >= kMaxInFlight) return 0;
  std::unique_ptr<pipeline::Exchange> design = std::move(designs_.front());
  designs_.erase(designs_.begin());
  designing_ = true;
  if (!Pass(design)) {
    designing_ = false;
    osc_->Answer(*design);
  }
  return 1;
}

void ControlSocket::Busy(pipeline::Exchange& exchange, const std::string& why) {
  counters_.Add(Counter::kControlBusy);
  counters_.Add(Counter::kControlRefused);
  exchange.reply.set_id(exchange.request.id());
  pipeline::FillReply(pipeline::Refused(v1::CODE_BUSY, why), exchange.reply);
}

bool ControlSocket::Pass(std::unique_ptr<pipeline::Exchange>& exchange) {
  if (in_flight_ == kMaxInFlight) {
    Busy(*exchange, "too many requests are waiting; try again");
    return false;
  }
  if (pipeline::IsStyleRequest(exchange->request)) {
    if (!PushOrKeep(mailboxes_.examples, exchange)) {
      Busy(*exchange, "too many examples are waiting; try again");
      return false;
    }
    mailboxes_.wake_files.Signal();
  } else {
    mailboxes_.commands.Push(std::move(exchange));  // never full: it holds more than kMaxInFlight
    mailboxes_.wake_pipeline.Signal();
  }
  ++in_flight_;
  return true;
}

void ControlSocket::Refuse(const std::vector<std::vector<std::byte>>& envelope,
                           const Status& status) {
  v1::Reply reply;
  pipeline::FillReply(status, reply);
  counters_.Add(Counter::kControlRefused);
  Send(envelope, reply);
}

// The reply is lost if the peer has gone or does not read.
void ControlSocket::Send(const std::vector<std::vector<std::byte>>& envelope,
                         const v1::Reply& reply) {
  for (const auto& part : envelope) {
    if (zmq_send(socket_.get(), part.data(), part.size(), ZMQ_SNDMORE | ZMQ_DONTWAIT) < 0) return;
  }
  const std::string bytes = reply.SerializeAsString();
  zmq_send(socket_.get(), bytes.data(), bytes.size(), ZMQ_DONTWAIT);
}

void ControlSocket::Run() {
  while (!stop_.load(std::memory_order_relaxed)) {
    if (DoWork() > 0) continue;
    std::array<zmq_pollitem_t, 3> items{
        zmq_pollitem_t{socket_.get(), 0, ZMQ_POLLIN, 0},
        zmq_pollitem_t{nullptr, mailboxes_.wake_control.fd(), ZMQ_POLLIN, 0},
        zmq_pollitem_t{nullptr, osc_ == nullptr ? -1 : osc_->fd(), ZMQ_POLLIN, 0}};
    zmq_poll(items.data(), osc_ == nullptr ? 2 : 3, 1000);
    if (items[1].revents != 0) mailboxes_.wake_control.Clear();
  }
}

void ControlSocket::Stop() {
  stop_.store(true, std::memory_order_relaxed);
  mailboxes_.wake_control.Signal();
}

Result<std::unique_ptr<ControlSocket>> MakeControlSocket(
    void* context, const config::Control& config, std::unique_ptr<OscSocket> osc,
    pipeline::Mailboxes& mailboxes, runtime::Counters& counters, std::string& endpoint,
    security::Gatekeeper* keeper) {
  runtime::ZmqSocket socket(context, ZMQ_ROUTER);
  if (socket.get() == nullptr) return Status::Error("control: " + std::string(zmq_strerror(errno)));
  socket.Set(ZMQ_LINGER, 100);
  socket.Set(ZMQ_HANDSHAKE_IVL, 1000);
  // Larger than kMaxFileRequestBytes, so that a request that is slightly too large gets an answer.
  // libzmq cuts the connection of a larger one.
  socket.Set(ZMQ_MAXMSGSIZE, static_cast<std::int64_t>(kMaxFileRequestBytes + (1U << 20U)));
  socket.Set(ZMQ_RCVHWM, 64);
  socket.Set(ZMQ_SNDHWM, 64);
  socket.Set(ZMQ_TCP_KEEPALIVE, 1);
  const auto ipc = security::ResolveIpc(config.ipc, "control");
  if (!ipc.ok()) return ipc.status();
  if (keeper != nullptr) {
    const Status status = keeper->Guard(socket, security::Door::kControl);
    if (!status.ok()) return status;
  }
  const Status status = socket.Bind(config.address, "control.address", endpoint, ipc.value());
  if (!status.ok()) return status;
  return std::make_unique<ControlSocket>(std::move(socket), std::move(osc),
                                         keeper == nullptr ? nullptr : &keeper->access(), mailboxes,
                                         counters);
}

}  // namespace styled::control
