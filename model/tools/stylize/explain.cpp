// stylize --explain: how a clip's or an avatar's skeleton is understood.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "model/base/text.h"
#include "model/clip/avatar.h"
#include "model/clip/bind_clip.h"
#include "model/rig/check_binding.h"
#include "model/rig/find_humanoid.h"
#include "model/rig/motion_up.h"
#include "model/tools/stylize/stylize.h"

namespace styled::stylize {
namespace {

using rig::Vec3;

constexpr std::size_t kShown = 64;      // bytes of a joint's name
constexpr std::size_t kTreeWidth = 48;  // columns

// The canonical name of a source joint; "" if it has none.
std::string_view CanonicalOf(const std::array<int, body::kJointCount>& map, std::size_t joint) {
  const auto* const found = std::find(map.begin(), map.end(), static_cast<int>(joint));
  return found == map.end() ? ""
                            : body::kHumanoid[static_cast<std::size_t>(found - map.begin())].name;
}

// The text with blanks up to a width in columns: signs of Japanese and Chinese take two.
std::string Padded(std::string text, std::size_t width) {
  std::size_t columns = 0;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte & 0xC0U) != 0x80U) columns += byte >= 0xE2 ? 2 : 1;
  }
  text.append(columns < width ? width - columns : 0, ' ');
  return text;
}

void PrintTree(const rig::Skeleton& skeleton,
               const std::optional<std::array<int, body::kJointCount>>& map) {
  std::printf("\ntree:\n");
  std::vector<int> depth(skeleton.names.size(), 0);
  for (std::size_t j = 0; j < skeleton.names.size(); ++j) {
    const int parent = skeleton.parents[j];
    if (parent >= 0) depth[j] = depth[static_cast<std::size_t>(parent)] + 1;
    const std::string line = std::string(2 * static_cast<std::size_t>(depth[j]) + 2, ' ') +
                             Printable(skeleton.names[j], kShown);
    const std::string_view canonical = map ? CanonicalOf(*map, j) : "";
    if (canonical.empty()) {
      std::printf("%s\n", line.c_str());
    } else {
      std::printf("%s %.*s\n", Padded(line, kTreeWidth).c_str(), static_cast<int>(canonical.size()),
                  canonical.data());
    }
  }
}

void PrintMap(const rig::Skeleton& skeleton, const std::array<int, body::kJointCount>& map,
              const char* option) {
  std::printf("\njoints:\n");
  std::string by_hand;
  for (std::size_t c = 0; c < map.size(); ++c) {
    const std::string canonical(body::kHumanoid[c].name);
    const std::string name = map[c] < 0 ? "" : skeleton.names[static_cast<std::size_t>(map[c])];
    std::printf("  %-16s %s\n", canonical.c_str(),
                map[c] < 0 ? "-" : Printable(name, kShown).c_str());
    by_hand += std::string(" ") + option + " '" + canonical + "=" + Printable(name, kShown) + "'";
  }
  std::printf("by hand, to copy and change:\n %s\n", by_hand.c_str());
}

std::string AxisText(const Vec3& axis) {
  Eigen::Index largest = 0;
  const float size = axis.cwiseAbs().maxCoeff(&largest);
  const std::string name = (axis[largest] < 0 ? "-" : "+") + std::string(1, "XYZ"[largest]);
  return size > 0.98F ? name : "near " + name;
}

void PrintAxes(const rig::Binding& binding) {
  const auto axis = [&](const Vec3& ours) {
    return AxisText(binding.spec().canonical_from_source.conjugate() * ours);
  };
  std::printf("\naxes: up is %s, forward %s, left %s of the file\n", axis(Vec3::UnitY()).c_str(),
              axis(Vec3::UnitZ()).c_str(), axis(Vec3::UnitX()).c_str());
  std::printf("unit: %.4g m if the performer's legs are as long as the humanoid's%s\n",
              static_cast<double>(binding.scale()),
              binding.scale() > 0.007F && binding.scale() < 0.014F   ? "; centimetres"
              : binding.scale() > 0.7F && binding.scale() < 1.4F     ? "; metres"
              : binding.scale() > 0.018F && binding.scale() < 0.035F ? "; inches"
                                                                     : "");
}

// Two views of the humanoid in a pose as letters: from the front, and from its left.
class Picture {
 public:
  explicit Picture(const body::Pose& pose) {
    body::WorldPose world;
    body::ForwardKinematics(pose, world);
    const Vec3 hips = world.positions_m[body::kHips];
    for (int c = 1; c < body::kJointCount; ++c) {
      const auto parent = static_cast<std::size_t>(body::kHumanoid[c].parent);
      const Vec3 from = world.positions_m[parent] - hips, to = world.positions_m[c] - hips;
      for (int i = 0; i <= kSteps; ++i) {
        const Vec3 at = from + (to - from) * (static_cast<float>(i) / kSteps);
        Dot(kWidth / 2, at.x(), at.y(), c);
        Dot(kWidth + kWidth / 2, at.z(), at.y(), c);
      }
    }
  }
  void Print() const {
    std::printf("\n%-*s%s\n", kWidth, "  from the front", "  from its left, looking right");
    for (const std::string& row : rows_) {
      const std::size_t end = row.find_last_not_of(' ');
      std::printf("%s\n", row.substr(0, end == std::string::npos ? 0 : end + 1).c_str());
    }
  }

 private:
  static constexpr int kWidth = 40, kHeight = 23, kSteps = 12;
  static constexpr float kAcross_m = 0.05F, kDown_m = 0.09F;  // of a letter

  void Dot(int middle, float across_m, float up_m, int joint) {
    const int x = middle + static_cast<int>(std::lround(across_m / kAcross_m));
    const int y = kHeight * 2 / 5 - static_cast<int>(std::lround(up_m / kDown_m));
    if (x < middle - kWidth / 2 || x >= middle + kWidth / 2 || y < 0 || y >= kHeight) return;
    const bool left = body::MirrorJoint(joint) > joint,
               middle_joint = body::MirrorJoint(joint) == joint;
    rows_[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)] = middle_joint ? '#'
                                                                      : left       ? 'l'
                                                                                   : 'r';
  }

  std::array<std::string, kHeight> rows_ = [] {
    std::array<std::string, kHeight> rows;
    rows.fill(std::string(2 * kWidth, ' '));
    return rows;
  }();
};

void PrintBones(const rig::Binding& binding, std::span<const rig::RigPose> poses) {
  const auto bones = rig::CompareBones(binding, poses);
  if (bones.empty()) return;
  std::printf("check: on the humanoid the bone at %s is %.0f degrees off, the others less\n",
              Printable(bones.front().joint, kShown).c_str(),
              static_cast<double>(bones.front().degrees));
}

Status ExplainAvatar(const std::string& file, const rig::JointNames& joints) {
  const auto avatar = clip::ReadAvatar(file, "auto", joints);
  if (!avatar.ok()) return avatar.status();
  const rig::Binding& binding = *avatar.value().binding;
  std::printf(
      "%s: %d joints, %s\n", file.c_str(), binding.skeleton().joint_count(),
      avatar.value().dialect == "vrm" ? "by VRM's table of bones" : "by the tree and names");
  PrintMap(binding.skeleton(), binding.spec().source_joint, "--avatar-joints");
  PrintTree(binding.skeleton(), binding.spec().source_joint);
  PrintAxes(binding);
  std::printf("rest pose: %s\n", avatar.value().dialect == "vrm"
                                     ? "the file's, VRM's T-pose"
                                     : "from how it stands in the file");
  Picture(body::Pose()).Print();
  return Status::Ok();
}

}  // namespace

Status Explain(const Arguments& arguments) {
  const std::string& file = arguments.explain;
  std::string extension = std::filesystem::path(file).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto joints = rig::ParseJoints("--joints", arguments.joints);
  if (!joints.ok()) return joints.status();
  if (extension == ".glb" || extension == ".gltf" || extension == ".vrm" || extension == ".vrma") {
    return ExplainAvatar(file, joints.value());
  }
  const auto clip = clip::ReadBvh(file);
  if (!clip.ok()) return clip.status();
  const rig::Skeleton& skeleton = clip.value().skeleton;
  std::printf("%s: %zu frames at %s Hz, %d joints\n", file.c_str(), clip.value().frames.size(),
              NumberText(clip.value().rate_hz).c_str(), skeleton.joint_count());
  if (!clip.value().remark.empty()) std::printf("text: %s\n", clip.value().remark.c_str());
  const auto bound =
      clip::BindClip(clip.value(), {arguments.rig, clip::ParseRestPose(arguments.rest).value(),
                                    joints.value(), clip::ParseUp(arguments.up).value()});
  if (!bound.ok()) {
    const auto found = rig::FindHumanoid(skeleton, joints.value(), clip.value().frames);
    if (found.ok()) {
      std::printf("found %s; not bound, see below\n", found.value().reason.c_str());
      PrintMap(skeleton, found.value().joint, "--joints");
    }
    PrintTree(skeleton, found.ok() ? std::optional(found.value().joint) : std::nullopt);
    std::fflush(stdout);
    return Status::Error(file + ": " + bound.status().message());
  }
  const auto& [binding, dialect, rest, map, remark] = bound.value();
  std::printf("found %s, confidence %.2f\n", map.reason.c_str(),
              static_cast<double>(map.confidence));
  if (!remark.empty()) std::printf("warning: %s\n", remark.c_str());
  PrintMap(skeleton, map.joint, "--joints");
  PrintTree(skeleton, map.joint);
  PrintAxes(binding);
  std::printf("rest pose: %s\n", rest.empty() ? ("the zero pose, of dialect " + dialect).c_str()
                                              : ("from its " + rest).c_str());
  PrintBones(binding, clip.value().frames);
  body::Pose pose;
  binding.Bind(clip.value().frames[clip.value().frames.size() / 2], pose);
  Picture(pose).Print();
  return Status::Ok();
}

}  // namespace styled::stylize
