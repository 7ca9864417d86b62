#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "model/base/status.h"

namespace styled::web {

// Decides which HTTP requests are answered. A web site can point its own name at this machine (DNS
// rebinding); a browser then sends that name as Host. On a loopback address Host must therefore be
// a loopback name, on another address without a token a numeric address or a loopback name; on
// both, a name of `hosts` is allowed, too. With a token on another address every name is allowed,
// because such a site does not have the token. On every address, a page of another site is refused:
// the browser sends the page's origin (Origin), which must be the gateway's own or listed. Names
// are compared case-insensitively, and without the dot that may end an absolute name.
struct AccessRules {
  bool loopback = true;    // the gateway listens on a loopback address
  std::string token = {};  // required if Judge is called with needs_token; "" = none
  // Names of this machine without a port, e.g. "stage.lan".
  std::vector<std::string> hosts = {};
  // Origins of other sites whose pages may connect, e.g. "http://stage.lan:5173".
  std::vector<std::string> origins = {};
};

// The parts of an HTTP request that access depends on; "" if absent.
struct Credentials {
  std::string_view host = {};           // the first Host
  std::string_view origin = {};         // the first Origin
  std::size_t hosts = 1, origins = 1;   // the number of each
  std::string_view authorization = {};  // Authorization
  std::string_view target = {};         // path and query
};

// kHost: a Host that is malformed, missing or not allowed. kTwice: a second Host or Origin. With
// two of them, a proxy in front of the gateway may have checked the one that the gateway does not
// read.
enum class Verdict : std::uint8_t { kAllowed, kTwice, kHost, kOrigin, kToken };

// `needs_token`: true for everything but the page itself, which is public. Any thread; allocates
// nothing.
Verdict Judge(const AccessRules& rules, const Credentials& credentials, bool needs_token) noexcept;

// Whether the text is a name or address as in Host, without a port: [::1], 10.0.0.5, stage.lan. Any
// thread.
bool IsHostName(std::string_view name) noexcept;

// Text for the body of a refusal: what was expected instead. "" for kAllowed.
std::string_view Explain(Verdict verdict) noexcept;

// Reads the token from the first line of `file`: 16 to 256 of A-Z a-z 0-9 . _ ~ -, which need no
// escaping in a URL. Like a key file, the file is refused if other users can read it or if another
// user owns it (proto/keys/key_folder.h). Errors name the file and what was expected.
Result<std::string> ReadToken(const std::string& file);

}  // namespace styled::web
