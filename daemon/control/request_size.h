#pragma once

#include <cstddef>
#include <span>

namespace styled::control {

// Counts the bytes of a styled.v1.Request outside its file (Like.clip, ImportStyle.file, the state
// of a checkpoint). A file is one string in memory, but 2 bytes of anything else, an empty entry of
// a list, can take 60. Therefore the bytes are counted before the request is parsed. If the bytes
// are not a message, all bytes from the fault on are counted. Reads the bytes once; does not
// allocate; any thread. Pinned by tests/unit/daemon/control/request_size_test.cpp.
struct RequestSize {
  std::size_t beside_file = 0;
  bool has_checkpoint = false;
};
RequestSize SizeOfRequest(std::span<const std::byte> request);

// The limit of these bytes: a checkpoint has a body and the names of a thousand styles.
constexpr std::size_t MostBesideFile(const RequestSize& size) {
  return size.has_checkpoint ? 160 * 1024 : 64 * 1024;
}

}  // namespace styled::control
