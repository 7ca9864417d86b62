#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "clients/cpp/stylemon/meter.h"
#include "clients/cpp/stylemon/screen.h"
#include "clients/cpp/stylemon/steering.h"
#include "clients/cpp/subscriber.h"

namespace styled::stylemon {

struct MonitorOptions {
  std::string publisher{client::kDefaultPublisher};
  std::string control{client::kDefaultControl};
  std::string performer;  // "" = the first that comes
  Side side = Side::kSide;
  std::optional<client::Curve> curve;  // for a daemon that asks for keys
};

enum class Key : std::uint8_t {
  kNextPerformer,
  kPreviousPerformer,
  kSide,
  kPause,
  kClear,
  kStronger,
  kWeaker,
  kMoreStyles
};

// Listens to a daemon and keeps a View of it: everybody's bodies and statistics, and one
// performer's input and styled frames, all of them, so that drops are counted. One thread at a
// time; control commands run on Steering's.
class Monitor {
 public:
  static Result<std::unique_ptr<Monitor>> Start(const MonitorOptions& options);
  ~Monitor();

  // Reads what comes for about `duration`, at most; returns early never, but for signals.
  void Listen(std::chrono::milliseconds duration);
  // The state of things now. The reference holds until the next call of anything here.
  const View& view();

  void Press(Key key);
  void PressStyle(int number);  // 1..9
  // Frames of the styled stream so far, of all performers that were looked at.
  std::uint64_t frames() const;

 private:
  struct Impl;
  explicit Monitor(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace styled::stylemon
