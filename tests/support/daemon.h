#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/child.h"
#include "tests/support/clients.h"

namespace styled::erd {
struct WeightsFile;
}

namespace styled::support {

// The real `styled` as a child, all ports chosen by the system, with random weights (styles
// "neutral", "style1" ... "style4", aliases "s1" ...), UDP source "rig" and TCP source "tcp".
class Daemon {
 public:
  // `settings` as of --set: "performers.stale_ms=100". By default the limits on time are so wide
  // that a busy machine does not make frames late or senders silent. `extra` is TOML for the file.
  // `weights`: a file to use instead of random ones, if not empty.
  explicit Daemon(std::vector<std::string> settings = {}, const std::string& extra = "",
                  const std::map<std::string, std::string>& environment = {},
                  const std::string& weights = "");

  // Starts it (again, after Stop) and waits until it is ready; a test failure if it is not.
  void Start();
  // SIGTERM; its exit code, or -1 when it did not end within 5 s.
  int Stop();
  void Configure(const std::string& extra);  // rewrites the file; SIGHUP is the test's

  std::string udp, tcp, publish, control, osc;  // addresses
  std::string server_key;                       // "" where it asks nobody for keys
  std::vector<std::string> listens;             // of all sources, those of `extra` behind these two
  std::string Log() const { return ReadText(folder / "stderr.txt"); }

  TemporaryFolder folder;
  std::unique_ptr<Child> child;

 private:
  std::vector<std::string> settings_;
  std::map<std::string, std::string> environment_;
};

// Writes random weights of `styles` styles, neutral included.
void WriteRandomWeights(const std::string& file, int styles = 5, unsigned seed = 1);
void WriteWeights(const std::string& file, const erd::WeightsFile& weights);
// The path of the daemon's binary.
std::string Binary();

}  // namespace styled::support
