#pragma once

#include <span>
#include <string>
#include <vector>

#include "tests/unit/vmc/bytes.h"

// How others read OSC: each message of a datagram as "ADDRESS ,TYPES VALUE ...", in order. Floats
// as their bits in hexadecimal, blobs by their size.
namespace styled::vmc::testing {

struct Witness {
  bool taken = false;  // the datagram was
  std::vector<std::string> messages;
};

Witness ReadOurs(std::span<const std::byte> datagram);
Witness ReadLiblo(std::span<const std::byte> datagram);
Witness ReadOscpack(std::span<const std::byte> datagram);

}  // namespace styled::vmc::testing
