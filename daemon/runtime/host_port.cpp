#include "daemon/runtime/host_port.h"

#include <charconv>

#include "model/base/text.h"

namespace styled::runtime {
namespace {

constexpr std::size_t kShown = 128;  // bytes of the text that errors quote

}  // namespace

Result<HostPort> ParseHostPort(std::string_view text) {
  const auto refuse = [&text] {
    return Status::Error("\"" + Printable(text, kShown) +
                         "\" is not an address: expected HOST:PORT, e.g. \"0.0.0.0:7000\"");
  };
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos || colon == 0) return refuse();
  std::string_view host = text.substr(0, colon);
  const std::string_view port = text.substr(colon + 1);
  if (host.front() == '[' && host.back() == ']' && host.size() > 2) {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string_view::npos) {
    return refuse();
  }
  HostPort parsed{std::string(host), 0};
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), parsed.port);
  if (port.empty() || end != port.data() + port.size()) return refuse();
  if (error != std::errc()) {
    return Status::Error("\"" + Printable(text, kShown) + "\": the port is " +
                         Printable(port, kShown) + "; expected 0 to 65535");
  }
  return parsed;
}

}  // namespace styled::runtime
