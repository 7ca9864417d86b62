#include "clients/doctor/format.h"

#include <utility>

namespace styled::doctor {
namespace {

using rigs::RigType;

constexpr RigType kUnknownFormat{
    .word = "unknown",
    .name = "an unknown format",
    .in_the_sender = "Check the target address of the rig's software."};

}  // namespace

const RigType& Row(Format format) {
  if (format == Format::kUnknown) return kUnknownFormat;
  if (format == Format::kNative) return rigs::kNative;
  const auto first = static_cast<std::size_t>(Format::kNative) + 1;
  return rigs::kRigs[static_cast<std::size_t>(format) - first];
}

std::string InTheSender(Format format, bool stream) {
  std::string text(Row(format).in_the_sender);
  if (!stream) return text;
  for (const auto& [udp, tcp] :
       {std::pair<std::string_view, std::string_view>{"protocol UDP", "protocol TCP"},
        {"udp://", "tcp://"}}) {
    const std::size_t at = text.find(udp);
    if (at != std::string::npos) text.replace(at, udp.size(), tcp);
  }
  return text;
}

Format FormatOfType(std::string_view type) {
  const rigs::SourceType* const known = rigs::FindSourceType(type);
  if (known == nullptr || known->usb) return Format::kUnknown;
  auto format = static_cast<int>(Format::kNative);
  while (&Row(static_cast<Format>(format)) != known->rig) ++format;
  return static_cast<Format>(format);
}

bool IsStreamType(std::string_view type) {
  const rigs::SourceType* const known = rigs::FindSourceType(type);
  return known != nullptr && known->stream;
}

std::string_view TypeFor(Format format, bool stream) {
  const RigType& row = Row(format);
  return stream && !row.stream.empty() ? row.stream : row.datagrams;
}

std::string NetworkTypes() {
  std::string types;
  for (const rigs::SourceType& type : rigs::kSourceTypes) {
    if (!type.usb) types.append(types.empty() ? "" : ", ").append(type.name);
  }
  return types;
}

}  // namespace styled::doctor
