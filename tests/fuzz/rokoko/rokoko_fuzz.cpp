// Fuzzes styled::rokoko: with the input as a datagram, and compressed, so that LZ4's checksums do
// not hide the text behind them. A decoded frame is written by the encoder, reads back the same,
// and encodes to the same bytes again. Seeds: tests/unit/rokoko/texts.h and lz4_frames.h.
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>
#include <vector>

#include "proto/rigs/rokoko/rokoko.h"

namespace {

using styled::rokoko::DecodeResult;
using styled::rokoko::Frame;
using styled::rokoko::kMaxTextSize;

void Require(bool condition) {
  if (!condition) std::abort();
}

void CheckFrame(styled::rokoko::Decoder& decoder, const Frame& frame) {
  static std::string text(kMaxTextSize, '\0'), again(kMaxTextSize, '\0');
  static Frame read;
  const std::size_t size = EncodeText(frame, text);
  Require(size > 0);
  Require(decoder.DecodeText(std::string_view(text).substr(0, size), read) == DecodeResult::kOk);
  Require(EncodeText(read, again) == size);
  Require(text.compare(0, size, again, 0, size) == 0);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static styled::rokoko::Decoder decoder;
  static styled::rokoko::Lz4Packer packer;
  static Frame frame;
  const auto bytes = std::as_bytes(std::span(data, size));
  const DecodeResult plain = decoder.Decode(bytes, frame);
  if (plain == DecodeResult::kOk) CheckFrame(decoder, frame);

  std::vector<std::byte> packed(size + 64);
  const std::size_t packed_size = packer.Pack(bytes, packed);
  if (packed_size == 0) return 0;  // more than a megabyte, or not compressible
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  static Frame unpacked;
  Require(decoder.Decode(std::span(packed).first(packed_size), unpacked) ==
          decoder.DecodeText(text, frame));
  return 0;
}
