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

// Our own protocol (proto/styled/v1/WIRE.md), as it comes over UDP, TCP and USB and out of
// recordings: the one place where its datagrams become SourceFrames. What cannot be decoded is
// counted for the source and goes no further: header and checksum (proto/rigs/native), a malformed
// message (source.malformed), a performer without a valid name (source.bad_name). One per source;
// pipeline thread. Allocates nothing.
class NativeDecoder {
 public:
  NativeDecoder(int source, runtime::Counters& counters);

  // Up to kBatch whole datagrams or records that arrived together, oldest first, and who sent each:
  // as many machines as datagrams, or none where the transport vouches for its senders. Hands on
  // what could be decoded, in one call. Whatever was refused counts as received, too.
  void HandOn(std::span<const std::span<const std::byte>> datagrams,
              std::span<const Machine> senders, Receiver& receiver);

 private:
  int source_;
  runtime::Counters& counters_;
  std::array<SourceFrame, kBatch> frames_;
};

enum class [[nodiscard]] FrameResult : std::uint8_t {
  kOk,
  kMalformed,  // no valid protobuf, or a field of another type
  kBadName,    // performer is not [A-Za-z0-9_-]{1,32}
};

// Reads a serialized v1::SourceFrame without protobuf's objects: those give back a frame's
// timecode, and grow with a hostile frame, on the heap. Floats must be packed (proto3's default;
// one run per field), expressions and thru in one run (the last one counts); unknown fields are
// skipped, the last of repeated scalars wins. Fills in all but machine, session and sequence;
// `frame` is unspecified unless kOk, and views `payload`. Pure; any thread. Pinned against protobuf
// by tests/unit/daemon/native_decoder_test.cpp.
STYLED_REALTIME FrameResult ReadSourceFrame(std::span<const std::byte> payload,
                                            SourceFrame& frame) noexcept;

// Only the performer's name of a serialized SourceFrame or Body (field 1 of both); empty when there
// is none or the bytes are malformed before it.
STYLED_REALTIME std::string_view ReadPerformer(std::span<const std::byte> payload) noexcept;

}  // namespace styled::source
