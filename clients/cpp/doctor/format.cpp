#include "clients/cpp/doctor/format.h"

#include <algorithm>
#include <utility>

namespace styled::doctor {
namespace {

constexpr std::array<FormatRow, static_cast<std::size_t>(Format::kCount)> kRows{{
    {Format::kUnknown, "unknown", "an unknown format", {}, "Look where the rig's software sends."},
    {Format::kNative,
     "native",
     "styled's own format",
     {7000, 0},
     "Look at the sender's address and port (stylesim: --to udp://HOST:PORT)."},
    {Format::kVmc,
     "vmc",
     "VMC",
     {39540, 39539},
     "In the sending app switch the VMC (OSC) sender on and set address and port."},
    {Format::kMvn,
     "mvn",
     "Xsens MVN",
     {9763, 0},
     "In MVN: Options, Network Streamer: add a target with address and port, protocol UDP, and "
     "tick Position + Orientation (Quaternion)."},
    {Format::kMocopi,
     "mocopi",
     "Sony mocopi",
     {12351, 0},
     "In the mocopi app: Settings, PC connection: address and port, format mocopi (UDP); then "
     "press Send."},
    {Format::kNatNet,
     "natnet",
     "OptiTrack NatNet",
     {1511, 0},
     "In Motive: Streaming: Broadcast Frame Data on, Skeletons on, Local Interface not loopback."},
    {Format::kRokoko,
     "rokoko",
     "Rokoko Studio",
     {14043, 0},
     "In Rokoko Studio: Livestream, Custom: forward IP and port, data format JSON v3."},
    {Format::kSlimeVr,
     "slimevr",
     "SlimeVR",
     {6969, 0},
     "Trackers look for their server by broadcast: they must be in this machine's network, and no "
     "SlimeVR server may run here."},
}};

constexpr bool InOrder() {
  for (std::size_t i = 0; i < kRows.size(); ++i) {
    if (static_cast<std::size_t>(kRows[i].format) != i) return false;
  }
  return true;
}
static_assert(InOrder());

}  // namespace

const FormatRow& Row(Format format) { return kRows[static_cast<std::size_t>(format)]; }

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
  if (type == "udp" || type == "tcp") return Format::kNative;
  if (type.ends_with("-tcp")) type.remove_suffix(4);
  const auto row = std::ranges::find_if(
      kRows, [type](const FormatRow& r) { return r.format > Format::kNative && r.word == type; });
  return row == kRows.end() ? Format::kUnknown : row->format;
}

bool IsStreamType(std::string_view type) { return type == "tcp" || type.ends_with("-tcp"); }

std::string_view TypeFor(Format format, bool stream) {
  if (format == Format::kUnknown) return "";
  if (format == Format::kNative) return stream ? "tcp" : "udp";
  if (format == Format::kMvn && stream) return "mvn-tcp";
  return Row(format).word;
}

}  // namespace styled::doctor
