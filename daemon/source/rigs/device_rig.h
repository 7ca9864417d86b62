#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/source/note_limit.h"
#include "daemon/source/rigs/solved_stream.h"
#include "daemon/source/translator.h"
#include "model/base/realtime.h"
#include "model/base/status.h"
#include "model/devices/devices.h"

namespace styled::source {

// One performer who wears devices that measure where they are and how they are turned, whatever
// protocol they come by (VMC's devices, VRChat's trackers). Passes what they measure to the body
// solver (model/devices) and sends its poses: the rest pose until the first calibration, nothing
// while all are silent. Each calibration starts a new session, because the pose jumps. Pipeline
// thread; Take and Tick do not allocate once the devices are known and the first frame was sent.
// Pinned by tests/unit/vrchat/translator_test.cpp.
//
// A device is worn where `trackers` of the source says, else where the protocol has it by habit
// (`usual_part`), else where a calibration guesses it by height and side in the T-pose
// (devices::GuessParts), until the next one. Two devices are never on one part: the first keeps it.
class DeviceRig {
 public:
  static constexpr std::size_t kMaxDevices = 32;
  // A device that was silent for this long may be sent by somebody else, or make room for another.
  static constexpr std::int64_t kSilent_ns = 1'000'000'000;

  struct Device {
    std::string_view name;  // at most 64 bytes; the configuration's word for it
    int usual_part = devices::Seen::kUnknown;
    bool is_head = false, at_joint = false;  // as in devices::Seen
  };
  // Right-handed, +Y up, metres. What is not measured is NaN.
  struct Measured {
    body::Vec3 position_m;
    body::Quat rotation;
  };

  explicit DeviceRig(const config::Source& config);

  // Takes what a device measured. Refuses values that are not finite or beyond 1 km, and what
  // measures nothing (source.malformed), a device that another sender sends
  // (pipeline.second_sender), and new ones while kMaxDevices are live (source.table_full).
  void Take(const Device& device, const Measured& measured, std::uint64_t peer, std::int64_t now_ns,
            Outbox& out);
  // A heading that the sender gives for the performer in the T-pose, radians; for devices whose
  // places do not show it. It stays, for the head's device of the same sender, since some say it
  // once. For kSilent_ns another sender's is refused (pipeline.second_sender).
  STYLED_REALTIME void NoteHeading(float heading, std::uint64_t peer, std::int64_t now_ns,
                                   Outbox& out) noexcept;
  // The sender started again: a new session, with the calibration as it is.
  void Restart() { stream_.Restart(devices_.scale()); }

  void Tick(std::int64_t now_ns, Outbox& out);
  std::int64_t NextDeadline_ns() const { return stream_.NextDeadline_ns(); }
  // Whether frames are sent.
  bool speaks() const { return NextDeadline_ns() != Translator::kNever; }

  // Only kFull. The result is logged with the next Tick, with the parts of the devices and what
  // heading and size are from. Errors: nothing could be calibrated, or no size that a performer
  // has; the last calibration stays in force then.
  Status Calibrate(Calibration what, std::int64_t now_ns);

 private:
  struct Known {
    std::string name;
    bool is_head = false, at_joint = false;
    std::uint64_t peer = 0;
    int part = devices::Seen::kUnknown;
    bool fixed = false;  // the part is not a guess
    std::int64_t place_ns = 0, rotation_ns = 0, heard_ns = 0;
    Measured last;
  };

  Known* Find(const Device& device, std::uint64_t peer, std::int64_t now_ns, Outbox& out);
  int PartOf(const Device& device) const;
  void Introduce(Known& known, std::int64_t now_ns, Outbox& out);
  std::vector<devices::Seen> See(std::int64_t now_ns, std::vector<Known*>& who);
  bool IsTurned(const Known& known, std::int64_t now_ns) const;

  std::vector<config::Tracker> assigned_;
  std::vector<Known> known_;  // reserved
  devices::Devices::Options options_;
  devices::Devices devices_;
  SolvedStream stream_;
  bool calibrated_ = false;
  std::int64_t heard_ns_ = 0;  // the last device
  struct {
    float heading = 0;  // as noted
    std::uint64_t peer = 0;
    std::int64_t heard_ns = 0;  // 0: none
  } noted_;
  NoteLimit strangers_{static_cast<int>(kMaxDevices)};
  std::string note_;  // for the log
};

}  // namespace styled::source
