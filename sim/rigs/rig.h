#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/base/status.h"
#include "model/body/pose.h"

namespace styled::rigs {

// One instant of all performers, as a rig's sender sees it.
struct Frame {
  std::uint64_t index = 0;                 // in this session
  double time_s = 0;                       // since the session began
  std::span<const body::Pose> poses;       // one per performer; canonical: right-handed, +Y up, +Z
                                           // forward, +X left, metres. NaN rotation: not tracked
  std::span<const body::Pose> whole = {};  // the same with nothing untracked; empty: not known.
                                           // For sensors that do not hang on the parent's
};

// Where a rig's datagrams go, in their order. Bytes are valid during the call.
using Send = std::function<void(std::span<const std::byte>)>;

struct Options {
  std::vector<std::string> performers{"sim"};  // their names, as many as there are poses
  double rate_hz = 60;
  std::uint64_t seed = 1;
  // Quirks by name, e.g. "t-first", "tcp", "lz4", "4.1"; which there are is said by each rig's
  // header. Make() refuses others.
  std::vector<std::string> quirks;
};

// Stands in for a rig's sender: poses of the canonical humanoid in the rig's own bytes, with the
// habits of the real one. May allocate. One thread.
class Rig {
 public:
  Rig() = default;
  virtual ~Rig() = default;
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;

  // All that the sender sends for one frame.
  virtual void Encode(const Frame& frame, const Send& send) = 0;
  // The sender dies and begins anew; the next frame has index 0.
  virtual void Restart() {}
  // What came back on the sender's socket (a handshake, a heartbeat); answers go to `send`, which
  // here sends to whom it came from.
  virtual void Receive(std::span<const std::byte> /*datagram*/, const Send& /*send*/) {}

  // Where such a rig sends by default, "udp://127.0.0.1:9763"; where it listens, if it is a server
  // that sends to whoever asked.
  virtual std::string default_address() const = 0;
  virtual bool is_server() const { return false; }
};

// The stand-in for "mvn", ...; errors name the word and those known. Registered in make.cpp.
Result<std::unique_ptr<Rig>> Make(const std::string& type, const Options& options);

// For the makers of rigs: refuses quirks other than these and more performers than the rig has
// (0: any number).
Status CheckOptions(const std::string& type, const Options& options, int max_performers,
                    std::initializer_list<std::string_view> quirks);

}  // namespace styled::rigs
