// Fuzzes styled::live_link_face: a decoded datagram is written byte for byte as it came.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "proto/rigs/livelinkface/live_link_face.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace styled::live_link_face;
  const auto bytes = std::as_bytes(std::span(data, size));
  Frame frame;
  if (Decode(bytes, frame) != DecodeResult::kOk) return 0;
  std::array<std::byte, kMaxSize> written;
  const std::size_t written_size = Encode(frame, written);
  if (written_size != size || !std::equal(bytes.begin(), bytes.end(), written.begin()))
    std::abort();
  return 0;
}
