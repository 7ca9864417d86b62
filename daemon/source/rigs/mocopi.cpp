#include "daemon/source/rigs/mocopi.h"

#include <string>
#include <vector>

#include "daemon/runtime/clock.h"
#include "daemon/source/performer_stream.h"
#include "proto/rigs/mocopi/mocopi.h"
#include "proto/rigs/types.h"

namespace styled::source {
namespace {

using runtime::Counter;

// A frame at least this far behind the newest one means a restart. A smaller distance means a late
// frame, unless kMocopiOldFrames such frames occur in a row.
constexpr std::uint32_t kRestartFrames = 60;
constexpr float kMocopiRestart_s = 1.0F;
constexpr int kMocopiOldFrames = 5;
constexpr std::size_t kMostMocopiSenders = 8;

rig::RigBody MakeBody(const mocopi::Skeleton& bones) {
  rig::RigBody body;
  body.metres_per_unit = 1.0F;
  body.dialect = rigs::kMocopi.dialect;
  for (std::size_t id = 0; id < mocopi::kBones; ++id) {
    const auto& at = bones[id].rest.position_m;
    body.skeleton.names.emplace_back(mocopi::kBoneTable[id].name);
    body.skeleton.parents.push_back(bones[id].parent);
    body.skeleton.offsets.emplace_back(at[0], at[1], at[2]);
  }
  return body;
}

// One sending application at one address.
class MocopiSender {
 public:
  MocopiSender(std::uint64_t peer, std::string performer)
      : peer_(peer), stream_(std::move(performer)) {}

  std::uint64_t peer() const { return peer_; }
  std::int64_t seen_ns() const { return seen_ns_; }

  void Handle(const mocopi::Datagram& datagram, std::int64_t now_ns, Outbox& out) {
    seen_ns_ = now_ns;
    if (datagram.kind == mocopi::Datagram::Kind::kSkeleton) {
      HandleSkeleton(datagram.skeleton, out);
    } else {
      HandleFrame(datagram.frame, now_ns, out);
    }
  }

 private:
  void HandleSkeleton(const mocopi::Skeleton& skeleton, Outbox& out) {
    if (stream_.has_body() && skeleton == skeleton_) return;  // repeated every 3.5 s
    out.LeaveHotSection();
    skeleton_ = skeleton;
    stream_.SetBody(MakeBody(skeleton), out);
    pose_ = rig::RigPose(stream_.body().skeleton);
  }

  void HandleFrame(const mocopi::Frame& frame, std::int64_t now_ns, Outbox& out) {
    PerformerStream::FrameInfo info;
    if (!Admit(frame, info.lost, out)) return;
    if (!stream_.has_body()) HandleSkeleton(mocopi::UsualSkeleton(), out);
    for (std::size_t id = 0; id < mocopi::kBones; ++id) {
      const auto& r = frame.bones[id].rotation;
      pose_.rotations[id] = rig::Quat(r[3], r[0], r[1], r[2]);
    }
    const auto& root = frame.bones[0].position_m;  // the other bones repeat their offsets
    pose_.translations.front() = {root[0], root[1], root[2]};
    info.source_time_ns = static_cast<std::uint64_t>(double{frame.time_s} * 1e9);
    info.now_ns = now_ns;
    stream_.Send(pose_, info, out);
  }

  // Returns false for a duplicate or late frame.
  bool Admit(const mocopi::Frame& frame, std::uint64_t& lost, Outbox& out) noexcept {
    if (any_) {
      const bool back = frame.number <= number_;
      behind_ = frame.number < number_ ? behind_ + 1 : 0;
      const bool far = (back && number_ - frame.number >= kRestartFrames) ||
                       frame.time_s <= time_s_ - kMocopiRestart_s || behind_ == kMocopiOldFrames;
      if (back && !far) {
        out.Refuse(frame.number == number_ ? Counter::kPipelineDuplicate
                                           : Counter::kPipelineReordered);
        return false;
      }
      if (far) {
        behind_ = 0;
        stream_.Restart();
      } else {
        lost = frame.number - number_ - 1;
      }
    }
    any_ = true;
    number_ = frame.number;
    time_s_ = frame.time_s;
    return true;
  }

  std::uint64_t peer_;
  std::int64_t seen_ns_ = 0;
  PerformerStream stream_;
  mocopi::Skeleton skeleton_;
  rig::RigPose pose_;
  bool any_ = false;
  std::uint32_t number_ = 0;
  float time_s_ = 0;
  int behind_ = 0;  // consecutive frames that were older than the newest
};

class Mocopi final : public Translator {
 public:
  explicit Mocopi(const config::Source& config)
      : performer_(config.performer.empty() ? config.name : config.performer) {}

  void Handle(std::span<const std::byte> datagram, const Peer& peer, std::int64_t now_ns,
              Outbox& out) override {
    if (mocopi::Decode(datagram, datagram_) != mocopi::DecodeResult::kOk) {
      return out.Refuse(Counter::kSourceMalformed);
    }
    MocopiSender* sender = Find(peer, now_ns, out);
    if (sender == nullptr) return out.Refuse(Counter::kPipelineSecondSender);
    sender->Handle(datagram_, now_ns, out);
  }

 private:
  // Returns null if there are kMostMocopiSenders and none of them was silent for 10 s.
  MocopiSender* Find(const Peer& peer, std::int64_t now_ns, Outbox& out) {
    for (MocopiSender& sender : senders_) {
      if (sender.peer() == peer.id) return &sender;
    }
    out.LeaveHotSection();
    std::erase_if(senders_, [now_ns](const MocopiSender& sender) {
      return now_ns - sender.seen_ns() > 10 * runtime::kSecond_ns;
    });
    if (senders_.size() >= kMostMocopiSenders) return nullptr;
    return &senders_.emplace_back(peer.id, performer_);
  }

  std::string performer_;
  std::vector<MocopiSender> senders_;
  mocopi::Datagram datagram_;
};

}  // namespace

std::unique_ptr<Translator> MakeMocopi(const config::Source& config) {
  return std::make_unique<Mocopi>(config);
}

}  // namespace styled::source
