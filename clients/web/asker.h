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

#include "clients/cpp/control.h"

namespace styled::web {

// Runs the daemon's control socket on its own thread, so that a daemon that does not answer never
// delays frames. Requests are sent one after another. Any thread may call Ask; the destructor waits
// for the request in flight, at most its timeout.
class Asker {
 public:
  // The outcome of a request. If `status` is ok or refused, `reply` is the daemon's. Called on the
  // asker's thread.
  using Done = std::function<void(client::CallStatus status, v1::Reply reply)>;

  // Refuses an endpoint that ZeroMQ cannot parse, and invalid keys.
  static Result<std::unique_ptr<Asker>> Start(const std::string& endpoint,
                                              const std::optional<client::Curve>& curve = {});
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
  explicit Asker(std::unique_ptr<client::Control> control);
  void Loop(const std::stop_token& stop);

  std::unique_ptr<client::Control> control_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::deque<Waiting> waiting_;
  std::jthread thread_;
};

}  // namespace styled::web
