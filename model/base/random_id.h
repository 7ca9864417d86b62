#pragma once

#include <cstdint>
#include <random>

namespace styled {

// A random number of 64 bits from the operating system, never 0. It identifies a session, an epoch
// or a run. It is not a cryptographic key. Makes a system call; any thread. Throws
// std::runtime_error if the system provides no randomness.
inline std::uint64_t RandomId() {
  std::random_device device;
  const std::uint64_t high = device();
  const std::uint64_t id = (high << 32U) | device();
  return id == 0 ? 1 : id;
}

}  // namespace styled
