// Fuzzes styled::ifacialmocap: what is decoded is finite, and its whole percents are read again as
// they were written.
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "proto/rigs/ifacialmocap/ifacialmocap.h"

namespace {

void Require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace styled::ifacialmocap;
  Frame frame;
  if (Decode(std::as_bytes(std::span(data, size)), frame) != DecodeResult::kOk) return 0;
  for (float& shape : frame.shapes) {
    Require(std::isfinite(shape));
    if (!(std::abs(shape) < 1e4F)) shape = 0;
  }
  for (const float value : frame.head) Require(std::isfinite(value));
  std::array<char, kMaxSize> text;
  const std::size_t written = Encode(frame, 2, text);
  Require(written > 0);
  Frame again;
  Require(Decode(std::as_bytes(std::span(text).first(written)), again) == DecodeResult::kOk);
  for (std::size_t i = 0; i < frame.shapes.size(); ++i) {
    Require(std::abs(again.shapes[i] - frame.shapes[i]) <=
            0.0051F + 1e-5F * std::abs(frame.shapes[i]));
  }
  Require(again.head == frame.head && again.left_eye == frame.left_eye);
  return 0;
}
