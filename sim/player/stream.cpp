#include "sim/player/stream.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "model/base/crc32c.h"
#include "model/rig/dialects.h"

namespace styled::player {

using faults::Fault;

namespace {
// As many joints as fit into the largest datagram beside a frame's other fields.
constexpr int kOversizedJoints = 4080;
}  // namespace

bool IsPerformerName(std::string_view name) {
  return !name.empty() && name.size() <= 32 && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  });
}

Stream::Stream(StreamOptions options, std::unique_ptr<Motion> motion, faults::Faults faults)
    : options_(std::move(options)),
      motion_(std::move(motion)),
      faults_(faults),
      buffer_(native::kMaxDatagramSize) {
  assert(IsPerformerName(options_.performer) && options_.new_session);
  BeginSession();
}

std::uint64_t Stream::Ticks(double milliseconds) const {
  return static_cast<std::uint64_t>(std::ceil(milliseconds * options_.rate_hz / 1000.0));
}

void Stream::BeginSession() {
  session_ = options_.new_session();
  sequence_ = 0;
  frame_index_ = 0;
  burst_end_tick_ = 0;
  occlusions_.clear();
  faults_.ResetClock();
  ++counts_.sessions;
  MakeBody();
}

void Stream::MakeBody() {
  const RigBody& rig = motion_->body();
  body_.Clear();
  body_.set_performer(options_.performer);
  for (int j = 0; j < rig.skeleton.joint_count(); ++j) {
    body_.add_names(rig.skeleton.names[j]);
    body_.add_parents(rig.skeleton.parents[j]);
    for (const float value : rig.skeleton.offsets[j]) body_.add_offsets(value);
  }
  for (const rig::Quat& rotation : rig.rest) {
    for (const float value : rotation.coeffs()) body_.add_rest(value);
  }
  body_.set_metres_per_unit(rig.metres_per_unit);
  body_.set_dialect(rig.dialect);
  binding_.reset();
  if (!options_.props.empty()) {
    auto bound = rig::BindDialect(rig.skeleton, rig.dialect);
    if (bound.ok()) binding_ = std::move(bound.value());
  }
  const std::string bytes = body_.SerializeAsString();
  body_crc_ = Crc32c(std::as_bytes(std::span(bytes)));
}

void Stream::MakeFrame(Fault fault) {
  frame_.Clear();
  frame_.set_performer(options_.performer);
  const double true_ns = static_cast<double>(frame_index_) * 1e9 / options_.rate_hz;
  const double error_ns = faults_.ClockError_s(true_ns * 1e-9, fault) * 1e9;
  frame_.set_source_time_ns(
      static_cast<std::uint64_t>(std::max(0LL, std::llround(true_ns + error_ns))));
  if (options_.timecode_s) AddTimecode();
  for (const float value : pose_.translations[0]) frame_.add_root_position(value);
  for (const rig::Quat& rotation : pose_.rotations) {
    for (const float value : rotation.coeffs()) frame_.add_rotations(value);
  }
  AddProps();
  frame_.set_body_crc(body_crc_);
  Occlude(fault);
  if (fault == Fault::kNan) SpoilJoint();
  if (fault == Fault::kOversized) frame_.mutable_rotations()->Resize(4 * kOversizedJoints, 0.5F);
}

void Stream::AddTimecode() {
  constexpr std::uint64_t kRate = 30, kDay_s = 86400;
  const double time_s = *options_.timecode_s + static_cast<double>(frame_index_) / options_.rate_hz;
  const auto frames = static_cast<std::uint64_t>(std::floor(time_s * kRate + 1e-6));
  const std::uint64_t seconds = frames / kRate % kDay_s;
  v1::Timecode& timecode = *frame_.mutable_timecode();
  timecode.set_hours(static_cast<std::uint32_t>(seconds / 3600));
  timecode.set_minutes(static_cast<std::uint32_t>(seconds / 60 % 60));
  timecode.set_seconds(static_cast<std::uint32_t>(seconds % 60));
  timecode.set_frames(static_cast<std::uint32_t>(frames % kRate));
  timecode.set_rate(kRate);
}

void Stream::AddProps() {
  if (!binding_) return;
  const rig::Wrists wrists(*binding_);
  const rig::WristPair pair = wrists.Read(pose_.translations[0], pose_.rotations);
  for (const PropSpec& spec : options_.props) {
    const auto placed = PlaceOf(spec, pair);
    if (!placed) continue;
    rig::Vec3 position;
    rig::Quat rotation;
    rig::FromCanonical(*binding_, *placed, position, rotation);
    v1::Prop& prop = *frame_.add_props();
    prop.set_name(spec.name);
    for (const float value : position) prop.add_position(value);
    for (const float value : rotation.coeffs()) prop.add_rotation(value);
  }
}

// Replaces one joint's rotation by an invalid one.
void Stream::SpoilJoint() {
  constexpr float kBad[] = {std::numeric_limits<float>::quiet_NaN(),
                            std::numeric_limits<float>::infinity(), 0.0F};
  const std::uint32_t joint = faults_.Choose(static_cast<std::uint32_t>(pose_.rotations.size()));
  const float bad = kBad[faults_.Choose(3)];
  for (std::uint32_t i = 0; i < 4; ++i) {
    frame_.set_rotations(static_cast<int>(4 * joint + i), bad);
  }
}

// Starts an occlusion if `fault` is one, and hides the joints of all current occlusions.
void Stream::Occlude(Fault fault) {
  if (const auto joints = static_cast<std::uint32_t>(pose_.rotations.size());
      fault == Fault::kOcclude && joints > 1) {
    const auto frames = static_cast<std::uint32_t>(faults_.spec().occlude_frames);
    occlusions_.push_back({1 + faults_.Choose(joints - 1), frames});
  }
  for (Occlusion& occlusion : occlusions_) {
    for (std::uint32_t i = 0; i < 4; ++i) {
      frame_.set_rotations(static_cast<int>(4 * occlusion.joint + i),
                           std::numeric_limits<float>::quiet_NaN());
    }
    --occlusion.frames_left;
  }
  std::erase_if(occlusions_, [](const Occlusion& o) { return o.frames_left == 0; });
}

// Encodes the message as a datagram at the start of buffer_; returns its size.
std::size_t Stream::Pack(native::Kind kind, const google::protobuf::MessageLite& message) {
  const std::size_t size = message.ByteSizeLong();
  std::byte* const payload = buffer_.data() + native::kHeaderSize;
  const bool fits =
      size <= native::kMaxPayloadSize && message.SerializeToArray(payload, static_cast<int>(size));
  return fits ? native::Encode({kind, session_, sequence_++, {payload, size}}, buffer_) : 0;
}

Status Stream::SendBody(Link& link) {
  const std::size_t size = Pack(native::Kind::kBody, body_);
  if (size == 0) {
    return Status::Error("performer " + options_.performer + ": its skeleton of " +
                         std::to_string(body_.names_size()) +
                         " joints does not fit into a datagram of 65507 bytes");
  }
  ++counts_.bodies;
  // Queued with the frames held back, to keep the order.
  if (burst_end_tick_ > 0 && tick_ <= burst_end_tick_) {
    Hold(burst_end_tick_, size);
    return Status::Ok();
  }
  return SendBytes(link, std::span(buffer_).first(size));
}

// Holds back the datagram at the start of buffer_ until `due_tick`.
void Stream::Hold(std::uint64_t due_tick, std::size_t size) {
  held_.push_back({due_tick, {buffer_.begin(), buffer_.begin() + std::ptrdiff_t(size)}});
}

Status Stream::SendFrame(Fault fault, Link& link) {
  std::size_t size = Pack(native::Kind::kSourceFrame, frame_);
  if (size == 0) return Status::Error("a frame does not fit into a datagram of 65507 bytes");
  if (fault == Fault::kLoss) return Status::Ok();
  if (fault == Fault::kReorder || fault == Fault::kLate) {
    // A reordered frame waits until the next one has left.
    const std::uint64_t wait =
        fault == Fault::kLate ? std::max<std::uint64_t>(2, Ticks(faults_.spec().late_ms)) : 1;
    Hold(tick_ + wait, size);
    return Status::Ok();
  }
  if (fault == Fault::kBurst) {
    burst_end_tick_ = tick_ + static_cast<std::uint64_t>(faults_.spec().burst_frames) - 1;
  }
  if (burst_end_tick_ > 0 && tick_ <= burst_end_tick_) {
    Hold(burst_end_tick_, size);
    return Status::Ok();
  }
  size = faults_.Damage(fault, buffer_.data(), size);
  const auto datagram = std::span<const std::byte>(buffer_).first(size);
  if (fault == Fault::kDuplicate) {
    if (Status status = SendBytes(link, datagram); !status.ok()) return status;
  }
  return SendBytes(link, datagram);
}

Status Stream::SendHeld(Link& link, bool all) {
  for (auto held = held_.begin(); held != held_.end();) {
    if (!all && held->due_tick > tick_) {
      ++held;
      continue;
    }
    if (Status status = SendBytes(link, held->datagram); !status.ok()) return status;
    held = held_.erase(held);
  }
  return Status::Ok();
}

Status Stream::Flush(Link& link) { return SendHeld(link, true); }

Stream::Step Stream::Tick(Link& link) {
  const auto failed = [this](Status status) {
    error_ = std::move(status);
    return Step::kError;
  };
  if (tick_ < silent_until_tick_) {
    ++tick_;
    return Step::kSilent;
  }
  const auto restart = [&] {
    if (Status status = SendHeld(link, true); !status.ok()) return failed(std::move(status));
    silent_until_tick_ = tick_ + Ticks(faults_.spec().restart_pause_ms);
    BeginSession();
    ++tick_;
    return Step::kSilent;
  };
  switch (motion_->Next(pose_)) {
    case Motion::Step::kEnd:
      return Step::kEnd;
    case Motion::Step::kError:
      return failed(motion_->error());
    case Motion::Step::kNewBody:
      return restart();
    case Motion::Step::kPose:
      break;
  }
  const auto frames_per_second =
      static_cast<std::uint64_t>(std::max(1LL, std::llround(options_.rate_hz)));
  if (frame_index_ % frames_per_second == 0) {
    if (Status status = SendBody(link); !status.ok()) return failed(std::move(status));
  }
  const Fault fault = faults_.Draw();
  MakeFrame(fault);
  ++counts_.frames;
  ++frame_index_;
  if (fault == Fault::kRestart) return restart();
  if (Status status = SendFrame(fault, link); !status.ok()) return failed(std::move(status));
  if (Status status = SendHeld(link, false); !status.ok()) return failed(std::move(status));
  ++tick_;
  return Step::kSent;
}

}  // namespace styled::player
