// Faults of peers: they do not read, they send garbage, they send more than can be styled.
#include <arpa/inet.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zmq.h>

#include <algorithm>
#include <fstream>
#include <random>

#include "clients/cpp/subscriber.h"
#include "proto/keys/key_folder.h"
#include "tests/faults/faults.h"
#include "tests/faults/stage.h"
#include "tests/support/clients.h"

namespace styled::faults {
namespace {

using support::ControlClient;
using support::Daemon;
using support::Sleep;

// "tcp://HOST:PORT" or "HOST:PORT".
std::uint16_t Port(const std::string& address) {
  return static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1)));
}

int ConnectTo(const std::string& address) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  to.sin_port = htons(Port(address));
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd >= 0) (void)connect(fd, reinterpret_cast<sockaddr*>(&to), sizeof to);
  return fd;
}

// A renderer with our client library, latest wins, in a process of its own that is stopped for a
// while. Once it continues, it reports the age of the first frame that it draws.
Outcome Stopped(const Effort& effort) {
  Daemon daemon({"publish.high_water_mark=64"});  // as it comes
  int told[2];
  if (pipe(told) != 0) return Failed("no pipe");
  const pid_t renderer = fork();
  if (renderer == 0) {
    auto subscriber = client::Subscriber::Connect({.endpoints = {daemon.publish}});
    std::vector<client::Update> updates;
    std::int64_t last_ns = Now_ns();
    for (;;) {
      subscriber.value()->ReceiveLatest(std::chrono::milliseconds(100), updates);
      const std::int64_t now_ns = Now_ns();
      double oldest_ms = -1;
      for (const auto& update : updates) {
        if (update.kind != client::Update::Kind::kFrame) continue;
        const auto sent_ns = static_cast<std::int64_t>(update.frame.publish_time_ns());
        oldest_ms = std::max(oldest_ms, static_cast<double>(now_ns - sent_ns) * 1e-6);
      }
      if (now_ns - last_ns > 1'000'000'000 && oldest_ms >= 0) {
        (void)!write(told[1], &oldest_ms, sizeof oldest_ms);
      }
      if (oldest_ms >= 0) last_ns = now_ns;
      usleep(8000);
    }
  }
  close(told[1]);
  const Watcher watcher(daemon.publish);
  Feed feed(daemon.udp, 4);
  bool running = watcher.Sees(5);
  Sleep(1);
  const Watcher::Seen before = watcher.seen();
  kill(renderer, SIGSTOP);
  const double seconds = effort.Seconds(60);
  Sleep(seconds);
  kill(renderer, SIGCONT);
  double oldest_ms = -1;
  running = running && read(told[0], &oldest_ms, sizeof oldest_ms) == sizeof oldest_ms;
  const Watcher::Seen after = watcher.seen();
  kill(renderer, SIGKILL);
  waitpid(renderer, nullptr, 0);
  close(told[0]);
  return {
      running && after.missing == before.missing, oldest_ms <= 100,
      Format("stopped for %.0f s: the oldest frame it drew on resume was %.1f ms old; the other "
             "subscriber got %llu frames, %llu missing",
             seconds, oldest_ms, static_cast<unsigned long long>(after.frames - before.frames),
             static_cast<unsigned long long>(after.missing - before.missing))};
}

// On one port after another: strangers who say nothing, half a greeting or noise, while a good
// client asks.
Outcome Garbage(const Effort& effort) {
  rlimit most{};
  getrlimit(RLIMIT_NOFILE, &most);
  most.rlim_cur = most.rlim_max;
  setrlimit(RLIMIT_NOFILE, &most);
  Daemon daemon;
  (void)prlimit(daemon.child->pid(), RLIMIT_NOFILE, &most, nullptr);
  const Watcher watcher(daemon.publish);
  Feed feed(daemon.udp, 2);
  if (!watcher.Sees(5)) return Failed("no frame");
  Sleep(0.5);
  const Watcher::Seen before = watcher.seen();
  std::mt19937 random(1);
  double slowest_ms = 0;
  const int half_open = effort.Times(1000), garbage = effort.Times(5000);
  for (const std::string& address : {daemon.tcp, daemon.publish, daemon.control}) {
    ControlClient control(daemon.control);
    (void)control.Status();
    std::vector<int> silent;
    for (int i = 0; i < half_open; ++i) {
      silent.push_back(ConnectTo(address));
      // Half of them begin a ZeroMQ greeting and never end it.
      const char greeting[] = {'\xff', 0, 0, 0, 0, 0, 0, 0, 1, '\x7f', 3};
      if (i % 2 == 0) (void)!send(silent.back(), greeting, sizeof greeting, MSG_NOSIGNAL);
    }
    for (int i = 0; i < garbage; ++i) {
      const int fd = ConnectTo(address);
      std::array<std::uint32_t, 64> noise;
      std::generate(noise.begin(), noise.end(), std::ref(random));
      (void)!send(fd, noise.data(), 1 + random() % sizeof noise, MSG_NOSIGNAL);
      close(fd);
      if (i % 50 != 0) continue;
      const std::int64_t from_ns = Now_ns();
      (void)control.Status();
      slowest_ms = std::max(slowest_ms, static_cast<double>(Now_ns() - from_ns) * 1e-6);
    }
    for (const int fd : silent) close(fd);
  }
  if (!daemon.child->Running()) return Failed("the daemon ended");
  const Watcher::Seen after = watcher.seen();
  return {
      after.missing == before.missing, slowest_ms <= 100,
      Format("%d garbage and %d half-open connections on each of 3 ports: status answered within "
             "%.1f ms at most, %llu frames, %llu missing",
             garbage, half_open, slowest_ms,
             static_cast<unsigned long long>(after.frames - before.frames),
             static_cast<unsigned long long>(after.missing - before.missing))};
}

// More than can be styled, as fast as a sender can: frames published and frames counted add up to
// the frames sent; afterwards all is as before.
Outcome Overload(const Effort& effort) {
  Daemon daemon({"performers.backlog_ms=100"});
  const Watcher watcher(daemon.publish);
  const auto quiet = [&daemon, &watcher] {
    Feed feed(daemon.udp, 1);
    return watcher.Sees(3);
  };
  if (!quiet()) return Failed("no frame");
  ControlClient control(daemon.control);
  const auto count = [&control](const char* name) { return control.Counter(name); };
  const auto frames0 = count("pipeline.frames"), lost0 = count("pipeline.lost"),
             passed0 = count("pipeline.backlog_dropped");
  const std::uint64_t rss0 = ResidentBytes(daemon.child->pid());
  std::uint64_t bodies = 0, frames = 0;
  {
    std::vector<support::Rig> rigs;
    const support::UdpLink link(daemon.udp);
    for (int i = 0; i < 32; ++i) {
      rigs.emplace_back("q" + std::to_string(i), 100 + i);
      link.Send(rigs.back().Body());
      ++bodies;
    }
    Sleep(0.2);
    const std::int64_t until_ns = Now_ns() + static_cast<std::int64_t>(effort.Seconds(20) * 1e9);
    while (Now_ns() < until_ns) {
      for (auto& rig : rigs) {
        link.Send(rig.Frame());
        ++frames;
      }
    }
    // A datagram dropped last counts as missed only when another one follows.
    Sleep(0.5);
    for (auto& rig : rigs) link.Send(rig.Frame());
    frames += rigs.size();
  }
  const std::int64_t from_ns = Now_ns();
  const bool back = quiet();
  const double back_s = static_cast<double>(Now_ns() - from_ns) * 1e-9;
  const std::uint64_t rss1 = ResidentBytes(daemon.child->pid());
  Sleep(0.5);
  // Lost by their sequence: dropped by the socket (source.kernel_dropped) or before it.
  const auto lost = count("pipeline.lost") - lost0;
  const auto passed_over = count("pipeline.backlog_dropped") - passed0;
  const auto styled = count("pipeline.frames") - frames0;
  const auto kernel = count("source.kernel_dropped");
  // The quiet performer's frames are styled, too; a body that was lost is a loss as well.
  const auto known = styled + lost + passed_over;
  const bool exact = known >= frames && known <= frames + bodies + 8 * 120;
  const double growth_mb = (static_cast<double>(rss1) - static_cast<double>(rss0)) / 1048576;
  return {exact && back && growth_mb <= 64, back_s <= 2,
          Format("%llu frames sent: %llu styled, %llu lost and counted (%llu at the socket), %llu "
                 "passed over and "
                 "counted; RSS %+.1f MB; normal after %.2f s",
                 static_cast<unsigned long long>(frames), static_cast<unsigned long long>(styled),
                 static_cast<unsigned long long>(lost), static_cast<unsigned long long>(kernel),
                 static_cast<unsigned long long>(passed_over), growth_mb, back_s)};
}

// Sends subscriptions that no other client has, 5,000 a second at most (so that their effect can be
// observed), on a thread of its own.
class Flooder {
 public:
  Flooder(const std::string& publish, const support::CurveKeys& keys) {
    context_ = zmq_ctx_new();
    socket_ = zmq_socket(context_, ZMQ_XSUB);
    const int none = 0, wait_ms = 50;
    zmq_setsockopt(socket_, ZMQ_LINGER, &none, sizeof none);
    zmq_setsockopt(socket_, ZMQ_SNDTIMEO, &wait_ms, sizeof wait_ms);
    if (!keys.server_key.empty()) {
      zmq_setsockopt(socket_, ZMQ_CURVE_SERVERKEY, keys.server_key.c_str(), 41);
      zmq_setsockopt(socket_, ZMQ_CURVE_PUBLICKEY, keys.public_key.c_str(), 41);
      zmq_setsockopt(socket_, ZMQ_CURVE_SECRETKEY, keys.secret_key.c_str(), 41);
    }
    zmq_connect(socket_, publish.c_str());
    thread_ = std::thread([this] { Run(); });
  }
  ~Flooder() {
    stop_ = true;
    thread_.join();
    zmq_close(socket_);
    zmq_ctx_term(context_);
  }
  Flooder(const Flooder&) = delete;
  Flooder& operator=(const Flooder&) = delete;
  std::uint64_t sent() const { return sent_; }

 private:
  void Run() {
    std::mt19937 random(3);
    std::string message(900, '\1');  // below the publisher's limit of 1,024
    while (!stop_) {
      for (std::size_t i = 1; i < message.size(); ++i) message[i] = static_cast<char>(random());
      if (zmq_send(socket_, message.data(), message.size(), 0) >= 0 && ++sent_ % 50 == 0) {
        Sleep(0.01);
      }
    }
  }
  void *context_, *socket_;
  std::atomic<bool> stop_{false};
  std::atomic<std::uint64_t> sent_{0};
  std::thread thread_;
};

// With keys required. libzmq keeps every subscription before the daemon sees it: with a key the
// flood is the service manager's to end, MemoryMax, for which a limit on the address space stands
// here.
Outcome Flood(const Effort& effort) {
  constexpr std::uint64_t kMemoryMax = 256U << 20U;
  const support::TemporaryFolder folder;
  Daemon daemon({"security.keys=" + (folder / "keys"), "publish.address=tcp://0.0.0.0:0"});
  const std::string publish = "tcp://127.0.0.1" + daemon.publish.substr(daemon.publish.rfind(':'));
  const auto pair = keys::MakePair();
  if (!pair.ok()) return Failed(pair.status().message());
  const auto allowed =
      keys::Allow(folder / "keys", {"peer", pair.value().public_key, keys::Role::kSubscriber});
  if (!allowed.ok()) return Failed(allowed.message());
  const support::CurveKeys key{daemon.server_key, pair.value().public_key, pair.value().secret_key};
  const Feed feed(daemon.udp, 1);
  const std::uint64_t before = ResidentBytes(daemon.child->pid());
  std::uint64_t strangers = 0;
  double strangers_mb = 0;
  {
    const Flooder stranger(publish, {});
    Sleep(effort.Seconds(5));
    ControlClient control(daemon.control);
    strangers =
        control.Counter("publish.subscriptions") + control.Counter("publish.subscriptions_refused");
    strangers_mb =
        (static_cast<double>(ResidentBytes(daemon.child->pid())) - static_cast<double>(before)) /
        (1 << 20);
  }
  {
    const support::Subscriber good(publish, {"styled/"}, key);
    if (!good.WaitForFrames(10)) return Failed("no frame to a subscriber with a key");
  }
  std::uint64_t virtual_pages = 0;
  std::ifstream("/proc/" + std::to_string(daemon.child->pid()) + "/statm") >> virtual_pages;
  const rlim_t most =
      virtual_pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) + kMemoryMax;
  const rlimit limit{most, most};
  (void)prlimit(daemon.child->pid(), RLIMIT_AS, &limit, nullptr);
  std::uint64_t counted = 0, largest = 0;
  std::uint64_t sent = 0;
  {
    const Flooder peer(publish, key);
    ControlClient control(daemon.control);
    control.SetPatience(0.5);
    for (const std::int64_t end_ns = Now_ns() + 60'000'000'000;
         daemon.child->Running() && Now_ns() < end_ns;) {
      largest = std::max(largest, ResidentBytes(daemon.child->pid()));
      const std::uint64_t refused = control.Counter("publish.subscriptions_refused");
      if (refused <= peer.sent()) counted = std::max(counted, refused);  // more: no answer
    }
    sent = peer.sent();
  }
  if (daemon.child->Running()) return Failed("a minute's flood did not reach the limit");
  const std::int64_t from_ns = Now_ns();
  daemon.Start();
  const double ready_s = static_cast<double>(Now_ns() - from_ns) * 1e-9;
  const std::string again = "tcp://127.0.0.1" + daemon.publish.substr(daemon.publish.rfind(':'));
  const Feed fresh(daemon.udp, 1);
  const support::Subscriber good(again, {"styled/"}, key);
  const bool back = good.WaitForFrames(10);
  return {strangers == 0 && strangers_mb < 16 && counted > 0 && back, ready_s <= 1,
          Format("without a key: %llu of its subscriptions came in, RSS %+.1f MB; with one: %llu "
                 "sent, %llu counted as refused, ended at %.0f MB by the limit, ready again after "
                 "%.2f s",
                 static_cast<unsigned long long>(strangers), strangers_mb,
                 static_cast<unsigned long long>(sent), static_cast<unsigned long long>(counted),
                 static_cast<double>(largest) / (1 << 20), ready_s)};
}

}  // namespace

std::vector<Fault> PeerFaults() {
  return {{"stopped", "a subscriber is stopped for 60 s",
           "others lose nothing; its oldest frame on resume <= 100 ms old", Stopped},
          {"garbage", "5,000 garbage and 1,000 half-open connections per port",
           "a good client served <= 100 ms meanwhile, nothing missing", Garbage},
          {"overload", "32 performers as fast as one sender can",
           "in = out + counted, RSS + <= 64 MB, normal within 2 s", Overload},
          {"flood", "subscriptions without end, without a key and with one",
           "impossible without; else bounded, counted, ready again <= 1 s", Flood}};
}

}  // namespace styled::faults
