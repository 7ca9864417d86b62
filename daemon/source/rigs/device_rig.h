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

// One performer who wears devices that measure their own position and rotation, whatever their
// protocol (VMC's devices, VRChat's trackers). Passes the measurements to the body solver
// (model/devices) and sends its poses: the rest pose until the first calibration, nothing while all
// devices are silent. Each calibration starts a new session, because the pose jumps. Pipeline
// thread; Accept and Tick do not allocate once the devices are known and the first frame was sent.
// Pinned by tests/unit/vrchat/translator_test.cpp.
//
// A device's part comes from `trackers` of the source; else from the protocol's convention
// (`usual_part`); else a calibration guesses it by height and side in the T-pose
// (devices::GuessParts), until the next calibration. Two devices are never on one part: the first
// keeps it.
class DeviceRig {
 public:
  static constexpr std::size_t kMaxDevices = 32;
  // After this long a silent device may be sent by another sender, or make room for another device.
  static constexpr std::int64_t kSilent_ns = 1'000'000'000;

  struct Device {
    std::string_view name;  // at most 64 bytes; its name in the configuration
    int usual_part = devices::Seen::kUnknown;
    bool is_head = false, at_joint = false;  // as in devices::Seen
  };
  // Right-handed, +Y up, metres. A value that was not measured is NaN.
  struct Measured {
    body::Vec3 position_m;
    body::Quat rotation;
  };

  explicit DeviceRig(const config::Source& config);

  // Accepts a device's measurement. Refuses values that are not finite or beyond 1 km, and a
  // message without a measurement (source.malformed); a device that another sender sends
  // (pipeline.second_sender); and new ones while kMaxDevices are live (source.table_full).
  void Accept(const Device& device, const Measured& measured, std::uint64_t peer,
              std::int64_t now_ns, Outbox& out);
  // The performer's heading in the T-pose according to the sender, in radians, for devices whose
  // positions do not show it. It remains valid, for the head's device of the same sender, because
  // some senders send it only once. Within kSilent_ns, headings from another sender are refused
  // (pipeline.second_sender).
  STYLED_REALTIME void NoteHeading(float heading, std::uint64_t peer, std::int64_t now_ns,
                                   Outbox& out) noexcept;
  // The sender restarted: a new session, with the same calibration.
  void Restart() { stream_.Restart(devices_.scale()); }

  void Tick(std::int64_t now_ns, Outbox& out);
  std::int64_t NextDeadline_ns() const { return stream_.NextDeadline_ns(); }
  // Whether frames are sent.
  bool speaks() const { return NextDeadline_ns() != Translator::kNever; }

  // Only kFull. The result is logged with the next Tick, with the parts of the devices and the
  // sources of heading and size. Errors: nothing could be calibrated, or the size is implausible;
  // the last calibration then stays in force.
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
    float heading = 0;  // the part that was logged
    std::uint64_t peer = 0;
    std::int64_t heard_ns = 0;  // 0: none
  } noted_;
  NoteLimit strangers_{static_cast<int>(kMaxDevices)};
  std::string note_;  // for the log
};

}  // namespace styled::source
