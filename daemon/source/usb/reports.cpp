#include "daemon/source/usb/reports.h"

#include <algorithm>
#include <cstring>
#include <type_traits>

namespace styled::source::usb {
namespace {

struct Header {
  std::int64_t arrival_ns = 0;
  std::uint32_t device = 0;
  std::uint32_t is_note = 0;
};
static_assert(std::is_trivially_copyable_v<Header>);

}  // namespace

Reports::Reports(runtime::Clock& clock, runtime::Counters& counters, std::size_t capacity)
    : clock_(clock), counters_(counters), ring_(capacity) {
  popped_.reserve(sizeof(Header) + kMaxSize);
}

bool Reports::Push(bool is_note, std::uint32_t device, std::span<const std::byte> bytes) noexcept {
  const Header header{clock_.Now_ns(), device, is_note ? 1U : 0U};
  const bool pushed = ring_.Push(
      {std::as_bytes(std::span(&header, 1)), bytes.first(std::min(bytes.size(), kMaxSize))});
  wakeup_.Signal();
  return pushed;
}

void Reports::PushData(std::uint32_t device, std::span<const std::byte> bytes) noexcept {
  if (!Push(false, device, bytes)) counters_.Add(runtime::Counter::kUsbRingFull);
}

void Reports::PushNote(std::string_view text) noexcept {
  (void)Push(true, 0, std::as_bytes(std::span(text)));
}

bool Reports::Pop(Report& report) noexcept {
  if (!ring_.Pop(popped_)) return false;
  Header header;
  std::memcpy(&header, popped_.data(), sizeof header);
  report = {header.is_note != 0, header.device, header.arrival_ns,
            std::span<const std::byte>(popped_).subspan(sizeof header)};
  return true;
}

}  // namespace styled::source::usb
