#pragma once

#include <cstdint>

#include "daemon/decide/admission.h"
#include "daemon/decide/frame_in_transit.h"
#include "daemon/source/source_frame.h"
#include "model/base/realtime.h"

namespace styled::decide {

// [performers] of the configuration, as far as a frame's fate depends on it.
struct Limits {
  SessionRules rules;
  std::int64_t late_ns = 0;     // from here on a frame is flagged late
  std::int64_t backlog_ns = 0;  // from here on only the newest frame is published
};

// What a decision about a frame depends on beside the performer's Admission.
struct Question {
  const source::SourceFrame& frame;
  bool has_body = false;        // a body of the performer is known, bound or not,
  std::uint32_t body_crc = 0;   // with this CRC
  std::int64_t receive_ns = 0;  // when the batch was read
  std::int64_t now_ns = 0;
  bool newest = true;             // no frame of the performer behind it in the batch is newer
  bool more_waiting = false;      // the batch is full: newer frames may wait in the socket
  bool keep_all = false;          // late frames are published, however many
  std::int64_t last_send_ns = 0;  // of the performer
};

// Decides what is done with each frame and body: its session and order, its lateness, the backlog.
// It knows no performer, no clock and no socket: all that it depends on are its arguments and the
// performer's Admission, which it updates. The same datagrams at the same times therefore give the
// same decisions, in a replay and on a standby. Pipeline thread; allocates nothing. Pinned by
// tests/unit/daemon/decide/decider_test.cpp.
class Decider {
 public:
  explicit Decider(const Limits& limits) : limits_(limits) {}
  void SetLimits(const Limits& limits) { limits_ = limits; }

  // The fate of a frame; FATE_STYLED if the performer takes its pose.
  STYLED_REALTIME Decision OfFrame(Admission& admission, const Question& question) const noexcept;
  // The same where the leader has decided already: its decision, on this daemon's Admission.
  STYLED_REALTIME Decision OfFrame(Admission& admission, const Question& question,
                                   const Decision& leaders) const noexcept;
  // Whether a body is next; `reason` tells if not.
  STYLED_REALTIME Decision OfBody(Admission& admission, const source::SourceFrame& body,
                                  std::int64_t receive_ns) const noexcept;
  // Whether OfFrame might admit the frame; changes nothing.
  STYLED_REALTIME bool IsPlausible(const Admission& admission, const source::SourceFrame& frame,
                                   std::int64_t receive_ns) const noexcept;

 private:
  STYLED_REALTIME Decision Admit(Admission& admission, const Question& question) const noexcept;
  STYLED_REALTIME bool PassOver(const Question& question, std::int64_t lateness_ns) const noexcept;

  Limits limits_;
};

}  // namespace styled::decide
