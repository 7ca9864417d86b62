#include "clients/nats/link.h"

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <utility>

namespace styled::stylenats {
namespace {

constexpr std::int64_t kPing_ms = 1000;
constexpr int kPingsOut = 2;
// Not shorter: a write that is cut off breaks the connection, and a busy broker may take a while.
// Without it a broker that is stopped (SIGSTOP) holds the writer, and libnats' lock, for ever.
constexpr std::int64_t kWriteDeadline_ms = 1000;
constexpr std::int64_t kConnect_ms = 1000;
constexpr std::int64_t kReconnectWait_ms = 200;  // frames should be back within 2 s
constexpr std::int64_t kReconnectJitter_ms = 50;
// The smallest: 0 would mean 8 MB. Frames that waited for a broker are of no use.
constexpr int kReconnectBuffer = 1;
constexpr std::size_t kMaxEvents = 64;

struct OptionsDeleter {
  void operator()(natsOptions* options) const { natsOptions_Destroy(options); }
};

std::string LastError(natsConnection* connection) {
  const char* text = nullptr;
  const natsStatus status = natsConnection_GetLastError(connection, &text);
  if (text != nullptr && *text != '\0') return text;
  return status == NATS_OK ? "the broker closed it" : natsStatus_GetText(status);
}

std::string Address(natsConnection* connection) {
  char text[256] = "";
  natsConnection_GetConnectedUrl(connection, text, sizeof text);
  return text;
}

// Users with an inbox prefix of their own cannot read each other's replies. A user whose name is
// not a token (of credentials, or with a dot) gets the common one.
std::string InboxPrefix(const LinkOptions& options) {
  if (!options.inbox.empty()) return options.inbox;
  const bool token = std::all_of(options.user.begin(), options.user.end(), [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_' ||
           c == '-';
  });
  return options.user.empty() || !token ? "_INBOX" : "_INBOX_" + options.user;
}

// The progress of a first attempt to connect, and the reason of its failure. The connection that
// retries by itself no longer has this information when it gives up, and reports nothing about
// certificates.
natsStatus Try(natsOptions* options, std::string& why) {
  natsConnection* connection = nullptr;
  const natsStatus status = natsConnection_Connect(&connection, options);
  natsConnection_Destroy(connection);
  const char* const detail = nats_GetLastError(nullptr);
  why = detail != nullptr && *detail != '\0' ? detail : natsStatus_GetText(status);
  return status;
}

}  // namespace

// Shared with libnats' callbacks, which may run after the Link is destroyed: `self` is released by
// the last of them.
struct Link::State {
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<LinkEvent> events;
  std::string last_error;
  std::string refusal;  // of the first attempt; "": it succeeded or was none. Written before the
                        // callbacks
  std::atomic<std::uint64_t> generation{0};
  bool closed = false;
  std::shared_ptr<State> self;

  void Add(LinkEvent::Kind kind, std::string text) {
    const std::scoped_lock lock(mutex);
    if (kind == LinkEvent::Kind::kError && std::exchange(last_error, text) == text) return;
    if (events.size() < kMaxEvents) events.push_back({kind, std::move(text)});
  }

  static void OnConnected(natsConnection* connection, void* closure) {
    auto& state = *static_cast<State*>(closure);
    const bool first = state.generation++ == 0;
    state.Add(first ? LinkEvent::Kind::kConnected : LinkEvent::Kind::kReconnected,
              Address(connection));
  }
  static void OnDisconnected(natsConnection* connection, void* closure) {
    static_cast<State*>(closure)->Add(LinkEvent::Kind::kDisconnected, LastError(connection));
  }
  static void OnError(natsConnection* connection, natsSubscription* /*subscription*/,
                      natsStatus status, void* closure) {
    const char* text = nullptr;
    natsConnection_GetLastError(connection, &text);
    static_cast<State*>(closure)->Add(LinkEvent::Kind::kError, text != nullptr && *text != '\0'
                                                                   ? text
                                                                   : natsStatus_GetText(status));
  }
  static void OnClosed(natsConnection* connection, void* closure) {
    auto* const state = static_cast<State*>(closure);
    state->Add(LinkEvent::Kind::kClosed,
               state->refusal.empty() ? LastError(connection) : state->refusal);
    std::shared_ptr<State> last;
    const std::scoped_lock lock(state->mutex);
    last = state->self;
    state->self.reset();
    state->closed = true;
    state->changed.notify_all();
  }
};

Result<std::unique_ptr<Link>> Link::Open(const LinkOptions& options) {
  std::vector<const char*> servers;
  bool tls = false;
  for (const std::string& server : options.servers) {
    if (const Status status = CheckServer(server); !status.ok()) return status;
    tls = tls || server.starts_with("tls://");
    servers.push_back(server.c_str());
  }
  if (!options.ca.empty() && !tls) {
    return Status::Error("--nats-ca " + options.ca + ": no --nats is tls://HOST:PORT");
  }
  natsOptions* raw = nullptr;
  if (natsOptions_Create(&raw) != NATS_OK) return Status::Error("libnats: out of memory");
  const std::unique_ptr<natsOptions, OptionsDeleter> o(raw);
  auto state = std::make_shared<State>();
  natsStatus status = NATS_OK;
  const auto set = [&status](natsStatus result) {
    if (status == NATS_OK) status = result;
  };
  set(natsOptions_SetServers(raw, servers.data(), static_cast<int>(servers.size())));
  set(natsOptions_SetNoRandomize(raw, true));
  set(natsOptions_SetIgnoreDiscoveredServers(raw, true));
  set(natsOptions_SetName(raw, options.name.c_str()));
  set(natsOptions_SetTimeout(raw, kConnect_ms));
  set(natsOptions_SetPingInterval(raw, kPing_ms));
  set(natsOptions_SetMaxPingsOut(raw, kPingsOut));
  set(natsOptions_SetMaxReconnect(raw, -1));
  set(natsOptions_SetReconnectWait(raw, kReconnectWait_ms));
  set(natsOptions_SetReconnectJitter(raw, kReconnectJitter_ms, kReconnectJitter_ms));
  set(natsOptions_SetReconnectBufSize(raw, kReconnectBuffer));
  set(natsOptions_SetFailRequestsOnDisconnect(raw, true));
  set(natsOptions_SetWriteDeadline(raw, kWriteDeadline_ms));
  if (options.shared_thread) set(natsOptions_UseGlobalMessageDelivery(raw, true));
  if (!options.user.empty()) {
    set(natsOptions_SetUserInfo(raw, options.user.c_str(), options.password.c_str()));
  }
  if (!options.credentials.empty()) {
    set(natsOptions_SetUserCredentialsFromFiles(raw, options.credentials.c_str(), nullptr));
  }
  const std::string inbox_prefix = InboxPrefix(options);
  if (natsOptions_SetCustomInboxPrefix(raw, inbox_prefix.c_str()) != NATS_OK) {
    return Status::Error("--nats-inbox '" + inbox_prefix + "': expected tokens of a subject");
  }
  if (tls) set(natsOptions_SetSecure(raw, true));
  if (status != NATS_OK) {
    return Status::Error(std::string("libnats refuses an option: ") + natsStatus_GetText(status));
  }
  if (!options.ca.empty()) {
    status = natsOptions_LoadCATrustedCertificates(raw, options.ca.c_str());
    if (status != NATS_OK) {
      return Status::Error("--nats-ca " + options.ca + ": " + natsStatus_GetText(status) +
                           "; expected a file of certificates, PEM");
    }
  }
  std::string why;
  const natsStatus first = Try(raw, why);
  if (first == NATS_CONNECTION_AUTH_FAILED || first == NATS_SSL_ERROR) state->refusal = why;
  set(natsOptions_SetErrorHandler(raw, State::OnError, state.get()));
  set(natsOptions_SetDisconnectedCB(raw, State::OnDisconnected, state.get()));
  set(natsOptions_SetReconnectedCB(raw, State::OnConnected, state.get()));
  set(natsOptions_SetClosedCB(raw, State::OnClosed, state.get()));
  set(natsOptions_SetRetryOnFailedConnect(raw, true, State::OnConnected, state.get()));
  if (status != NATS_OK) return Status::Error("libnats refuses a callback");
  std::unique_ptr<Link> link(new Link(state));
  link->inbox_prefix_ = inbox_prefix;
  state->self = state;
  status = natsConnection_Connect(&link->connection_, raw);
  if (status == NATS_OK) {
    State::OnConnected(link->connection_, state.get());
  } else if (status == NATS_NOT_YET_CONNECTED) {
    if (first != NATS_CONNECTION_AUTH_FAILED) {
      state->Add(LinkEvent::Kind::kAbsent, first == NATS_SSL_ERROR ? why : "");
    }
  } else {
    state->self.reset();  // no callback follows
    return Status::Error(std::string("--nats ") + options.servers.front() + ": " +
                         natsStatus_GetText(status));
  }
  return link;
}

Link::~Link() {
  if (connection_ == nullptr) return;
  natsConnection_Close(connection_);
  {
    // The callback that closes is the last one. It is called at once, on a thread of libnats.
    std::unique_lock lock(state_->mutex);
    state_->changed.wait_for(lock, std::chrono::seconds(1), [this] { return state_->closed; });
  }
  natsConnection_Destroy(connection_);
}

std::uint64_t Link::generation() const { return state_->generation; }

std::vector<LinkEvent> Link::Events() {
  const std::scoped_lock lock(state_->mutex);
  return std::exchange(state_->events, {});
}

std::string Link::NewInbox() const {
  natsInbox* inbox = nullptr;
  if (natsInbox_Create(&inbox) != NATS_OK) return "";
  const std::string made = inbox;
  natsInbox_Destroy(inbox);
  return inbox_prefix_ + made.substr(made.find('.'));  // it begins with _INBOX
}

bool Link::Flush(std::chrono::milliseconds timeout) {
  return natsConnection_FlushTimeout(connection_, std::max<std::int64_t>(1, timeout.count())) ==
         NATS_OK;
}

}  // namespace styled::stylenats
