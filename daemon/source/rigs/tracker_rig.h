#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/source/note_limit.h"
#include "daemon/source/rigs/solved_stream.h"
#include "daemon/source/translator.h"
#include "model/base/status.h"
#include "model/rig/trackers.h"
#include "proto/rigs/slimevr/hid.h"
#include "proto/rigs/slimevr/tracker_id.h"

namespace styled::source {

// One performer who carries SlimeVR's trackers, however their records arrive (UDP, or the receiver
// on USB). Passes the records to the body solver and sends its poses at config.rate_hz, as body
// "canonical" in metres: the rest pose until the first full reset, nothing while all trackers are
// silent. Each reset starts a new session, because the pose jumps. Pipeline thread; Accept and Tick
// do not allocate once the first frame was sent. Pinned by tests/unit/slimevr/tracker_rig_test.cpp.
class TrackerRig {
 public:
  explicit TrackerRig(const config::Source& config);

  static constexpr int kUnassigned = -1;
  // The joint that carries the tracker: as configured; else, if no other tracker has that joint,
  // the one that the tracker itself reports (`position`, SlimeVR's TrackerPosition; 0: none). Logs
  // the result the first time. For trackers without a joint, which anyone can forge, it logs at
  // most one line a second after the first kMaxKnown / 4. Allocates: keep the result.
  int PartOf(const slimevr::TrackerId& id, int position, std::int64_t now_ns, Outbox& out);

  // The addresses of the devices that the configuration names, each once.
  std::vector<std::uint64_t> ConfiguredDevices() const;

  STYLED_REALTIME void Accept(body::Joint part, const slimevr::Orientation& orientation,
                              std::int64_t now_ns) noexcept;
  void Tick(std::int64_t now_ns, Outbox& out);
  std::int64_t NextDeadline_ns() const { return stream_.NextDeadline_ns(); }

  // The result is logged with the next Tick, including the trackers left out. Errors: nothing could
  // be calibrated.
  Status Calibrate(Calibration what, std::int64_t now_ns);

 private:
  struct Known {
    slimevr::TrackerId id;
    int part = kUnassigned;
    bool logged = false;  // the result was logged
  };
  static constexpr std::size_t kMaxKnown = 256;

  int FreePart(int position) const;
  void ReportPart(const slimevr::TrackerId& id, int part, std::int64_t now_ns, Outbox& out);

  std::vector<Known> assigned_;  // by the configuration
  std::vector<Known> known_;     // trackers that are not configured; oldest first
  NoteLimit strangers_{kMaxKnown / 4};
  std::string note_;  // for the log
  bool calibration_requested_ = false;
  rig::Trackers::Options options_;
  rig::Trackers trackers_;
  SolvedStream stream_;
};

}  // namespace styled::source
