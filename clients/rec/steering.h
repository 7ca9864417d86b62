#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clients/cpp/control.h"
#include "clients/rec/outlet.h"
#include "sim/player/clock.h"

namespace styled::rec {

// The control socket of the daemon that is played to: recorded commands are given again at their
// places among the datagrams, and a daemon that falls behind is waited for, so that no socket runs
// over at any speed. What a frame's lateness decides stays a matter of the daemon's clock
// (`styled --replay` takes the recording's). Both by the daemon's own count of what it received; a
// source that counts in another way (a rig's translator) is taken to have caught up when the count
// stands still for 20 ms and some looks.
class Steering final : public Outlet {
 public:
  // Refuses an endpoint that makes no sense, keys that are none, and where nobody answers.
  static Result<std::unique_ptr<Steering>> Connect(
      const std::string& endpoint, player::Clock& clock,
      const std::optional<client::Curve>& curve = std::nullopt);

  void Note(const recording::Record& record) override;  // commands are given, too
  Status Take(const recording::Record& record) override;
  void Restart() override {}
  void Finish() override { CatchUp(); }

  // Called before each datagram; waits where too many are under way.
  void BeforeSending();
  // Waits until the daemon has received all that was sent.
  void CatchUp() { Settle(0); }

  std::uint64_t commands() const { return commands_; }
  // What the daemon refused, one line each.
  const std::vector<std::string>& refused() const { return refused_; }

 private:
  Steering(std::unique_ptr<client::Control> control, player::Clock& clock)
      : control_(std::move(control)), clock_(clock) {}
  // Waits until at most `under_way` of what was sent have not been received.
  void Settle(std::uint64_t under_way);
  std::optional<std::uint64_t> Received();  // by the daemon's count; nothing without an answer

  std::unique_ptr<client::Control> control_;
  player::Clock& clock_;
  std::uint64_t before_ = 0;  // received before the first datagram
  std::uint64_t sent_ = 0;
  std::uint64_t known_ = 0;  // of what was sent, received for certain
  std::uint64_t commands_ = 0;
  std::vector<std::string> refused_;
};

}  // namespace styled::rec
