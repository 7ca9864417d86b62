// styled_abuse --minutes 60: a pair of daemons, sixteen performers at 120 Hz, a program that
// subscribes to both, and all attacks of attacks.h in turn, with noise at the sources; with --kill
// also kill -9 of the leader once a minute. Prints the losses, the longest time without a sign of
// life, how long both led, and the growth of memory. Exit code 1: a bound is broken.
#include <signal.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <random>

#include "clients/cpp/subscriber.h"
#include "tests/e2e/examples.h"
#include "tests/hostile/attacks.h"
#include "tests/hostile/stage.h"

namespace {

using namespace styled;
using hostile::Clock;
using support::Sleep;

double SecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

struct Sample {
  double hours, megabytes;
};

constexpr double kMostSlope_mb_h = 1;

// Megabytes an hour, by least squares.
double Slope(const std::vector<Sample>& samples) {
  double hours = 0, megabytes = 0, both = 0, squares = 0;
  for (const Sample& sample : samples) {
    hours += sample.hours / static_cast<double>(samples.size());
    megabytes += sample.megabytes / static_cast<double>(samples.size());
  }
  for (const Sample& sample : samples) {
    both += (sample.hours - hours) * (sample.megabytes - megabytes);
    squares += (sample.hours - hours) * (sample.hours - hours);
  }
  return squares > 0 ? both / squares : 0;
}

double ResidentMegabytes(pid_t pid) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  std::string line;
  while (std::getline(status, line)) {
    if (line.starts_with("VmRSS:")) return std::stod(line.substr(6)) / 1024;
  }
  return 0;
}

// A daemon of the pair, under a service manager of its own.
struct Member {
  hostile::ServiceManager manager;
  std::unique_ptr<support::Daemon> daemon;
  std::vector<Sample> memory;
  Clock::time_point since;  // its last start
  double silence_s = 0;

  void Note(double hours) {
    memory.push_back({hours, ResidentMegabytes(daemon->child->pid())});
    silence_s = std::max(silence_s, manager.LongestSilence_s(since));
    since = Clock::now();
    manager.Forget();
  }
};

class Pair {
 public:
  Pair() {
    const std::string weights = support::CausalWeights(folder_ / "weights.safetensors");
    for (int own = 0; own < 2; ++own) {
      auto& member = *(members_[static_cast<std::size_t>(own)] = std::make_unique<Member>());
      const std::string kept = folder_ / ("kept" + std::to_string(own));
      member.daemon = std::make_unique<support::Daemon>(
          std::vector<std::string>{"state.dir='" + kept + "/state'",
                                   "style.library='" + kept + "/library'"},
          hostile::StandbyTable(folder_, own),
          std::map<std::string, std::string>{{"NOTIFY_SOCKET", member.manager.path()},
                                             {"WATCHDOG_USEC", "10000000"}},
          weights);
      member.since = Clock::now();
    }
  }
  Member& member(int i) { return *members_[static_cast<std::size_t>(i)]; }
  int leader() {
    for (int i = 0; i < 2; ++i) {
      if (Role(i) == "leading") return i;
    }
    return -1;
  }
  std::string Role(int i) {
    support::ControlClient control(member(i).daemon->control);
    return RoleBy(control);
  }
  static std::string RoleBy(support::ControlClient& control) {
    control.SetPatience(2);
    return control.Status().stats().standby().role();
  }

 private:
  support::TemporaryFolder folder_;
  std::array<std::unique_ptr<Member>, 2> members_;
};

// Sixteen performers, for both daemons.
void Perform(Pair& pair, int performers, const std::stop_token& stop) {
  std::vector<support::Rig> rigs;
  for (int i = 0; i < performers; ++i) {
    rigs.emplace_back("performer" + std::to_string(i), 1000 + static_cast<std::uint64_t>(i));
  }
  const support::UdpLink first(pair.member(0).daemon->udp), second(pair.member(1).daemon->udp);
  auto due = Clock::now();
  for (int frame = 0; !stop.stop_requested(); ++frame) {
    for (int i = 0; i < performers; ++i) {
      auto& rig = rigs[static_cast<std::size_t>(i)];
      if ((frame + i) % 120 == 0 || frame == 0) {
        const auto body = rig.Body();
        first.Send(body);
        second.Send(body);
      }
      const auto bytes = rig.Frame();
      first.Send(bytes);
      second.Send(bytes);
    }
    due += std::chrono::nanoseconds(1'000'000'000 / 120);
    std::this_thread::sleep_until(due);
  }
}

void Attack(Pair& pair, const hostile::RequestAttack& attack, const hostile::Loot& loot,
            std::mt19937& random) {
  const int leader = std::max(pair.leader(), 0);
  const v1::Request request = attack.make(loot);
  std::vector<std::jthread> clients;
  for (int i = 0; i < 3; ++i) {
    clients.emplace_back([&pair, &request, leader] {
      support::ControlClient control(pair.member(leader).daemon->control);
      control.SetPatience(20);
      const auto begin = Clock::now();
      do {
        (void)control.Ask(request);
      } while (SecondsSince(begin) < 1);
    });
  }
  const support::UdpLink link(pair.member(leader).daemon->udp);
  const support::TcpLink stuck(pair.member(leader).daemon->tcp);
  for (int i = 0; i < 500; ++i) {
    support::Bytes noise(random() % 2000 + 1);
    for (std::byte& byte : noise) byte = static_cast<std::byte>(random());
    link.Send(noise);
    Sleep(0.002);
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Everything hostile at once, for as long as it takes.", "styled_abuse");
  double minutes = 60;
  int performers = 16;
  bool kill = false;
  app.add_option("--minutes", minutes)->capture_default_str();
  app.add_option("--performers", performers)->capture_default_str();
  app.add_flag("--kill", kill, "kill -9 of the leader once a minute");
  CLI11_PARSE(app, argc, argv);

  Pair pair;
  for (int i = 0; i < 300 && pair.Role(1) != "following"; ++i) Sleep(0.1);
  client::SubscriberOptions options;
  options.endpoints = {pair.member(0).daemon->publish, pair.member(1).daemon->publish};
  auto connected = client::Subscriber::Connect(options);
  if (!connected.ok()) return std::fprintf(stderr, "%s\n", connected.status().message().c_str()), 1;
  std::atomic<std::uint64_t> frames{0}, missed{0};
  std::jthread viewer([&](const std::stop_token& stop) {
    client::Update update;
    while (!stop.stop_requested()) {
      if (!connected.value()->Receive(std::chrono::milliseconds(20), update)) continue;
      if (update.kind != client::Update::Kind::kFrame) continue;
      ++frames;
      missed += update.missed;
    }
  });
  Sleep(1);
  std::jthread sender([&](const std::stop_token& stop) { Perform(pair, performers, stop); });
  Sleep(2);
  hostile::Loot loot = hostile::TakeLoot(*pair.member(0).daemon, "rig.performer0");
  const auto attacks = hostile::RequestAttacks();
  std::mt19937 random(1);
  double both_lead_s = 0;
  std::atomic<bool> watching{true};
  std::thread roles([&] {
    auto since = Clock::now();
    // Connected once: twenty new connections a second would be an attack of their own.
    support::ControlClient first(pair.member(0).daemon->control);
    support::ControlClient second(pair.member(1).daemon->control);
    while (watching) {
      if (Pair::RoleBy(first) != "leading" || Pair::RoleBy(second) != "leading") {
        since = Clock::now();
      }
      both_lead_s = std::max(both_lead_s, SecondsSince(since));
      Sleep(0.1);
    }
  });
  const auto begin = Clock::now();
  double noted_min = 0;
  int kills = 0;
  for (std::size_t round = 0; SecondsSince(begin) < 60 * minutes; ++round) {
    // Requests that move or lead a performer elsewhere, or are sent to a standby, are included.
    Attack(pair, attacks[random() % attacks.size()], loot, random);
    if (SecondsSince(begin) / 60 < noted_min + 1) continue;
    noted_min += 1;
    for (int i = 0; i < 2; ++i) pair.member(i).Note(SecondsSince(begin) / 3600);
    std::printf("%3.0f min: %llu frames, %llu missed, memory %.1f and %.1f MB\n", noted_min,
                static_cast<unsigned long long>(frames), static_cast<unsigned long long>(missed),
                pair.member(0).memory.back().megabytes, pair.member(1).memory.back().megabytes);
    std::fflush(stdout);
    const int leader = pair.leader();
    if (!kill || leader < 0) continue;
    pair.member(leader).daemon->child->Signal(SIGKILL);
    pair.member(leader).daemon->child->Wait(5);
    pair.member(leader).daemon->Start();
    pair.member(leader).memory.clear();
    pair.member(leader).since = Clock::now();
    ++kills;
  }
  watching = false;
  roles.join();
  Sleep(1);
  bool good = missed == 0 && both_lead_s < 2;
  std::printf(
      "%zu kinds of attack, %d kills: %llu frames, %llu missed; both led for %.1f s at most\n",
      attacks.size(), kills, static_cast<unsigned long long>(frames),
      static_cast<unsigned long long>(missed), both_lead_s);
  for (int i = 0; i < 2; ++i) {
    Member& member = pair.member(i);
    member.Note(SecondsSince(begin) / 3600);
    // The first half fills caches and the heaps of threads. After a kill there is too little left.
    std::vector<Sample> later(
        member.memory.begin() + static_cast<std::ptrdiff_t>(member.memory.size() / 2),
        member.memory.end());
    const double slope = Slope(later);
    std::printf(
        "daemon %d: no sign of life for %.2f s at most, memory %+.2f MB an hour (%.1f MB)\n", i,
        member.silence_s, slope, member.memory.back().megabytes);
    good = good && member.silence_s < 1 && (kill || slope <= kMostSlope_mb_h);
  }
  return good ? 0 : 1;
}
