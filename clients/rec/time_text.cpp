#include "clients/rec/time_text.h"

#include <array>
#include <charconv>
#include <cstdio>
#include <ctime>

namespace styled::rec {
namespace {

constexpr std::int64_t kSecondIn_ns = 1'000'000'000;
constexpr double kLongest_s = 100 * 365 * 86400.0;  // ago

// Empty if the text is not "-NUMBER" and a unit.
Result<std::int64_t> ParseAgo(const std::string& text, std::int64_t now_ns) {
  double number = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data() + 1, end, number);
  double unit_s = 0;
  if (error == std::errc() && stop + 1 == end) {
    unit_s = *stop == 's' ? 1 : *stop == 'm' ? 60 : *stop == 'h' ? 3600 : *stop == 'd' ? 86400 : 0;
  }
  if (unit_s == 0 || !(number >= 0 && number * unit_s <= kLongest_s)) {
    return Status::Error("'" + text + "': expected e.g. -90s, -15m, -2h or -1d");
  }
  return now_ns - static_cast<std::int64_t>(number * unit_s * 1e9);
}

}  // namespace

Result<std::int64_t> ParseTime(const std::string& text, std::int64_t now_ns) {
  if (text.starts_with('-')) return ParseAgo(text, now_ns);
  const Status wrong = Status::Error(
      "'" + text + "': expected e.g. 2026-11-26T14:03:05, with Z at its end for UTC, or -15m");
  std::tm parts{};
  const char* rest = strptime(text.c_str(), "%Y-%m-%dT%H:%M:%S", &parts);
  if (rest == nullptr) {
    parts = {};
    rest = strptime(text.c_str(), "%Y-%m-%dT%H:%M", &parts);
  }
  if (rest == nullptr) return wrong;
  double fraction_s = 0;
  const char* const end = text.c_str() + text.size();
  if (*rest == '.') {
    const auto [stop, error] = std::from_chars(rest, end, fraction_s, std::chars_format::fixed);
    if (error != std::errc() || !(fraction_s >= 0 && fraction_s < 1)) return wrong;
    rest = stop;
  }
  const bool utc = *rest == 'Z';
  if (rest + (utc ? 1 : 0) != end) return wrong;
  parts.tm_isdst = -1;
  const std::time_t seconds = utc ? timegm(&parts) : std::mktime(&parts);
  if (seconds < 0) return wrong;
  return seconds * kSecondIn_ns + static_cast<std::int64_t>(fraction_s * 1e9 + 0.5);
}

std::string TimeText(std::int64_t unix_ns) {
  const std::time_t seconds = unix_ns / kSecondIn_ns;
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  std::array<char, 64> text{};
  const std::size_t size = std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%S", &parts);
  std::array<char, 16> fraction{};
  std::snprintf(fraction.data(), fraction.size(), ".%03dZ",
                static_cast<int>(unix_ns % kSecondIn_ns / 1'000'000));
  return std::string(text.data(), size) + fraction.data();
}

}  // namespace styled::rec
