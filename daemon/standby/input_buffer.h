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

// The last frame of a performer that the leader handled, as the standby learned it.
struct LastHandled {
  source::Machine machine{};
  std::uint64_t session = 0, sequence = 0, source_time_ns = 0;
  std::uint32_t pose_crc = 0;  // PoseCrc of the frame as it came from the rig
  std::int64_t at_ns = 0;      // when the leader had it, on this daemon's clock
};

STYLED_REALTIME std::uint32_t PoseCrc(const source::SourceFrame& frame) noexcept;

// Keeps what the rigs send to a standby, for the moment at which it goes on alone. Pipeline thread.
// Pinned by tests/unit/standby/input_buffer_test.cpp.
class InputBuffer {
 public:
  struct Frame {
    int source = 0;
    std::int64_t at_ns = 0;
    source::SourceFrame frame;
    std::uint32_t pose_crc = 0;
    source::FrameMemory memory{kUsualBytes};
  };
  // Longer than it takes to notice that the leader is gone, on a machine that stands still
  // meanwhile.
  static constexpr std::int64_t kKeep_ns = 1'000'000'000;
  // A second of 64 performers at 120 Hz. Beyond that the oldest give way.
  static constexpr std::size_t kMost = 8192;

  void Add(int source, std::span<const source::SourceFrame> frames, std::int64_t now_ns);
  void Clear();
  // Drops what is older than kKeep_ns, and the bodies of those who have sent nothing since.
  void Expire(const std::vector<std::string>& source_names, std::int64_t now_ns);
  const std::deque<std::unique_ptr<Frame>>& frames() const { return frames_; }
  // The newest body of each performer, by source and name.
  const std::map<std::pair<int, std::string>, std::unique_ptr<Frame>>& bodies() const {
    return bodies_;
  }
  // When the last frame of a performer came; nothing within kKeep_ns: INT64_MIN.
  std::int64_t LastOf(const std::vector<std::string>& source_names, std::string_view id) const;

  // Where a performer's own frames continue behind the leader's last one: the frame here that is
  // that one (null: none here), and how many of frames() from the beginning do not come after it.
  // Rigs whose protocol has no session and numbers get these from each daemon on its own, so the
  // frame is found by its numbers, or else by its pose, or else by its time.
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
