#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "model/base/status.h"

namespace styled::web {

// Who may ask. On a loopback address only what is called by a loopback name is answered: a web site
// whose name was made to point here (DNS rebinding) is not. On every address a page of another site
// is refused: a browser says whose page asks (Origin), and it must be ours. Names are compared
// without regard to case.
struct AccessRules {
  bool loopback = true;    // the gateway listens on a loopback address
  std::string token = {};  // to be shown by whom Judge is told to ask for it; "" = none
  std::vector<std::string> origins =
      {};  // of other pages that may ask, e.g. "http://stage.lan:5173"
};

// The parts of an HTTP request that decide; "" where absent.
struct Credentials {
  std::string_view host = {};           // Host, the first one
  std::string_view origin = {};         // Origin, the first one
  std::size_t hosts = 1, origins = 1;   // how many of each there are
  std::string_view authorization = {};  // Authorization
  std::string_view target = {};         // path and query
};

// kTwice: a second Host or Origin. Of two, a proxy before us may have judged the other one.
enum class Verdict : std::uint8_t { kAllowed, kTwice, kHost, kOrigin, kToken };

// `needs_token`: of what only those who have it may see; the page itself is for everybody. Any
// thread; allocates nothing.
Verdict Judge(const AccessRules& rules, const Credentials& credentials, bool needs_token) noexcept;

// What was expected instead, for the reply's body. "" for kAllowed.
std::string_view Explain(Verdict verdict) noexcept;

// The token in `file`: its first line, 16 to 256 of A-Z a-z 0-9 . _ ~ -, which needs no escaping in
// an address. A file that others can read, or that somebody else owns, is refused as a file of keys
// is (proto/keys/key_folder.h). Errors name the file and what was expected.
Result<std::string> ReadToken(const std::string& file);

}  // namespace styled::web
