#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "tests/unit/mocopi/decode_cases.h"

namespace styled::mocopi::testing {

// A datagram of the real thing, of the MIT-licensed t-34400/mocopi_protocol_supplement; empty where
// there is no data. In $STYLED_DATA, else in `usual`.
inline Bytes ReadRecording(const std::string& name, const std::string& usual) {
  const char* set = std::getenv("STYLED_DATA");
  const std::filesystem::path folder = set != nullptr ? set : usual;
  std::ifstream file(folder / "packets" / name, std::ios::binary);
  const std::string text(std::istreambuf_iterator<char>(file), {});
  return Text(text);
}

}  // namespace styled::mocopi::testing
