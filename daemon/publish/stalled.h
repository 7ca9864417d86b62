#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace styled::publish {

// The remote addresses ("10.0.0.3:4711") of connections to `port` whose other side takes nothing
// more: its window is closed, or it has acknowledged nothing for several repetitions. `table`: the
// text of /proc/net/tcp or tcp6.
std::vector<std::string> FindStalled(std::string_view table, std::uint16_t port);

// Finds subscribers that have stopped reading. libzmq drops their messages at their own queue and
// tells nobody; but the kernel shows that their connection takes nothing. Of tcp:// addresses only.
// One thread.
class StalledSubscribers {
 public:
  // `endpoint`: the bound address; of another than tcp:// nothing is found.
  explicit StalledSubscribers(std::string_view endpoint);
  // Call about once a second. `fresh` and `recovered` receive those that are new since the last
  // call, and those that read again or have gone.
  void Look(std::vector<std::string>& fresh, std::vector<std::string>& recovered);
  // For tests: the same of given tables.
  void Judge(std::vector<std::string> stalled, std::vector<std::string>& fresh,
             std::vector<std::string>& recovered);
  std::size_t count() const { return stalled_.size(); }

 private:
  std::uint16_t port_ = 0;
  std::vector<std::string> last_;     // at the last look: one look alone may see a short pause
  std::vector<std::string> stalled_;  // at two looks in a row, and reported
};

}  // namespace styled::publish
