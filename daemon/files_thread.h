#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/log/recorder.h"
#include "daemon/looks/mailboxes.h"
#include "daemon/looks/runtime_config.h"
#include "daemon/origin.h"
#include "daemon/runtime/clock.h"
#include "daemon/runtime/counters.h"
#include "daemon/runtime/notify.h"
#include "daemon/styles/style_requests.h"

namespace styled {

// The thread for all work that may take long: reloads, styles from examples, the library, the state
// file, the free space of a recording's disk. It does one piece of work per turn, so a stream of
// one kind does not delay the others. Signals, the log and the sign of life are on other threads.
// Pinned by tests/hostile and tests/e2e/service.
class FilesThread {
 public:
  // All references must outlive it, and so must `recorder` (null: nothing is recorded). `running`
  // is the configuration that the pipeline has, `weights_crc` that of its weights.
  FilesThread(const config::Config& config, const Origin& origin,
              std::shared_ptr<const pipeline::RuntimeConfig> running, std::uint32_t weights_crc,
              pipeline::Mailboxes& mailboxes, runtime::Counters& counters,
              const runtime::Clock& clock, log::Recorder* recorder);
  ~FilesThread();
  FilesThread(const FilesThread&) = delete;
  FilesThread& operator=(const FilesThread&) = delete;

  void Start();
  // Reads the configuration again. Requests during a reload lead to one further reload. Any thread.
  void RequestReload();
  // Why the last reload was refused; "": it was accepted, or there was none. Any thread.
  std::string refused() const;

  // Call once, after the pipeline has ended. Completes the current request, writes `last` (the
  // newest settings; null: those of the mailbox), and waits for at most kPatience_s. False: the
  // disk does not answer, and the caller must end the process without destroying this object.
  bool Stop(std::unique_ptr<std::vector<pipeline::Profile>> last);
  // Seconds. A disk that wakes up or a network mount that reconnects takes some of them.
  static constexpr double kPatience_s = 10;

 private:
  void Run();
  bool DoTurn();
  void Reload();
  Status Adopt();
  void WarnOfRestartKeys(const config::Config& fresh) const;
  void DoStyleRequest(std::unique_ptr<pipeline::Exchange> exchange);
  // `newest` replaces the profiles in the mailbox: profiles that did not fit into it.
  void KeepProfiles(std::unique_ptr<std::vector<pipeline::Profile>> newest = nullptr);
  // See StyleRequests::KeepMoved.
  void KeepMovedStyles(bool now);
  void CheckRecording();
  bool Push(pipeline::Reload reload);

  config::Config config_;
  const Origin& origin_;
  std::shared_ptr<const pipeline::RuntimeConfig> running_;
  std::uint32_t weights_crc_;
  pipeline::Mailboxes& mailboxes_;
  runtime::Counters& counters_;
  const runtime::Clock& clock_;
  log::Recorder* const recorder_;
  runtime::Notifier notifier_ = runtime::Notifier::FromEnvironment();
  pipeline::StyleRequests style_requests_;

  std::atomic<bool> reload_{false}, stop_{false};
  std::unique_ptr<std::vector<pipeline::Profile>> last_;
  mutable std::mutex mutex_;  // protects the members below
  std::string refused_;
  bool ended_ = false;
  std::condition_variable end_;
  std::thread thread_;
};

}  // namespace styled
