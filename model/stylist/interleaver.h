#pragma once

#include <array>
#include <cstdint>

#include "model/base/realtime.h"
#include "model/net/stylizer.h"
#include "model/stylist/stylist.h"
#include "model/stylist/tuning.h"

namespace styled::stylist {

// The frame-rate rule (style-ERD, "live"): a network is trained at one rate f_m; a stream of k
// times that rate is served by k interleaved recurrent states, each stepped at f_m. Ticks lie on a
// grid in source time; a frame within 20 % of a period of its tick is taken as it is, otherwise the
// state is stepped on the input interpolated at its own tick. Missed ticks are made up by
// interpolation, as far as the allowance of work goes: whatever a sender's clock does, one frame
// never runs more than kMaxStepsPerFrame ticks, nor n frames in a row more than
// kMaxStepsPerFrame + n * kMeanStepsPerFrame.
class Interleaver {
 public:
  // Forgets everything but the allowance; the next frame is the first.
  STYLED_REALTIME void Restart() noexcept;

  // Announces the frame at `time_ns`. Returns false, and the caller restarts, if the stream's rate
  // has changed so that another number of states is due, or if the ticks since the last frame are
  // more than the allowance.
  [[nodiscard]] STYLED_REALTIME bool Begin(std::int64_t time_ns, float network_rate_hz) noexcept;

  // The next tick that is due at the current frame: which state, and where between the frame before
  // (share 0) and this one (share 1). False when none is left.
  struct Tick {
    int state = 0;
    float share = 1.0F;
  };
  [[nodiscard]] STYLED_REALTIME bool Next(Tick& tick) noexcept;

  int interleaved() const { return interleaved_; }
  // Median time between the last frames, s; 0 before the second.
  double frame_period_s() const { return frame_period_s_; }

 private:
  STYLED_REALTIME void Measure(double dt_s) noexcept;
  STYLED_REALTIME void Interleave(int states, double network_rate_hz) noexcept;
  STYLED_REALTIME bool Afford() noexcept;

  std::array<double, tuning::kRateHistory> history_s_{};
  int history_count_ = 0, history_next_ = 0, disagreements_ = 0;
  double frame_period_s_ = 0;

  int interleaved_ = 0;  // 0: not yet decided, one state
  double tick_period_s_ = 0;
  std::int64_t origin_ns_ = 0, last_ns_ = 0, now_ns_ = 0;
  std::int64_t next_tick_ = 0;
  bool started_ = false;
  int allowance_ = kMaxStepsPerFrame;  // ticks
  int ran_ = 0;                        // of the current frame
};

}  // namespace styled::stylist
