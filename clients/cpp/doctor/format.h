#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace styled::doctor {

// The formats that the daemon takes, as proto/rigs has them.
enum class Format : std::uint8_t {
  kUnknown,
  kNative,
  kVmc,
  kMvn,
  kMocopi,
  kNatNet,
  kRokoko,
  kSlimeVr,
  kCount
};

struct FormatRow {
  Format format;
  std::string_view word;               // for programs; the source's type, but for kNative
  std::string_view name;               // for people
  std::array<std::uint16_t, 2> ports;  // usual ones at the receiver, the daemon's first; 0: none
  std::string_view in_the_sender;      // what to look for there, one sentence
};

// `in_the_sender` for one that sends by TCP, or by UDP.
std::string InTheSender(Format format, bool stream);
const FormatRow& Row(Format format);  // of kUnknown too
// Of source.type: "udp", "mvn-tcp"; kUnknown where it is not known here.
Format FormatOfType(std::string_view type);
bool IsStreamType(std::string_view type);  // comes over TCP
// The type that a source for `format` has; "" for kUnknown.
std::string_view TypeFor(Format format, bool stream);

}  // namespace styled::doctor
