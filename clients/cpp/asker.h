#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "clients/cpp/control.h"

namespace styled::client {

// Whether the daemon may need long for it: an example, a preview, a style file.
bool IsLong(const v1::Request& request);

// Runs the daemon's control socket on threads of its own, so that a daemon that does not answer
// never delays frames. Requests are sent one after another, except long ones (IsLong): up to four
// of those wait for their replies in parallel, at most 10 s and the length of a take, so that a
// take of a minute does not delay Panic. Any thread may call Ask; the destructor waits for the
// requests in flight, at most their timeout without the length of a take.
class Asker {
 public:
  // The outcome of a request. If `status` is ok or refused, `reply` is the daemon's. Called on a
  // thread of the asker.
  using Done = std::function<void(CallStatus status, v1::Reply reply)>;

  // Refuses an endpoint that ZeroMQ cannot parse, and invalid keys.
  static Result<std::unique_ptr<Asker>> Start(const std::string& endpoint,
                                              const std::optional<Curve>& curve = {});
  ~Asker();
  Asker(const Asker&) = delete;
  Asker& operator=(const Asker&) = delete;

  // False if the queue is full; `done` is dropped then. A request that has waited longer than the
  // timeout is not sent.
  bool Ask(v1::Request request, Done done);

 private:
  struct Waiting {
    v1::Request request;
    Done done;
    std::chrono::steady_clock::time_point since;
  };
  // A control socket and its thread. A second one is connected when two long requests meet.
  struct Lane {
    std::unique_ptr<Control> control;
    std::condition_variable_any wake;
    std::deque<Waiting> waiting;
    bool busy = false;
    std::jthread thread;  // last: it ends before the rest
  };
  Asker() = default;
  Status AddLane();
  Lane* LaneFor(const v1::Request& request);
  void Loop(const std::stop_token& stop, Lane& lane);

  ControlOptions options_;
  std::stop_source ending_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Lane>> lanes_;  // the first one for all but long requests
};

}  // namespace styled::client
