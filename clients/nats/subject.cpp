#include "clients/nats/subject.h"

namespace styled::stylenats {
namespace {

constexpr std::string_view kDigits = "0123456789ABCDEF";

bool IsPlain(char c) {
  return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' ||
         c == '-';
}

}  // namespace

std::string Escape(std::string_view name) {
  std::string token;
  token.reserve(name.size());
  for (const char c : name) {
    if (IsPlain(c)) {
      token += c;
      continue;
    }
    const auto byte = static_cast<unsigned char>(c);
    token += '=';
    token += kDigits[byte >> 4U];
    token += kDigits[byte & 15U];
  }
  return token;
}

std::optional<std::string> Unescape(std::string_view token) {
  if (token.empty()) return std::nullopt;
  std::string name;
  name.reserve(token.size());
  for (std::size_t i = 0; i < token.size(); ++i) {
    if (IsPlain(token[i])) {
      name += token[i];
      continue;
    }
    if (token[i] != '=' || token.size() - i < 3) return std::nullopt;
    const std::size_t high = kDigits.find(token[i + 1]), low = kDigits.find(token[i + 2]);
    if (high == std::string_view::npos || low == std::string_view::npos) return std::nullopt;
    const char c = static_cast<char>(high * 16 + low);
    if (IsPlain(c)) return std::nullopt;
    name += c;
    i += 2;
  }
  return name;
}

std::string FrameSubject(std::string_view site, std::string_view performer,
                         std::string_view stream) {
  return "styled." + Escape(site) + "." + Escape(performer) + "." + Escape(stream);
}

std::string BodySubject(std::string_view site, std::string_view performer,
                        std::string_view stream) {
  return FrameSubject(site, performer, stream) + ".body";
}

std::string ControlSubject(std::string_view site) { return "styledctl." + Escape(site); }

std::string BodyKey(std::string_view site, std::string_view performer, std::string_view stream) {
  return Escape(site) + ".body." + Escape(performer) + "." + Escape(stream);
}

std::string PerformerKey(std::string_view site, std::string_view performer) {
  return Escape(site) + ".performer." + Escape(performer);
}

}  // namespace styled::stylenats
