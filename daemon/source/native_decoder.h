#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "daemon/runtime/counters.h"
#include "daemon/source/source_frame.h"
#include "daemon/source/transport.h"
#include "model/base/realtime.h"

namespace styled::source {

// For records that one read of a stream returned, the kernel reports only when the last byte
// arrived.
struct ReadTogether {
  std::int64_t last_ns = 0;        // time at which the last byte arrived
  std::int64_t not_before_ns = 0;  // time until which nothing had arrived
};

// Decodes the native protocol (proto/styled/v1/WIRE.md) into SourceFrames, for UDP, TCP, USB and
// recordings alike. Datagrams that cannot be decoded are counted for the source and dropped: bad
// header or checksum (proto/rigs/native), malformed message (source.malformed), performer without a
// valid name (source.bad_name). One per source; pipeline thread. Allocates nothing.
class NativeDecoder {
 public:
  NativeDecoder(int source, runtime::Counters& counters);

  // Decodes up to kBatch whole datagrams or records that arrived together, oldest first, and passes
  // the frames to `receiver` in one call. `senders` holds the machine of each datagram, or is empty
  // where the transport itself distinguishes its senders. `arrivals_ns`: when each arrived, or
  // empty (SourceFrame::arrival_ns). Refused datagrams count as received, too.
  void HandOn(std::span<const std::span<const std::byte>> datagrams,
              std::span<const Machine> senders, Receiver& receiver,
              std::span<const std::int64_t> arrivals_ns = {});
  // The same for a stream's records. The arrival times of a performer's earlier frames are spaced
  // as its rig captured them, counted back from its last frame. Otherwise frames that waited while
  // the loop was delayed would all seem to be new.
  void HandOn(std::span<const std::span<const std::byte>> records, std::span<const Machine> senders,
              Receiver& receiver, const ReadTogether& read);

 private:
  std::size_t DecodeAll(std::span<const std::span<const std::byte>> datagrams,
                        std::span<const Machine> senders,
                        std::span<const std::int64_t> arrivals_ns);
  void Spread(std::span<SourceFrame> frames, const ReadTogether& read) noexcept;

  int source_;
  runtime::Counters& counters_;
  std::array<SourceFrame, kBatch> frames_;
};

enum class [[nodiscard]] FrameResult : std::uint8_t {
  kOk,
  kMalformed,  // not valid protobuf, or a field of the wrong type
  kBadName,    // performer is not [A-Za-z0-9_-]{1,32}
};

// Parses a serialized v1::SourceFrame without protobuf objects, which would allocate for a frame's
// timecode and grow with a hostile frame. Floats must be packed (proto3's default; one run per
// field). Expressions and thru must form one run (the last one counts), and so must props, whose
// content is not checked. Unknown fields are skipped;
// the last one of a repeated scalar counts. Fills in everything but machine, session and sequence.
// `frame` is unspecified unless kOk, and its views point into `payload`. Pure; any thread. Pinned
// against protobuf by tests/unit/daemon/source/native_decoder_test.cpp.
STYLED_REALTIME FrameResult ReadSourceFrame(std::span<const std::byte> payload,
                                            SourceFrame& frame) noexcept;

// The performer's name of a serialized SourceFrame or Body (field 1 of both). Empty when there is
// none or the bytes before it are malformed.
STYLED_REALTIME std::string_view ReadPerformer(std::span<const std::byte> payload) noexcept;

}  // namespace styled::source
