#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/source/frame_memory.h"
#include "daemon/source/transport.h"

namespace styled::standby {

// The performer's last frame that the leader processed, from the journal.
struct LastHandled {
  source::Machine machine{};
  std::uint64_t session = 0, sequence = 0, source_time_ns = 0;
  std::uint32_t pose_crc = 0;  // PoseCrc of the frame as received from the rig
  std::int64_t at_ns = 0;      // when the leader received it, on this daemon's clock
};

STYLED_REALTIME std::uint32_t PoseCrc(const source::SourceFrame& frame) noexcept;

// Buffers the rigs' frames at a standby, for a takeover. Pipeline thread. Pinned by
// tests/unit/standby/input_buffer_test.cpp.
class InputBuffer {
 public:
  struct Frame {
    int source = 0;
    std::int64_t at_ns = 0;
    source::SourceFrame frame;
    std::uint32_t pose_crc = 0;
    source::FrameMemory memory{kUsualBytes};
  };
  // Longer than the detection of a dead leader takes, even if this machine is interrupted
  // meanwhile.
  static constexpr std::int64_t kKeep_ns = 1'000'000'000;
  // A second of 64 performers at 120 Hz. Beyond that the oldest frames are dropped.
  static constexpr std::size_t kMost = 8192;

  void Add(int source, std::span<const source::SourceFrame> frames, std::int64_t now_ns);
  void Clear();
  // Drops frames older than kKeep_ns, and bodies whose performers have sent nothing since.
  void Expire(const std::vector<std::string>& source_names, std::int64_t now_ns);
  const std::deque<std::unique_ptr<Frame>>& frames() const { return frames_; }
  // The newest body of each performer, by source and name.
  const std::map<std::pair<int, std::string>, std::unique_ptr<Frame>>& bodies() const {
    return bodies_;
  }
  // Arrival of the performer's last frame; INT64_MIN if none arrived within kKeep_ns.
  std::int64_t LastOf(const std::vector<std::string>& source_names, std::string_view id) const;

  // The position in frames() from which a performer's frames follow the leader's last one. `same`:
  // the buffered frame that is the leader's last one; null: it is not buffered. `after`: the number
  // of frames from the beginning that are not later than it. For a rig whose protocol has no
  // session and numbers, each daemon assigns its own. The frame is therefore found by its numbers,
  // otherwise by its pose, otherwise by its time.
  struct Place {
    const Frame* same = nullptr;
    std::size_t after = 0;
  };
  Place Find(const std::vector<std::string>& source_names, std::string_view id,
             const LastHandled& last) const;

 private:
  static constexpr std::size_t kUsualBytes = 2048;
  void DropOld(std::int64_t now_ns);
  std::unique_ptr<Frame> Keep(int source, const source::SourceFrame& frame, std::int64_t now_ns);
  static bool IsOf(const Frame& held, const std::vector<std::string>& source_names,
                   std::string_view id);

  std::deque<std::unique_ptr<Frame>> frames_;  // without bodies, oldest first
  std::map<std::pair<int, std::string>, std::unique_ptr<Frame>> bodies_;
  std::vector<std::unique_ptr<Frame>> free_;
};

}  // namespace styled::standby
