#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "model/base/status.h"

namespace styled::web {

// Which HTTP requests are answered. On a loopback address, only requests whose Host is a loopback
// name: that defeats a web site whose name was pointed at this machine (DNS rebinding). On every
// address, a page of another site is refused: the browser sends the page's origin (Origin), which
// must be the gateway's own or listed. Names are compared case-insensitively.
struct AccessRules {
  bool loopback = true;    // the gateway listens on a loopback address
  std::string token = {};  // required if Judge is called with needs_token; "" = none
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

// kTwice: a second Host or Origin. With two of them, a proxy in front of the gateway may have
// checked the other one.
enum class Verdict : std::uint8_t { kAllowed, kTwice, kHost, kOrigin, kToken };

// `needs_token`: true for everything but the page itself, which is public. Any thread; allocates
// nothing.
Verdict Judge(const AccessRules& rules, const Credentials& credentials, bool needs_token) noexcept;

// Text for the body of a refusal: what was expected instead. "" for kAllowed.
std::string_view Explain(Verdict verdict) noexcept;

// Reads the token from the first line of `file`: 16 to 256 of A-Z a-z 0-9 . _ ~ -, which need no
// escaping in a URL. Like a key file, the file is refused if other users can read it or if another
// user owns it (proto/keys/key_folder.h). Errors name the file and what was expected.
Result<std::string> ReadToken(const std::string& file);

}  // namespace styled::web
