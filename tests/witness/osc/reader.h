#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/daemon.h"
#include "tests/support/rig.h"
#include "tests/unit/vmc_out/ear.h"

#ifndef OSC_MIN_FOLDER
#define OSC_MIN_FOLDER "."  // CMakeLists.txt says where npm put it
#endif

// Others' programs that print the OSC messages that come to a port: liblo's oscdump, and npm's
// osc-min by vmc.mjs.
namespace styled::support {

using Lines = std::vector<std::string>;
using stylevmc::Ear;

inline bool IsHere(const std::string& program) {
  return std::system(("command -v " + program + " >/dev/null 2>&1").c_str()) == 0;
}
inline bool HasOscMin() {
  return IsHere("node") && std::filesystem::exists(OSC_MIN_FOLDER "/node_modules/osc-min");
}

// Why a test with this reader is skipped; "": it is not.
inline std::string Missing(const std::string& program) {
  if (program == "oscdump" && !IsHere("oscdump"))
    return "skipped, no oscdump (Debian: liblo-tools)";
  if (program == "osc-min" && !HasOscMin()) return "skipped, no osc-min (npm)";
  return "";
}

// The first that differs, not both lists.
inline void ExpectTheSame(const Lines& read, const Lines& sent) {
  EXPECT_EQ(read.size(), sent.size());
  for (std::size_t i = 0; i < std::min(read.size(), sent.size()); ++i) {
    ASSERT_EQ(read[i], sent[i]) << "message " << i;
  }
}

inline Lines Split(const std::string& text) {
  std::istringstream stream(text);
  Lines lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// "ADDRESS ,TYPES VALUE ..." with floats as bits, to oscdump's "ADDRESS TYPES VALUE ...".
inline std::string AsOscdump(const std::string& line) {
  std::istringstream words(line);
  std::string address, types, word;
  words >> address >> types;
  std::string out = address;
  if (types.size() > 1) out += " " + types.substr(1);
  for (std::size_t i = 1; words >> word; ++i) {
    if (types.at(i) == 's') word = "\"" + word + "\"";
    if (types.at(i) == 'f') {
      char text[64];
      const auto bits = static_cast<std::uint32_t>(std::stoul(word, nullptr, 16));
      std::snprintf(text, sizeof text, "%f", std::bit_cast<float>(bits));
      word = text;
    }
    out += " " + word;
  }
  return out;
}

// Another project's program, which prints the messages that arrive at a port.
class Reader {
 public:
  static constexpr const char* kProbe = "/ready";

  // "oscdump" or "osc-min".
  explicit Reader(const std::string& program)
      : oscdump_(program == "oscdump"), port_(Ear().port()) {
    const std::string command = oscdump_
                                    ? "oscdump -L " + port_
                                    : "cd '" OSC_MIN_FOLDER "' && exec node vmc.mjs read " + port_;
    child_ = std::make_unique<Child>(
        Lines{"/bin/sh", "-c", (oscdump_ ? "exec " : "") + command + " > '" + file() + "'"},
        folder_ / "stderr.txt");
    // Listens once it has printed a message.
    const UdpLink link(address());
    Bytes probe(12, std::byte{0});
    std::memcpy(probe.data(), kProbe, 6);
    probe[8] = std::byte{','};
    for (int i = 0; i < 400 && ReadText(file()).empty(); ++i) {
      link.Send(probe);
      Sleep(0.05);
    }
    EXPECT_FALSE(ReadText(file()).empty()) << ReadText(folder_ / "stderr.txt");
  }

  std::string address() const { return "127.0.0.1:" + port_; }
  std::string file() const { return folder_ / "out.txt"; }

  // The printed messages, as soon as there are `count` and no more arrive.
  Lines WaitFor(std::size_t count) const {
    Lines lines;
    for (int i = 0; i < 200; ++i) {
      Sleep(0.05);
      const Lines now = Read();
      if (now.size() >= count && now.size() == lines.size()) return now;
      lines = now;
    }
    return lines;
  }
  // The same lines as this reader prints them.
  Lines Expect(const Lines& sent) const {
    Lines lines;
    for (const std::string& line : sent) lines.push_back(oscdump_ ? AsOscdump(line) : line);
    return lines;
  }

 private:
  Lines Read() const {
    Lines lines;
    for (std::string& line : Split(ReadText(file()))) {
      if (oscdump_) line.erase(0, line.find(' ') + 1);  // the time tag
      while (line.ends_with(' ')) line.pop_back();
      if (!line.starts_with(kProbe)) lines.push_back(std::move(line));
    }
    return lines;
  }

  bool oscdump_;
  std::string port_;
  TemporaryFolder folder_;
  std::unique_ptr<Child> child_;
};

}  // namespace styled::support
