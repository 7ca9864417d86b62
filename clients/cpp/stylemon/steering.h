#pragma once

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

namespace styled::stylemon {

// The control socket on a thread of its own, so that a daemon that does not answer never stops the
// picture. Keys become commands in a queue; what came of them is read by the drawing thread. All
// functions may be called from the drawing thread and return at once; the destructor waits for the
// command in flight, at most its timeout.
class Steering {
 public:
  // What the drawing thread may show.
  struct State {
    std::vector<std::string> styles;  // neutral left out, the daemon's order
    std::string message;              // outcome of the last command, refusals with their reason
    bool bad = false;
  };

  static Result<std::unique_ptr<Steering>> Start(const std::string& endpoint,
                                                 const std::optional<client::Curve>& curve = {});
  ~Steering();
  Steering(const Steering&) = delete;
  Steering& operator=(const Steering&) = delete;

  void FetchStyles();
  void SetStyle(const std::string& performer, const std::string& style);
  void SetStrength(const std::string& performer, float strength);
  void Clear(const std::string& performer);
  State state();

 private:
  using Command = std::function<void(client::Control&)>;
  explicit Steering(std::unique_ptr<client::Control> control);
  void Loop(const std::stop_token& stop);
  void Push(Command command);
  void Change(const std::string& performer, const v1::Set& change, const std::string& what);

  std::unique_ptr<client::Control> control_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::deque<Command> commands_;
  State state_;
  std::jthread thread_;
};

}  // namespace styled::stylemon
