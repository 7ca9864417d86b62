#include "tests/hostile/stage.h"

#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "tests/e2e/examples.h"

namespace styled::hostile {
namespace {

using support::Sleep;

double Seconds(Clock::duration duration) { return std::chrono::duration<double>(duration).count(); }

// A field of /proc/PID/status in bytes.
std::int64_t Memory(pid_t pid, const std::string& field) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  std::string line;
  while (std::getline(status, line)) {
    if (line.starts_with(field + ":")) return 1024 * std::stoll(line.substr(field.size() + 1));
  }
  return 0;
}

// From now on VmHWM is the peak since this call.
void ForgetPeak(pid_t pid) { std::ofstream("/proc/" + std::to_string(pid) + "/clear_refs") << 5; }

}  // namespace

std::string StandbyTable(const support::TemporaryFolder& folder, int own) {
  const auto address = [&folder](int which) {
    return "\"ipc://" + std::string(folder / ("journal" + std::to_string(which))) + "\"\n";
  };
  // A machine that runs other tests too stands still for longer than the usual 100 ms.
  return "[standby]\naddress = " + address(own) + "peer = " + address(1 - own) +
         "hold_ms = 1000\nfirst = " + (own == 0 ? "true" : "false") + "\n";
}

ServiceManager::ServiceManager()
    : thread_([this] {
        while (!stop_) {
          auto text = datagrams_.Next(0.05);
          if (!text) continue;
          const std::lock_guard lock(mutex_);
          heard_.push_back({Clock::now(), std::move(*text)});
        }
      }) {}

ServiceManager::~ServiceManager() {
  stop_ = true;
  thread_.join();
}

void ServiceManager::Forget() {
  const std::lock_guard lock(mutex_);
  heard_.clear();
}

double ServiceManager::LongestSilence_s(Clock::time_point since) const {
  const std::lock_guard lock(mutex_);
  Clock::duration longest{};
  Clock::time_point last = since;
  for (const Heard& heard : heard_) {
    if (heard.at < since || heard.text != "WATCHDOG=1") continue;
    longest = std::max(longest, heard.at - last);
    last = heard.at;
  }
  return Seconds(std::max(longest, Clock::now() - last));
}

double ServiceManager::Until_s(const std::string& text, Clock::time_point since,
                               double patience_s) const {
  while (true) {
    {
      const std::lock_guard lock(mutex_);
      for (const Heard& heard : heard_) {
        if (heard.at < since || heard.text.find(text) == std::string::npos) continue;
        return Seconds(heard.at - since);
      }
    }
    if (Seconds(Clock::now() - since) > patience_s) return patience_s;
    Sleep(0.01);
  }
}

Stage::Stage(const std::string& extra, std::vector<std::string> settings) {
  const std::string weights = support::CausalWeights(folder_ / "weights.safetensors");
  for (int own = 0; own < 2; ++own) {
    const std::string kept = folder_ / ("kept" + std::to_string(own));
    const std::map<std::string, std::string> manager{{"NOTIFY_SOCKET", manager_.path()},
                                                     {"WATCHDOG_USEC", "10000000"}};
    std::vector<std::string> all{"state.dir='" + kept + "/state'",
                                 "style.library='" + kept + "/library'"};
    all.insert(all.end(), settings.begin(), settings.end());
    daemons_.push_back(std::make_unique<support::Daemon>(
        all, StandbyTable(folder_, own) + extra,
        own == 0 ? manager : std::map<std::string, std::string>(), weights));
  }
  subscriber_ = std::make_unique<support::Subscriber>(
      daemon().publish, std::vector<std::string>{"body/", "styled/rig.victim/rig/"});
  threads_.emplace_back([this](const std::stop_token& stop) { Perform(stop); });
  threads_.emplace_back([this](const std::stop_token& stop) { WatchRoles(stop); });
  EXPECT_TRUE(subscriber_->WaitForBody());
  support::ControlClient control(daemon().control);
  EXPECT_EQ(control.SetStyle("rig.victim", "style1").code(), v1::CODE_OK) << daemon().Log();
}

Loot CollectLoot(const support::Daemon& daemon, const std::string& performer) {
  Loot loot;
  support::ControlClient control(daemon.control);
  v1::Request request;
  request.mutable_like()->set_name("loot");
  request.mutable_like()->set_clip(support::WalkBvh(60, 2));
  v1::Reply reply = control.Ask(request);
  EXPECT_EQ(reply.code(), v1::CODE_OK) << reply.reason();
  request.mutable_export_style()->set_name("loot");
  loot.style_file = control.Ask(request).style_file().file();
  EXPECT_FALSE(loot.style_file.empty());
  request.set_performer(performer);
  request.mutable_take_checkpoint();
  reply = control.Ask(request);
  EXPECT_EQ(reply.code(), v1::CODE_OK) << reply.reason();
  loot.checkpoint = reply.checkpoint();
  return loot;
}

Stage::~Stage() {
  for (auto& thread : threads_) thread.request_stop();
}

void Stage::Perform(const std::stop_token& stop) {
  support::Rig victim("victim", 4711);
  std::vector<std::unique_ptr<support::UdpLink>> links;
  for (const auto& daemon : daemons_) {
    links.push_back(std::make_unique<support::UdpLink>(daemon->udp));
  }
  auto due = Clock::now();
  for (int i = 0; !stop.stop_requested(); ++i) {
    const support::Bytes body = i % 120 == 0 ? victim.Body() : support::Bytes();
    const support::Bytes frame = victim.Frame();
    for (const auto& link : links) {
      if (!body.empty()) link->Send(body);
      link->Send(frame);
    }
    ++sent_;
    due += std::chrono::nanoseconds(1'000'000'000 / 120);
    std::this_thread::sleep_until(due);
  }
}

void Stage::WatchRoles(const std::stop_token& stop) {
  std::vector<std::unique_ptr<support::ControlClient>> controls;
  for (const auto& daemon : daemons_) {
    controls.push_back(std::make_unique<support::ControlClient>(daemon->control));
  }
  Clock::time_point since = Clock::now();
  while (!stop.stop_requested()) {
    const bool both = std::ranges::all_of(controls, [](const auto& control) {
      return control->Status().stats().standby().role() == "leading";
    });
    if (!both) since = Clock::now();
    both_lead_s_ = std::max<double>(both_lead_s_, Seconds(Clock::now() - since));
    Sleep(0.1);
  }
}

std::int64_t Stage::DiskBytes() const {
  std::int64_t bytes = 0;
  std::error_code error;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(folder_ / "kept0", error)) {
    if (entry.is_regular_file(error)) bytes += static_cast<std::int64_t>(entry.file_size(error));
  }
  return bytes;
}

void Stage::Begin() {
  Sleep(0.5);  // what the last attack has begun ends
  memory_before_ = Memory(daemon().child->pid(), "VmRSS");
  ForgetPeak(daemon().child->pid());
  disk_before_ = DiskBytes();
  received_before_ = subscriber_->Count("styled/rig.victim/");
  sent_before_ = sent_;
  both_lead_s_ = 0;
  begin_ = Clock::now();
}

Measured Stage::Watch(const std::function<void()>& attack) {
  constexpr double kPatience_s = 20;
  Measured measured;
  Begin();
  std::thread attacker(attack);
  Sleep(0.3);
  const auto asked = Clock::now();
  daemon().child->Signal(SIGHUP);
  measured.reload_s = manager_.Until_s("RELOADING=1", asked, kPatience_s);
  attacker.join();
  measured.silence_s = manager_.LongestSilence_s(begin_);
  End(measured);
  return measured;
}

void Stage::End(Measured& measured) {
  measured.memory = Memory(daemon().child->pid(), "VmHWM") - memory_before_;
  measured.disk = DiskBytes() - disk_before_;
  measured.victim = sent_ - sent_before_;
  subscriber_->WaitForFrames(received_before_ + measured.victim, "styled/rig.victim/", 5);
  measured.received = std::min<std::uint64_t>(
      subscriber_->Count("styled/rig.victim/") - received_before_, measured.victim);
  measured.alive = daemon().child->Running();
  support::ControlClient leader(daemons_[0]->control), follower(daemons_[1]->control);
  for (int i = 0; i < 100 && !measured.one_leads; ++i) {
    measured.one_leads = leader.Status().stats().standby().role() == "leading" &&
                         follower.Status().stats().standby().role() == "following";
    if (!measured.one_leads) Sleep(0.1);
  }
  measured.both_lead_s = both_lead_s_;
}

}  // namespace styled::hostile
