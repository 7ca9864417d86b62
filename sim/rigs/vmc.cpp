#include "sim/rigs/vmc.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>

#include "proto/rigs/vmc/bones.h"
#include "proto/rigs/vmc/vmc.h"
#include "sim/rigs/vmc_trackers.h"
#include "sim/rigs/worn_devices.h"

namespace styled::rigs {
namespace {

using body::Quat;
using body::Vec3;

constexpr std::size_t kBonesPerDatagram = 13;

// Mirrors at the plane x = 0: from our axes to Unity's.
Vec3 ToUnity(const Vec3& p) { return {-p.x(), p.y(), p.z()}; }
Quat ToUnity(const Quat& q) { return {q.w(), q.x(), -q.y(), -q.z()}; }

vmc::Transform Place(const Vec3& p, const Quat& q) {
  return {{p.x(), p.y(), p.z()}, {q.x(), q.y(), q.z(), q.w()}};
}

std::string Vrm1Name(std::string_view unity) {
  std::string name(unity);
  name[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(name[0])));
  for (const auto& [from, to] :
       {std::pair<std::string_view, std::string_view>{"ThumbProximal", "ThumbMetacarpal"},
        {"ThumbIntermediate", "ThumbProximal"}}) {
    if (!name.ends_with(from)) continue;
    name.replace(name.size() - from.size(), from.size(), to);
    break;
  }
  return name;
}

// A bone of the avatar: the joint that moves it, and its offset from its parent.
struct AvatarBone {
  std::string name;
  int bone = 0;    // vmc::BoneIndex
  int joint = -1;  // of the canonical humanoid; -1: at rest
  Vec3 offset = Vec3::Zero();
};

// The bones in the order of HumanBodyBones. The upper chest, if there is one, is half-way to the
// neck.
std::vector<AvatarBone> MakeAvatar(bool full, bool vrm1) {
  const Vec3 upper_chest = 0.5F * body::Offset(body::kNeck);
  std::vector<AvatarBone> bones;
  for (int bone = 0; bone < vmc::kBoneCount; ++bone) {
    const vmc::BoneRow& row = vmc::kBones[static_cast<std::size_t>(bone)];
    AvatarBone made;
    made.bone = bone;
    made.name = vrm1 ? Vrm1Name(row.name) : std::string(row.name);
    for (int j = 0; j < body::kJointCount; ++j) {
      if (vmc::FindBone(body::kHumanoid[static_cast<std::size_t>(j)].name, false) == bone) {
        made.joint = j;
      }
    }
    if (!full && made.joint < 0) continue;
    if (made.joint >= 0) made.offset = body::Offset(made.joint);
    if (full && row.parent == vmc::kUpperChest) made.offset -= upper_chest;
    if (bone == vmc::kUpperChest) made.offset = upper_chest;
    if (row.parent == vmc::kHead) made.offset = {0, 0.05F, 0.08F};
    if (vmc::Has(vmc::kFingers, bone)) {
      made.offset = {bone < vmc::kRightThumbProximal ? 0.03F : -0.03F, 0, 0};
    }
    bones.push_back(std::move(made));
  }
  return bones;
}

bool OfHand(int bone) {
  return vmc::Has(vmc::kFingers, bone) || bone == vmc::kLeftHand || bone == vmc::kRightHand;
}

// A finger bone of the quirk "hands": thumbs rest, the others bend towards the palm, which looks
// down in the T-pose.
Quat Bent(int bone, double time_s) {
  const bool left = bone < vmc::kRightThumbProximal;
  const int first = left ? vmc::kLeftThumbProximal : vmc::kRightThumbProximal;
  if (bone - first < 3) return Quat::Identity();
  const auto bend_rad = static_cast<float>(HandsBend_rad(time_s));
  return Quat(Eigen::AngleAxisf(left ? -bend_rad : bend_rad, Vec3::UnitZ()));
}

class Vmc final : public Rig {
 public:
  explicit Vmc(const Options& options)
      : time_first_(HasQuirk(options, "t-first")),
        nested_(HasQuirk(options, "nested")),
        single_(HasQuirk(options, "single")),
        moving_root_(HasQuirk(options, "moving-root")),
        zero_offsets_(HasQuirk(options, "zero-offsets")),
        has_time_(!HasQuirk(options, "no-t")),
        hands_(HasQuirk(options, "hands")),
        avatar_(MakeAvatar(HasQuirk(options, "full") || hands_, HasQuirk(options, "vrm1"))) {
    if (hands_) std::erase_if(avatar_, [](const AvatarBone& bone) { return !OfHand(bone.bone); });
  }

  void Encode(const Frame& frame, const Send& send) override {
    Pose(frame);
    time_.seconds = static_cast<float>(frame.time_s);
    if (nested_ || time_first_) {
      SendTimeFirst(send);
    } else if (single_) {
      SendSingles(send);
    } else {
      SendAsTheApplication(send);
    }
  }

  std::string default_address() const override { return "udp://127.0.0.1:39540"; }

 private:
  void Pose(const Frame& frame);
  void SendTimeFirst(const Send& send);
  void SendSingles(const Send& send);
  void SendAsTheApplication(const Send& send);
  void PutRootOfMixedReality(vmc::osc::Writer& writer) const;
  template <typename Fill>
  void SendBundle(const Send& send, const Fill& fill) {
    vmc::osc::Writer writer(buffer_);
    writer.BeginBundle();
    fill(writer);
    writer.EndBundle();
    send(std::span(buffer_).first(writer.size()));
  }

  bool time_first_, nested_, single_, moving_root_, zero_offsets_, has_time_, hands_;
  std::vector<AvatarBone> avatar_;
  std::array<std::byte, 16384> buffer_;
  // The current frame.
  vmc::Root root_;
  std::vector<vmc::Bone> bones_;
  vmc::Time time_;
};

void Vmc::Pose(const Frame& frame) {
  const body::Pose& pose = frame.poses.front();
  const Vec3 hips = ToUnity(pose.hips_position_m);
  Vec3 root_position = Vec3::Zero();
  Quat root_rotation = Quat::Identity();
  if (moving_root_) {
    root_position = {hips.x(), 0, hips.z()};
    const float yaw_rad = 0.01F * static_cast<float>(frame.index);
    root_rotation = Quat(Eigen::AngleAxisf(yaw_rad, Vec3::UnitY()));
  }
  root_.transform = Place(root_position, root_rotation);
  bones_.clear();
  body::WorldPose world;
  if (hands_) body::ForwardKinematics(pose, world);
  for (const AvatarBone& bone : avatar_) {
    Quat rotation = Quat::Identity();
    if (bone.joint >= 0) rotation = ToUnity(pose.rotations[static_cast<std::size_t>(bone.joint)]);
    if (hands_ && bone.joint >= 0) {
      rotation = ToUnity(world.rotations[static_cast<std::size_t>(bone.joint)]);
    } else if (hands_) {
      rotation = ToUnity(Bent(bone.bone, frame.time_s));
    }
    if (!rotation.coeffs().allFinite()) continue;
    Vec3 position = zero_offsets_ ? Vec3(Vec3::Zero()) : ToUnity(bone.offset);
    if (bone.joint == body::kHips) {
      position = root_rotation.conjugate() * (hips - root_position);
      rotation = root_rotation.conjugate() * rotation;
    }
    if (time_first_ && rotation.w() > 0) rotation.coeffs() = -rotation.coeffs();
    bones_.push_back({bone.name, Place(position, rotation)});
  }
}

void Vmc::SendTimeFirst(const Send& send) {
  SendBundle(send, [this](vmc::osc::Writer& writer) {
    if (has_time_) vmc::Put(time_, writer);
    writer.BeginMessage("/VMC/Ext/OK", "i");
    writer.Int(1);
    writer.EndMessage();
    if (nested_) writer.BeginBundle();
    vmc::Put(root_, writer);
    if (nested_) writer.BeginBundle();
    for (const vmc::Bone& bone : bones_) vmc::Put(bone, writer);
    if (nested_) writer.EndBundle();
    if (nested_) writer.EndBundle();
  });
}

void Vmc::SendSingles(const Send& send) {
  const auto send_one = [&](const auto& message) {
    vmc::osc::Writer writer(buffer_);
    vmc::Put(message, writer);
    send(std::span(buffer_).first(writer.size()));
  };
  send_one(root_);
  for (const vmc::Bone& bone : bones_) send_one(bone);
  send_one(vmc::Available());
  if (has_time_) send_one(time_);
}

void Vmc::SendAsTheApplication(const Send& send) {
  std::span<const vmc::Bone> bones = bones_;
  for (; bones.size() > kBonesPerDatagram; bones = bones.subspan(kBonesPerDatagram)) {
    SendBundle(send, [&](vmc::osc::Writer& writer) {
      for (const vmc::Bone& bone : bones.first(kBonesPerDatagram)) vmc::Put(bone, writer);
    });
  }
  SendBundle(send, [](vmc::osc::Writer& writer) {
    for (const auto* name : {"Neutral", "A", "I", "U", "E", "O", "Blink", "Joy"}) {
      vmc::Put(vmc::Blend{name, 0}, writer);
    }
    vmc::Put(vmc::BlendApply(), writer);
  });
  SendBundle(send, [&](vmc::osc::Writer& writer) {
    PutRootOfMixedReality(writer);
    writer.BeginBundle();
    for (const vmc::Bone& bone : bones) vmc::Put(bone, writer);
    writer.EndBundle();
    writer.BeginMessage("/VMC/Ext/OK", "iii");
    for (const int value : {1, 3, 0}) writer.Int(value);
    writer.EndMessage();
    if (has_time_) vmc::Put(time_, writer);
  });
}

// Appends the play space's scale and offset.
void Vmc::PutRootOfMixedReality(vmc::osc::Writer& writer) const {
  writer.BeginMessage("/VMC/Ext/Root/Pos", "sfffffffffffff");
  writer.Text("root");
  for (const float value : root_.transform.position) writer.Float(value);
  for (const float value : root_.transform.rotation) writer.Float(value);
  for (const float value : {1.0F, 1.0F, 1.0F, 0.0F, 0.0F, 0.0F}) writer.Float(value);
  writer.EndMessage();
}

}  // namespace

double HandsBend_rad(double time_s) {
  constexpr double kMost_rad = 1.0, kPeriod_s = 2;
  return 0.5 * kMost_rad * (1 - std::cos(2 * std::numbers::pi * time_s / kPeriod_s));
}

Result<std::unique_ptr<Rig>> MakeVmc(const Options& options) {
  if (HasQuirk(options, "trackers")) return MakeVmcTrackers(options);
  const Status status = CheckOptions("vmc", options, 1,
                                     {"t-first", "nested", "single", "full", "vrm1", "moving-root",
                                      "zero-offsets", "no-t", "hands", "trackers"});
  if (!status.ok()) return status;
  return std::unique_ptr<Rig>(std::make_unique<Vmc>(options));
}

}  // namespace styled::rigs
