#include "clients/web/access.h"

#include <algorithm>

#include "proto/keys/key_folder.h"

namespace styled::web {
namespace {

constexpr std::size_t kMinToken = 16, kMaxToken = 256;

bool All(std::string_view text, bool (*is)(char)) noexcept {
  return std::all_of(text.begin(), text.end(), is);
}

bool IsDigit(char c) noexcept { return c >= '0' && c <= '9'; }

bool IsIpv6(std::string_view name) noexcept {
  const auto inside = [](char c) {
    return IsDigit(c) || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F') || c == ':' || c == '.';
  };
  return name.size() > 4 && name.front() == '[' && name.back() == ']' &&
         All(name.substr(1, name.size() - 2), inside);
}

// A name of digits and dots alone cannot be registered by a site: its last label would need a
// letter.
bool IsIpv4(std::string_view name) noexcept {
  return !name.empty() && IsDigit(name.front()) && IsDigit(name.back()) &&
         All(name, [](char c) { return IsDigit(c) || c == '.'; });
}

// The name in a Host, without port and final dot; "" where it is malformed.
std::string_view NameOf(std::string_view host) noexcept {
  std::string_view name = host;
  if (const std::size_t colon = host.rfind(':'); colon != host.npos && !host.ends_with(']')) {
    constexpr std::size_t kMostDigits = 5;
    const std::string_view port = host.substr(colon + 1);
    if (port.size() > kMostDigits || !All(port, IsDigit)) return {};
    name = host.substr(0, colon);
  }
  if (name.ends_with('.')) name.remove_suffix(1);
  return IsHostName(name) ? name : std::string_view();
}

// Host names and schemes are case-insensitive (RFC 9110, 4.2.3).
bool SameName(std::string_view a, std::string_view b) noexcept {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [&lower](char x, char y) { return lower(x) == lower(y); });
}

bool IsLoopbackName(std::string_view name) noexcept {
  return SameName(name, "localhost") || name == "[::1]" ||
         (name.starts_with("127.") && IsIpv4(name));
}

bool IsAllowedHost(const AccessRules& rules, std::string_view host) noexcept {
  const std::string_view name = NameOf(host);
  if (name.empty()) return false;
  if (IsLoopbackName(name)) return true;
  if (!rules.loopback && (!rules.token.empty() || IsIpv4(name) || IsIpv6(name))) return true;
  return std::any_of(rules.hosts.begin(), rules.hosts.end(),
                     [name](const std::string& known) { return SameName(name, known); });
}

bool IsOurs(const AccessRules& rules, std::string_view origin, std::string_view host) noexcept {
  const auto is_origin = [origin](const std::string& known) { return SameName(origin, known); };
  if (std::any_of(rules.origins.begin(), rules.origins.end(), is_origin)) return true;
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (!host.empty() && SameName(origin.substr(0, scheme.size()), scheme) &&
        SameName(origin.substr(scheme.size()), host)) {
      return true;
    }
  }
  return false;
}

// Compares in constant time, so that the duration does not reveal a correct prefix.
bool Same(std::string_view given, std::string_view token) noexcept {
  if (given.size() != token.size()) return false;
  unsigned different = 0;
  for (std::size_t i = 0; i < token.size(); ++i) {
    different |= static_cast<unsigned char>(given[i]) ^ static_cast<unsigned char>(token[i]);
  }
  return different == 0;
}

std::string_view TokenOf(const Credentials& credentials) noexcept {
  constexpr std::string_view kBearer = "Bearer ", kParameter = "token=";
  if (credentials.authorization.starts_with(kBearer)) {
    return credentials.authorization.substr(kBearer.size());
  }
  std::string_view query = credentials.target;
  const std::size_t mark = query.find('?');
  if (mark == std::string_view::npos) return {};
  query.remove_prefix(mark + 1);
  for (;;) {
    const std::size_t end = query.find('&');
    if (query.starts_with(kParameter)) {
      return query.substr(kParameter.size(), end - kParameter.size());
    }
    if (end == std::string_view::npos) return {};
    query.remove_prefix(end + 1);
  }
}

bool IsTokenCharacter(char c) noexcept {
  return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' ||
         c == '_' || c == '~' || c == '-';
}

}  // namespace

bool IsHostName(std::string_view name) noexcept {
  if (name.starts_with('[')) return IsIpv6(name);
  return !name.empty() && All(name, [](char c) {
    return IsDigit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '.' || c == '-' ||
           c == '_';
  });
}

Verdict Judge(const AccessRules& rules, const Credentials& credentials, bool needs_token) noexcept {
  if (credentials.hosts > 1 || credentials.origins > 1) return Verdict::kTwice;
  if (!IsAllowedHost(rules, credentials.host)) return Verdict::kHost;
  if (!credentials.origin.empty() && !IsOurs(rules, credentials.origin, credentials.host)) {
    return Verdict::kOrigin;
  }
  if (needs_token && !rules.token.empty() && !Same(TokenOf(credentials), rules.token)) {
    return Verdict::kToken;
  }
  return Verdict::kAllowed;
}

std::string_view Explain(Verdict verdict) noexcept {
  switch (verdict) {
    case Verdict::kAllowed:
      return "";
    case Verdict::kTwice:
      return "Host or Origin occurs twice; expected each at most once";
    case Verdict::kHost:
      return "this gateway is not known by that name: call it by its address (on its own machine "
             "localhost), or name it with --host";
    case Verdict::kOrigin:
      return "a page of another site may not connect; allow it with --origin";
    case Verdict::kToken:
      return "the token is missing or wrong; expected ?token=... or Authorization: Bearer ...";
  }
  return "";
}

Result<std::string> ReadToken(const std::string& file) {
  const auto text = keys::ReadTokenFile(file);
  if (!text.ok()) return Status::Error("--token-file " + text.status().message());
  std::string token = text.value().substr(0, text.value().find('\n'));
  if (!token.empty() && token.back() == '\r') token.pop_back();
  if (token.size() < kMinToken || token.size() > kMaxToken ||
      !std::all_of(token.begin(), token.end(), IsTokenCharacter)) {
    return Status::Error(
        "--token-file " + file +
        ": its first line is not a token, expected 16 to 256 of A-Z a-z 0-9 . _ ~ -");
  }
  return token;
}

}  // namespace styled::web
