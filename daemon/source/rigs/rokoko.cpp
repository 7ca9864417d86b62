#include "daemon/source/rigs/rokoko.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "daemon/runtime/clock.h"
#include "daemon/source/face_stream.h"
#include "daemon/source/performer_stream.h"
#include "daemon/source/props.h"
#include "daemon/source/rigs/world_pose.h"
#include "proto/rigs/rokoko/rokoko.h"
#include "proto/rigs/types.h"

namespace styled::source {
namespace {

using rokoko::kHip;
using rokoko::kJoints;
using runtime::Counter;
using Joints = std::bitset<kJoints>;

constexpr std::size_t kMaxActors = 64;  // for all senders
// A smaller step back in time means a late frame, unless kRokokoOldFrames such frames occur in a
// row.
constexpr double kRokokoRestart_s = 1;
constexpr int kRokokoOldFrames = 5;

// Mirrors through the plane x = 0, from left-handed to right-handed.
rig::Vec3 Mirrored(const std::array<float, 3>& p) { return {-p[0], p[1], p[2]}; }
rig::Quat Mirrored(const std::array<float, 4>& q) { return {q[3], q[0], -q[1], -q[2]}; }

// The joints that are present and have a valid rotation.
Joints Usable(const rokoko::Actor& actor) noexcept {
  Joints usable = actor.has;
  for (std::size_t j = 0; j < kJoints; ++j) {
    const float length = Mirrored(actor.joints[j].rotation).squaredNorm();
    if (usable[j] && !(length > 0.25F && length < 4)) usable.reset(j);
  }
  return usable;
}

class Actor {
 public:
  // `occurrence`: index among the actors of this name in one frame.
  Actor(std::uint64_t peer, std::string_view name, int occurrence, std::string performer,
        bool presets)
      : peer_(peer),
        name_(name),
        occurrence_(occurrence),
        stream_(std::move(performer)),
        face_(presets) {}

  bool Is(std::uint64_t peer, std::string_view name, int occurrence) const {
    return peer_ == peer && occurrence_ == occurrence && name_ == name;
  }
  std::uint64_t peer() const { return peer_; }
  std::int64_t seen_ns() const { return seen_ns_; }
  const std::string& performer() const { return stream_.performer(); }

  void Handle(const rokoko::Actor& actor, const PropList& props, double time_s, std::int64_t now_ns,
              Outbox& out) {
    seen_ns_ = now_ns;
    const Joints usable = Usable(actor);
    if (!stream_.has_body() && !usable[kHip]) return out.Refuse(Counter::kSourceIncomplete);
    if (!Admit(time_s, out)) return;
    const bool lacks = (known_ & ~usable).any();
    const bool adds = (usable & ~known_).any();
    if (usable[kHip] && ((adds && !lacks) || actor.hip_height_m != hip_height_m_)) {
      MakeBody(actor, usable, out);
    }
    Send(actor, usable, props, time_s, now_ns, out);
  }

 private:
  // Returns false for a duplicate or late frame.
  bool Admit(double time_s, Outbox& out) noexcept {
    if (any_ && time_s == time_s_) {
      out.Refuse(Counter::kPipelineDuplicate);
      return false;
    }
    behind_ = any_ && time_s < time_s_ ? behind_ + 1 : 0;
    if (behind_ > 0) {
      if (time_s_ - time_s < kRokokoRestart_s && behind_ < kRokokoOldFrames) {
        out.Refuse(Counter::kPipelineReordered);
        return false;
      }
      stream_.Restart();
      behind_ = 0;
    }
    any_ = true;
    time_s_ = time_s;
    return true;
  }

  // Bones do not stretch, so any frame shows where a joint is in its parent's frame.
  void MakeBody(const rokoko::Actor& actor, const Joints& usable, Outbox& out) {
    out.LeaveHotSection();
    known_ = usable;
    hip_height_m_ = actor.hip_height_m;
    rig::RigBody body;
    body.metres_per_unit = 1;
    body.dialect = rigs::kRokoko.dialect;
    joint_of_.clear();
    std::array<int, kJoints> place{};
    std::vector<rig::Vec3> positions;
    for (std::size_t j = 0; j < kJoints; ++j) {
      if (!known_[j]) continue;
      place[j] = static_cast<int>(joint_of_.size());
      // The nearest ancestor that is present; the hip always is.
      int parent = rokoko::kJointTable[j].parent;
      while (parent >= 0 && !known_[static_cast<std::size_t>(parent)]) {
        parent = rokoko::kJointTable[static_cast<std::size_t>(parent)].parent;
      }
      body.skeleton.names.emplace_back(rokoko::kJointTable[j].name);
      body.skeleton.parents.push_back(parent < 0 ? -1 : place[static_cast<std::size_t>(parent)]);
      joint_of_.push_back(j);
      positions.push_back(Mirrored(actor.joints[j].position_m));
    }
    CopyRotations(actor, usable);
    body.skeleton.offsets.resize(joint_of_.size());
    OffsetsFromWorld(body.skeleton.parents, positions, world_, body.skeleton.offsets);
    stream_.SetBody(body, out);
    stream_.ReserveFace();
    pose_ = rig::RigPose(body.skeleton);
  }

  // World rotations of the body's joints, right-handed; NaN where the frame has none.
  void CopyRotations(const rokoko::Actor& actor, const Joints& usable) {
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    world_.resize(joint_of_.size());
    for (std::size_t i = 0; i < joint_of_.size(); ++i) {
      const std::size_t j = joint_of_[i];
      world_[i] =
          usable[j] ? Mirrored(actor.joints[j].rotation) : rig::Quat(kNan, kNan, kNan, kNan);
    }
  }

  void Send(const rokoko::Actor& actor, const Joints& usable, const PropList& props, double time_s,
            std::int64_t now_ns, Outbox& out) {
    CopyRotations(actor, usable);
    LocalFromWorld(stream_.body().skeleton.parents, world_, pose_);
    if (actor.has[kHip]) pose_.translations.front() = Mirrored(actor.joints[kHip].position_m);
    PerformerStream::FrameInfo info;
    info.source_time_ns = static_cast<std::uint64_t>(std::llround(time_s * 1e9));
    info.now_ns = now_ns;
    if (actor.has_face) info.face = &face_.Of(actor.face);
    info.props = props.all();
    info.scene_props = true;
    stream_.Send(pose_, info, out);
  }

  std::uint64_t peer_;
  std::string name_;
  int occurrence_;
  std::int64_t seen_ns_ = 0;
  PerformerStream stream_;
  ShapeFace face_;
  bool any_ = false;
  double time_s_ = 0;
  int behind_ = 0;  // consecutive frames that were older than the newest
  Joints known_;
  float hip_height_m_ = 0;
  std::vector<std::size_t> joint_of_;  // the body's joints as indices into kJointTable
  std::vector<rig::Quat> world_;
  rig::RigPose pose_;
};

class Rokoko final : public Translator {
 public:
  explicit Rokoko(const config::Source& config)
      : unnamed_(config.performer.empty() ? config.name : config.performer),
        presets_(config.expressions == "vrm") {}

  void Handle(std::span<const std::byte> datagram, const Peer& peer, std::int64_t now_ns,
              Outbox& out) override {
    if (decoder_.Decode(datagram, frame_) != rokoko::DecodeResult::kOk) {
      return out.Refuse(Counter::kSourceMalformed);
    }
    for (int k = 0; k < frame_.actors_left_out; ++k) {
      out.Refuse(Counter::kPipelinePerformersRefused);
    }
    CopyProps(out);
    for (int k = 0; k < frame_.actor_count; ++k) {
      Actor* actor = Find(k, peer, now_ns, out);
      if (actor == nullptr) {
        out.Refuse(Counter::kPipelinePerformersRefused);
      } else {
        actor->Handle(frame_.actors[static_cast<std::size_t>(k)], props_, frame_.time_s, now_ns,
                      out);
      }
    }
  }

 private:
  // The scene's props, made right-handed.
  void CopyProps(Outbox& out) noexcept {
    for (int k = 0; k < frame_.props_left_out; ++k) out.Refuse(Counter::kPipelinePropsLeftOut);
    props_.count = 0;
    for (std::size_t k = 0; k < static_cast<std::size_t>(frame_.prop_count); ++k) {
      const rokoko::Prop& prop = frame_.props[k];
      props_.Add({prop.name(), Mirrored(prop.pose.position_m), Mirrored(prop.pose.rotation)});
    }
  }

  // The actor to which the frame's actor `k` belongs. Null if there are kMaxActors and none of them
  // was silent for 10 s.
  Actor* Find(int k, const Peer& peer, std::int64_t now_ns, Outbox& out) {
    const auto* const first = frame_.actors.begin();
    const std::string_view name = first[k].name();
    const auto occurrence = static_cast<int>(std::count_if(
        first, first + k, [name](const rokoko::Actor& other) { return other.name() == name; }));
    for (const auto& actor : actors_) {
      if (actor->Is(peer.id, name, occurrence)) return actor.get();
    }
    out.LeaveHotSection();
    if (actors_.size() >= kMaxActors) {
      std::erase_if(actors_, [now_ns](const auto& actor) {
        return now_ns - actor->seen_ns() > 10 * runtime::kSecond_ns;
      });
    }
    if (actors_.size() >= kMaxActors) return nullptr;
    actors_.push_back(
        std::make_unique<Actor>(peer.id, name, occurrence, FreeName(name, peer.id), presets_));
    return actors_.back().get();
  }

  // A performer's name that no other actor of the same sender has. Another sender's actor may have
  // the same name: the pipeline admits one sender at a time.
  std::string FreeName(std::string_view name, std::uint64_t peer) const {
    std::string free = name.empty() ? unnamed_ : MakeName(name);
    const std::string stem = free.substr(0, 28);
    for (int i = 2; IsInUse(free, peer); ++i) free = stem + "-" + std::to_string(i);
    return free;
  }
  bool IsInUse(const std::string& name, std::uint64_t peer) const {
    return std::any_of(actors_.begin(), actors_.end(), [&](const auto& other) {
      return other->peer() == peer && other->performer() == name;
    });
  }

  std::string unnamed_;
  bool presets_;
  std::vector<std::unique_ptr<Actor>> actors_;
  rokoko::Decoder decoder_;
  rokoko::Frame frame_;
  PropList props_;  // names view frame_
};

}  // namespace

std::unique_ptr<Translator> MakeRokoko(const config::Source& config) {
  return std::make_unique<Rokoko>(config);
}

}  // namespace styled::source
