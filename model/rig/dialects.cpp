#include "model/rig/dialects.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "model/base/text.h"
#include "model/rig/axes.h"
#include "model/rig/dialect_rests.h"
#include "model/rig/tail.h"

namespace styled::rig {
namespace {

using body::kHumanoid;
using body::kJointCount;
using JointMap = std::array<int, kJointCount>;

// The source of a dialect's T-pose.
enum class Rest {
  kIdentity,     // the zero pose is a T-pose
  kBandaiNamco,  // constants
  kRokoko,       // constants, unless the decoder already removed them
  kCmu,          // the zero pose with its legs closed, then swung
};
struct Dialect {
  std::string_view name;
  Rest rest;
};
constexpr std::size_t kMaxDialectShown = 80;  // bytes of a name that is given

constexpr Dialect kDialects[] = {
    {"bandai-namco", Rest::kBandaiNamco},
    {"cmu", Rest::kCmu},
    {"canonical", Rest::kIdentity},
    {"vrm", Rest::kIdentity},
    {"unity", Rest::kIdentity},
    {"vmc", Rest::kIdentity},
    {"mixamo", Rest::kIdentity},
    {"hik", Rest::kIdentity},
    {"lafan1", Rest::kIdentity},
    {"xsens", Rest::kIdentity},
    {"motive", Rest::kIdentity},
    {"rokoko", Rest::kRokoko},
    {"axis", Rest::kIdentity},
    {"mocopi", Rest::kIdentity},
    {"poser", Rest::kIdentity},
    {"character-creator", Rest::kIdentity},
};

// The name of the first dialect with this rest pose: "canonical" for all with kIdentity.
std::string_view NameOf(Rest rest) {
  return std::find_if(std::begin(kDialects), std::end(kDialects),
                      [rest](const Dialect& row) { return row.rest == rest; })
      ->name;
}

std::string KnownDialects() {
  std::string known = "auto";
  for (const Dialect& dialect : kDialects) known.append(", ").append(dialect.name);
  return known;
}

Status RequireMapped(const JointMap& map, std::string_view dialect) {
  std::string missing;
  for (int c = 0; c < kJointCount; ++c) {
    const bool optional = c == body::kSpine || c == body::kChest || c == body::kNeck ||
                          c == body::kLeftShoulder || c == body::kRightShoulder ||
                          c == body::kLeftHand || c == body::kRightHand || c == body::kLeftFoot ||
                          c == body::kRightFoot || c == body::kLeftToes || c == body::kRightToes;
    if (!optional && map[c] < 0) missing.append(" ").append(kHumanoid[c].name);
  }
  if (missing.empty()) return Status::Ok();
  return Status::Error("rig: dialect " + std::string(dialect) + ": found no joint named like" +
                       missing + ", expected the names of one of " + KnownDialects() +
                       "; name the joints by hand otherwise");
}

// World positions of all joints, the hips' ancestors included, if their world rotations are `rest`.
std::vector<Vec3> RestPositions(const Skeleton& skeleton, const std::vector<Quat>& rest) {
  std::vector<Vec3> positions(skeleton.offsets);
  for (int joint = 1; joint < skeleton.joint_count(); ++joint) {
    const int parent = skeleton.parents[joint];
    positions[joint] = positions[parent] + rest[parent] * skeleton.offsets[joint];
  }
  return positions;
}

// A T-pose judged by its joint positions: the source axes that point up, forward and left, and what
// is wrong with the pose ("" if nothing).
struct Judgement {
  std::string fault;
  Quat canonical_from_source = Quat::Identity();
};
Judgement JudgeTPose(const Skeleton& skeleton, const JointMap& map, const std::vector<Quat>& rest) {
  const std::vector<Vec3> positions = RestPositions(skeleton, rest);
  const auto at = [&](int c) { return positions[map[c]]; };
  const Vec3 up_bone = at(body::kHead) - at(body::kHips);
  const Vec3 left_bone = at(body::kLeftUpperLeg) - at(body::kRightUpperLeg);
  if (up_bone.norm() <= 0 || left_bone.norm() <= 0) {
    return {"the hips and the head, or both upper legs, at the same place"};
  }
  const Vec3 up = NearestAxis(up_bone);
  const Vec3 left = NearestAxis(left_bone);
  if (up.dot(left) != 0) return {"the upper legs above one another"};
  Judgement judged;
  Eigen::Matrix3f axes;
  axes.row(0) = left;
  axes.row(1) = up;
  axes.row(2) = left.cross(up);
  judged.canonical_from_source = Quat(axes).normalized();

  constexpr float kTolerance_deg = 25.0F;
  const auto check = [&](int from, int to, const Vec3& expected, const char* what) {
    if (!judged.fault.empty() || map[from] < 0 || map[to] < 0) return;
    const Vec3 bone = at(to) - at(from);
    if (bone.norm() <= 0) return;
    const float angle_deg =
        std::acos(std::clamp(bone.normalized().dot(expected), -1.0F, 1.0F)) * 180.0F / 3.14159265F;
    if (!(angle_deg <= kTolerance_deg)) {
      judged.fault = std::string(kHumanoid[from].name) + " to " + std::string(kHumanoid[to].name) +
                     " " + std::to_string(std::lround(angle_deg)) + " degrees away from " + what;
    }
  };
  check(body::kHips, body::kHead, up, "up");
  check(body::kLeftUpperArm, body::kLeftLowerArm, left, "the left");
  check(body::kLeftLowerArm, body::kLeftHand, left, "the left");
  check(body::kRightUpperArm, body::kRightLowerArm, -left, "the right");
  check(body::kRightLowerArm, body::kRightHand, -left, "the right");
  check(body::kLeftUpperLeg, body::kLeftLowerLeg, -up, "down");
  check(body::kLeftLowerLeg, body::kLeftFoot, -up, "down");
  check(body::kRightUpperLeg, body::kRightLowerLeg, -up, "down");
  check(body::kRightLowerLeg, body::kRightFoot, -up, "down");
  if (judged.fault.empty() && map[body::kLeftFoot] >= 0 && map[body::kLeftToes] >= 0 &&
      (at(body::kLeftToes) - at(body::kLeftFoot)).dot(left.cross(up)) < 0) {
    judged.fault = "toes that point backward, as in a left-handed skeleton that is not mirrored";
  }
  return judged;
}

std::vector<Quat> IdentityRest(const Skeleton& skeleton) {
  return std::vector<Quat>(skeleton.names.size(), Quat::Identity());
}

// Constants by canonical joint. Unmapped joints get the rotation of their parent.
std::vector<Quat> ConstantRest(const Skeleton& skeleton, const JointMap& map,
                               const RestTable& table) {
  std::vector<Quat> rest = IdentityRest(skeleton);
  std::vector<bool> mapped(rest.size(), false);
  for (int c = 0; c < kJointCount; ++c) {
    if (map[c] < 0) continue;
    rest[map[c]] = Quat(table[c].w, table[c].x, table[c].y, table[c].z).normalized();
    mapped[map[c]] = true;
  }
  for (int joint = 1; joint < skeleton.joint_count(); ++joint) {
    if (!mapped[joint]) rest[joint] = rest[skeleton.parents[joint]];
  }
  return rest;
}

// Turns the thumbs, and what hangs from them, which ConstantRest gave the hands' rotation.
void RestThumbs(const Skeleton& skeleton, std::vector<Quat>& rest) {
  const TailMap tail = MapTailNames(skeleton);
  for (const auto& [begin, thumb] : {std::pair{kTailLeftThumb, kRokokoLeftThumb},
                                     std::pair{kTailRightThumb, kRokokoRightThumb}}) {
    std::vector<bool> turned(rest.size(), false);
    for (int i = 0; i < kFingerJoints; ++i) {
      const int joint = tail[static_cast<std::size_t>(begin) + static_cast<std::size_t>(i)];
      if (joint < 0) continue;
      const RestRow& row = i == 0 ? thumb.first : thumb.others;
      rest[joint] = Quat(row.w, row.x, row.y, row.z).normalized();
      turned[joint] = true;
    }
    for (int joint = 1; joint < skeleton.joint_count(); ++joint) {
      const int parent = skeleton.parents[joint];
      if (turned[joint] || !turned[parent]) continue;
      rest[joint] = rest[parent];
      turned[joint] = true;
    }
  }
}

// The zero pose stands with its legs spread by 20 degrees each. Closing them at the hip joints
// gives the standing pose that RestBySwing expects.
std::vector<Quat> CmuRest(const Skeleton& skeleton, const JointMap& map,
                          const Quat& canonical_from_source) {
  RigPose standing(skeleton);
  const std::vector<Vec3> positions = RestPositions(skeleton, IdentityRest(skeleton));
  const Vec3 down = canonical_from_source.conjugate() * -Vec3::UnitY();
  for (auto [upper, lower] : {std::pair{body::kLeftUpperLeg, body::kLeftLowerLeg},
                              std::pair{body::kRightUpperLeg, body::kRightLowerLeg}}) {
    const Vec3 thigh = positions[map[lower]] - positions[map[upper]];
    if (thigh.norm() > 0) standing.rotations[map[upper]] = body::ShortestTurn(thigh, down);
  }
  return RestBySwing(skeleton, map, standing, canonical_from_source);
}

// The rest pose of one dialect, and whether it is a T-pose of this skeleton.
struct Candidate {
  std::vector<Quat> rest;
  Judgement judged;
};
Candidate Try(const Skeleton& skeleton, const JointMap& map, Rest dialect) {
  Candidate candidate{IdentityRest(skeleton), {}};
  candidate.judged = JudgeTPose(skeleton, map, candidate.rest);
  if (dialect == Rest::kCmu && candidate.judged.fault.empty()) {
    candidate.rest = CmuRest(skeleton, map, candidate.judged.canonical_from_source);
  }
  if (dialect == Rest::kRokoko && !candidate.judged.fault.empty()) {
    candidate.rest = ConstantRest(skeleton, map, kRokokoRest);
    RestThumbs(skeleton, candidate.rest);
    candidate.judged = JudgeTPose(skeleton, map, candidate.rest);
  }
  if (dialect == Rest::kBandaiNamco) {
    candidate.rest = ConstantRest(skeleton, map, kBandaiNamcoRest);
    candidate.judged = JudgeTPose(skeleton, map, candidate.rest);
  }
  return candidate;
}

bool HasNames(const Skeleton& skeleton, std::span<const std::string_view> names) {
  for (std::string_view name : names) {
    bool found = name.empty();
    for (const std::string& joint : skeleton.names) found = found || joint == name;
    if (!found) return false;
  }
  return true;
}

const Dialect* FindDialect(std::string_view name) {
  const auto* const row =
      std::find_if(std::begin(kDialects), std::end(kDialects),
                   [name](const Dialect& dialect) { return dialect.name == name; });
  return row == std::end(kDialects) ? nullptr : row;
}

// Joint names that only one dialect has.
struct Signature {
  std::string_view dialect;
  std::array<std::string_view, 6> names;  // as many as are not empty
};
constexpr Signature kSignatures[] = {
    {"bandai-namco", {"Hips", "Chest", "Shoulder_L", "UpperArm_L", "LowerLeg_R", "Toes_R"}},
    {"cmu", {"LHipJoint", "RHipJoint", "LowerBack"}},
    {"rokoko", {"hip", "leftUpLeg", "leftLowerArm", "rightToe"}},
    {"poser", {"hip", "abdomen", "chest", "lShldr", "rForeArm", "lShin"}},
    {"character-creator", {"CC_Base_Hip", "CC_Base_Waist", "CC_Base_L_Upperarm"}},
};

}  // namespace

bool IsDialect(std::string_view name) { return name == "auto" || FindDialect(name) != nullptr; }

std::string_view DialectOfNames(const Skeleton& skeleton) {
  for (const Signature& signature : kSignatures) {
    if (HasNames(skeleton, signature.names)) return signature.dialect;
  }
  return "";
}

Result<Binding> BindDialect(const Skeleton& skeleton, std::string_view dialect, std::string* used,
                            const JointNames& given) {
  if (skeleton.joint_count() == 0 || skeleton.parents.size() != skeleton.names.size() ||
      skeleton.offsets.size() != skeleton.names.size() || skeleton.parents[0] != -1) {
    return Binding::Make({skeleton, {}, {}, Quat::Identity()});  // for its error message
  }
  for (int joint = 1; joint < skeleton.joint_count(); ++joint) {
    if (skeleton.parents[joint] < 0 || skeleton.parents[joint] >= joint) {
      return Binding::Make({skeleton, {}, {}, Quat::Identity()});
    }
  }
  const auto mapped = MapJoints(skeleton, given);
  if (!mapped.ok()) return mapped.status();
  return BindMapped(skeleton, dialect, used, mapped.value());
}

Result<Binding> BindMapped(const Skeleton& skeleton, std::string_view dialect, std::string* used,
                           const JointMap& map) {
  const std::string_view name = dialect == "auto" ? DialectOfNames(skeleton) : dialect;
  const Dialect* const row = FindDialect(name);
  Rest rest = row != nullptr ? row->rest : Rest::kIdentity;
  if (!IsDialect(dialect)) {
    return Status::Error("rig: found dialect " + Printable(dialect, kMaxDialectShown) +
                         ", expected one of " + KnownDialects());
  }
  if (Status status = RequireMapped(map, dialect); !status.ok()) return status;
  Candidate candidate = Try(skeleton, map, rest);
  if (!candidate.judged.fault.empty() && dialect == "auto" && rest != Rest::kIdentity) {
    rest = Rest::kIdentity;
    candidate = Try(skeleton, map, rest);  // known names, but a body whose rest pose was normalized
  }
  if (!candidate.judged.fault.empty()) {
    return Status::Error("rig: dialect " + std::string(dialect) +
                         ": found a rest pose that is not a T-pose (" + candidate.judged.fault +
                         "), expected one within 25 degrees; give the rest rotations, or "
                         "name another dialect of " +
                         KnownDialects());
  }
  // A known name with another rest pose is reported under the dialect that was used.
  const bool as_named = row != nullptr && row->rest == rest;
  if (used != nullptr) *used = as_named ? name : NameOf(rest);
  return Binding::Make(
      {skeleton, map, std::move(candidate.rest), candidate.judged.canonical_from_source});
}

}  // namespace styled::rig
