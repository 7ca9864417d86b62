#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "daemon/publish/publisher.h"
#include "daemon/publish/subscriptions.h"

namespace styled::publish {

// Gathers the frames of all performers on one output into messages (v1.Frames) on a topic of their
// own. A client that shows a whole stage then receives one message per cycle instead of one per
// performer. Most of the cost on both sides is per message, not per frame. Pipeline thread.
class Bundle {
 public:
  // `topic` must outlive it.
  explicit Bundle(const Topic& topic) : topic_(topic) { bytes_.reserve(kUsualBytes); }

  // Appends a serialized v1.Frame, if a client subscribes. Sends the message first if the frame
  // would make it longer than kMostBytes. Allocates only for more than kUsualBytes.
  void Add(std::span<const std::byte> frame, Publisher& publisher) noexcept;
  bool empty() const noexcept { return bytes_.empty(); }
  // Sends the gathered frames, if there are any.
  void Send(Publisher& publisher) noexcept;

  // A cycle of kBatch frames of a usual body is 40 kB.
  static constexpr std::size_t kUsualBytes = 128 << 10;
  // Clients refuse messages of more than 1 MiB.
  static constexpr std::size_t kMostBytes = 512 << 10;

 private:
  const Topic& topic_;
  std::vector<std::byte> bytes_;
};

}  // namespace styled::publish
