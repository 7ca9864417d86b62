#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "daemon/publish/publisher.h"
#include "daemon/publish/subscriptions.h"

namespace styled::publish {

// The frames of all performers on one output, gathered into messages (v1.Frames) on a topic of
// their own. Who shows a whole stage then receives a message a cycle instead of one a performer;
// on both sides most of the cost is a message's, not a frame's. Pipeline thread.
class Bundle {
 public:
  // `topic` must outlive it.
  explicit Bundle(const Topic& topic) : topic_(topic) { bytes_.reserve(kUsualBytes); }

  // Appends a serialized v1.Frame, if a client subscribes. A message that would become longer than
  // kMostBytes is sent before. Allocates only for more than kUsualBytes.
  void Add(std::span<const std::byte> frame, Publisher& publisher) noexcept;
  bool empty() const noexcept { return bytes_.empty(); }
  // Sends what was gathered, if anything was.
  void Send(Publisher& publisher) noexcept;

  // A cycle of kBatch frames of a usual body has 40 kB.
  static constexpr std::size_t kUsualBytes = 128 << 10;
  // Clients refuse messages of more than 1 MiB.
  static constexpr std::size_t kMostBytes = 512 << 10;

 private:
  const Topic& topic_;
  std::vector<std::byte> bytes_;
};

}  // namespace styled::publish
