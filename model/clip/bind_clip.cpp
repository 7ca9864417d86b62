#include "model/clip/bind_clip.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "model/base/text.h"
#include "model/rig/calibration.h"
#include "model/rig/check_binding.h"
#include "model/rig/motion_up.h"

namespace styled::clip {
namespace {

using rig::Quat;
using rig::RigPose;
using rig::Vec3;
using JointMap = std::array<int, body::kJointCount>;

// A performer who stands stays standing for some time. A zero pose is straight by design, a frame
// only by chance. A skeleton with fingers has some 60 joints. No measurement on record picked
// these.
constexpr double kLookEvery_s = 0.1;
constexpr float kZeroBonus_deg = 5;
constexpr const char* kZeroPose = "zero pose";
constexpr std::size_t kNamesShown = 60, kShownName = 64;  // bytes of each name

// World transforms of one pose, in source units and axes.
struct World {
  std::vector<Vec3> positions;
  std::vector<Quat> rotations;
  World(const rig::Skeleton& skeleton, const RigPose& pose) {
    rig::WorldTransforms(skeleton, pose, positions, rotations);
  }
};

// A pose that stands, and how far from straight: degrees of the worst of back and legs.
struct Stander {
  RigPose pose;
  float off_deg = 0;
  std::string name;
};

Result<Stander> Judge(const rig::Skeleton& skeleton, const JointMap& map, const RigPose& pose,
                      std::string name) {
  float worst_deg = 0;
  const auto bound = rig::BindStanding(skeleton, map, pose, false, &worst_deg);
  if (!bound.ok()) {
    // rig::BindStanding's errors mention avatars; here it is a clip.
    const std::string& why = bound.status().message();
    const std::string_view avatar = "avatar: ";
    return Status::Error(name + ": " + (why.starts_with(avatar) ? why.substr(avatar.size()) : why));
  }
  return Stander{pose, worst_deg, std::move(name)};
}

std::string FrameName(const Clip& clip, std::size_t frame) {
  return "frame at " + NumberText(static_cast<double>(frame) / clip.rate_hz, 3) + " s";
}

// A standing pose put together from the frames of a clip, each limb from the frame in which it is
// straightest: in a walk one leg stands while the other swings, and no frame has both.
class Straightest {
 public:
  Straightest(const Clip& clip, const JointMap& map) : clip_(clip), map_(map) {
    const auto stride = static_cast<std::size_t>(std::ceil(clip.rate_hz * kLookEvery_s));
    Vec3 spines = Vec3::Zero();
    for (std::size_t frame = 0; frame < clip.frames.size(); frame += stride) {
      frames_.push_back(frame);
      worlds_.emplace_back(clip.skeleton, clip.frames[frame]);
      spines += Bone(worlds_.back(), body::kHips, body::kHead);
    }
    Eigen::Index axis = 0;
    spines.cwiseAbs().maxCoeff(&axis);
    up_ = Vec3::Unit(axis) * (spines[axis] < 0 ? -1.0F : 1.0F);
  }

  // `off_deg` is set to how far the worst of back and legs was from straight in its frame.
  RigPose Make(float& off_deg) const {
    const auto back = Best([this](const World& world) {
      return Angle_deg(Bone(world, body::kHips, body::kHead), up_);
    });
    RigPose pose = clip_.frames[frames_[back]];
    off_deg = Angle_deg(Bone(worlds_[back], body::kHips, body::kHead), up_);
    for (const bool left : {true, false}) {
      const auto side = [left](int joint) { return left ? joint : body::MirrorJoint(joint); };
      const int thigh = side(body::kLeftUpperLeg), shin = side(body::kLeftLowerLeg);
      const int foot = side(body::kLeftFoot), toes = side(body::kLeftToes);
      CopyLimb(thigh, body::kHips, Best([&](const World& world) {
                 return std::max(Angle_deg(Bone(world, thigh, shin), -up_),
                                 Angle_deg(Bone(world, shin, Has(foot) ? foot : toes), -up_));
               }),
               pose);
      off_deg = std::max(off_deg, Straighten(thigh, shin, pose));
      off_deg = std::max(off_deg, Straighten(shin, Has(foot) ? foot : toes, pose));
      const int arm = side(body::kLeftUpperArm), forearm = side(body::kLeftLowerArm);
      const int hand = side(body::kLeftHand), shoulder = side(body::kLeftShoulder);
      // Straight and hanging, or sideways: from there the elbow's axis is known.
      CopyLimb(Has(shoulder) ? shoulder : arm, body::kChest, Best([&](const World& world) {
                 const Vec3 upper = Bone(world, arm, forearm);
                 const Vec3 across = Bone(world, side(body::kRightUpperArm), arm);
                 const float bent = Has(hand) ? Angle_deg(upper, Bone(world, forearm, hand)) : 0;
                 return bent + std::min(Angle_deg(upper, -up_), Angle_deg(upper, across));
               }),
               pose);
      if (Has(foot) && Has(toes)) LayFlat(foot, toes, pose);
    }
    return pose;
  }

 private:
  bool Has(int c) const { return map_[static_cast<std::size_t>(c)] >= 0; }
  std::size_t At(int c) const {
    return static_cast<std::size_t>(map_[static_cast<std::size_t>(c)]);
  }
  Vec3 Bone(const World& world, int from, int to) const {
    return Has(from) && Has(to) ? Vec3(world.positions[At(to)] - world.positions[At(from)])
                                : Vec3(Vec3::Zero());
  }
  static float Angle_deg(const Vec3& a, const Vec3& b) {
    const float lengths = a.norm() * b.norm();
    return lengths > 0 ? std::acos(std::clamp(a.dot(b) / lengths, -1.0F, 1.0F)) * 57.29578F : 0;
  }

  // The index of the frame with the smallest `off`.
  template <typename Off>
  std::size_t Best(const Off& off) const {
    std::size_t best = 0;
    float least = INFINITY;
    for (std::size_t i = 0; i < worlds_.size(); ++i) {
      const float here = off(worlds_[i]);
      if (here < least) {
        least = here;
        best = i;
      }
    }
    return best;
  }

  // Copies the limb that begins at `first`, and the joints between it and `trunk`, from a frame.
  void CopyLimb(int first, int trunk, std::size_t from, RigPose& pose) const {
    const auto& parents = clip_.skeleton.parents;
    const RigPose& frame = clip_.frames[frames_[from]];
    std::vector<bool> limb(parents.size(), false);
    const int end = Has(trunk) ? static_cast<int>(At(trunk)) : -1;
    limb[At(first)] = true;
    for (int above = parents[At(first)]; above >= 0 && above != end && !Mapped(above);
         above = parents[static_cast<std::size_t>(above)]) {
      limb[static_cast<std::size_t>(above)] = true;
    }
    for (std::size_t joint = At(first); joint < parents.size(); ++joint) {
      if (parents[joint] >= 0 && Below(joint, At(first))) limb[joint] = true;
      if (limb[joint]) pose.rotations[joint] = frame.rotations[joint];
    }
    for (std::size_t joint = 0; joint < At(first); ++joint) {
      if (limb[joint]) pose.rotations[joint] = frame.rotations[joint];
    }
  }
  bool Mapped(int joint) const { return std::find(map_.begin(), map_.end(), joint) != map_.end(); }
  bool Below(std::size_t joint, std::size_t above) const {
    for (int up = clip_.skeleton.parents[joint]; up >= 0;
         up = clip_.skeleton.parents[static_cast<std::size_t>(up)]) {
      if (static_cast<std::size_t>(up) == above) return true;
    }
    return false;
  }

  // Swings the bone from `from` to `to` down by the shortest arc, as rig::RestBySwing would;
  // returns how far it was off. A bone too far off is left for BindStanding to refuse: the limit is
  // wider than its own, because in a clip that only walks a calf is bent where it is straightest.
  // Of 22 such clips of Character Creator six are bent by 34 to 49 degrees.
  float Straighten(int from, int to, RigPose& pose) const {
    constexpr float kMost_deg = 50;
    const World now(clip_.skeleton, pose);
    const Vec3 bone = Bone(now, from, to);
    const float off_deg = Angle_deg(bone, -up_);
    if (off_deg > kMost_deg || !(bone.norm() > 0)) return off_deg;
    const Quat above = now.rotations[static_cast<std::size_t>(clip_.skeleton.parents[At(from)])];
    pose.rotations[At(from)] =
        (above.conjugate() * body::ShortestTurn(bone, -up_) * now.rotations[At(from)]).normalized();
    return off_deg;
  }

  // The direction across the hips, level.
  Vec3 Left(const World& world) const {
    const Vec3 left = Bone(world, body::kRightUpperLeg, body::kLeftUpperLeg);
    return left - up_ * left.dot(up_);
  }

  // Turns a foot as in the frame in which it lies flattest: ankle and toes both lowest, relative to
  // the heading of the hips there.
  void LayFlat(int foot, int toes, RigPose& pose) const {
    float lowest_ankle = INFINITY, lowest_toes = INFINITY;
    for (const World& world : worlds_) {
      lowest_ankle = std::min(lowest_ankle, world.positions[At(foot)].dot(up_));
      lowest_toes = std::min(lowest_toes, world.positions[At(toes)].dot(up_));
    }
    const World& flat = worlds_[Best([&](const World& world) {
      return std::max(world.positions[At(foot)].dot(up_) - lowest_ankle,
                      world.positions[At(toes)].dot(up_) - lowest_toes);
    })];
    const World now(clip_.skeleton, pose);
    const auto above = static_cast<std::size_t>(clip_.skeleton.parents[At(foot)]);
    const Vec3 there = Left(flat), here = Left(now);
    const float turn_rad = std::atan2(there.cross(here).dot(up_), there.dot(here));
    pose.rotations[At(foot)] = (now.rotations[above].conjugate() *
                                Quat(Eigen::AngleAxisf(turn_rad, up_)) * flat.rotations[At(foot)])
                                   .normalized();
    if (clip_.skeleton.parents[At(toes)] == static_cast<int>(At(foot))) {
      pose.rotations[At(toes)] =
          (flat.rotations[At(foot)].conjugate() * flat.rotations[At(toes)]).normalized();
    }
  }

  const Clip& clip_;
  const JointMap& map_;
  std::vector<std::size_t> frames_;
  std::vector<World> worlds_;
  Vec3 up_;
};

// The straighter of the zero pose and the frames, as far as `kind` allows them.
Result<Stander> FindStander(const Clip& clip, const JointMap& map, RestPose::Kind kind) {
  auto zero = Judge(clip.skeleton, map, RigPose(clip.skeleton), kZeroPose);
  if (kind == RestPose::Kind::kZero) return zero;
  float off_deg = 0;
  auto frames =
      Judge(clip.skeleton, map, Straightest(clip, map).Make(off_deg), "straightest frames");
  if (frames.ok()) frames.value().off_deg = off_deg;
  if (kind == RestPose::Kind::kStanding) return frames;
  if (!frames.ok()) return zero.ok() ? std::move(zero) : std::move(frames);
  if (!zero.ok()) return frames;
  return zero.value().off_deg - kZeroBonus_deg <= frames.value().off_deg ? std::move(zero)
                                                                         : std::move(frames);
}

Result<Stander> FrameAt(const Clip& clip, const JointMap& map, double time_s) {
  const double frame = std::round(time_s * clip.rate_hz);
  if (!(frame >= 0 && frame < static_cast<double>(clip.frames.size()))) {
    return Status::Error("found no frame at " + NumberText(time_s) + " s, expected 0 to " +
                         NumberText(static_cast<double>(clip.frames.size() - 1) / clip.rate_hz, 3) +
                         " s");
  }
  const auto index = static_cast<std::size_t>(frame);
  return Judge(clip.skeleton, map, clip.frames[index], FrameName(clip, index));
}

// Frames from all of a clip, for what is true of most of it.
std::vector<RigPose> SomeFrames(const Clip& clip) {
  constexpr std::size_t kFrames = 40;
  const std::size_t stride = std::max<std::size_t>(1, clip.frames.size() / kFrames);
  std::vector<RigPose> frames;
  for (std::size_t i = 0; i < clip.frames.size(); i += stride) frames.push_back(clip.frames[i]);
  return frames;
}

std::string AxisText(const Vec3& axis) {
  Eigen::Index largest = 0;
  axis.cwiseAbs().maxCoeff(&largest);
  return (axis[largest] < 0 ? "-" : "+") + std::string(1, "XYZ"[largest]);
}
// As ParseUp reads it.
std::string AxisWord(const Vec3& axis) {
  Eigen::Index largest = 0;
  axis.cwiseAbs().maxCoeff(&largest);
  return (axis[largest] < 0 ? "-" : "") + std::string(1, "xyz"[largest]);
}

// Turns the binding to the motion's up axis, and writes the remark.
Status Check(const std::vector<RigPose>& frames, const std::optional<Vec3>& wanted,
             BoundClip& bound) {
  bound.remark = bound.map.remark;
  const auto say = [&bound](const std::string& sentence) {
    if (sentence.empty()) return;
    bound.remark += (bound.remark.empty() ? "" : "; ") + sentence;
  };
  const Vec3 was = rig::UpOf(bound.binding);
  const auto up = wanted ? wanted : rig::UpOfMotion(bound.binding, frames);
  if (up && up->dot(was) < 0.99F) {
    auto turned = rig::WithUp(bound.binding, *up);
    if (!turned.ok()) return turned.status();
    const bool stands = wanted || rig::StandsOnFloor(turned.value(), frames);
    if (stands) bound.binding = std::move(turned.value());
    if (!wanted) {
      say("the zero pose stands along " + AxisText(was) + ", the frames along " + AxisText(*up) +
          (stands ? ", which is taken for up; if they lie: --up " + AxisWord(was)
                  : ", but not above a floor there, so that they lie; if they stand: --up " +
                        AxisWord(*up)));
    }
  } else if (!wanted && !bound.rest.empty() && bound.rest != kZeroPose &&
             was.dot(Vec3::UnitY()) < 0.99F && !rig::StandsOnFloor(bound.binding, frames)) {
    say("up is taken to be " + AxisText(was) +
        ", along which the trunk lies in the frames; "
        "another axis: --up");
  }
  say(rig::WrongBone(bound.binding, frames));
  return Status::Ok();
}

std::string Names(const rig::Skeleton& skeleton) {
  std::string names;
  for (std::size_t i = 0; i < std::min(skeleton.names.size(), kNamesShown); ++i) {
    names += (i == 0 ? "" : ", ") + Printable(skeleton.names[i], kShownName);
  }
  return names + (skeleton.names.size() > kNamesShown ? ", ..." : "");
}

Result<BoundClip> BindPose(const Clip& clip, const BindOptions& options, const JointMap& map) {
  const std::string& dialect = options.dialect;
  const RestPose& rest = options.rest;
  std::string used;
  auto known = rig::BindMapped(clip.skeleton, dialect, &used, map);
  if (rest.kind == RestPose::Kind::kAuto && known.ok()) {
    return BoundClip{std::move(known.value()), used, "", {}, ""};
  }
  if (!known.ok() && dialect != "auto" &&
      (rest.kind == RestPose::Kind::kAuto || !rig::IsDialect(dialect))) {
    return known.status();
  }
  if (!rig::CanCalibrate(map).ok()) {
    return Status::Error(known.status().message() + "; its joints: " + Names(clip.skeleton));
  }
  const auto stander = rest.kind == RestPose::Kind::kTime ? FrameAt(clip, map, rest.time_s)
                                                          : FindStander(clip, map, rest.kind);
  if (!stander.ok()) {
    return Status::Error("found no pose to take the T-pose from (" + stander.status().message() +
                         "), expected an upright one");
  }
  auto binding = rig::BindStanding(clip.skeleton, map, stander.value().pose, false);
  if (!binding.ok()) return binding.status();
  const std::string_view named = rig::DialectOfNames(clip.skeleton);
  return BoundClip{std::move(binding.value()),
                   std::string(named.empty() ? "standing" : named),
                   stander.value().name,
                   {},
                   ""};
}

}  // namespace

Result<RestPose> ParseRestPose(const std::string& text) {
  using Kind = RestPose::Kind;
  for (const auto& [word, kind] : {std::pair{"auto", Kind::kAuto}, std::pair{"zero", Kind::kZero},
                                   std::pair{"standing", Kind::kStanding}}) {
    if (text == word) return RestPose{kind, 0};
  }
  double time_s = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, time_s);
  if (error == std::errc() && stop == end && time_s >= 0 && std::isfinite(time_s)) {
    return RestPose{Kind::kTime, time_s};
  }
  return Status::Error("'" + text +
                       "': expected auto, zero, standing, or the seconds at which the performer "
                       "stands");
}

Result<std::optional<Vec3>> ParseUp(const std::string& text) {
  if (text == "auto") return std::optional<Vec3>();
  const bool minus = text.starts_with('-'), sign = minus || text.starts_with('+');
  const std::size_t axis = std::string_view("xyzXYZ").find(text.substr(sign ? 1 : 0));
  if (text.size() != (sign ? 2U : 1U) || axis == std::string_view::npos) {
    return Status::Error("'" + text + "': expected auto, x, y, z, -x, -y or -z");
  }
  return std::optional<Vec3>((minus ? -1.0F : 1.0F) * Vec3::Unit(static_cast<int>(axis % 3)));
}

Result<BoundClip> BindClip(const Clip& clip, const BindOptions& options) {
  const std::vector<RigPose> frames = SomeFrames(clip);
  auto map = rig::FindHumanoid(clip.skeleton, options.joints, frames);
  if (!map.ok()) {
    return Status::Error(map.status().message() + "; its joints: " + Names(clip.skeleton));
  }
  auto bound = BindPose(clip, options, map.value().joint);
  if (!bound.ok()) {
    const std::string& remark = map.value().remark;
    return Status::Error(bound.status().message() + (remark.empty() ? "" : "; " + remark));
  }
  bound.value().map = std::move(map.value());
  const Status status = Check(frames, options.up, bound.value());
  if (!status.ok()) return status;
  return bound;
}

Clip WithTPose(Clip clip, const rig::Binding& binding) {
  // World rotations of the T-pose, from the old zero pose; from the new one they are identities.
  const std::vector<rig::Quat>& world = binding.spec().rest_rotations;
  rig::Skeleton& skeleton = clip.skeleton;
  for (std::size_t j = 0; j < world.size(); ++j) {
    const int parent = skeleton.parents[j];
    const rig::Quat above =
        parent < 0 ? rig::Quat::Identity() : world[static_cast<std::size_t>(parent)];
    skeleton.offsets[j] = above * skeleton.offsets[j];
    for (rig::RigPose& frame : clip.frames) {
      frame.translations[j] = above * frame.translations[j];
      frame.rotations[j] = (above * frame.rotations[j] * world[j].conjugate()).normalized();
    }
    if (j < clip.end_sites.size()) {
      for (rig::Vec3& end : clip.end_sites[j]) end = world[j] * end;
    }
  }
  return clip;
}

}  // namespace styled::clip
