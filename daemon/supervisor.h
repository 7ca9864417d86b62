#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/control/control_socket.h"
#include "daemon/files_thread.h"
#include "daemon/log/recorder.h"
#include "daemon/looks/mailboxes.h"
#include "daemon/looks/runtime_config.h"
#include "daemon/origin.h"
#include "daemon/pipeline/pipeline.h"
#include "daemon/pipeline/pipeline_thread.h"
#include "daemon/publish/publisher.h"
#include "daemon/runtime/clock.h"
#include "daemon/runtime/clock_watch.h"
#include "daemon/runtime/counters.h"
#include "daemon/runtime/helpers.h"
#include "daemon/runtime/notify.h"
#include "daemon/runtime/sign_of_life.h"
#include "daemon/security/gatekeeper.h"
#include "daemon/standby/standby.h"

namespace styled {

// Assembles the daemon and supervises it on the main thread: signals and the log. The other threads
// are the pipeline and its helpers, control, files, the sign of life (if the service manager asks
// for it), security (with keys only), the recording's writer (while recording), one per USB source,
// and ZeroMQ's own.
class Supervisor {
 public:
  Supervisor(config::Config config, Origin origin);
  ~Supervisor();
  Supervisor(const Supervisor&) = delete;
  Supervisor& operator=(const Supervisor&) = delete;

  // Opens everything and reports READY to the service manager. Errors: weights, addresses, keys,
  // the ready file. SIGTERM, SIGINT and SIGHUP must be blocked in the process.
  Status Start();
  // Runs until SIGTERM or SIGINT.
  void Run();

 private:
  Status OpenSources();
  Status OpenGate();
  security::Gatekeeper* KeeperOf(const std::string& address, bool allow_unauthenticated_remote);
  Status OpenSockets();
  Status OpenStandby();
  void StartRecording();
  void CloseRecording();
  void RestoreProfiles();
  void StartHelpers();
  void StartThreads();
  void StartSignOfLife();
  Status WriteReadyFile() const;
  void Stop();
  void LogEvents();
  void LogTrouble();
  std::string NamesOf(std::uint64_t sources) const;
  void ReportStatus(double seconds);

  config::Config config_;
  Origin origin_;
  runtime::SystemClock clock_;
  // The pipeline's thread uses it as soon as it runs.
  runtime::ClockWatch clock_watch_{config_.time.ptp4l};
  runtime::Counters counters_;
  runtime::Notifier notifier_ = runtime::Notifier::FromEnvironment();
  pipeline::Mailboxes mailboxes_;
  void* context_;
  std::uint64_t epoch_;
  std::shared_ptr<const pipeline::RuntimeConfig> runtime_config_;
  std::uint32_t weights_crc_ = 0;
  std::vector<int> standby_fds_;
  std::string standby_endpoint_, publish_endpoint_, osc_endpoint_, control_endpoint_;
  std::vector<std::string> source_endpoints_;
  std::vector<std::unique_ptr<source::Transport>> transports_;
  std::unique_ptr<security::Gatekeeper> gatekeeper_;  // null: no socket requires keys
  std::unique_ptr<publish::Publisher> publisher_;
  std::unique_ptr<standby::Standby> standby_;  // null: this daemon is alone
  std::unique_ptr<control::ControlSocket> control_;
  std::unique_ptr<log::Recorder> recorder_;    // null: nothing is recorded
  std::unique_ptr<runtime::Helpers> helpers_;  // null: realtime.styling_threads is 1
  std::unique_ptr<pipeline::Pipeline> pipeline_;
  std::unique_ptr<pipeline::PipelineThread> pipeline_loop_;
  std::unique_ptr<FilesThread> files_;
  std::unique_ptr<runtime::SignOfLife> sign_of_life_;  // null: the service manager has no watchdog
  std::thread pipeline_thread_, control_thread_;
  std::array<std::uint64_t, static_cast<std::size_t>(runtime::Counter::kCount)> logged_{};
  // Seconds for which a counter has grown without a pause.
  std::array<std::uint64_t, static_cast<std::size_t>(runtime::Counter::kCount)> growing_s_{};
  std::uint64_t frames_said_ = 0;
};

}  // namespace styled
