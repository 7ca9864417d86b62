#include "clients/nats/link_options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <sstream>

#include "proto/keys/key_folder.h"

namespace styled::stylenats {
namespace {

// The user and the password in a file, which no other user may read.
Status ReadLogin(const std::string& file, LinkOptions& link) {
  const auto text = keys::ReadTokenFile(file);
  if (!text.ok()) return Status::Error("--nats-login " + text.status().message());
  std::istringstream lines(text.value());
  for (std::string* const line : {&link.user, &link.password}) {
    std::getline(lines, *line);
    if (!line->empty() && line->back() == '\r') line->pop_back();
    if (line->empty()) {
      return Status::Error("--nats-login " + file + ": expected two lines, a user and a password");
    }
  }
  return Status::Ok();
}

// The address for a logged message: without a user and password before an @, and without anything
// after the port, such as ?token=.
std::string WithoutSecrets(const std::string& server) {
  const std::size_t slashes = server.find("//");
  const std::size_t host = slashes == std::string::npos ? 0 : slashes + 2;
  const std::size_t at = server.rfind('@');
  const bool user = at != std::string::npos && at >= host;
  std::string shown =
      server.substr(0, host) + (user ? "..." + server.substr(at) : server.substr(host));
  if (const std::size_t more = shown.find_first_of("/?#", host); more != std::string::npos) {
    shown.replace(more, std::string::npos, "...");
  }
  return shown;
}

}  // namespace

void Declare(CLI::App& app, const std::string& broker, LinkOptions& options, std::string& login) {
  app.add_option("--nats", options.servers, broker)
      ->envname("STYLED_NATS")
      ->allow_extra_args(false)
      ->capture_default_str();
  app.add_option("--nats-login", login,
                 "file whose first line is the user, its second the password; refused where others "
                 "can read it");
  app.add_option("--nats-creds", options.credentials,
                 "credentials file of nsc (JWT and seed), instead of --nats-login");
  app.add_option(
      "--nats-inbox", options.inbox,
      "first token of the subjects of replies to this program, if the broker permits "
      "another one; default: _INBOX_ and the user's name, or _INBOX without --nats-login");
  app.add_option("--nats-ca", options.ca,
                 "certificates, PEM, one of which has signed a tls:// broker's; default: the "
                 "system's");
}

Status Complete(const std::string& login, LinkOptions& options) {
  if (!login.empty() && !options.credentials.empty()) {
    return Status::Error("--nats-login and --nats-creds: expected one of them");
  }
  if (!login.empty()) {
    if (Status status = ReadLogin(login, options); !status.ok()) return status;
  }
  if (!options.credentials.empty() && !std::ifstream(options.credentials)) {
    return Status::Error("--nats-creds " + options.credentials + ": cannot be read");
  }
  return Status::Ok();
}

Status CheckServer(const std::string& server) {
  const bool tls = server.starts_with("tls://");
  const auto fail = [&server](const std::string& what) {
    return Status::Error("--nats '" + WithoutSecrets(server) + "': " + what +
                         "; expected nats://HOST:PORT or tls://HOST:PORT");
  };
  if (!tls && !server.starts_with("nats://")) return fail("neither nats:// nor tls://");
  const std::string rest = server.substr(server.find("//") + 2);
  if (rest.find('@') != std::string::npos) {
    return fail(
        "a user in the address is visible to everyone on this machine: use --nats-login FILE");
  }
  if (rest.find_first_of("/?#") != std::string::npos) return fail("something follows the port");
  const std::size_t colon = rest.rfind(':');
  const std::string port = colon == std::string::npos ? "" : rest.substr(colon + 1);
  if (colon == 0 || colon == std::string::npos) return fail("host or port is missing");
  if (port.empty() || port.size() > 5 ||
      !std::all_of(port.begin(), port.end(), [](char c) { return c >= '0' && c <= '9'; }) ||
      std::stoi(port) < 1 || std::stoi(port) > 65535) {
    return fail("'" + port + "' is not a port, 1 to 65535");
  }
  return Status::Ok();
}

std::string BrokersText(const LinkOptions& link) {
  std::string text;
  for (const std::string& server : link.servers) text += (text.empty() ? "" : ", ") + server;
  return text;
}

}  // namespace styled::stylenats
