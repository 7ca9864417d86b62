#pragma once

#include <cstdint>
#include <random>

namespace styled {

// 64 bits of the system's randomness, never 0: names a session, an epoch or a run so that two of
// them differ. Not a key. Makes a system call. Throws std::runtime_error where the system has none.
inline std::uint64_t RandomId() {
  std::random_device device;
  const std::uint64_t high = device();
  const std::uint64_t id = (high << 32U) | device();
  return id == 0 ? 1 : id;
}

}  // namespace styled
