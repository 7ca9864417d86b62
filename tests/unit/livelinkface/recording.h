#pragma once

#include <gtest/gtest.h>
#include <zlib.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

namespace styled::live_link_face::testing {

// `data`: the folder of data where STYLED_DATA is not set. The frames of a recording of LLV: gzip
// of { u8 6; u32 n; n x { u32 size; datagram } }.
inline std::vector<std::vector<std::byte>> ReadRecording(const std::string& name,
                                                         const char* data) {
  const char* set = std::getenv("STYLED_DATA");
  const std::filesystem::path folder = set != nullptr ? set : data;
  const gzFile file = gzopen((folder / "packets" / "livelinkface" / name).c_str(), "rb");
  std::vector<std::vector<std::byte>> datagrams;
  if (file == nullptr) return datagrams;
  const auto word = [file] {
    std::uint32_t value = 0;
    for (int i = 0; i < 4; ++i) value = value << 8U | static_cast<std::uint32_t>(gzgetc(file));
    return value;
  };
  if (gzgetc(file) == 6) {
    for (std::uint32_t left = word(); left > 0; --left) {
      std::vector<std::byte>& datagram = datagrams.emplace_back(word());
      if (gzread(file, datagram.data(), static_cast<unsigned>(datagram.size())) !=
          static_cast<int>(datagram.size())) {
        ADD_FAILURE() << name << ": cut";
      }
    }
  }
  gzclose(file);
  return datagrams;
}

}  // namespace styled::live_link_face::testing
