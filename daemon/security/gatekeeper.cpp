#include "daemon/security/gatekeeper.h"

#include <pthread.h>
#include <spdlog/spdlog.h>
#include <sys/inotify.h>
#include <unistd.h>
#include <zmq.h>

#include <utility>

namespace styled::security {
namespace {

using runtime::Counter;

constexpr const char* kZapAddress = "inproc://zeromq.zap.01";
// ZMQ_ZAP_ENFORCE_DOMAIN, which Debian's header hides as a draft: a socket with a domain refuses
// every client while no ZAP handler answers.
constexpr int kZapEnforceDomain = 93;
// "300" means try again later. A libzmq client that receives "400" never reconnects, so that
// `stylectl allow` would have no effect before the client is restarted.
constexpr const char* kRefused = "300";
constexpr const char* kAllowed = "200";
constexpr std::size_t kMaxFrames = 16;
constexpr int kPerTurn = 64;
constexpr std::int64_t kLogAgain_ns = 60 * runtime::kSecond_ns;
constexpr std::uint32_t kChanges = IN_CLOSE_WRITE | IN_MOVED_TO | IN_MOVED_FROM | IN_DELETE |
                                   IN_ATTRIB | IN_DELETE_SELF | IN_MOVE_SELF | IN_ONLYDIR;

std::string MonitorOf(Door door) { return "inproc://handshakes." + std::string(Domain(door)); }

std::string Describe(const keys::Client& client) {
  return client.name + " (" + std::string(Name(client.role)) + ")";
}

}  // namespace

Gatekeeper::Gatekeeper(void* context, const std::string& folder, runtime::Counters& counters,
                       keys::KeyFile pair)
    : folder_(folder), counters_(counters), pair_(std::move(pair)), zap_(context, ZMQ_REP) {
  zmq_msg_init(&message_);
  for (auto& socket : failures_) socket = runtime::ZmqSocket(context, ZMQ_PAIR);
}

Gatekeeper::~Gatekeeper() {
  stop_.store(true, std::memory_order_relaxed);
  wake_.Signal();
  if (thread_.joinable()) thread_.join();
  zmq_msg_close(&message_);
}

Result<std::unique_ptr<Gatekeeper>> Gatekeeper::Open(void* context, const std::string& folder,
                                                     runtime::Counters& counters) {
  bool made = false;
  auto pair = keys::ServerPair(folder, made);
  if (!pair.ok()) return Status::Error("security.keys: " + pair.status().message());
  if (made) spdlog::info("security: made a pair of keys, {}", keys::ServerKeyFile(folder));
  std::unique_ptr<Gatekeeper> keeper(
      new Gatekeeper(context, folder, counters, std::move(pair.value())));
  if (const Status status = keeper->Bind(); !status.ok()) return status;
  keeper->Watch();
  const auto clients = keys::ReadClients(folder);
  if (!clients.ok()) return Status::Error("security.keys: " + clients.status().message());
  keeper->Reread();
  return keeper;
}

Status Gatekeeper::Bind() {
  zap_.Set(ZMQ_LINGER, 0);
  if (zap_.get() == nullptr || zmq_bind(zap_.get(), kZapAddress) != 0) {
    return Status::Error("security: " + std::string(zmq_strerror(zmq_errno())));
  }
  for (const Door door : {Door::kPublish, Door::kControl}) {
    auto& socket = failures_[static_cast<std::size_t>(door)];
    socket.Set(ZMQ_LINGER, 0);
    if (socket.get() == nullptr || zmq_connect(socket.get(), MonitorOf(door).c_str()) != 0) {
      return Status::Error("security: " + std::string(zmq_strerror(zmq_errno())));
    }
  }
  return Status::Ok();
}

Status Gatekeeper::Encrypt(runtime::ZmqSocket& socket, Door door) const {
  const std::string domain(Domain(door));
  const std::string& secret = pair_.secret_key;
  const bool done =
      socket.Set(ZMQ_CURVE_SERVER, 1) &&
      zmq_setsockopt(socket.get(), ZMQ_CURVE_SECRETKEY, secret.c_str(), secret.size() + 1) == 0 &&
      zmq_setsockopt(socket.get(), ZMQ_ZAP_DOMAIN, domain.data(), domain.size()) == 0 &&
      socket.Set(kZapEnforceDomain, 1);
  if (!done) return Status::Error(domain + ": CURVE: " + zmq_strerror(zmq_errno()));
  return Status::Ok();
}

Status Gatekeeper::Guard(runtime::ZmqSocket& socket, Door door) {
  if (Status status = Encrypt(socket, door); !status.ok()) return status;
  // Clients without a key, or with another server's key, fail before the request to ZAP. The
  // monitor counts them.
  zmq_socket_monitor(socket.get(), MonitorOf(door).c_str(),
                     ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL | ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL);
  return Status::Ok();
}

Status Gatekeeper::GuardPeers(runtime::ZmqSocket& socket) {
  return Encrypt(socket, Door::kControl);
}

Status Gatekeeper::Introduce(runtime::ZmqSocket& socket, const std::string& server_key) const {
  const auto set = [&](int option, const std::string& key) {
    return zmq_setsockopt(socket.get(), option, key.c_str(), key.size() + 1) == 0;
  };
  if (set(ZMQ_CURVE_SERVERKEY, server_key) && set(ZMQ_CURVE_PUBLICKEY, pair_.public_key) &&
      set(ZMQ_CURVE_SECRETKEY, pair_.secret_key)) {
    return Status::Ok();
  }
  return Status::Error(std::string("CURVE: ") + zmq_strerror(zmq_errno()));
}

// Watch before reading the folder, so that a change in between is noticed.
void Gatekeeper::Watch() {
  inotify_ = Descriptor(inotify_init1(IN_CLOEXEC | IN_NONBLOCK));
  watch_ = inotify_add_watch(inotify_.get(), keys::ClientsFolder(folder_).c_str(), kChanges);
}

void Gatekeeper::Start() {
  thread_ = std::thread([this] {
    pthread_setname_np(pthread_self(), "security");
    Run();
  });
}

void Gatekeeper::Run() {
  while (!stop_.load(std::memory_order_relaxed)) {
    if (DoWork()) continue;
    std::array<zmq_pollitem_t, 5> items{zmq_pollitem_t{zap_.get(), 0, ZMQ_POLLIN, 0},
                                        zmq_pollitem_t{failures_[0].get(), 0, ZMQ_POLLIN, 0},
                                        zmq_pollitem_t{failures_[1].get(), 0, ZMQ_POLLIN, 0},
                                        zmq_pollitem_t{nullptr, wake_.fd(), ZMQ_POLLIN, 0},
                                        zmq_pollitem_t{nullptr, inotify_.get(), ZMQ_POLLIN, 0}};
    zmq_poll(items.data(), inotify_.get() < 0 ? 4 : 5, 1000);
  }
}

bool Gatekeeper::DoWork() {
  const bool changed = FollowFolder();
  int answered = 0;
  while (answered < kPerTurn && Answer()) ++answered;
  const bool failed = CountFailures();
  const std::int64_t now_ns = clock_.Now_ns();
  if (now_ns >= next_tick_ns_) Tick(now_ns);
  return changed || answered > 0 || failed;
}

// Runs before the requests are answered, so that a client just revoked is refused.
bool Gatekeeper::FollowFolder() {
  alignas(inotify_event) std::array<char, 4096> events;
  bool changed = false;
  while (inotify_.get() >= 0) {
    const ssize_t size = read(inotify_.get(), events.data(), events.size());
    if (size <= 0) break;
    changed = true;
    for (ssize_t at = 0; at < size;) {
      const auto* const event = reinterpret_cast<const inotify_event*>(events.data() + at);
      // The folder was removed or renamed. Tick() looks once a second for a folder in its place.
      if ((event->mask & (IN_IGNORED | IN_MOVE_SELF)) != 0) watch_ = -1;
      at += static_cast<ssize_t>(sizeof(inotify_event) + event->len);
    }
  }
  if (changed) Reread();
  return changed;
}

// On an error (e.g. no descriptors or memory left) the present list stays in force and the read is
// tried again by Tick().
void Gatekeeper::Reread() {
  auto clients = keys::ReadClients(folder_);
  reread_ = !clients.ok();
  if (!clients.ok()) {
    spdlog::error("security: the list of clients is unchanged: {}", clients.status().message());
    return;
  }
  const Access::Change change = access_.Replace(std::move(clients.value().allowed));
  counters_.Set(Counter::kSecurityClients, access_.size());
  counters_.Add(Counter::kSecurityCut, static_cast<std::uint64_t>(change.cut));
  for (const auto& client : change.revoked) {
    spdlog::info("security: {} is no longer allowed", Describe(client));
  }
  for (const auto& client : change.allowed) {
    spdlog::info("security: {} is allowed", Describe(client));
  }
  if (change.cut > 0) spdlog::info("security: {} connections cut", change.cut);
  if (complaints_ == clients.value().complaints) return;
  complaints_ = std::move(clients.value().complaints);
  for (const auto& complaint : complaints_) spdlog::warn("security: {}", complaint);
}

bool Gatekeeper::Answer() {
  frames_.clear();
  std::size_t count = 0;
  do {
    if (zmq_msg_recv(&message_, zap_.get(), ZMQ_DONTWAIT) < 0) return false;
    ++count;
    if (count > kMaxFrames) continue;
    frames_.emplace_back(static_cast<const char*>(zmq_msg_data(&message_)),
                         zmq_msg_size(&message_));
  } while (zmq_msg_more(&message_) != 0);
  ZapRequest request;
  const bool understood = count <= kMaxFrames && ParseZap(frames_, request) == ZapResult::kOk;
  const bool admitted = understood && Admit(request);
  counters_.Add(admitted ? Counter::kSecurityAdmitted : Counter::kSecurityRefused);
  Reply(frames_.size() > 1 ? frames_[1] : "", admitted ? request.key : "");
  return true;
}

bool Gatekeeper::Admit(const ZapRequest& request) {
  keys::Client client;
  const Access::Verdict verdict = access_.Judge(request.key, request.door, &client);
  if (verdict == Access::Verdict::kAllowed) {
    spdlog::debug("security: {} connects to {} from {}", Describe(client), Domain(request.door),
                  request.address);
    return true;
  }
  refusal_ = std::string(request.address) + " is refused at " + std::string(Domain(request.door));
  refusal_ += verdict == Access::Verdict::kRole
                  ? ": " + Describe(client) + ", expected an operator"
                  : ": unknown key; to allow it: stylectl allow NAME '" + request.key + "'";
  return false;
}

// `user` "" refuses. Otherwise libzmq attaches it to every message of the client as "User-Id".
void Gatekeeper::Reply(const std::string& id, const std::string& user) {
  const bool admitted = !user.empty();
  const std::array<std::string, 6> frames{
      "1.0", id, admitted ? kAllowed : kRefused, admitted ? "OK" : "Refused", user, ""};
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const int more = i + 1 < frames.size() ? ZMQ_SNDMORE : 0;
    zmq_send(zap_.get(), frames[i].data(), frames[i].size(), more | ZMQ_DONTWAIT);
  }
}

bool Gatekeeper::CountFailures() {
  bool any = false;
  for (auto& socket : failures_) {
    for (int i = 0; i < kPerTurn && zmq_msg_recv(&message_, socket.get(), ZMQ_DONTWAIT) >= 0; ++i) {
      any = true;
      while (zmq_msg_more(&message_) != 0) {
        if (zmq_msg_recv(&message_, socket.get(), 0) < 0) break;
      }
      counters_.Add(Counter::kSecurityHandshakesFailed);
    }
  }
  return any;
}

// Once a second: retries what failed, and logs one refusal for all of the last second. A client
// that keeps retrying is logged once a minute.
void Gatekeeper::Tick(std::int64_t now_ns) {
  next_tick_ns_ = now_ns + runtime::kSecond_ns;
  if (watch_ < 0 || reread_) {
    if (watch_ < 0) Watch();
    Reread();
  }
  counters_.Add(Counter::kSecurityCut, static_cast<std::uint64_t>(access_.Sweep()));
  const bool again = refusal_ == logged_refusal_ && now_ns < log_again_ns_;
  if (!refusal_.empty() && !again) {
    spdlog::warn("security: {}", refusal_);
    logged_refusal_ = refusal_;
    log_again_ns_ = now_ns + kLogAgain_ns;
  }
  refusal_.clear();
}

}  // namespace styled::security
