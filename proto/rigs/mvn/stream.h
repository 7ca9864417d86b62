#pragma once

#include <cstddef>
#include <span>

#include "model/base/realtime.h"
#include "proto/rigs/cut.h"

namespace styled::mvn {

// Over TCP, MXTP datagrams follow one another, delimited by the payload sizes in their headers.
using rigs::Cut;

// Examines the front of the received bytes; writes `size` on kRecord only. Old senders leave the
// payload size 0 in types 01 and 02; it is then computed from the number of items.
STYLED_REALTIME Cut CutRecord(std::span<const std::byte> received, std::size_t& size) noexcept;

}  // namespace styled::mvn
