#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace styled::doctor {

// The formats that the daemon accepts, one per codec in proto/rigs and the native one.
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
  std::string_view word;               // machine-readable; equals source.type, except for kNative
  std::string_view name;               // for people
  std::array<std::uint16_t, 2> ports;  // at the receiver, the daemon's default first; 0: none
  std::string_view in_the_sender;      // where to look in the sending application, one sentence
};

// The text of `in_the_sender` for a sender that uses TCP, or UDP.
std::string InTheSender(Format format, bool stream);
const FormatRow& Row(Format format);  // also of kUnknown
// The format of a source.type ("udp", "mvn-tcp"); kUnknown for an unknown type.
Format FormatOfType(std::string_view type);
bool IsStreamType(std::string_view type);  // the type uses TCP
// The source.type for `format`; "" for kUnknown.
std::string_view TypeFor(Format format, bool stream);

}  // namespace styled::doctor
