#pragma once

#include <array>
#include <cstdint>

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/net/stylizer.h"
#include "model/stylist/stylist.h"
#include "model/stylist/tuning.h"

namespace styled::stylist {

// The frame-rate rule (model/README.md, 3). A network is trained at one rate; a stream of k times
// that rate is served by k interleaved recurrent states, each stepped at the network's rate. Ticks
// lie on a grid in source time. A frame within 20 % of a period of its tick is used as it is;
// otherwise the state is stepped with the input interpolated at its tick. Missed ticks are made up
// with interpolated input, within an allowance of work: whatever a sender's clock does, one frame
// never runs more than kMaxStepsPerFrame ticks, and n frames in a row never more than
// kMaxStepsPerFrame + n * kMeanStepsPerFrame. Fixed size, no allocation; one thread at a time.
// Pinned by tests/unit/stylist/interleaver_test.cpp.
class Interleaver {
 public:
  // Clears everything but the allowance: the next frame counts as the first.
  STYLED_REALTIME void Restart() noexcept;

  // Announces the frame at `time_ns`. Returns false if the caller must restart: the stream's rate
  // has changed so that another number of states is needed, or the ticks since the last frame
  // exceed the allowance.
  [[nodiscard]] STYLED_REALTIME bool Begin(std::int64_t time_ns, float network_rate_hz) noexcept;

  // The next tick that is due in the current frame: its state, and its place between the frame
  // before (share 0) and this one (share 1). Returns false if none is left.
  struct Tick {
    int state = 0;
    float share = 1.0F;
  };
  [[nodiscard]] STYLED_REALTIME bool Next(Tick& tick) noexcept;

  int interleaved() const { return interleaved_; }
  // Median time between the last frames, s; 0 before the second frame.
  double frame_period_s() const { return frame_period_s_; }
  // See model/base/checkpoint.h.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept;

 private:
  STYLED_REALTIME void Measure(double dt_s) noexcept;
  STYLED_REALTIME void Interleave(int states, double network_rate_hz) noexcept;
  STYLED_REALTIME bool Afford() noexcept;

  std::array<double, tuning::kRateHistory> history_s_{};
  int history_count_ = 0, history_next_ = 0, disagreements_ = 0;
  double frame_period_s_ = 0;

  int interleaved_ = 0;  // number of states; 0: not yet decided, one is used
  double tick_period_s_ = 0;
  std::int64_t origin_ns_ = 0, last_ns_ = 0, now_ns_ = 0;
  std::int64_t next_tick_ = 0;
  bool started_ = false;
  int allowance_ = kMaxStepsPerFrame;  // ticks
  int ran_ = 0;                        // ticks run in the current frame
};

}  // namespace styled::stylist
