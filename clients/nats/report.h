#pragma once

#include <ostream>
#include <string>

#include "clients/cpp/reach.h"
#include "clients/nats/bridge.h"

namespace styled::stylenats {

// What happened to the connection to the broker, for people. `brokers`: their addresses; `lost` and
// `again`: what that means, "; ..." or "".
std::string EventText(const LinkEvent& event, const std::string& brokers, const std::string& lost,
                      const std::string& again);

// Prints what happens to the connections, and the counters when they changed. One thread.
class Report {
 public:
  Report(const Options& options, std::ostream& out, std::ostream& err);

  void PrintStart();
  // Call after every Step. True: the broker refused us for good, which was printed.
  bool PrintNews(Bridge& bridge);
  void PrintCounters(const Bridge& bridge, const FrameQueue& queue);

 private:
  void PrintDaemon(Bridge& bridge);

  const Options& options_;
  std::ostream& out_;
  std::ostream& err_;
  client::Lookout lookout_;
  std::string why_;         // what was said of the daemon
  bool daemon_ = false;     // was said to be there
  std::string last_error_;  // of the broker
  Totals shown_;
};

}  // namespace styled::stylenats
