#pragma once

#include <cstddef>
#include <vector>

#include "model/base/checkpoint.h"

namespace styled {

// The bytes that `carry` passes to a Checkpoint. `carry` is called twice: to count, and to write.
// Allocates.
template <typename Carry>
std::vector<std::byte> CheckpointBytes(Carry carry) {
  Checkpoint count;
  carry(count);
  std::vector<std::byte> bytes(count.size());
  Checkpoint writer = Checkpoint::Into(bytes);
  carry(writer);
  return bytes;
}

}  // namespace styled
