#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace styled::publish {

// The remote addresses ("10.0.0.3:4711") of connections to `port` that no longer accept data: their
// window is closed, or several repetitions were not acknowledged. `table`: the text of
// /proc/net/tcp or tcp6.
std::vector<std::string> FindStalled(std::string_view table, std::uint16_t port);

// Finds subscribers that have stopped reading. libzmq silently drops their messages at their queue,
// but the kernel shows that their connection accepts no data. Only for tcp:// addresses. One
// thread.
class StalledSubscribers {
 public:
  // `endpoint`: the bound address. If it is not a tcp:// address, nothing is found.
  explicit StalledSubscribers(std::string_view endpoint);
  // Call about once a second. `fresh` receives the subscribers that have stalled since the last
  // call, `recovered` those that read again or have gone.
  void Look(std::vector<std::string>& fresh, std::vector<std::string>& recovered);
  // For tests: the same with given tables.
  void Judge(std::vector<std::string> stalled, std::vector<std::string>& fresh,
             std::vector<std::string>& recovered);
  std::size_t count() const { return stalled_.size(); }

 private:
  std::uint16_t port_ = 0;
  std::vector<std::string> last_;     // found in the last table; a single table may show a short
                                      // pause
  std::vector<std::string> stalled_;  // found in two tables in a row, and reported
};

}  // namespace styled::publish
