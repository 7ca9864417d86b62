#pragma once

#include <sys/socket.h>

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "model/base/realtime.h"
#include "proto/recording/byte_ring.h"
#include "proto/recording/writer.h"

namespace styled::recording {

// A source, as an Arrival names it.
struct Origin {
  std::string name, type, listen;
};

struct RecordingThreadOptions {
  std::size_t ring_bytes = 16U << 20U;  // a power of two; bounds the data that may wait for the
                                        // disk
  WriterOptions writer;
};

// Records for a thread that must not wait: entries go through a bounded ring to another thread,
// which compresses and writes them. A full ring drops entries and counts them. An entry is in the
// file 30 ms after its push, unless the machine is busy. All Push functions: one thread. The rest:
// any thread. Pinned by tests/unit/recording/recording_thread_test.cpp.
class RecordingThread {
 public:
  // Creates the file; errors are those of FileWriter::Create. `origins[i]` describes source number
  // i.
  static Result<std::unique_ptr<RecordingThread>> Start(const std::filesystem::path& file,
                                                        const FileHeader& header,
                                                        std::vector<Origin> origins,
                                                        const RecordingThreadOptions& options = {});
  ~RecordingThread() { Stop(); }
  RecordingThread(const RecordingThread&) = delete;
  RecordingThread& operator=(const RecordingThread&) = delete;

  // Writes all pushed entries and ends the thread. Push nothing afterwards.
  void Stop();

  // Each Push returns false and increments dropped() if the ring is full, or if the entry is larger
  // than a record may be (kMaxRecordSize, block.h). Times are those of MonotonicNow_ns(). `peer`
  // may be null; `source` is an index into the origins; a topic is cut to 64 KiB.
  STYLED_REALTIME bool PushArrival(std::int64_t time_ns, int source, const sockaddr* peer,
                                   socklen_t peer_size,
                                   std::span<const std::byte> datagram) noexcept;
  // Data of one USB transfer; `device` is the number of the device's opening.
  STYLED_REALTIME bool PushTransfer(std::int64_t time_ns, int source, std::uint32_t device,
                                    std::span<const std::byte> bytes) noexcept;
  STYLED_REALTIME bool PushPublished(std::int64_t time_ns, std::string_view topic,
                                     std::span<const std::byte> payload) noexcept;
  bool PushCommand(std::int64_t time_ns, const Command& command);  // allocates
  bool PushDecided(std::int64_t time_ns, const Decided& decided);  // allocates
  bool PushNote(std::int64_t time_ns, std::string_view text) noexcept;

  std::uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }
  // Records written to the file, and records given up because they could not be written (error()
  // gives the reason).
  std::uint64_t written() const { return written_.load(std::memory_order_relaxed); }
  std::uint64_t lost() const { return lost_.load(std::memory_order_relaxed); }
  Status error() const;  // the last error

 private:
  RecordingThread(std::unique_ptr<FileWriter> writer, std::vector<Origin> origins,
                  std::size_t ring_bytes);
  STYLED_REALTIME bool Push(std::initializer_list<std::span<const std::byte>> parts) noexcept;
  void Run(const std::stop_token& stop);
  void Drain();
  bool Decode(std::span<const std::byte> entry);
  void Note(const Status& status);

  ByteRing ring_;
  std::atomic<std::uint64_t> dropped_{0}, written_{0}, lost_{0};

  // Used by the writing thread only.
  std::unique_ptr<FileWriter> writer_;
  std::vector<Origin> origins_;
  std::vector<std::byte> entry_;
  Record record_;

  mutable std::mutex mutex_;  // guards error_; also for wake_
  std::condition_variable_any wake_;
  Status error_ = Status::Ok();
  std::jthread thread_;
};

// The address as text, "127.0.0.1:9763" or "[::1]:9763"; "" if it is neither IPv4 nor IPv6.
std::string AddressText(const sockaddr* address, socklen_t size);

}  // namespace styled::recording
