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

// Runs the control socket on its own thread, so that a daemon that does not answer never blocks the
// display. Keys become queued commands; the drawing thread reads their outcome. All functions may
// be called from the drawing thread and return at once. The destructor waits for the command in
// flight, at most its timeout.
class Steering {
 public:
  // The state for the drawing thread.
  struct State {
    std::vector<std::string> styles;  // without neutral, in the daemon's order
    std::string message;              // outcome of the last command; for a refusal, the reason
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
  void Change(const std::string& performer, const v1::Look& change, const std::string& what);

  std::unique_ptr<client::Control> control_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::deque<Command> commands_;
  State state_;
  std::jthread thread_;
};

}  // namespace styled::stylemon
