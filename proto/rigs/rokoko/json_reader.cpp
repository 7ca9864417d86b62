#include "proto/rigs/rokoko/json_reader.h"

#include <algorithm>
#include <cstring>
#include <new>

namespace styled::rokoko {

JsonReader::JsonReader(std::size_t max_bytes)
    : max_bytes_(max_bytes),
      text_(std::make_unique<char[]>(max_bytes + simdjson::SIMDJSON_PADDING)) {
  if (parser_.allocate(max_bytes, kMaxDepth) != simdjson::SUCCESS) throw std::bad_alloc();
}

bool JsonReader::Fail(Error error) noexcept {
  if (ok()) error_ = error;
  return false;
}

bool JsonReader::Mismatch(Value& value, Type type) noexcept {
  Type found{};
  const bool other = value.type().get(found) == simdjson::SUCCESS && found != type;
  return Fail(other ? Error::kOther : Error::kSyntax);
}

bool JsonReader::Open(std::size_t size, simdjson::ondemand::document& document,
                      simdjson::ondemand::object& root) noexcept {
  error_ = Error::kNone;
  depth_ = 1;
  if (size > max_bytes_) return Fail(Error::kSyntax);
  // simdjson reads padding beyond the text, which must not contain an earlier text.
  std::memset(text_.get() + size, 0, simdjson::SIMDJSON_PADDING);
  if (parser_.iterate(text_.get(), size, size + simdjson::SIMDJSON_PADDING).get(document) !=
      simdjson::SUCCESS) {
    return Fail(Error::kSyntax);
  }
  Type type{};
  if (document.type().get(type) != simdjson::SUCCESS) return Fail(Error::kSyntax);
  if (type != Type::object) return Fail(Error::kOther);
  return document.get_object().get(root) == simdjson::SUCCESS || Fail(Error::kSyntax);
}

bool JsonReader::Close(simdjson::ondemand::document& document) noexcept {
  return document.current_location().error() == simdjson::OUT_OF_BOUNDS || Fail(Error::kSyntax);
}

bool JsonReader::Bool(Value& value, bool& flag) noexcept {
  return (ok() && value.get_bool().get(flag) == simdjson::SUCCESS) ||
         Mismatch(value, Type::boolean);
}

bool JsonReader::String(Value& value, std::span<char> out, std::size_t& size) noexcept {
  std::string_view text;
  if (!ok() || value.get_string().get(text) != simdjson::SUCCESS) {
    return Mismatch(value, Type::string);
  }
  if (HasHalfPair(text)) return Fail(Error::kSyntax);
  size = std::min(text.size(), out.size());
  // Goes back to the first byte of a character that does not fit.
  while (size < text.size() && size > 0 &&
         (static_cast<unsigned char>(text[size]) & 0xC0U) == 0x80) {
    --size;
  }
  std::copy_n(text.begin(), size, out.begin());
  return true;
}

bool JsonReader::Skip(Value& value) noexcept {
  Type type{};
  if (!ok() || value.type().get(type) != simdjson::SUCCESS) return Fail(Error::kSyntax);
  switch (type) {
    case Type::object:
      return Members(value, [this](std::string_view, Value& inner) { return Skip(inner); });
    case Type::array:
      return Elements(value, [this](Value& inner) { return Skip(inner); });
    case Type::string: {
      std::size_t size = 0;
      return String(value, {}, size);
    }
    case Type::number: {
      double number = 0;
      return Number(value, number);
    }
    case Type::boolean: {
      bool flag = false;
      return Bool(value, flag);
    }
    case Type::null: {
      bool null = false;
      return (value.is_null().get(null) == simdjson::SUCCESS && null) || Fail(Error::kSyntax);
    }
  }
  return Fail(Error::kSyntax);
}

}  // namespace styled::rokoko
