#include "clients/nats/commands.h"

#include <utility>

#include "clients/nats/subject.h"

namespace styled::stylenats {
namespace {

constexpr std::int64_t kGlance_ms = 100;  // interval of the checks whether the program ends
// Requests that wait in libnats: as many as the asker takes, of the largest size twice.
constexpr int kMaxWaiting = 64, kMaxWaitingBytes = 20 << 20;

v1::Reply Refusal(std::uint64_t id, v1::Code code, const std::string& reason) {
  v1::Reply reply;
  reply.set_id(id);
  reply.set_code(code);
  reply.set_reason("stylenats: " + reason);
  return reply;
}

}  // namespace

Result<std::unique_ptr<Commands>> Commands::Start(Link& link, const std::string& site,
                                                  const std::string& control,
                                                  const std::optional<client::Curve>& curve) {
  std::unique_ptr<Commands> commands(new Commands(link));
  auto asker = client::Asker::Start(control, curve);
  if (!asker.ok()) return asker.status();
  commands->asker_ = std::move(asker.value());
  commands->subject_ = ControlSubject(site);
  commands->thread_ =
      std::jthread([c = commands.get()](const std::stop_token& stop) { c->Loop(stop); });
  return commands;
}

Commands::~Commands() {
  thread_ = {};  // waits for it
  asker_.reset();
  natsSubscription_Destroy(subscription_);
}

// Also before the first connection: libnats subscribes once there is one. It fails only if the
// connection is closed for good, which ends the program.
bool Commands::Subscribed() {
  if (subscription_ != nullptr) return true;
  if (natsConnection_SubscribeSync(&subscription_, link_.get(), subject_.c_str()) != NATS_OK) {
    return false;
  }
  natsSubscription_SetPendingLimits(subscription_, kMaxWaiting, kMaxWaitingBytes);
  return true;
}

void Commands::Loop(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    if (!Subscribed()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(kGlance_ms));
      continue;
    }
    natsMsg* message = nullptr;
    const natsStatus status = natsSubscription_NextMsg(&message, subscription_, kGlance_ms);
    if (status == NATS_OK) {
      const char* const reply_to = natsMsg_GetReply(message);
      Ask(reply_to == nullptr ? "" : reply_to, natsMsg_GetData(message),
          natsMsg_GetDataLength(message));
      natsMsg_Destroy(message);
    } else if (status != NATS_TIMEOUT) {
      // A limit was exceeded (NATS_SLOW_CONSUMER), or the connection is closed.
      std::this_thread::sleep_for(std::chrono::milliseconds(kGlance_ms));
    }
  }
}

void Commands::Ask(const std::string& reply_to, const char* bytes, int size) {
  ++counts_.requests;
  v1::Request request;
  if (!request.ParseFromArray(bytes, size)) {
    return Answer(reply_to,
                  Refusal(0, v1::CODE_MALFORMED, "the payload is not a Request of control.proto"));
  }
  const std::uint64_t id = request.id();
  const bool taken = asker_->Ask(
      std::move(request), [this, reply_to](const client::CallStatus& status, v1::Reply reply) {
        using Kind = client::CallStatus::Kind;
        if (status.kind() == Kind::kNoAnswer || status.kind() == Kind::kGarbled) {
          ++counts_.unanswered;
          reply = Refusal(reply.id(), v1::CODE_BUSY, status.reason());
        } else if (reply.code() == v1::CODE_STANDBY ||
                   reply.status().stats().standby().role() == "following") {
          ++counts_.left;  // the leading daemon has a bridge of its own, which answers
          return;
        }
        Answer(reply_to, reply);
      });
  if (!taken) {
    Answer(reply_to, Refusal(id, v1::CODE_BUSY, "too many requests wait for the daemon"));
  }
}

void Commands::Answer(const std::string& reply_to, const v1::Reply& reply) {
  if (reply_to.empty()) return;
  std::string bytes = reply.SerializeAsString();
  const std::int64_t limit = natsConnection_GetMaxPayload(link_.get());
  if (limit > 0 && static_cast<std::int64_t>(bytes.size()) > limit) {
    ++counts_.too_large;
    bytes = Refusal(reply.id(), v1::CODE_TOO_LARGE,
                    "the daemon's reply has " + std::to_string(bytes.size()) +
                        " bytes, the broker accepts " + std::to_string(limit) + " (max_payload)")
                .SerializeAsString();
  }
  if (!link_.connected() || natsConnection_Publish(link_.get(), reply_to.c_str(), bytes.data(),
                                                   static_cast<int>(bytes.size())) != NATS_OK) {
    ++counts_.lost;
  }
}

}  // namespace styled::stylenats
