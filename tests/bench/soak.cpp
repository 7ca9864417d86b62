// A stage for hours: a pair of daemons, a stylenats and a leaf server, a hub, a hundred viewers
// there and a program beside the daemons. A viewer is stopped at a third of the time, the leading
// daemon is killed at five sixths. Prints each process's memory, and the frames that are missing
// without being counted. No assertions.
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <cstdio>
#include <fstream>
#include <iostream>

#include "clients/cpp/subscriber.h"
#include "tests/e2e/nats/raw_subscribers.h"
#include "tests/e2e/nats/stage.h"

namespace styled::bench {
namespace {

using namespace support;

struct Options {
  int performers = 4, viewers = 100;
  double minutes = 60;
};

// Rigs that send to both daemons, at 120 Hz.
class Rigs {
 public:
  Rigs(int count, const std::vector<std::string>& addresses)
      : thread_([=](const std::stop_token& stop) {
          std::vector<std::unique_ptr<UdpLink>> links;
          for (const auto& to : addresses) links.push_back(std::make_unique<UdpLink>(to));
          std::vector<Rig> rigs;
          for (int i = 0; i < count; ++i) rigs.emplace_back("a" + std::to_string(i));
          auto due = std::chrono::steady_clock::now();
          for (int tick = 0; !stop.stop_requested(); ++tick) {
            for (Rig& rig : rigs) {
              const Bytes body = tick % 120 == 0 ? rig.Body() : Bytes();
              const Bytes frame = rig.Frame();
              for (const auto& link : links) {
                if (!body.empty()) link->Send(body);
                link->Send(frame);
              }
            }
            due += std::chrono::nanoseconds(1'000'000'000 / 120);
            std::this_thread::sleep_until(due);
          }
        }) {}

 private:
  std::jthread thread_;
};

// The shipped client at both daemons.
class Program {
 public:
  explicit Program(const std::vector<std::string>& endpoints) {
    client::SubscriberOptions options;
    options.endpoints = endpoints;
    auto subscriber = client::Subscriber::Connect(options);
    if (!subscriber.ok()) throw std::runtime_error(subscriber.status().message());
    thread_ =
        std::jthread([this, from = std::move(subscriber.value())](const std::stop_token& stop) {
          client::Update update;
          while (!stop.stop_requested()) {
            if (!from->Receive(std::chrono::milliseconds(50), update)) continue;
            if (update.kind != client::Update::Kind::kFrame) continue;
            ++frames;
            missed += update.missed;
            epochs += update.new_epoch ? 1 : 0;
          }
        });
  }
  std::atomic<std::uint64_t> frames{0}, missed{0}, epochs{0};

 private:
  std::jthread thread_;
};

// The memory of a process over time.
class Memory {
 public:
  Memory(std::string name, pid_t pid) : name_(std::move(name)), pid_(pid) {}
  void Sample(double minute) {
    std::ifstream statm("/proc/" + std::to_string(pid_) + "/statm");
    double size = 0, resident = 0;
    if (statm >> size >> resident && resident > 0) {
      samples_.emplace_back(minute, resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6);
    }
  }
  // Of the samples from `from` minutes on, by least squares.
  void Print(double from) const {
    double n = 0, x = 0, y = 0, xx = 0, xy = 0;
    for (const auto& [minute, mb] : samples_) {
      if (minute < from) continue;
      n += 1, x += minute, y += mb, xx += minute * minute, xy += minute * mb;
    }
    const double spread = n * xx - x * x;
    const double slope = spread > 0 ? 60 * (n * xy - x * y) / spread : 0;
    std::printf("%-28s %8.1f %8.1f %10.2f\n", name_.c_str(),
                samples_.empty() ? 0 : samples_.front().second,
                samples_.empty() ? 0 : samples_.back().second, slope);
  }

 private:
  std::string name_;
  pid_t pid_;
  std::vector<std::pair<double, double>> samples_;  // minutes, MB
};

std::string PairOf(const std::string& journal, int own) {
  return "[standby]\naddress = \"ipc://" + journal + std::to_string(own) + "\"\npeer = \"ipc://" +
         journal + std::to_string(1 - own) + "\"\nfirst = " + (own == 0 ? "true" : "false") + "\n";
}

int Run(const Options& o) {
  const TemporaryFolder folder;
  const std::string journal = folder / "journal";
  NatsServers servers;
  servers.StartHub();
  servers.StartLeaf();
  Daemon leader({}, PairOf(journal, 0)), standby({}, PairOf(journal, 1));
  const auto bridge_of = [&](const Daemon& daemon) {
    return std::make_unique<Stylenats>(daemon, servers.leaf_port);
  };
  const auto leaders = bridge_of(leader), standbys = bridge_of(standby);
  const Rigs rigs(o.performers, {leader.udp, standby.udp});
  const Program program({leader.publish, standby.publish});
  RawOptions viewing{
      Wire::kNats, servers.hub_port, "viewer", {"styled.hall.*.canonical"}, o.viewers};
  RawSubscribers viewers(viewing);
  if (!viewers.ok()) throw std::runtime_error(viewers.error());
  std::unique_ptr<RawSubscribers> stopped;
  std::vector<Memory> memories{{"leading daemon", leader.child->pid()},
                               {"standby", standby.child->pid()},
                               {"leader's stylenats", leaders->child->pid()},
                               {"standby's stylenats", standbys->child->pid()},
                               {"leaf server", servers.leaf->pid()},
                               {"hub", servers.hub->pid()}};
  Sleep(10);
  const std::int64_t begin_ns = Monotonic_ns();
  const auto minute = [&] { return static_cast<double>(Monotonic_ns() - begin_ns) / 6e10; };
  std::uint64_t delivered = 0, lost = 0, doubled = 0;
  double p99_ms = 0, worst_ms = 0;
  bool killed = false;
  int styles = 0;
  while (minute() < o.minutes) {
    const bool kill = !killed && minute() >= o.minutes * 5 / 6;
    if (!stopped && minute() >= o.minutes / 3) {
      RawOptions one = viewing;
      one.count = 1;
      one.stopped = true;
      stopped = std::make_unique<RawSubscribers>(one);
    }
    viewers.Begin();
    if (kill) leader.child->Signal(SIGKILL);
    killed = killed || kill;
    for (int part = 0; part < 3; ++part) {
      Sleep(kill ? 5 : 9.5);
      ControlClient(killed ? standby.control : leader.control)
          .SetStyle("rig.a0", "style" + std::to_string(1 + styles++ % 4));
      for (Memory& memory : memories) memory.Sample(minute());
    }
    const RawResult result = viewers.Collect();
    delivered += result.delivered;
    lost += result.lost;
    doubled += result.doubled;
    p99_ms = std::max(p99_ms, result.Quantile_ms(0.99));
    worst_ms = std::max(worst_ms, result.Quantile_ms(1));
    std::printf("%5.1f min: program %llu frames, missed %llu; viewers %llu, lost %llu%s\n",
                minute(), static_cast<unsigned long long>(program.frames),
                static_cast<unsigned long long>(program.missed),
                static_cast<unsigned long long>(delivered), static_cast<unsigned long long>(lost),
                kill ? "; the leader was killed" : "");
    std::fflush(stdout);
  }
  std::printf("%.0f minutes, %d performers, %d viewers\n", minute(), o.performers, o.viewers);
  std::printf("%-28s %8s %8s %10s\n", "", "MB first", "MB last", "MB/h");
  for (const Memory& memory : memories) memory.Print(o.minutes / 6);
  std::printf("program beside the daemons: %llu frames, %llu missed, %llu epochs\n",
              static_cast<unsigned long long>(program.frames),
              static_cast<unsigned long long>(program.missed),
              static_cast<unsigned long long>(program.epochs));
  std::printf(
      "viewers by NATS: %llu frames, %llu lost, %llu doubled; in the worst half minute p99 "
      "%.1f ms, at most %.1f ms\n",
      static_cast<unsigned long long>(delivered), static_cast<unsigned long long>(lost),
      static_cast<unsigned long long>(doubled), p99_ms, worst_ms);
  std::printf("leader's stylenats: %s\nstandby's: %s\n", leaders->Counters().c_str(),
              standbys->Counters().c_str());
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
  CLI::App app{"A stage with a standby and viewers by NATS for hours: memory and missing frames"};
  app.option_defaults()->always_capture_default();
  app.add_option("--minutes", o.minutes);
  app.add_option("--performers", o.performers, "at 120 Hz");
  app.add_option("--viewers", o.viewers, "by NATS, each of all performers");
  CLI11_PARSE(app, argc, argv);
  try {
    return styled::bench::Run(o);
  } catch (const std::runtime_error& error) {
    std::cerr << error.what() << "\n";
    return 1;
  }
}
