#pragma once

#include <optional>
#include <string>

#include "tests/support/temporary_folder.h"

namespace styled::support {

// Stands in for the service manager and the journal: a datagram socket in its own folder that
// stores what it receives.
class Datagrams {
 public:
  Datagrams();
  ~Datagrams();
  Datagrams(const Datagrams&) = delete;
  Datagrams& operator=(const Datagrams&) = delete;
  const std::string& path() const { return path_; }

  // The next datagram; empty if none arrives within `seconds`.
  std::optional<std::string> Next(double seconds = 0);
  // The next datagram that contains `text`; earlier ones are dropped. Empty if none arrives in 20
  // s.
  std::optional<std::string> Await(const std::string& text);

 private:
  TemporaryFolder folder_;
  std::string path_;
  int fd_;
};

}  // namespace styled::support
