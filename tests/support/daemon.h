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

// The real `styled` as a child process. All ports are chosen by the system, the weights are random
// (styles "neutral", "style1" ... "style4", aliases "s1" ...) without the shipped "open" beside
// them, and the sources are UDP "rig" and TCP "tcp".
class Daemon {
 public:
  // `settings` as for --set: "performers.stale_ms=100". By default the time limits are so wide that
  // a busy machine makes no frame late, no sender stale and no style fade out. `extra` is TOML for
  // the configuration file. `weights`: a file to use instead of random weights, if not empty.
  explicit Daemon(std::vector<std::string> settings = {}, const std::string& extra = "",
                  const std::map<std::string, std::string>& environment = {},
                  const std::string& weights = "");

  // Starts the daemon (again, after Stop) and waits until it is ready; otherwise the test fails.
  void Start();
  // Sends SIGTERM. The exit code, or -1 if the daemon did not end within 5 s.
  int Stop();
  void Configure(const std::string& extra);  // rewrites the file; the test sends SIGHUP

  std::string udp, tcp, publish, control, osc;  // addresses
  std::string server_key;                       // "" if it requires no keys
  std::vector<std::string> listens;  // of all sources: the two above, then those of `extra`
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
