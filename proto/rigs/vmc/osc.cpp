#include "proto/rigs/vmc/osc.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "proto/rigs/result_name.h"

namespace styled::vmc::osc {
namespace {

constexpr std::string_view kBundle{"#bundle\0", 8};
constexpr std::size_t kBundleHeader = 16;  // includes the timetag

std::uint32_t Word(std::span<const std::byte> bytes) noexcept {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i)
    value = (value << 8U) | std::to_integer<std::uint32_t>(bytes[i]);
  return value;
}

constexpr std::size_t Padded(std::size_t size) noexcept { return (size + 3) & ~std::size_t{3}; }

// Removes `size` bytes and their zero padding to a multiple of 4 from the front of `bytes`.
bool SkipPadded(std::span<const std::byte>& bytes, std::size_t size) noexcept {
  if (size > bytes.size() || Padded(size) > bytes.size()) return false;
  const auto padding = bytes.subspan(size, Padded(size) - size);
  bytes = bytes.subspan(Padded(size));
  return std::ranges::all_of(padding, [](std::byte byte) { return byte == std::byte{0}; });
}

// Removes a text and its padding from the front of `bytes`. Returns false if it has no end.
bool ReadText(std::span<const std::byte>& bytes, std::string_view& text) noexcept {
  const auto end = std::find(bytes.begin(), bytes.end(), std::byte{0});
  if (end == bytes.end()) return false;
  text = {reinterpret_cast<const char*>(bytes.data()),
          static_cast<std::size_t>(end - bytes.begin())};
  return SkipPadded(bytes, text.size() + 1);
}

// Checks that the bytes of the arguments match their types exactly.
Result CheckArguments(std::string_view types, std::span<const std::byte> bytes) noexcept {
  const auto skip = [&bytes](std::size_t size) {
    if (size > bytes.size()) return false;
    bytes = bytes.subspan(size);
    return true;
  };
  std::string_view text;
  for (const char type : types) {
    bool there = true;
    switch (type) {
      case 'i':
      case 'f':
      case 'c':
      case 'r':
      case 'm':
        there = skip(4);
        break;
      case 'h':
      case 't':
      case 'd':
        there = skip(8);
        break;
      case 's':
      case 'S':
        there = ReadText(bytes, text);
        break;
      case 'b': {
        const std::size_t size = bytes.size() < 4 ? 0 : Word(bytes);
        there = skip(4) && SkipPadded(bytes, size);
        break;
      }
      case 'T':
      case 'F':
      case 'N':
      case 'I':
      case '[':  // an array's brackets have no argument bytes
      case ']':
        break;
      default:
        return Result::kBadTypes;
    }
    if (!there) return Result::kBadArguments;
  }
  return bytes.empty() ? Result::kOk : Result::kSurplus;
}

Result ReadMessage(std::span<const std::byte> bytes, Message& message) noexcept {
  message.bytes = bytes;
  if (bytes.front() != std::byte{'/'} || !ReadText(bytes, message.address)) {
    return Result::kBadAddress;
  }
  message.types = {};
  // Old senders omit the type tags of a message without arguments.
  if (!bytes.empty()) {
    if (bytes.front() != std::byte{','} || !ReadText(bytes, message.types)) {
      return Result::kBadTypes;
    }
    message.types.remove_prefix(1);
  }
  message.arguments = bytes;
  return CheckArguments(message.types, bytes);
}

}  // namespace

std::string_view Name(Result result) noexcept {
  return rigs::ResultName(result,
                          {"ok", "too_short", "too_long", "bad_size", "bad_address", "bad_types",
                           "bad_arguments", "surplus", "bad_element", "too_deep"});
}

Reader::Reader(std::span<const std::byte> datagram) noexcept { rest_[0] = datagram; }

Reader::Step Reader::Fail(Result why) noexcept {
  result_ = why;
  return Step::kBroken;
}

// Reads a message, or opens a bundle. kEnd means a bundle was opened and there is no message yet.
Reader::Step Reader::EnterElement(std::span<const std::byte> element, Message& message) noexcept {
  if (element.size() % 4 != 0) return Fail(Result::kBadSize);
  if (element.size() >= kBundle.size() &&
      std::memcmp(element.data(), kBundle.data(), kBundle.size()) == 0) {
    if (element.size() < kBundleHeader) return Fail(Result::kTooShort);
    if (depth_ == kMaxDepth) return Fail(Result::kTooDeep);
    rest_[static_cast<std::size_t>(++depth_)] = element.subspan(kBundleHeader);
    return Step::kEnd;
  }
  const Result result = ReadMessage(element, message);
  return result == Result::kOk ? Step::kMessage : Fail(result);
}

Reader::Step Reader::Next(Message& message) noexcept {
  if (result_ != Result::kOk) return Step::kBroken;
  if (!started_) {
    started_ = true;
    const auto datagram = rest_[0];
    if (datagram.empty()) return Fail(Result::kTooShort);
    if (datagram.size() > kMaxDatagramSize) return Fail(Result::kTooLong);
    const Step step = EnterElement(datagram, message);
    if (step != Step::kEnd) return step;
  }
  while (depth_ > 0) {
    auto& rest = rest_[static_cast<std::size_t>(depth_)];
    if (rest.empty()) {
      --depth_;
      continue;
    }
    // `rest` has at least 4 bytes: like the bundle, it is a multiple of 4.
    const std::size_t size = Word(rest);
    if (size == 0 || size > rest.size() - 4) return Fail(Result::kBadElement);
    const auto element = rest.subspan(4, size);
    if (size % 4 != 0) return Fail(Result::kBadSize);
    rest = rest.subspan(4 + size);
    const Step step = EnterElement(element, message);
    if (step != Step::kEnd) return step;
  }
  return Step::kEnd;
}

Result Check(std::span<const std::byte> datagram) noexcept {
  Reader reader(datagram);
  Message message;
  while (reader.Next(message) == Reader::Step::kMessage) {
  }
  return reader.result();
}

bool Arguments::ReadWord(char type, std::uint32_t& word) noexcept {
  if (types_.empty() || types_.front() != type) return false;
  word = Word(bytes_);
  bytes_ = bytes_.subspan(4);
  types_.remove_prefix(1);
  return true;
}

bool Arguments::Int(std::int32_t& value) noexcept {
  std::uint32_t word = 0;
  if (!ReadWord('i', word)) return false;
  value = static_cast<std::int32_t>(word);
  return true;
}

bool Arguments::Float(float& value) noexcept {
  std::uint32_t word = 0;
  if (!ReadWord('f', word)) return false;
  value = std::bit_cast<float>(word);
  return true;
}

bool Arguments::Text(std::string_view& value) noexcept {
  if (types_.empty() || types_.front() != 's') return false;
  types_.remove_prefix(1);
  return ReadText(bytes_, value);
}

std::byte* Writer::Grow(std::size_t size) noexcept {
  if (!ok_ || size > out_.size() - size_) {
    ok_ = false;
    return nullptr;
  }
  std::byte* const at = out_.data() + size_;
  size_ += size;
  return at;
}

void Writer::Word(std::uint32_t value) noexcept {
  std::byte* const at = Grow(4);
  if (at == nullptr) return;
  for (std::size_t i = 0; i < 4; ++i) at[i] = static_cast<std::byte>(value >> (24 - 8 * i));
}

// Writes `first`, if it is not 0, before the text.
void Writer::Padded(char first, std::string_view text) noexcept {
  text = text.substr(0, text.find('\0'));
  const std::size_t before = first == 0 ? 0 : 1;
  const std::size_t size = osc::Padded(before + text.size() + 1);
  std::byte* const at = Grow(size);
  if (at == nullptr) return;
  std::memset(at, 0, size);
  if (first != 0) at[0] = static_cast<std::byte>(first);
  if (!text.empty()) std::memcpy(at + before, text.data(), text.size());
}

// Within a bundle, an element is preceded by its size.
void Writer::BeginElement() noexcept {
  if (depth_ > kMaxDepth) {
    ok_ = false;
    return;
  }
  if (depth_ > 0) Word(0);
  begin_[static_cast<std::size_t>(depth_++)] = size_;
}

void Writer::EndElement() noexcept {
  if (!ok_ || depth_ == 0) return;
  const std::size_t begin = begin_[static_cast<std::size_t>(--depth_)];
  if (depth_ == 0) return;
  const std::size_t end = size_;
  size_ = begin - 4;
  Word(static_cast<std::uint32_t>(end - begin));
  size_ = end;
}

void Writer::BeginBundle() noexcept {
  if (depth_ == kMaxDepth) ok_ = false;
  BeginElement();
  std::byte* const at = Grow(kBundle.size());
  if (at != nullptr) std::memcpy(at, kBundle.data(), kBundle.size());
  Word(0);
  Word(1);
}

void Writer::EndBundle() noexcept { EndElement(); }

void Writer::BeginMessage(std::string_view address, std::string_view types) noexcept {
  BeginElement();
  Padded(0, address);
  Padded(',', types);
}

void Writer::Int(std::int32_t value) noexcept { Word(static_cast<std::uint32_t>(value)); }
void Writer::Float(float value) noexcept { Word(std::bit_cast<std::uint32_t>(value)); }
void Writer::Text(std::string_view value) noexcept { Padded(0, value); }
void Writer::EndMessage() noexcept { EndElement(); }

void Writer::Raw(std::span<const std::byte> message) noexcept {
  BeginElement();
  std::byte* const at = Grow(message.size());
  if (at != nullptr && !message.empty()) std::memcpy(at, message.data(), message.size());
  EndElement();
}

}  // namespace styled::vmc::osc
