#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "clients/cpp/subscriber.h"
#include "clients/stylemon/meter.h"
#include "clients/stylemon/screen.h"
#include "clients/stylemon/steering.h"

namespace styled::stylemon {

struct MonitorOptions {
  std::string publisher{client::kDefaultPublisher};
  std::string control{client::kDefaultControl};
  std::string performer;  // "" = the first that appears
  Side side = Side::kSide;
  std::optional<client::Curve> curve;  // for a daemon that requires keys
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

// Listens to a daemon and maintains a View of it: the bodies of all performers, the statistics, and
// the input and styled frames of one performer. It reads every frame, so that drops are counted.
// One thread at a time; control commands run on the thread of Steering.
class Monitor {
 public:
  static Result<std::unique_ptr<Monitor>> Start(const MonitorOptions& options);
  ~Monitor();

  // Receives messages for about `duration`; only a signal ends it earlier.
  void Listen(std::chrono::milliseconds duration);
  // The current state. The reference is valid until the next call of any member function.
  const View& view();

  void Press(Key key);
  void PressStyle(int number);  // 1..9
  // Number of styled frames received, over all performers that were selected.
  std::uint64_t frames() const;

 private:
  struct Impl;
  explicit Monitor(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace styled::stylemon
