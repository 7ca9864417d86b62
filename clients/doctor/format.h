#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "proto/rigs/types.h"

namespace styled::doctor {

// The formats that the daemon accepts: our own, and the rigs of proto/rigs/types.h.
#define STYLED_RIG(Name, ...) k##Name,
enum class Format : std::uint8_t { kUnknown, kNative, STYLED_RIGS(STYLED_RIG) kCount };
#undef STYLED_RIG

// The text of `in_the_sender` for a sender that uses TCP, or UDP.
std::string InTheSender(Format format, bool stream);
const rigs::RigType& Row(Format format);  // also of kUnknown
// The format of a source.type ("udp", "mvn-tcp"); kUnknown for an unknown type and for USB.
Format FormatOfType(std::string_view type);
bool IsStreamType(std::string_view type);  // the type uses TCP
// The source.type for `format`; "" for kUnknown.
std::string_view TypeFor(Format format, bool stream);
// Of all types that come over a network, "udp, tcp, ...".
std::string NetworkTypes();

}  // namespace styled::doctor
