#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "tests/hostile/attacks.h"
#include "tests/support/daemon.h"
#include "tests/support/datagrams.h"
#include "tests/support/rig.h"

namespace styled::hostile {

using Clock = std::chrono::steady_clock;

// The notifications that a service manager gets from a daemon, with their times. A thread of its
// own.
class ServiceManager {
 public:
  ServiceManager();
  ~ServiceManager();
  const std::string& path() const { return datagrams_.path(); }
  // Drops what was heard, so that an hour does not fill memory.
  void Forget();

  // The longest time without WATCHDOG=1 since `since`, the time until now included, in seconds.
  double LongestSilence_s(Clock::time_point since) const;
  // Seconds from `since` to the first message that contains `text`; `patience_s` if none comes.
  double Until_s(const std::string& text, Clock::time_point since, double patience_s) const;

 private:
  struct Heard {
    Clock::time_point at;
    std::string text;
  };
  support::Datagrams datagrams_;
  mutable std::mutex mutex_;
  std::vector<Heard> heard_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

// The [standby] table of one of two daemons, `own` 0 or 1; the journals are in the folder.
std::string StandbyTable(const support::TemporaryFolder& folder, int own);
// Makes a style and takes a checkpoint of the performer.
Loot TakeLoot(const support::Daemon& daemon, const std::string& performer);

// The properties that hold whatever a client, file or rig does; the bounds are theirs.
struct Measured {
  double silence_s = 0;        // without a sign of life
  double reload_s = 0;         // from SIGHUP to RELOADING=1
  std::int64_t memory = 0;     // bytes by which the peak exceeds what was there before
  std::int64_t disk = 0;       // bytes by which the daemon's folder grew
  std::uint64_t victim = 0;    // frames of the victim that were sent
  std::uint64_t received = 0;  // of these, those that a subscriber received
  double both_lead_s = 0;      // longest time for which both daemons said that they lead
  bool one_leads = false;      // at the end one leads, and the other is its standby
  bool alive = false;          // the process runs
};

// A pair of daemons, under a service manager, with a library and a state folder; a victim who
// performs at 120 Hz for both; and a subscriber. Attacks go to the leader.
class Stage {
 public:
  // `extra`: TOML for both daemons. `settings`: as of support::Daemon.
  explicit Stage(const std::string& extra = "", std::vector<std::string> settings = {});
  ~Stage();

  support::Daemon& daemon() { return *daemons_[0]; }
  ServiceManager& manager() { return manager_; }
  const support::TemporaryFolder& folder() const { return folder_; }
  // Runs `attack` on a thread of its own, beside the victim, with a reload in the middle, and
  // measures until it has ended.
  Measured Watch(const std::function<void()>& attack);

 private:
  void Begin();
  void End(Measured& measured);
  void Perform(const std::stop_token& stop);
  void WatchRoles(const std::stop_token& stop);
  std::int64_t DiskBytes() const;

  support::TemporaryFolder folder_;
  ServiceManager manager_;
  std::vector<std::unique_ptr<support::Daemon>> daemons_;  // the leader first
  std::unique_ptr<support::Subscriber> subscriber_;
  std::atomic<std::uint64_t> sent_{0};
  std::atomic<double> both_lead_s_{0};
  Clock::time_point begin_;
  std::int64_t memory_before_ = 0, disk_before_ = 0;
  std::uint64_t sent_before_ = 0, received_before_ = 0;
  std::vector<std::jthread> threads_;
};

}  // namespace styled::hostile
