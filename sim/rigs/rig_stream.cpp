#include "sim/rigs/rig_stream.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/rig/dialects.h"

namespace styled::rigs {

using faults::Fault;
using player::Motion;

Result<std::unique_ptr<RigStream>> RigStream::Make(
    std::unique_ptr<Rig> rig, std::vector<std::unique_ptr<player::Motion>> motions, double rate_hz,
    const faults::Spec& spec, std::vector<player::PropSpec> props) {
  std::unique_ptr<RigStream> stream(
      new RigStream(std::move(rig), std::move(motions), rate_hz, spec));
  stream->props_ = std::move(props);
  for (std::size_t k = 0; k < stream->motions_.size(); ++k) {
    if (Status status = stream->Bind(k); !status.ok()) return status;
  }
  return stream;
}

RigStream::RigStream(std::unique_ptr<Rig> rig, std::vector<std::unique_ptr<player::Motion>> motions,
                     double rate_hz, const faults::Spec& spec)
    : rig_(std::move(rig)),
      motions_(std::move(motions)),
      bindings_(motions_.size()),
      poses_(motions_.size()),
      rate_hz_(rate_hz),
      faults_(spec),
      received_(65536) {
  counts_.sessions = 1;
}

std::uint64_t RigStream::Ticks(double milliseconds) const {
  return static_cast<std::uint64_t>(std::ceil(milliseconds * rate_hz_ / 1000.0));
}

Status RigStream::Bind(std::size_t k) {
  const rig::RigBody& body = motions_[k]->body();
  auto bound = rig::BindDialect(body.skeleton, body.dialect);
  if (!bound.ok()) return bound.status();
  bindings_[k] = std::make_unique<rig::Binding>(std::move(bound.value()));
  return Status::Ok();
}

void RigStream::Restart() {
  silent_until_tick_ = tick_ + Ticks(faults_.spec().restart_pause_ms);
  frame_index_ = 0;
  burst_end_tick_ = 0;
  occlusions_.clear();
  faults_.ResetClock();
  ++counts_.sessions;
  rig_->Restart();
}

// Reads the next pose of every motion. kSilent: one of them has a new body.
RigStream::Step RigStream::Advance() {
  Step result = Step::kSent;
  for (std::size_t k = 0; k < motions_.size(); ++k) {
    switch (motions_[k]->Next(source_)) {
      case Motion::Step::kEnd:
        return Step::kEnd;
      case Motion::Step::kError:
        error_ = motions_[k]->error();
        return Step::kError;
      case Motion::Step::kNewBody:
        error_ = Bind(k);
        if (!error_.ok()) return Step::kError;
        result = Step::kSilent;
        break;
      case Motion::Step::kPose:
        bindings_[k]->Bind(source_, poses_[k]);
        break;
    }
  }
  return result;
}

// Starts an occlusion if `fault` is one, and hides the joints of all current occlusions.
void RigStream::Occlude(Fault fault) {
  if (fault == Fault::kNan || fault == Fault::kOcclude) {
    const std::uint32_t performer = faults_.Choose(static_cast<std::uint32_t>(poses_.size()));
    // Never the hips, because rigs lose a limb or a hand.
    const std::uint32_t joint = 1 + faults_.Choose(body::kJointCount - 1);
    const double frames = fault == Fault::kNan ? 1 : faults_.spec().occlude_frames;
    occlusions_.push_back({performer, joint, static_cast<std::uint32_t>(frames)});
  }
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  for (Occlusion& occlusion : occlusions_) {
    poses_[occlusion.performer].rotations[occlusion.joint] = body::Quat(kNan, kNan, kNan, kNan);
    --occlusion.frames_left;
  }
  std::erase_if(occlusions_, [](const Occlusion& o) { return o.frames_left == 0; });
}

// Truncates one of the datagrams or flips one of its bits.
void RigStream::Damage(Fault fault, Datagrams& datagrams) {
  if (datagrams.empty()) return;
  auto& datagram = datagrams[faults_.Choose(static_cast<std::uint32_t>(datagrams.size()))];
  const auto size = static_cast<std::uint32_t>(datagram.size());
  if (size == 0) return;
  if (fault == Fault::kTruncate) {
    datagram.resize(faults_.Choose(size));
  } else {
    const std::uint32_t bit = faults_.Choose(size * 8);
    datagram[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
  }
}

Status RigStream::SendAll(const Datagrams& datagrams, player::Link& link) {
  for (const auto& datagram : datagrams) {
    if (Status status = SendBytes(link, datagram); !status.ok()) return status;
  }
  return Status::Ok();
}

Status RigStream::SendHeld(player::Link& link, bool all) {
  for (auto held = held_.begin(); held != held_.end();) {
    if (!all && held->due_tick > tick_) {
      ++held;
      continue;
    }
    if (Status status = SendAll(held->datagrams, link); !status.ok()) return status;
    held = held_.erase(held);
  }
  return Status::Ok();
}

Status RigStream::Flush(player::Link& link) { return SendHeld(link, true); }

Status RigStream::SendFrame(Fault fault, player::Link& link) {
  Datagrams datagrams;
  std::vector<std::optional<rig::Placed>> props;
  for (const auto& prop : props_) {
    props.push_back(player::PlaceOf(prop, rig::WristsOf(whole_.front())));
  }
  const double true_s = static_cast<double>(frame_index_) / rate_hz_;
  rig_->Encode({frame_index_, true_s + faults_.ClockError_s(true_s, fault), poses_, whole_, props},
               [&datagrams](std::span<const std::byte> bytes) {
                 datagrams.emplace_back(bytes.begin(), bytes.end());
               });
  if (fault == Fault::kLoss) return Status::Ok();
  if (fault == Fault::kReorder || fault == Fault::kLate) {
    const std::uint64_t wait =
        fault == Fault::kLate ? std::max<std::uint64_t>(2, Ticks(faults_.spec().late_ms)) : 1;
    held_.push_back({tick_ + wait, std::move(datagrams)});
    return Status::Ok();
  }
  if (fault == Fault::kBurst) {
    burst_end_tick_ = tick_ + static_cast<std::uint64_t>(faults_.spec().burst_frames) - 1;
  }
  if (burst_end_tick_ > 0 && tick_ <= burst_end_tick_) {
    held_.push_back({burst_end_tick_, std::move(datagrams)});
    return Status::Ok();
  }
  if (fault == Fault::kCorrupt || fault == Fault::kTruncate) Damage(fault, datagrams);
  if (fault == Fault::kDuplicate) {
    if (Status status = SendAll(datagrams, link); !status.ok()) return status;
  }
  return SendAll(datagrams, link);
}

RigStream::Step RigStream::Tick(player::Link& link) {
  const auto failed = [this](Status status) {
    error_ = std::move(status);
    return Step::kError;
  };
  for (std::size_t size = 0; (size = link.Receive(received_)) > 0;) {
    rig_->Receive(std::span(received_).first(size), [&link](std::span<const std::byte> bytes) {
      (void)link.Answer(bytes);  // the client may have left
    });
  }
  if (tick_ < silent_until_tick_) {
    ++tick_;
    return Step::kSilent;
  }
  Step step = Advance();
  if (step == Step::kEnd || step == Step::kError) return step;
  const Fault fault = step == Step::kSilent ? Fault::kRestart : faults_.Draw();
  if (fault == Fault::kRestart) {
    if (Status status = SendHeld(link, true); !status.ok()) return failed(std::move(status));
    Restart();
    ++tick_;
    return Step::kSilent;
  }
  whole_ = poses_;
  Occlude(fault);
  if (Status status = SendFrame(fault, link); !status.ok()) return failed(std::move(status));
  ++counts_.frames;
  ++frame_index_;
  if (Status status = SendHeld(link, false); !status.ok()) return failed(std::move(status));
  ++tick_;
  return Step::kSent;
}

}  // namespace styled::rigs
