#pragma once

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/unit/natnet/bytes.h"

// Packets that others captured: single messages and a session of a Motive 2.1 server, of
// mje-nz/python_natnet (BSD-3).
namespace styled::natnet::testing {

// In $STYLED_DATA, else in `usual`.
inline std::filesystem::path CaptureFolder(const std::string& usual) {
  const char* set = std::getenv("STYLED_DATA");
  return std::filesystem::path(set != nullptr ? set : usual) / "packets";
}

inline Bytes ReadCaptured(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  Bytes bytes(text.size());
  std::memcpy(bytes.data(), text.data(), text.size());
  return bytes;
}

// The UDP payloads of a pcapng file's Enhanced Packet Blocks (Ethernet, IPv4).
inline std::vector<Bytes> ReadUdp(const Bytes& file) {
  const auto u32 = [&](std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, &file.at(at), sizeof value);
    return value;
  };
  std::vector<Bytes> payloads;
  for (std::size_t at = 0; at + 12 <= file.size(); at += u32(at + 4)) {
    if (u32(at) != 6) continue;
    const std::size_t ethernet = at + 28, ip = ethernet + 14;
    const std::size_t udp = ip + 4 * (std::to_integer<std::size_t>(file.at(ip)) & 15U);
    const std::size_t size = std::to_integer<std::size_t>(file.at(udp + 4)) << 8 |
                             std::to_integer<std::size_t>(file.at(udp + 5));
    const auto begin = file.begin() + static_cast<std::ptrdiff_t>(udp);
    payloads.emplace_back(begin + 8, begin + static_cast<std::ptrdiff_t>(size));
  }
  return payloads;
}

}  // namespace styled::natnet::testing
