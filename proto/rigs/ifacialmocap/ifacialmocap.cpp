#include "proto/rigs/ifacialmocap/ifacialmocap.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>

#include "proto/rigs/result_name.h"

namespace styled::ifacialmocap {
namespace {

constexpr float kPercent = 100;

bool ReadNumber(std::string_view text, float& value) noexcept {
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end && std::isfinite(value);
}

// As many numbers as `values` has, with commas between them.
bool ReadNumbers(std::string_view text, std::span<float> values) noexcept {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t comma = text.find(',');
    const bool last = i + 1 == values.size();
    if ((comma == std::string_view::npos) != last) return false;
    if (!ReadNumber(text.substr(0, comma), values[i])) return false;
    if (!last) text.remove_prefix(comma + 1);
  }
  return true;
}

// Which of "=head#", "rightEye#", "leftEye#" a part is; empty: another.
std::span<float> PlaceOf(std::string_view name, Frame& frame) noexcept {
  if (name.starts_with('=')) name.remove_prefix(1);
  if (name == "head") return frame.head;
  if (name == "rightEye") return frame.right_eye;
  if (name == "leftEye") return frame.left_eye;
  return {};
}

// Reads one part; returns false if its value is not a number. Sets `known` for a known part.
bool ReadPart(std::string_view part, Frame& frame, bool& known) noexcept {
  if (const std::size_t mark = part.find('#'); mark != std::string_view::npos) {
    const std::span<float> place = PlaceOf(part.substr(0, mark), frame);
    known = known || !place.empty();
    return place.empty() || ReadNumbers(part.substr(mark + 1), place);
  }
  std::size_t mark = part.find('&');  // values of version 2 may have a sign
  if (mark == std::string_view::npos) mark = part.find('-');
  if (mark == std::string_view::npos) return true;
  const auto shape = arkit::Find(part.substr(0, mark));
  if (!shape) return true;
  float percent = 0;
  if (!ReadNumber(part.substr(mark + 1), percent)) return false;
  frame.shapes[*shape] = percent / kPercent;
  ++frame.known;
  known = true;
  return true;
}

}  // namespace

std::string_view Name(DecodeResult result) noexcept {
  return rigs::ResultName(result, {"ok", "not_face", "bad_number", "too_long"});
}

DecodeResult Decode(std::span<const std::byte> datagram, Frame& frame) noexcept {
  frame = {};
  if (datagram.size() > kMaxSize) return DecodeResult::kTooLong;
  std::string_view text(reinterpret_cast<const char*>(datagram.data()), datagram.size());
  const bool printable = std::ranges::all_of(text, [](char c) { return c >= ' ' && c <= '~'; });
  if (!printable) return DecodeResult::kNotFace;
  bool known = false;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('|'), text.size());
    if (!ReadPart(text.substr(0, end), frame, known)) return DecodeResult::kBadNumber;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return known ? DecodeResult::kOk : DecodeResult::kNotFace;
}

std::size_t Encode(const Frame& frame, int version, std::span<char> to) noexcept {
  std::size_t size = 0;
  bool fits = true;
  const auto write = [&](const char* format, auto... values) {
    if (!fits) return;
    const int added = std::snprintf(to.data() + size, to.size() - size, format, values...);
    fits = added >= 0 && size + static_cast<std::size_t>(added) < to.size();
    if (fits) size += static_cast<std::size_t>(added);
  };
  for (std::size_t i = 0; i < arkit::kShapes; ++i) {
    const auto [stem, side] = arkit::SideOf(arkit::kNames[i]);
    const std::string_view end = side == 0 ? "" : side == 'L' ? "_L" : "_R";
    write("%.*s%s%c%ld|", static_cast<int>(stem.size()), stem.data(), end.data(),
          version == 1 ? '-' : '&', std::lround(kPercent * frame.shapes[i]));
  }
  const auto& h = frame.head;
  write("=head#%.9g,%.9g,%.9g,%.9g,%.9g,%.9g|", double{h[0]}, double{h[1]}, double{h[2]},
        double{h[3]}, double{h[4]}, double{h[5]});
  const auto& r = frame.right_eye;
  write("rightEye#%.9g,%.9g,%.9g|", double{r[0]}, double{r[1]}, double{r[2]});
  const auto& l = frame.left_eye;
  write("leftEye#%.9g,%.9g,%.9g|", double{l[0]}, double{l[1]}, double{l[2]});
  return fits ? size : 0;
}

}  // namespace styled::ifacialmocap
