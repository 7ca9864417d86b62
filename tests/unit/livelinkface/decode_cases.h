#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "proto/rigs/livelinkface/live_link_face.h"

namespace styled::live_link_face::testing {

using Bytes = std::vector<std::byte>;

struct Case {
  std::string name;
  Bytes bytes;
  DecodeResult result;
};

inline Bytes Written(const Frame& frame) {
  Bytes bytes(kMaxSize);
  bytes.resize(Encode(frame, bytes));
  return bytes;
}

inline Frame Smile(std::int32_t number = 1000) {
  Frame frame;
  frame.device = "DEVICE-1";
  frame.subject = "anna's phone";
  frame.frame = number;
  frame.subframe = 0.25F;
  frame.has_face = true;
  frame.values[23] = frame.values[24] = 0.75F;  // mouthSmileLeft, mouthSmileRight
  return frame;
}

// Bytes by hand: version 6, texts "A" and "B", frame 258, subframe 0.5, 60/1, no face.
inline Bytes ByHand() {
  Bytes bytes;
  for (const int byte : {6, 0,    0, 0, 1, int{'A'}, 0, 0, 0,  1, int{'B'}, 0, 0, 1,
                         2, 0x3F, 0, 0, 0, 0,        0, 0, 60, 0, 0,        0, 1}) {
    bytes.push_back(static_cast<std::byte>(byte));
  }
  return bytes;
}

inline std::vector<Case> DecodeCases() {
  const Bytes good = Written(Smile());
  const auto changed = [&good](std::size_t at, int byte) {
    Bytes bytes = good;
    bytes.at(at) = static_cast<std::byte>(byte);
    return bytes;
  };
  const std::size_t subject = 1 + 4 + 8, rate = subject + 4 + 12 + 8, count = rate + 8;
  std::vector<Case> cases{
      {"a face", good, DecodeResult::kOk},
      {"no face, by hand", ByHand(), DecodeResult::kOk},
      {"nothing", {}, DecodeResult::kNotFace},
      {"version 5", changed(0, 5), DecodeResult::kBadVersion},
      {"a text of 2^24 bytes", changed(1, 1), DecodeResult::kBadText},
      {"a negative length", changed(subject, 0xFF), DecodeResult::kBadText},
      {"rate 0", changed(rate + 3, 0), DecodeResult::kBadRate},
      {"a negative divisor", changed(rate + 4, 0x80), DecodeResult::kBadRate},
      {"52 values", changed(count, 52), DecodeResult::kBadCount},
      {"one byte less", Bytes(good.begin(), good.end() - 1), DecodeResult::kBadSize},
  };
  Bytes long_text = ByHand();
  long_text.at(4) = std::byte{250};
  cases.push_back({"a text that is longer than the datagram", long_text, DecodeResult::kNotFace});
  Bytes longer = good;
  longer.push_back(std::byte{0});
  cases.push_back({"one byte more", longer, DecodeResult::kBadSize});
  for (const std::size_t size : {std::size_t{3}, std::size_t{7}, subject + 2, rate - 1}) {
    const auto end = good.begin() + static_cast<std::ptrdiff_t>(size);
    cases.push_back(
        {"cut at " + std::to_string(size), Bytes(good.begin(), end), DecodeResult::kNotFace});
  }
  return cases;
}

}  // namespace styled::live_link_face::testing
