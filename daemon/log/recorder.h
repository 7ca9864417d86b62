#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/log/writer.h"
#include "daemon/runtime/counters.h"
#include "daemon/source/transport.h"
#include "model/base/realtime.h"
#include "model/base/status.h"
#include "proto/recording/recording_thread.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::log {

// Whether a successful request changes something.
bool Changes(const v1::Request& request);

// Data about the daemon, for the header of its recording.
struct About {
  std::string config;                 // text of the configuration file and of the overrides
  std::string weights, weights_hash;  // names and hashes of the weights files
  std::string state;                  // text of the state file
};

// Records what the daemon receives and which commands it executes, as configured in [record], in
// the format of proto/recording/FORMAT.md. A thread of its own compresses and writes; no other
// thread waits for it. If the disk is full, slow or gone, records are lost and counted; nothing
// else suffers. Pinned by tests/e2e/recordings/daemon_test.cpp and tests/realtime.
class Recorder final : public Writer {
 public:
  // Creates the folder and the file. `endpoints[i]` is the address of source i. Errors name the
  // file.
  static Result<std::unique_ptr<Recorder>> Start(const config::Config& config,
                                                 const std::vector<std::string>& endpoints,
                                                 const About& about);

  // Pipeline thread, or before it starts.
  STYLED_REALTIME void OnArrival(const source::Arrival& arrival) noexcept override;
  // These allocate. OnRequest records only requests that changed something.
  void OnFrames(int source, std::span<const decide::FrameInTransit> frames, std::int64_t receive_ns,
                std::int64_t wall_ns) override;
  void OnSilence(std::int64_t now_ns, const v1::Silence& silence) override;
  void OnRequest(std::int64_t now_ns, const v1::Request& request, const v1::Reply& reply) override;
  void OnReload(std::int64_t now_ns, std::string_view weights) override;

  // Files thread, a few times a second. Checks the disk, sets the counters record.*, and
  // returns a line for the log when a new problem appeared, else "".
  std::string Check(runtime::Counters& counters);

  // Writes what is still waiting. Call after the pipeline has ended.
  void Close() { thread_->Stop(); }

  const std::filesystem::path& file() const { return file_; }
  std::uint64_t written() const { return thread_->written(); }
  // Records that found the ring full, could not be written, or came while the disk was too full.
  std::uint64_t lost() const {
    return thread_->dropped() + thread_->lost() + skipped_.load(std::memory_order_relaxed);
  }

 private:
  Recorder(std::filesystem::path file, std::uint64_t min_free_bytes,
           std::unique_ptr<recording::RecordingThread> thread,
           std::vector<std::string> source_names)
      : file_(std::move(file)),
        min_free_bytes_(min_free_bytes),
        thread_(std::move(thread)),
        source_names_(std::move(source_names)) {}
  STYLED_REALTIME bool Paused() noexcept;

  std::filesystem::path file_;
  std::uint64_t min_free_bytes_;
  std::unique_ptr<recording::RecordingThread> thread_;
  std::vector<std::string> source_names_;
  recording::Decided fates_;         // refilled for each batch, so that it keeps its memory
  std::atomic<bool> paused_{false};  // the disk is too full
  std::atomic<std::uint64_t> skipped_{0};
  std::string last_complaint_;  // files thread
};

// The file name that record.file gives at time `unix_s`: strftime's conversions are replaced, in
// local time. A folder, or a pattern that ends in '/', gets a name made of date and time. If the
// file exists, "-2", "-3", ... is added before its extension.
std::filesystem::path FileAt(const std::string& pattern, std::int64_t unix_s);

}  // namespace styled::log
