#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/runtime/counters.h"
#include "daemon/source/transport.h"
#include "model/base/realtime.h"
#include "model/base/status.h"
#include "proto/recording/recording_thread.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::record {

// What a recording's header says of the daemon that made it.
struct About {
  std::string config;  // text of the configuration file, and what was set over it
  std::filesystem::path weights;
  std::string state;  // text of the state file
};

// Records what the daemon receives and is told, as [record] in styled.toml says, in the format of
// proto/recording/FORMAT.md. A thread of its own compresses and writes; nobody waits for it. A disk
// that is full, slow or gone costs records, which are counted, and nothing else.
// Pinned by tests/e2e/recordings/daemon_test.cpp and tests/realtime.
class Recorder {
 public:
  // Makes the folder and the file. `endpoints[i]`: where source i listens. Errors name the file.
  static Result<std::unique_ptr<Recorder>> Start(const config::Config& config,
                                                 const std::vector<std::string>& endpoints,
                                                 const About& about);

  // Pipeline thread, or before it runs.
  STYLED_REALTIME void OnArrival(const source::Arrival& arrival) noexcept;
  // A request that was answered; recorded where it changed something. Allocates.
  void OnRequest(std::int64_t now_ns, const v1::Request& request, const v1::Reply& reply);
  void OnNote(std::int64_t now_ns, std::string_view text) noexcept;

  // Supervisor thread, a few times a second: looks at the disk, sets the counters record.*, and
  // says what is newly wrong, a line for the log; "" = nothing.
  std::string Check(runtime::Counters& counters);

  // Writes what is waiting; when the pipeline has ended.
  void Close() { thread_->Stop(); }

  const std::filesystem::path& file() const { return file_; }
  std::uint64_t written() const { return thread_->written(); }
  // Found the ring full, could not be written, or came while the disk was too full.
  std::uint64_t lost() const {
    return thread_->dropped() + thread_->lost() + skipped_.load(std::memory_order_relaxed);
  }

 private:
  Recorder(std::filesystem::path file, std::uint64_t min_free_bytes,
           std::unique_ptr<recording::RecordingThread> thread)
      : file_(std::move(file)), min_free_bytes_(min_free_bytes), thread_(std::move(thread)) {}
  STYLED_REALTIME bool Paused() noexcept;

  std::filesystem::path file_;
  std::uint64_t min_free_bytes_;
  std::unique_ptr<recording::RecordingThread> thread_;
  std::atomic<bool> paused_{false};  // the disk is too full
  std::atomic<std::uint64_t> skipped_{0};
  std::string said_;  // the supervisor's: the last complaint
};

// The file that record.file means at `unix_s`: strftime's conversions replaced, local time; a
// folder, or what ends in '/', gets a name with date and time; where the file exists, "-2", "-3",
// ... before its extension.
std::filesystem::path FileAt(const std::string& pattern, std::int64_t unix_s);

}  // namespace styled::record
