#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clients/cpp/control.h"
#include "clients/rec/outlet.h"
#include "sim/player/clock.h"

namespace styled::rec {

// The control socket of the daemon that receives the playback. Recorded commands are repeated at
// their places among the datagrams. The outlet waits for a daemon that falls behind, so that no
// socket buffer overflows at any speed. Both rely on the daemon's counter of received datagrams.
// For a source that counts in another way (a rig's translator), the daemon is considered to have
// caught up when the counter has not changed for 20 ms and over several polls. The flag for late
// frames still depends on the daemon's clock (`styled --replay` uses the recording's clock).
class Steering final : public Outlet {
 public:
  // Refuses an invalid endpoint, invalid keys, and an endpoint where no daemon replies.
  static Result<std::unique_ptr<Steering>> Connect(
      const std::string& endpoint, player::Clock& clock,
      const std::optional<client::Curve>& curve = std::nullopt);

  void Note(const recording::Record& record) override;  // commands are repeated, too
  Status Play(const recording::Record& record) override;
  void Restart() override {}
  void Finish() override { CatchUp(); }

  // Call before each datagram; waits if too many are unacknowledged.
  void BeforeSending();
  // Waits until the daemon has received all that was sent.
  void CatchUp() { Settle(0); }

  std::uint64_t commands() const { return commands_; }
  // The daemon's refusals, one line each.
  const std::vector<std::string>& refused() const { return refused_; }

 private:
  Steering(std::unique_ptr<client::Control> control, player::Clock& clock)
      : control_(std::move(control)), clock_(clock) {}
  // Waits until at most `under_way` of the sent datagrams have not been received.
  void Settle(std::uint64_t under_way);
  std::optional<std::uint64_t> Received();  // by the daemon's counter; empty without a reply

  std::unique_ptr<client::Control> control_;
  player::Clock& clock_;
  std::uint64_t before_ = 0;  // received before the first datagram
  std::uint64_t sent_ = 0;
  std::uint64_t known_ = 0;  // of `sent_`: certainly received
  std::uint64_t commands_ = 0;
  std::vector<std::string> refused_;
};

}  // namespace styled::rec
