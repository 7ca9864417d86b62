#include "proto/rigs/slimevr/tracker_id.h"

#include <algorithm>
#include <charconv>

namespace styled::slimevr {
namespace {

std::optional<unsigned> ParseNumber(std::string_view text, unsigned largest) {
  unsigned value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value > largest) return {};
  return value;
}

std::optional<std::uint64_t> ParseIpv4(std::string_view text) {
  std::uint64_t address = kIsIpv4 >> 32U;  // the loop below shifts it above the four bytes
  for (int i = 0; i < 4; ++i) {
    const auto dot = i < 3 ? text.find('.') : text.size();
    if (dot == std::string_view::npos) return {};
    const auto byte = ParseNumber(text.substr(0, dot), 255);
    if (!byte) return {};
    address = address << 8U | *byte;
    text.remove_prefix(std::min(text.size(), dot + 1));
  }
  return address;
}

std::optional<std::uint64_t> ParseAddress(std::string_view text) {
  std::uint64_t address = 0;
  int digits = 0;
  for (const char c : text) {
    if (c == ':' && digits % 2 == 0) continue;
    unsigned digit = 0;
    if (std::from_chars(&c, &c + 1, digit, 16).ec != std::errc()) return {};
    address = address << 4U | digit;
    ++digits;
  }
  if (digits != 12) return {};
  return address;
}

}  // namespace

std::optional<TrackerId> ParseTrackerId(std::string_view text) {
  TrackerId id;
  const auto slash = text.find('/');
  if (slash != std::string_view::npos) {
    const auto sensor = ParseNumber(text.substr(slash + 1), 255);
    if (!sensor) return {};
    id.sensor = static_cast<std::uint8_t>(*sensor);
    text = text.substr(0, slash);
  }
  const auto address =
      text.find('.') == std::string_view::npos ? ParseAddress(text) : ParseIpv4(text);
  if (!address) return {};
  id.address = *address;
  return id;
}

std::string ToText(const TrackerId& id) {
  std::string text;
  if ((id.address & kIsIpv4) != 0) {
    for (int shift = 24; shift >= 0; shift -= 8) {
      text += std::to_string(id.address >> static_cast<unsigned>(shift) & 0xFFU);
      if (shift > 0) text += '.';
    }
  } else {
    for (int shift = 44; shift >= 0; shift -= 4) {
      text += "0123456789ABCDEF"[id.address >> static_cast<unsigned>(shift) & 0xFU];
    }
  }
  return text + "/" + std::to_string(id.sensor);
}

}  // namespace styled::slimevr
