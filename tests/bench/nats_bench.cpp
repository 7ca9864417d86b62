// Measures the cost of NATS for viewers, and the effect of its trouble on other subscribers: the
// real daemon, stylenats and the shipped servers, raw sockets as subscribers of both engines.
// Compare within one run. No assertions.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <stdexcept>

#include "tests/e2e/nats/raw_subscribers.h"
#include "tests/e2e/nats/stage.h"
#include "tests/e2e/nats/tcp_relay.h"

namespace styled::bench {
namespace {

using namespace support;

struct Options {
  int performers = 16, viewers = 20, rounds = 3, extra = 0, delay_ms = 0;
  double seconds = 8;
  std::string hang_port;
};

constexpr const char* kFrames = "styled.hall.*.canonical";

std::vector<std::string> Names(int performers) {
  std::vector<std::string> names;
  for (int i = 0; i < performers; ++i) names.push_back("a" + std::to_string(i));
  return names;
}

// The same frames as kFrames, on ZeroMQ.
std::vector<std::string> Topics(int performers) {
  std::vector<std::string> topics;
  for (const std::string& name : Names(performers)) {
    topics.push_back("styled/rig." + name + "/canonical/");
  }
  return topics;
}

std::string PortOf(const std::string& endpoint) { return endpoint.substr(endpoint.rfind(':') + 1); }

double Cpu_s(const Child& child) {
  std::ifstream stat("/proc/" + std::to_string(child.pid()) + "/stat");
  std::string text;
  std::getline(stat, text);
  std::istringstream fields(text.substr(text.rfind(')') + 2));
  std::string skipped;
  for (int i = 0; i < 11; ++i) fields >> skipped;
  double user = 0, system = 0;
  fields >> user >> system;
  return (user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

void Add(RawResult& to, const RawResult& result) {
  to.delivered += result.delivered;
  to.lost += result.lost;
  to.doubled += result.doubled;
  to.latency_ms.insert(to.latency_ms.end(), result.latency_ms.begin(), result.latency_ms.end());
  std::sort(to.latency_ms.begin(), to.latency_ms.end());
}

void Header() {
  double load[1] = {};
  getloadavg(load, 1);
  std::printf("load %.1f\n", load[0]);
  std::printf("%-44s %10s %7s %7s %9s %9s %9s\n", "", "delivered", "lost", "doubled", "p50 ms",
              "p99 ms", "max ms");
}

void Row(const std::string& what, const RawResult& r) {
  std::printf("%-44s %10llu %7llu %7llu %9.3f %9.3f %9.3f\n", what.c_str(),
              static_cast<unsigned long long>(r.delivered), static_cast<unsigned long long>(r.lost),
              static_cast<unsigned long long>(r.doubled), r.Quantile_ms(0.5), r.Quantile_ms(0.99),
              r.Quantile_ms(1));
  std::fflush(stdout);
}

std::unique_ptr<RawSubscribers> Connect(const RawOptions& options) {
  auto subscribers = std::make_unique<RawSubscribers>(options);
  if (subscribers->ok()) return subscribers;
  throw std::runtime_error(subscribers->error());
}

std::unique_ptr<RawSubscribers> Local(const Daemon& daemon, int performers, int count) {
  return Connect({Wire::kZmtp, PortOf(daemon.publish), "", Topics(performers), count});
}

std::unique_ptr<RawSubscribers> Viewers(const std::string& port, int count,
                                        const std::string& user = "viewer") {
  return Connect({Wire::kNats, port, user, {kFrames}, count});
}

// Until frames come to all, and a second more.
void Settle(const RawSubscribers& subscribers, int count, int performers) {
  const std::uint64_t before = subscribers.frames();
  const auto enough = static_cast<std::uint64_t>(30 * count * performers);
  if (!WaitUntil([&] { return subscribers.frames() >= before + enough; }, 60)) {
    throw std::runtime_error("no frames came");
  }
  Sleep(1);
}

// A daemon with performers, before the servers.
struct Hall {
  explicit Hall(const Options& o)
      : walker(daemon, Names(o.performers), static_cast<std::size_t>(o.extra)) {}
  Daemon daemon;
  Walker walker;
};

// Whether the bucket shows that the first performer has the style. It waits 0.2 s at most: a stream
// without a leader does not answer.
bool HasStyle(const NatsUser& user, const std::string& style) {
  natsMsg* answer = nullptr;
  v1::PerformerStats performer;
  const char* const subject = "$JS.API.DIRECT.GET.KV_styled.$KV.styled.hall.performer.rig=2Ea0";
  if (natsConnection_RequestString(&answer, user.get(), subject, "", 200) != NATS_OK) return false;
  const bool parsed =
      performer.ParseFromArray(natsMsg_GetData(answer), natsMsg_GetDataLength(answer));
  natsMsg_Destroy(answer);
  return parsed && performer.look().mix_size() == 1 && performer.look().mix(0).style() == style;
}

// The same viewers, each of all performers, at the daemon and at the hub in turn.
int FanOut(const Options& o) {
  const Hall hall(o);
  RawResult zeromq, nats;
  double zeromq_s = 0, hub_s = 0, others_s = 0, daemon_s = 0;
  long replaced = 0;
  for (int round = 0; round < o.rounds; ++round) {
    {
      const auto local = Local(hall.daemon, o.performers, o.viewers);
      Settle(*local, o.viewers, o.performers);
      zeromq_s -= Cpu_s(*hall.daemon.child);
      local->Begin();
      Sleep(o.seconds);
      zeromq_s += Cpu_s(*hall.daemon.child);
      Add(zeromq, local->Collect());
    }
    NatsServers servers;
    servers.StartHub();
    servers.StartLeaf();
    const Stylenats bridge(hall.daemon, servers.leaf_port);
    const auto viewers = Viewers(servers.hub_port, o.viewers);
    Settle(*viewers, o.viewers, o.performers);
    hub_s -= Cpu_s(*servers.hub);
    daemon_s -= Cpu_s(*hall.daemon.child);
    others_s -= Cpu_s(*servers.leaf) + Cpu_s(*bridge.child);
    viewers->Begin();
    Sleep(o.seconds);
    hub_s += Cpu_s(*servers.hub);
    daemon_s += Cpu_s(*hall.daemon.child);
    others_s += Cpu_s(*servers.leaf) + Cpu_s(*bridge.child);
    Add(nats, viewers->Collect());
    replaced += bridge.Count("replaced,");
  }
  const double all_s = o.seconds * o.rounds;
  std::printf("%d performers, %d viewers of each, %d rounds of %.0f s\n", o.performers, o.viewers,
              o.rounds, o.seconds);
  Header();
  Row("ZeroMQ, at the daemon", zeromq);
  Row("NATS, at the hub", nats);
  std::printf("p50 %.2f, p99 %.2f times ZeroMQ's; replaced in stylenats %ld\n",
              nats.Quantile_ms(0.5) / zeromq.Quantile_ms(0.5),
              nats.Quantile_ms(0.99) / zeromq.Quantile_ms(0.99), replaced);
  std::printf(
      "CPU, %% of a core: daemon alone %.0f; daemon %.0f, hub %.0f, leaf and stylenats %.0f\n",
      100 * zeromq_s / all_s, 100 * daemon_s / all_s, 100 * hub_s / all_s, 100 * others_s / all_s);
  return 0;
}

// The number behind "KEY": in what a hub's monitoring says.
long Monitored(const std::string& port, const std::string& path, const std::string& key) {
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(std::stoi(port)));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::string said;
  const std::string request = "GET " + path + " HTTP/1.0\r\n\r\n";
  if (connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
      send(fd, request.data(), request.size(), MSG_NOSIGNAL) > 0) {
    char buffer[4096];
    for (ssize_t size = 0; (size = recv(fd, buffer, sizeof buffer, 0)) > 0;) {
      said.append(buffer, static_cast<std::size_t>(size));
    }
  }
  close(fd);
  const std::size_t at = said.find("\"" + key + "\":");
  return at == std::string::npos ? -1 : std::stol(said.substr(at + key.size() + 3));
}

// One more viewer, in a process of its own, is stopped.
int Stopped(const Options& o) {
  const Hall hall(o);
  NatsServers servers;
  const std::string monitor = FreePort();
  servers.Edit("hub", "# http: 127.0.0.1:8223", "http: 127.0.0.1:" + monitor);
  servers.StartHub();
  servers.StartLeaf();
  const Stylenats bridge(hall.daemon, servers.leaf_port);
  const auto local = Local(hall.daemon, o.performers, 4);
  const auto viewers = Viewers(servers.hub_port, o.viewers);
  TemporaryFolder folder;
  const Child hung({"/proc/self/exe", "hang", "--port", servers.hub_port}, folder / "log.txt");
  Settle(*viewers, o.viewers, o.performers);
  const auto measure = [&](const std::string& when, double seconds) {
    local->Begin();
    viewers->Begin();
    Sleep(seconds);
    RawResult of_viewers = viewers->Collect(0.5);
    Row("ZeroMQ, 4 at the daemon, " + when, local->Collect(0));
    Row("NATS, the other viewers, " + when, of_viewers);
    return of_viewers;
  };
  std::printf("%d performers, %d viewers and one that is stopped\n", o.performers, o.viewers);
  Header();
  measure("before", o.seconds);
  const long slow = Monitored(monitor, "/varz", "slow_consumers");
  hung.Signal(SIGSTOP);
  const std::int64_t begin_ns = Monotonic_ns();
  double cut_s = 0;
  std::jthread watch([&](const std::stop_token& stop) {
    while (!stop.stop_requested() && cut_s == 0) {
      if (servers.Log().find("Slow Consumer") != std::string::npos) {
        cut_s = 1e-9 * static_cast<double>(Monotonic_ns() - begin_ns);
      }
      Sleep(0.02);
    }
  });
  const RawResult during = measure("stopped", 2 * o.seconds);
  watch = {};
  std::printf("the stopped one was cut %.1f s after SIGSTOP; slow_consumers %ld -> %ld\n", cut_s,
              slow, Monitored(monitor, "/varz", "slow_consumers"));
  std::printf("worst of the others in each second, ms:");
  for (const auto& [second, ms] : during.worst_ms) std::printf(" %.1f", static_cast<double>(ms));
  std::printf("\nreplaced in stylenats %ld, its slow calls %ld\n", bridge.Count("replaced,"),
              bridge.Count("slow calls"));
  hung.Signal(SIGKILL);
  return 0;
}

// How long until a style that was set is in the bucket, and until frames come; "new" ones.
struct Back {
  double frames_s = -1, bucket_s = -1;
};

// A stage whose link between leaf server and hub can be cut.
struct Site {
  explicit Site(const Options& o)
      : hall(o), relay(servers.hub_leaf_port, std::chrono::milliseconds(o.delay_ms)) {
    // Or the leaf server learns the hub's own address and goes past the relay.
    servers.Edit("hub", "listen: 127.0.0.1:" + servers.hub_leaf_port,
                 "listen: 127.0.0.1:" + servers.hub_leaf_port +
                     "\n  advertise: \"127.0.0.1:" + relay.port + "\"");
    servers.leaf_reaches = relay.port;
  }
  void Start() {
    servers.StartHub();
    servers.StartLeaf();
    bridge = std::make_unique<Stylenats>(hall.daemon, servers.leaf_port);
  }
  Hall hall;
  NatsServers servers;
  TcpRelay relay;
  std::unique_ptr<Stylenats> bridge;
};

int Failures(const Options& o) {
  Site site(o);
  site.Start();
  NatsServers& servers = site.servers;
  const auto local = Local(site.hall.daemon, o.performers, 4);
  auto viewers = Viewers(servers.hub_port, 4);
  ControlClient control(site.hall.daemon.control);
  Settle(*viewers, 4, o.performers);
  std::printf("%d performers, 4 viewers of each engine, %d ms each way between leaf and hub\n",
              o.performers, o.delay_ms);
  Header();
  local->Begin();
  viewers->Begin();
  Sleep(o.seconds);
  Row("ZeroMQ, nothing amiss", local->Collect());
  Row("NATS, nothing amiss", viewers->Collect(0));

  int styles = 0;
  const auto trouble = [&](const std::string& what, double seconds, const auto& begin,
                           const auto& end, bool hub_gone = false) {
    local->Begin();
    if (!hub_gone) viewers->Begin();
    Sleep(0.5);
    begin();
    const std::string style = "style" + std::to_string(1 + styles++ % 2);
    control.SetStyle("rig.a0", style);
    Sleep(seconds);
    end();
    const std::int64_t end_ns = Monotonic_ns();
    const auto since_s = [end_ns] { return 1e-9 * static_cast<double>(Monotonic_ns() - end_ns); };
    if (hub_gone) {
      viewers = Viewers(servers.hub_port, 4);
      viewers->Begin();
    }
    Back back;
    if (WaitUntil([&] { return viewers->last_ns() > end_ns; }, 30)) back.frames_s = since_s();
    {
      NatsUser user(servers.hub_port, "viewer");
      if (WaitUntil([&] { return HasStyle(user, style); }, 30)) back.bucket_s = since_s();
    }
    Sleep(2);
    Row("ZeroMQ, " + what, local->Collect());
    Row("NATS, " + what, viewers->Collect(0));
    std::printf("  back after %.2f s, the bucket %.2f s\n", back.frames_s, back.bucket_s);
  };
  const auto nothing = [] {};
  trouble(
      "hub killed, 2 s", 2,
      [&] {
        servers.hub->Signal(SIGKILL);
        servers.hub->Wait(5);
      },
      [&] { servers.StartHub(); }, true);
  trouble(
      "leaf killed, 2 s", 2,
      [&] {
        servers.leaf->Signal(SIGKILL);
        servers.leaf->Wait(5);
      },
      [&] { servers.StartLeaf(); });
  trouble(
      "leaf stands still, 5 s", 5, [&] { servers.leaf->Signal(SIGSTOP); },
      [&] { servers.leaf->Signal(SIGCONT); });
  trouble(
      "hub stands still, 5 s", 5, [&] { servers.hub->Signal(SIGSTOP); },
      [&] { servers.hub->Signal(SIGCONT); }, true);
  trouble(
      "link silent, 5 s", 5, [&] { site.relay.Set(TcpRelay::State::kSilent); },
      [&] { site.relay.Set(TcpRelay::State::kUp); });
  trouble(
      "link closed, 5 s", 5, [&] { site.relay.Set(TcpRelay::State::kClosed); },
      [&] { site.relay.Set(TcpRelay::State::kUp); });
  trouble("nothing, 1 s", 1, nothing, nothing);
  std::printf("%s\n", site.bridge->Counters().c_str());
  return 0;
}

// Makes a stream in files, `take`, of all frames. `owner` is the user bridge.
bool KeepFrames(const NatsUser& owner) {
  jsCtx* jetstream = nullptr;
  const char* subject = "styled.>";
  jsStreamConfig config;
  jsStreamConfig_Init(&config);
  config.Name = "take";
  config.Subjects = &subject;
  config.SubjectsLen = 1;
  config.Storage = js_FileStorage;
  config.NoAck = true;
  const bool made = natsConnection_JetStream(&jetstream, owner.get(), nullptr) == NATS_OK &&
                    js_AddStream(nullptr, jetstream, &config, nullptr, nullptr) == NATS_OK;
  jsCtx_Destroy(jetstream);
  return made;
}

// The hub's JetStream folder is a file system of 2 MB, which a stream of all frames fills.
int DiskFull(const Options& o) {
  const Hall hall(o);
  NatsServers servers;
  std::filesystem::create_directories(servers.Folder());
  servers.hub_under = OnSmallDisk(servers.Folder(), false);
  servers.StartHub();
  servers.StartLeaf();
  const Stylenats bridge(hall.daemon, servers.leaf_port);
  const auto local = Local(hall.daemon, o.performers, 4);
  const auto viewers = Viewers(servers.hub_port, 4);
  ControlClient control(hall.daemon.control);
  Settle(*viewers, 4, o.performers);
  Header();
  local->Begin();
  viewers->Begin();
  {
    const NatsUser owner(servers.hub_port, "bridge");
    if (!KeepFrames(owner)) std::cerr << "no stream\n";
  }
  Sleep(o.seconds);
  Row("ZeroMQ, the disk is full", local->Collect());
  Row("NATS, the disk is full", viewers->Collect(0));
  control.SetStyle("rig.a0", "style1");
  NatsUser user(servers.hub_port, "viewer");
  const bool kept = WaitUntil([&] { return HasStyle(user, "style1"); }, 10);
  std::printf("the bucket takes a new style: %s\n", kept ? "yes" : "no");
  std::istringstream lines(servers.Log());
  for (std::string line; std::getline(lines, line);) {
    if (line.find("space") != std::string::npos || line.find("DISABLED") != std::string::npos) {
      std::printf("%s\n", line.c_str());
      break;
    }
  }
  std::printf("%s\n", bridge.Counters().c_str());
  return 0;
}

// Three hubs as a cluster, with a bucket and a stream in files of three replicas.
class Cluster {
 public:
  Cluster() {
    std::string routes, leafs;
    const auto add = [](std::string& list, const std::string& url) {
      list += (list.empty() ? "\"" : ", \"") + url + "\"";
    };
    for (std::string& port : ports_) add(routes, "nats://127.0.0.1:" + (port = FreePort()));
    for (int i = 0; i < kHubs; ++i) {
      hubs[i].Edit("hub", "server_name: styled_hub",
                   "server_name: " + Name(i) + "\ncluster { name: hubs, listen: \"127.0.0.1:" +
                       ports_[i] + "\", routes: [" + routes + "] }");
      add(leafs, "nats://leaf:leafword@127.0.0.1:" + hubs[i].hub_leaf_port);
    }
    hubs[0].Edit("leaf", "{ url: $STYLED_NATS_HUB }", "{ urls: [" + leafs + "] }");
    for (NatsServers& hub : hubs) hub.StartHub();
    hubs[0].StartLeaf();
    const NatsUser owner(hubs[0].hub_port, "bridge");
    jsCtx* jetstream = nullptr;
    natsConnection_JetStream(&jetstream, owner.get(), nullptr);
    // Until there is a leader of all, nothing can be made.
    if (!WaitUntil([&] { return Make(jetstream); }, 30)) throw std::runtime_error("no cluster");
    jsCtx_Destroy(jetstream);
  }
  // The hub that leads the stream.
  int Leader(int ask, const std::string& stream) {
    const NatsUser owner(hubs[ask].hub_port, "bridge");
    jsCtx* jetstream = nullptr;
    jsStreamInfo* info = nullptr;
    natsConnection_JetStream(&jetstream, owner.get(), nullptr);
    int leader = -1;
    if (js_GetStreamInfo(&info, jetstream, stream.c_str(), nullptr, nullptr) == NATS_OK &&
        info->Cluster != nullptr && info->Cluster->Leader != nullptr) {
      for (int i = 0; i < kHubs; ++i) leader = Name(i) == info->Cluster->Leader ? i : leader;
    }
    jsStreamInfo_Destroy(info);
    jsCtx_Destroy(jetstream);
    return leader;
  }
  static constexpr int kHubs = 3;
  static constexpr const char* kStream = "bench";
  std::array<NatsServers, kHubs> hubs;

 private:
  static std::string Name(int i) { return "hub" + std::to_string(i); }
  static bool Make(jsCtx* jetstream) {
    kvStore* bucket = nullptr;
    kvConfig values;
    kvConfig_Init(&values);
    values.Bucket = "styled";
    values.StorageType = js_MemoryStorage;
    values.MaxBytes = std::int64_t{64} << 20U;
    values.Replicas = kHubs;
    const bool made = js_CreateKeyValue(&bucket, jetstream, &values) == NATS_OK;
    kvStore_Destroy(bucket);
    if (!made) return false;
    const char* subject = "styled.bench.>";
    jsStreamConfig config;
    jsStreamConfig_Init(&config);
    config.Name = kStream;
    config.Subjects = &subject;
    config.SubjectsLen = 1;
    config.Storage = js_FileStorage;
    config.MaxBytes = 1 << 20;
    config.Replicas = kHubs;
    return WaitUntil(
        [&] { return js_AddStream(nullptr, jetstream, &config, nullptr, nullptr) == NATS_OK; }, 10);
  }
  std::array<std::string, kHubs> ports_;
};

// Kills the server that leads the bucket, or the stream, and starts it again.
int LeaderKilled(const Options& o) {
  const Hall hall(o);
  Cluster cluster;
  const Stylenats bridge(hall.daemon, cluster.hubs[0].leaf_port);
  const auto local = Local(hall.daemon, o.performers, 4);
  ControlClient control(hall.daemon.control);
  std::printf("%d performers, 3 hubs, 3 replicas\n", o.performers);
  Header();
  int alive = 0, styles = 0;
  for (int i = 0; i < 2 * o.rounds; ++i) {
    const std::string stream = i % 2 == 0 ? "KV_styled" : Cluster::kStream;
    int leader = -1;
    WaitUntil([&] { return (leader = cluster.Leader(alive, stream)) >= 0; }, 20);
    if (leader < 0) throw std::runtime_error("no leader of " + stream);
    alive = (leader + 1) % Cluster::kHubs;
    const auto viewers = Viewers(cluster.hubs[alive].hub_port, 4);
    Settle(*viewers, 4, o.performers);
    NatsUser user(cluster.hubs[alive].hub_port, "viewer");
    const NatsUser owner(cluster.hubs[alive].hub_port, "bridge");
    jsCtx* jetstream = nullptr;
    natsConnection_JetStream(&jetstream, owner.get(), nullptr);
    local->Begin();
    viewers->Begin();
    NatsServers& killed = cluster.hubs[leader];
    killed.hub->Signal(SIGKILL);
    killed.hub->Wait(5);
    const std::int64_t begin_ns = Monotonic_ns();
    const auto since_s = [begin_ns] {
      return 1e-9 * static_cast<double>(Monotonic_ns() - begin_ns);
    };
    const std::string style = "style" + std::to_string(1 + styles++ % 2);
    control.SetStyle("rig.a0", style);
    double frames_s = -1, bucket_s = -1, stream_s = -1;
    jsPubOptions publish;
    jsPubOptions_Init(&publish);
    publish.MaxWait = 200;
    WaitUntil(
        [&] {
          if (frames_s < 0 && viewers->last_ns() > begin_ns) frames_s = since_s();
          if (bucket_s < 0 && HasStyle(user, style)) bucket_s = since_s();
          if (stream_s < 0 && js_Publish(nullptr, jetstream, "styled.bench.x", "x", 1, &publish,
                                         nullptr) == NATS_OK) {
            stream_s = since_s();
          }
          return frames_s >= 0 && bucket_s >= 0 && stream_s >= 0;
        },
        40);
    jsCtx_Destroy(jetstream);
    Row("ZeroMQ, leader of " + stream + " killed", local->Collect());
    Row("NATS, leader of " + stream + " killed", viewers->Collect(0));
    std::printf("  frames after %.2f s, bucket %.2f s, stream %.2f s\n", frames_s, bucket_s,
                stream_s);
    killed.StartHub();
    Sleep(4);
  }
  return 0;
}

// stylenats at the hub itself, and through a leaf server, in turn.
int Hop(const Options& o) {
  const Hall hall(o);
  RawResult zeromq, direct, leaf;
  for (int round = 0; round < o.rounds; ++round) {
    for (const bool through : {false, true}) {
      NatsServers servers;
      servers.StartHub();
      if (through) servers.StartLeaf();
      const Stylenats bridge(
          hall.daemon, through ? servers.leaf_port : servers.hub_port,
          through ? std::vector<std::string>{"--domain", "hub"} : std::vector<std::string>{});
      const auto local = Local(hall.daemon, o.performers, 1);
      const auto viewers = Viewers(servers.hub_port, o.viewers);
      Settle(*viewers, o.viewers, o.performers);
      local->Begin();
      viewers->Begin();
      Sleep(o.seconds);
      Add(through ? leaf : direct, viewers->Collect());
      Add(zeromq, local->Collect(0));
    }
  }
  std::printf("%d performers, %d viewers, %d rounds of %.0f s\n", o.performers, o.viewers, o.rounds,
              o.seconds);
  Header();
  Row("ZeroMQ, 1 at the daemon", zeromq);
  Row("NATS, stylenats at the hub", direct);
  Row("NATS, through the leaf server", leaf);
  std::printf("the hop: p50 %.3f ms, p99 %.3f ms\n",
              leaf.Quantile_ms(0.5) - direct.Quantile_ms(0.5),
              leaf.Quantile_ms(0.99) - direct.Quantile_ms(0.99));
  return 0;
}

// A viewer that is to be stopped.
int Hang(const Options& o) {
  const auto viewer = Viewers(o.hang_port, 1);
  Sleep(3600);
  return 0;
}

}  // namespace
}  // namespace styled::bench

int main(int argc, char** argv) {
  styled::bench::Options o;
  rlimit files{};
  getrlimit(RLIMIT_NOFILE, &files);
  files.rlim_cur = files.rlim_max;
  setrlimit(RLIMIT_NOFILE, &files);
  CLI::App app{"Viewers by NATS beside subscribers of the daemon, in rows of one run each"};
  app.require_subcommand(1);
  app.option_defaults()->always_capture_default();
  const auto row = [&app, &o](const std::string& name, const std::string& text) {
    CLI::App* const command = app.add_subcommand(name, text);
    command->add_option("--performers", o.performers, "at 120 Hz");
    command->add_option("--viewers", o.viewers, "each of all performers");
    command->add_option("--rounds", o.rounds, "of both engines, or ways, in turn");
    command->add_option("--seconds", o.seconds, "of each round");
    command->add_option("--extra", o.extra, "bytes that each frame carries beside the pose");
    command->add_option("--delay", o.delay_ms, "between leaf server and hub, ms each way");
    return command;
  };
  const auto* const fan_out = row("fanout", "many viewers, at the daemon and at the hub in turn");
  const auto* const stopped = row("stopped", "a viewer is stopped (SIGSTOP)");
  const auto* const failures = row("failures", "servers killed and stopped, the link cut");
  const auto* const disk = row("disk", "the hub's disk is full (mounts: root)");
  const auto* const hop = row("hop", "what the leaf server costs");
  const auto* const cluster = row("cluster", "the server that leads a replicated bucket is killed");
  CLI::App* const hang = app.add_subcommand("hang", "a viewer, for `stopped`");
  hang->add_option("--port", o.hang_port);
  CLI11_PARSE(app, argc, argv);
  using namespace styled::bench;
  try {
    if (fan_out->parsed()) return FanOut(o);
    if (stopped->parsed()) return Stopped(o);
    if (failures->parsed()) return Failures(o);
    if (disk->parsed()) return DiskFull(o);
    if (hop->parsed()) return Hop(o);
    if (cluster->parsed()) return LeaderKilled(o);
    return Hang(o);
  } catch (const std::runtime_error& error) {
    std::cerr << error.what() << "\n";
    return 1;
  }
}
