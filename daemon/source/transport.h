#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace styled::source {

// What takes the bytes of all transports: the pipeline.
class Receiver {
 public:
  virtual ~Receiver() = default;
  // Whole datagrams or records that arrived together, oldest first, on source number `source`. The
  // bytes are the transport's and valid during the call only.
  virtual void OnDatagrams(int source, std::span<const std::span<const std::byte>> datagrams) = 0;
};

// One way for bytes to come in; sources/<type>.h each. Used by the pipeline thread alone, except
// construction. Never blocks.
class Transport {
 public:
  virtual ~Transport() = default;
  // Hands what has arrived to `receiver`, up to a bound, and returns how many datagrams that was.
  virtual int DoWork(Receiver& receiver) = 0;
  // Readable when DoWork may find something.
  virtual int fd() const = 0;
  // The address bound, "HOST:PORT" with the real port.
  virtual const std::string& endpoint() const = 0;
};

// At most this many datagrams are handed over at once: what bounds a cycle of the pipeline.
inline constexpr std::size_t kBatch = 32;

}  // namespace styled::source
