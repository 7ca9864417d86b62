#pragma once

#include <cstddef>
#include <span>

#include "model/base/realtime.h"

namespace styled::mvn {

// Over TCP, MXTP datagrams follow one another; their headers' payload sizes delimit them.
enum class [[nodiscard]] Cut {
  kRecord,    // `size` bytes at the front are one datagram
  kNeedMore,  // not all of it is there yet
  kBroken     // no header: nothing after this point can be trusted
};

// Looks at the front of what was received. Old senders leave the payload size 0 in types 01 and
// 02: then the items tell.
STYLED_REALTIME Cut CutRecord(std::span<const std::byte> received, std::size_t& size) noexcept;

}  // namespace styled::mvn
