#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "model/rig/binding.h"
#include "proto/rigs/native/datagram.h"
#include "proto/styled/v1/body.pb.h"
#include "proto/styled/v1/frame.pb.h"
#include "sim/faults/faults.h"
#include "sim/player/motion.h"
#include "sim/player/props.h"
#include "sim/player/sender.h"

namespace styled::player {

struct StreamOptions {
  std::string performer = "sim";  // [A-Za-z0-9_-]{1,32}
  double rate_hz = 120;           // 1 .. 1000
  // Returns session ids, nonzero and different on each call: random in the program, counted in
  // tests.
  std::function<std::uint64_t()> new_session;
  // SMPTE timecode of each session's first frame, in seconds, counted at 30 frames per second.
  std::optional<double> timecode_s = {};
  std::vector<PropSpec> props = {};
};

// One performer as datagrams of the native protocol, with faults. The Body is sent first and then
// once per second of source time. Source time is the frame's index divided by the rate, from 0 in
// each session, with the drift and steps of the clock that the faults specify; the timecode has
// none of them. Between two sessions the performer is silent for Spec::restart_pause_ms. One
// thread. Pinned by tests/unit/sim/stream_test.cpp.
class Stream final : public Sender {
 public:
  Stream(StreamOptions options, std::unique_ptr<Motion> motion, faults::Faults faults);

  // Sends one frame, or none if it is lost or held back, or during silence.
  Step Tick(Link& link) override;
  Status Flush(Link& link) override;

  const std::string& performer() const { return options_.performer; }
  const faults::Faults& faults() const override { return faults_; }
  double NextDelay_s() override { return faults_.DrawJitter_s(); }

 private:
  struct Held {
    std::uint64_t due_tick;
    std::vector<std::byte> datagram;
  };
  struct Occlusion {
    std::uint32_t joint, frames_left;
  };

  void BeginSession();
  void MakeBody();
  void MakeFrame(faults::Fault fault);
  void AddTimecode();
  void AddProps();
  void SpoilJoint();
  void Occlude(faults::Fault fault);
  void Hold(std::uint64_t due_tick, std::size_t size);
  std::size_t Pack(native::Kind kind, const google::protobuf::MessageLite& message);
  Status SendFrame(faults::Fault fault, Link& link);
  Status SendBody(Link& link);
  Status SendHeld(Link& link, bool all);
  std::uint64_t Ticks(double milliseconds) const;

  StreamOptions options_;
  std::unique_ptr<Motion> motion_;
  faults::Faults faults_;
  v1::Body body_;
  std::optional<rig::Binding> binding_;  // where there are props, and the skeleton is known
  v1::SourceFrame frame_;
  rig::RigPose pose_;
  std::vector<std::byte> buffer_;
  std::vector<Held> held_;
  std::uint64_t session_ = 0, sequence_ = 0;
  std::uint64_t frame_index_ = 0;  // in this session
  std::uint64_t tick_ = 0, silent_until_tick_ = 0;
  std::uint64_t burst_end_tick_ = 0;  // frames produced before this tick are sent at it
  std::vector<Occlusion> occlusions_;
  std::uint32_t body_crc_ = 0;
};

// Whether `name` is a valid performer name ([A-Za-z0-9_-]{1,32}).
bool IsPerformerName(std::string_view name);

}  // namespace styled::player
