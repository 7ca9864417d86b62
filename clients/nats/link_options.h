#pragma once

#include <string>
#include <vector>

#include "model/base/status.h"

namespace CLI {  // NOLINT(readability-identifier-naming): a library's
class App;
}

// How a program reaches a NATS broker: the options of its command line. Without libnats.
namespace styled::stylenats {

inline constexpr const char* kDefaultServer = "nats://127.0.0.1:4222";

struct LinkOptions {
  std::vector<std::string> servers = {kDefaultServer};  // nats://HOST:PORT or tls://HOST:PORT
  std::string name;                                     // shown by the broker's monitoring
  std::string user, password;                           // "": none
  std::string inbox;        // first token of the subjects of replies; "": _INBOX_USER, or _INBOX
  std::string credentials;  // file with JWT and seed, as nsc writes it; "": none
  // Callbacks of all subscriptions run on one thread of the process, not on one for each.
  bool shared_thread = false;
  std::string ca;  // file with certificates (PEM) that a tls:// the broker's must be signed by one
                   // of these
};

// Adds --nats (which `broker` explains), --nats-login, --nats-creds, --nats-inbox and
// --nats-ca. `login`: the
// file of --nats-login, for Complete.
void Declare(CLI::App& app, const std::string& broker, LinkOptions& options, std::string& login);
// Reads the login, if there is one. Errors name the option and the file.
Status Complete(const std::string& login, LinkOptions& options);

// Checks the text of a broker's address; the error says what was expected.
Status CheckServer(const std::string& server);
// "nats://A:4222, nats://B:4222"
std::string BrokersText(const LinkOptions& options);

}  // namespace styled::stylenats
