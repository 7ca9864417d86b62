#pragma once

#include <ostream>
#include <string>

#include "clients/cpp/reach.h"
#include "clients/nats/bridge.h"

namespace styled::stylenats {

// An event of the connection to the broker, as text. `brokers`: their addresses; `lost` and
// `again`: the consequence, "; ..." or "".
std::string EventText(const LinkEvent& event, const std::string& brokers, const std::string& lost,
                      const std::string& again);

// Prints the events of the connections, and the counters when they changed. One thread.
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
  std::string why_;         // the last printed state of the daemon
  bool daemon_ = false;     // it was printed as present
  std::string last_error_;  // of the broker
  Totals shown_;
};

}  // namespace styled::stylenats
