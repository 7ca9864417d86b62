#include "daemon/source/rigs/vmc.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/runtime/clock.h"
#include "daemon/source/face.h"
#include "daemon/source/face_stream.h"
#include "daemon/source/performer_stream.h"
#include "daemon/source/rigs/vmc_body.h"
#include "daemon/source/rigs/vmc_devices.h"
#include "model/base/text.h"
#include "proto/rigs/vmc/assembler.h"

namespace styled::source {
namespace {

using rig::Quat;
using rig::Vec3;
using runtime::Counter;
using vmc::BoneSet;

// The most frames made from one datagram. Senders put one frame, or a part of it, into each. The
// largest datagram could hold 680 frames, which takes more time than one frame allows.
constexpr int kMostFrames = 4;
constexpr std::size_t kMostVmcSenders = 8;
// Bones that moved by kMoved_m, and stay there, mean another avatar.
constexpr float kMoved_m = 0.01F, kSteady_m = 0.001F;
constexpr int kMovedFrames = 10;
// How long a sender's first frames wait for its root, and for bones that a body needs. Frames come
// 30 times a second or more; a slow sender repeats its root once a second.
constexpr std::int64_t kVmcPatience_ns = runtime::kSecond_ns;
// After this long a sender of expressions is one without bones.
constexpr std::int64_t kFaceAlone_ns = 2 * runtime::kSecond_ns;
constexpr std::int64_t kVmcSilent_ns = 10 * runtime::kSecond_ns;

Quat ToQuat(const std::array<float, 4>& r) { return {r[3], r[0], r[1], r[2]}; }
Vec3 ToVec3(const std::array<float, 3>& p) { return {p[0], p[1], p[2]}; }
// Mirrors through the plane x = 0: from Unity's axes to right-handed ones, and back.
Quat Mirrored(const Quat& q) { return {q.w(), q.x(), -q.y(), -q.z()}; }
Vec3 Mirrored(const Vec3& p) { return {-p.x(), p.y(), p.z()}; }

float Distance(const std::array<float, 3>& a, const std::array<float, 3>& b) {
  return (ToVec3(a) - ToVec3(b)).norm();
}

// The parts of a source that are merged into a performer: none for a source with performers of its
// own.
struct Merged {
  bool face = false, fingers = false;
};

// One sending application at one address.
class VmcSender {
 public:
  // `judges`: whether to refuse a sender whose bones make no body. `rootless_noted`: whether the
  // log has the line about a missing root; must outlive it.
  VmcSender(std::uint64_t peer, std::string performer, const Merged& merged, bool judges,
            bool& rootless_noted)
      : peer_(peer),
        merged_(merged),
        judges_(judges),
        rootless_noted_(rootless_noted),
        stream_(std::move(performer)) {
    if (merged_.face) faces_.emplace();
    face_.expressions.reserve(vmc::Frame::kMaxBlends);
    face_.thru.reserve(vmc::Frame::kMaxThrus);
  }

  std::uint64_t peer() const { return peer_; }
  std::int64_t seen_ns() const { return seen_ns_; }
  std::int64_t deadline_ns() const { return assembler_.deadline_ns(); }

  void Handle(std::span<const std::byte> datagram, std::int64_t now_ns, Outbox& out) {
    if (assembler_.Begin(datagram, now_ns) != vmc::osc::Result::kOk) {
      return out.Refuse(Counter::kSourceMalformed);
    }
    seen_ns_ = now_ns;
    for (int frames = 0; assembler_.Next(); ++frames) {
      if (frames < kMostFrames) {
        Use(assembler_.frame(), now_ns, out);
      } else {
        out.Refuse(Counter::kSourceMalformed);
      }
    }
    Report(out);
  }
  // The root that came before the sender was admitted.
  void SetRoot(const vmc::Transform& root);
  void Tick(std::int64_t now_ns, Outbox& out) {
    if (assembler_.Flush(now_ns)) Use(assembler_.frame(), now_ns, out);
    Report(out);
  }

 private:
  void Use(const vmc::Frame& frame, std::int64_t now_ns, Outbox& out);
  void UseFace(const vmc::Frame& frame, Outbox& out);
  void UseBones(const vmc::Frame& frame, std::int64_t now_ns, Outbox& out);
  void Remember(const vmc::Frame& frame);
  bool IsPartial(const vmc::Frame& frame, Outbox& out);
  bool AwaitsRoot(const vmc::Frame& frame, Outbox& out);
  BoneSet Wanted(const vmc::Frame& frame);
  void SetBody(BoneSet bones, Outbox& out);
  void Pose(const vmc::Frame& frame);
  const Face* Look(const vmc::Frame& frame);
  std::uint64_t Time_ns(const vmc::Frame& frame);
  void Report(Outbox& out);

  std::uint64_t peer_;
  Merged merged_;
  bool judges_;
  bool& rootless_noted_;
  std::int64_t seen_ns_ = 0;
  vmc::Assembler assembler_;
  vmc::Assembler::Counts reported_;
  PerformerStream stream_;
  std::optional<FaceStream> faces_;  // if the face is merged
  std::uint64_t face_number_ = 0;
  const BoneSet canonical_ = CanonicalBones(), required_ = RequiredBones();
  const BoneSet bindable_ = BindableBones();
  BoneSet bones_ = 0;          // the body's bones
  BoneSet before_ = 0;         // the last frame's bones
  BonePositions positions_{};  // each bone's last position
  BonePositions logged_{};     // the same when the body was made
  int moved_frames_ = 0;
  // Of the session: its first frame with bones (0: none yet), all its bones, and why they make no
  // body.
  std::int64_t since_ns_ = 0;
  BoneSet all_ = 0;
  std::shared_ptr<const std::string> refusal_;
  bool has_root_ = false, rootless_ = false;  // a rootless sender stays one
  Vec3 root_position_ = Vec3::Zero(), hips_position_ = Vec3::Zero();
  Quat root_rotation_ = Quat::Identity();
  std::vector<int> bone_of_joint_;
  rig::RigPose pose_;
  Face face_;
  std::int64_t source_from_arrival_ns_ = 0;  // offset from a time of arrival to source time
};

void VmcSender::UseFace(const vmc::Frame& frame, Outbox& out) {
  if (frame.restarted) {
    faces_->Restart();
    face_number_ = 0;
  }
  if (frame.blend_count > 0) faces_->Send(*Look(frame), face_number_++, Time_ns(frame), out);
}

void VmcSender::Use(const vmc::Frame& frame, std::int64_t now_ns, Outbox& out) {
  if (faces_) UseFace(frame, out);
  if (!faces_ || merged_.fingers) UseBones(frame, now_ns, out);
}

void VmcSender::UseBones(const vmc::Frame& frame, std::int64_t now_ns, Outbox& out) {
  if (frame.restarted) {
    stream_.Restart();
    bones_ = before_ = all_ = 0;  // the avatar may have changed
    since_ns_ = 0;
    refusal_ = nullptr;
    has_root_ = rootless_;
  }
  Remember(frame);
  if (frame.bones == 0) return;
  if (since_ns_ == 0) since_ns_ = frame.received_ns;
  if (!merged_.fingers && (IsPartial(frame, out) || AwaitsRoot(frame, out))) {
    before_ = frame.bones;
    return;
  }
  const BoneSet wanted = Wanted(frame);
  before_ = frame.bones;
  if (wanted == 0) return;
  if (wanted != bones_ || moved_frames_ >= kMovedFrames) SetBody(wanted, out);
  Pose(frame);
  PerformerStream::FrameInfo info;
  info.source_time_ns = Time_ns(frame);
  info.now_ns = now_ns;
  if (!merged_.fingers) info.face = Look(frame);
  stream_.Send(pose_, info, out);
}

// Whether the sender lacks bones of a body. Bones that came in the last half second count.
bool VmcSender::IsPartial(const vmc::Frame& frame, Outbox& out) {
  if (bones_ != 0 || !judges_) return false;
  const BoneSet now = frame.bones | (frame.missing & ~frame.stale);
  if ((bindable_ & ~now) == 0) return false;
  if (frame.received_ns - since_ns_ < kVmcPatience_ns) {
    out.Refuse(Counter::kSourceIncomplete);
    return true;
  }
  // The reason names all bones that ever came, so that tracked hands that come and go do not change
  // it with every frame.
  const BoneSet whole = (bindable_ & ~(all_ | now)) == 0 ? now : all_ | now;
  if (refusal_ == nullptr || whole != all_) {
    out.LeaveHotSection();
    all_ = whole;
    refusal_ = std::make_shared<const std::string>(WhyNoPerformer(all_));
    stream_.SetBody(MakeVmcBody(all_, positions_), out);
  }
  stream_.SendRefused(refusal_, frame.received_ns, out);
  return true;
}

// Whether the place of the hips is unknown, because the root has not come yet.
bool VmcSender::AwaitsRoot(const vmc::Frame& frame, Outbox& out) {
  if (has_root_) return false;
  if (frame.received_ns - since_ns_ < kVmcPatience_ns) {
    out.Refuse(Counter::kSourceIncomplete);
    return true;
  }
  has_root_ = rootless_ = true;
  if (std::exchange(rootless_noted_, true)) return false;
  out.Notice([this] {
    return stream_.performer() +
           ": VMC sends no /VMC/Ext/Root/Pos, so the "
           "root is taken to be at the origin and not "
           "turned: the hips' own position counts";
  });
  return false;
}

// Records positions and root. Values that are not finite are ignored.
void VmcSender::Remember(const vmc::Frame& frame) {
  bool moved = false, steady = true;
  for (int bone = 0; bone < vmc::kBoneCount; ++bone) {
    if (!vmc::Has(frame.bones, bone)) continue;
    const auto at = static_cast<std::size_t>(bone);
    const auto& position = frame.transforms[at].position;
    if (!ToVec3(position).allFinite()) continue;
    if (bone != vmc::kHips && vmc::Has(bones_, bone)) {
      moved = moved || Distance(position, logged_[at]) > kMoved_m;
      steady = steady && Distance(position, positions_[at]) < kSteady_m;
    }
    positions_[at] = position;
  }
  // If only hands are merged, their positions may be positions in the room; lengths do not matter
  // for fingers.
  moved_frames_ = moved && steady && !merged_.fingers ? moved_frames_ + 1 : 0;
  hips_position_ = ToVec3(positions_[vmc::kHips]);
  if (frame.has_root) SetRoot(frame.root);
}

void VmcSender::SetRoot(const vmc::Transform& root) {
  const Vec3 position = ToVec3(root.position);
  const Quat rotation = ToQuat(root.rotation);
  has_root_ = true;
  if (position.allFinite()) root_position_ = position;
  if (rotation.coeffs().allFinite() && rotation.norm() > 0) root_rotation_ = rotation.normalized();
}

// The bones that the body should have; 0 while that is unknown, because the first frame may be the
// end of one. A bone that disappeared is removed from the body only if no skeleton needs it.
// Fingers need only hands, which the sender may leave out, and a root.
BoneSet VmcSender::Wanted(const vmc::Frame& frame) {
  if (merged_.fingers) {
    if (bones_ == 0 && frame.bones != before_) return 0;
    constexpr BoneSet kNeeded =
        vmc::Bit(vmc::kHips) | vmc::Bit(vmc::kLeftHand) | vmc::Bit(vmc::kRightHand);
    return bones_ | frame.bones | kNeeded;
  }
  if (bones_ == 0) {
    const bool whole = (required_ & ~frame.bones) == 0 || frame.bones == before_;
    return whole && vmc::Has(frame.bones, vmc::kHips) ? frame.bones : 0;
  }
  return (bones_ | (frame.bones & before_)) & ~(frame.stale & ~canonical_);
}

void VmcSender::SetBody(BoneSet bones, Outbox& out) {
  out.LeaveHotSection();
  bones_ = bones;
  logged_ = positions_;
  moved_frames_ = 0;
  stream_.SetBody(MakeVmcBody(bones, positions_), out);
  stream_.ReserveFace();
  pose_ = rig::RigPose(stream_.body().skeleton);
  bone_of_joint_.clear();
  for (const int bone : vmc::kParentsFirst) {
    if (vmc::Has(bones, bone)) bone_of_joint_.push_back(bone);
  }
}

void VmcSender::Pose(const vmc::Frame& frame) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  for (std::size_t j = 0; j < bone_of_joint_.size(); ++j) {
    const int bone = bone_of_joint_[j];
    const Quat rotation = ToQuat(frame.transforms[static_cast<std::size_t>(bone)].rotation);
    pose_.rotations[j] =
        vmc::Has(frame.bones, bone) ? Mirrored(rotation) : Quat(kNan, kNan, kNan, kNan);
  }
  // world_from_hips = world_from_root * root_from_hips
  pose_.rotations.front() = Mirrored(root_rotation_) * pose_.rotations.front();
  pose_.translations.front() = Mirrored(root_position_ + root_rotation_ * hips_position_);
}

// The frame's expressions. Names that are not UTF-8 are left out, because subscribers could not
// parse them.
const Face* VmcSender::Look(const vmc::Frame& frame) {
  face_.expressions.clear();
  face_.thru.clear();
  for (std::size_t i = 0; i < frame.blend_count; ++i) {
    const auto& blend = frame.blends[i];
    if (std::isfinite(blend.value) && IsUtf8(blend.name())) {
      face_.expressions.push_back({blend.name(), blend.value});
    }
  }
  for (std::size_t i = 0; i < frame.thru_count; ++i) face_.thru.push_back(frame.thrus[i].bytes());
  return &face_;
}

// The frame's source time. For a frame without a time, or with one of more than 31 years, the time
// of arrival continues the sender's clock.
std::uint64_t VmcSender::Time_ns(const vmc::Frame& frame) {
  constexpr float kMost_s = 1e9F;
  if (frame.has_time && std::abs(frame.time_s) <= kMost_s) {
    source_from_arrival_ns_ = std::llround(double{frame.time_s} * 1e9) - frame.received_ns;
  }
  return static_cast<std::uint64_t>(frame.received_ns + source_from_arrival_ns_);
}

void VmcSender::Report(Outbox& out) {
  const auto& counts = assembler_.counts();
  const auto report = [&out](std::uint64_t& reported, std::uint64_t now, Counter counter) {
    for (; reported < now; ++reported) out.Refuse(counter);
  };
  report(reported_.refused, counts.refused, Counter::kSourceMalformed);
  report(reported_.ignored, counts.ignored, Counter::kSourceIgnored);
  report(reported_.duplicate, counts.duplicate, Counter::kPipelineDuplicate);
  report(reported_.late, counts.late, Counter::kPipelineReordered);
  report(reported_.incomplete, counts.incomplete, Counter::kSourceIncomplete);
}

// The first bone, expression or root of the datagram. Its text is a view into the datagram.
template <typename What>
std::optional<What> First(std::span<const std::byte> datagram) {
  vmc::osc::Reader reader(datagram);
  vmc::osc::Message bytes;
  vmc::Message message;
  while (reader.Next(bytes) == vmc::osc::Reader::Step::kMessage) {
    if (Decode(bytes, message) != vmc::DecodeResult::kOk) continue;
    if (const auto* what = std::get_if<What>(&message)) return *what;
  }
  return {};
}
template <typename What>
bool Has(std::span<const std::byte> datagram) {
  return First<What>(datagram).has_value();
}

class Vmc final : public Translator {
 public:
  explicit Vmc(const config::Source& config)
      : performer_(config.performer.empty() ? config.name : config.performer),
        merged_{config.Merges("face"),
                config.Merges("leftFingers") || config.Merges("rightFingers")},
        judges_(config.joints.empty()),
        devices_(config),
        face_(performer_) {}

  void Handle(std::span<const std::byte> datagram, const Peer& peer, std::int64_t now_ns,
              Outbox& out) override {
    for (const auto& sender : senders_) {
      if (sender->peer() == peer.id) return sender->Handle(datagram, now_ns, out);
    }
    if (vmc::osc::Check(datagram) != vmc::osc::Result::kOk) {
      return out.Refuse(Counter::kSourceMalformed);
    }
    const bool bones = merged_.fingers || !merged_.face;
    const bool useful =
        (bones && Has<vmc::Bone>(datagram)) || (merged_.face && Has<vmc::Blend>(datagram));
    if (!useful) {
      const bool alone = !merged_.face && !merged_.fingers;
      const bool devices = devices_.IsSender(peer.id) || VmcDevices::HasDevice(datagram);
      if (devices && alone) return devices_.Handle(datagram, peer.id, now_ns, out);
      if (alone && !AnyBones(now_ns) && Has<vmc::Blend>(datagram)) WatchFace(peer, now_ns, out);
      // In single messages the root comes before the sender's first bone.
      if (const auto root = First<vmc::Root>(datagram)) early_root_ = {peer.id, root->transform};
      return out.Refuse(Counter::kSourceIgnored);
    }
    VmcSender* sender = Add(peer, now_ns, out);
    if (sender == nullptr) return out.Refuse(Counter::kPipelineSecondSender);
    devices_.Forget(peer.id);
    if (early_root_.first == peer.id) sender->SetRoot(early_root_.second);
    early_root_ = {};
    sender->Handle(datagram, now_ns, out);
  }

  void Tick(std::int64_t now_ns, Outbox& out) override {
    for (const auto& sender : senders_) sender->Tick(now_ns, out);
    devices_.rig().Tick(now_ns, out);
  }

  std::int64_t NextDeadline_ns() const override {
    std::int64_t next_ns = devices_.rig().NextDeadline_ns();
    for (const auto& sender : senders_) next_ns = std::min(next_ns, sender->deadline_ns());
    return next_ns;
  }

  bool has_sensors() const override { return devices_.rig().speaks(); }
  Status Calibrate(Calibration what, std::int64_t now_ns) override {
    return devices_.rig().Calibrate(what, now_ns);
  }

 private:
  // Returns null if there are kMostVmcSenders and none of them was silent for 10 s.
  VmcSender* Add(const Peer& peer, std::int64_t now_ns, Outbox& out) {
    out.LeaveHotSection();
    std::erase_if(senders_, [now_ns](const auto& sender) {
      return now_ns - sender->seen_ns() > kVmcSilent_ns;
    });
    if (senders_.size() >= kMostVmcSenders) return nullptr;
    face_peer_ = 0;
    return senders_
        .emplace_back(
            std::make_unique<VmcSender>(peer.id, performer_, merged_, judges_, rootless_noted_))
        .get();
  }

  bool AnyBones(std::int64_t now_ns) const {
    return std::ranges::any_of(senders_, [now_ns](const auto& sender) {
      return now_ns - sender->seen_ns() <= kVmcSilent_ns;
    });
  }

  // Lists the performer as refused while a sender sends expressions and no bone.
  void WatchFace(const Peer& peer, std::int64_t now_ns, Outbox& out) {
    if (peer.id != face_peer_) {
      if (face_peer_ != 0 && now_ns - face_seen_ns_ < kFaceAlone_ns) return;
      face_peer_ = peer.id;
      face_since_ns_ = now_ns;
    }
    face_seen_ns_ = now_ns;
    if (now_ns - face_since_ns_ < kFaceAlone_ns) return;
    if (face_refusal_ == nullptr) {
      out.LeaveHotSection();
      face_refusal_ = std::make_shared<const std::string>(
          "VMC sends expressions and no bones: found a face, expected a body: "
          "let the application "
          "send bones, or give the face to a performer by merge_into and parts "
          "= [\"face\"]");
      face_.SetBody({}, out);
    }
    face_.SendRefused(face_refusal_, now_ns, out);
  }

  std::string performer_;
  Merged merged_;
  bool judges_;  // whether bones are known by their names alone
  VmcDevices devices_;
  bool rootless_noted_ = false;
  std::pair<std::uint64_t, vmc::Transform> early_root_{};  // by its sender; 0: none
  // The sender of expressions alone: its address (0: none), and the performer without a body.
  std::uint64_t face_peer_ = 0;
  std::int64_t face_since_ns_ = 0, face_seen_ns_ = 0;
  std::shared_ptr<const std::string> face_refusal_;
  PerformerStream face_;
  std::vector<std::unique_ptr<VmcSender>> senders_;
};

}  // namespace

std::unique_ptr<Translator> MakeVmc(const config::Source& config) {
  return std::make_unique<Vmc>(config);
}

}  // namespace styled::source
