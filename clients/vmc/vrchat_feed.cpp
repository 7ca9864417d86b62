#include "clients/vmc/vrchat_feed.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "proto/rigs/vrchat/vrchat.h"

namespace styled::stylevmc {
namespace {

using body::Quat;
using body::Vec3;

constexpr std::int64_t kPause_ns = 1'000'000'000;

// A tracker has the position of one joint and the rotation of another: a knee's has the thigh's.
struct Row {
  int at, turns_as;
};
// By number; [0] is the head.
constexpr std::array<Row, vrchat::kTrackers + 1> kRows{
    {{body::kHead, body::kHead},
     {body::kHips, body::kHips},
     {body::kLeftFoot, body::kLeftFoot},
     {body::kRightFoot, body::kRightFoot},
     {body::kLeftLowerLeg, body::kLeftUpperLeg},
     {body::kRightLowerLeg, body::kRightUpperLeg},
     {body::kChest, body::kChest},
     {body::kLeftLowerArm, body::kLeftUpperArm},
     {body::kRightLowerArm, body::kRightUpperArm}}};

constexpr std::array<std::pair<std::string_view, std::uint32_t>, 6> kWords{{{"hip", 1U << 1U},
                                                                            {"feet", 3U << 2U},
                                                                            {"knees", 3U << 4U},
                                                                            {"chest", 1U << 6U},
                                                                            {"elbows", 3U << 7U},
                                                                            {"all", 0xFFU << 1U}}};

// Mirrored in x = 0: Unity's axes.
std::array<float, 3> ToUnity(const Vec3& p) { return {-p.x(), p.y(), p.z()}; }
std::array<float, 3> ToEuler(const Quat& q) {
  return vrchat::EulerOf({q.x(), -q.y(), -q.z(), q.w()});
}

}  // namespace

Result<std::uint32_t> ParseTrackerSet(const std::string& list) {
  std::uint32_t set = 0;
  for (std::size_t begin = 0; begin <= list.size();) {
    const std::size_t end = std::min(list.find(',', begin), list.size());
    const std::string word = list.substr(begin, end - begin);
    std::uint32_t bits = 0;
    for (const auto& [name, of] : kWords) bits |= word == name ? of : 0;
    if (bits == 0) {
      return Status::Error("--trackers '" + list + "': found '" + word +
                           "', expected hip, feet, knees, chest, elbows, separated by commas, or "
                           "all");
    }
    set |= bits;
    begin = end + 1;
  }
  return set;
}

Status VrChatFeed::Bind(const v1::Body& body) {
  for (int j = 0; j < body::kJointCount; ++j) {
    const auto& row = body::kHumanoid[static_cast<std::size_t>(j)];
    if (j < body.names_size() && body.names(j) == row.name && body.parents(j) == row.parent) {
      continue;
    }
    return Status::Error("body of " + body.performer() + ": joint " + std::to_string(j) +
                         " is not '" + std::string(row.name) +
                         "'; expected the canonical humanoid");
  }
  for (int j = 0; j < body::kJointCount; ++j) {
    const float* offset = body.offsets().data() + 3 * j;
    offsets_[static_cast<std::size_t>(j)] = Vec3(offset[0], offset[1], offset[2]);
  }
  turn_ = true;
  return Status::Ok();
}

std::span<const std::byte> VrChatFeed::Pack(const v1::Frame& frame, std::int64_t now_ns) {
  std::array<Vec3, body::kJointCount> positions;
  std::array<Quat, body::kJointCount> rotations;
  for (std::size_t j = 0; j < body::kJointCount; ++j) {
    const float* q = frame.rotations().data() + 4 * j;
    const Quat local(q[3], q[0], q[1], q[2]);
    const int parent = body::kHumanoid[j].parent;
    if (parent < 0) {
      positions[j] = Vec3(frame.root_position(0), frame.root_position(1), frame.root_position(2));
      rotations[j] = local;
      continue;
    }
    const auto above = static_cast<std::size_t>(parent);
    positions[j] = positions[above] + rotations[above] * offsets_[j];
    rotations[j] = rotations[above] * local;
  }
  const auto scale = static_cast<float>(
      options_.user_height_m > 0 ? options_.user_height_m / kCanonicalHeight_m : 1.0);
  turn_ = turn_ || (frame.flags() & v1::FLAG_NEW_SESSION) != 0 || now_ns - last_ns_ > kPause_ns;
  last_ns_ = now_ns;

  vrchat::osc::Writer writer(buffer_);
  writer.BeginBundle();
  for (int index = 0; index <= vrchat::kTrackers; ++index) {
    const bool head = index == vrchat::kHead;
    if (!head && (options_.trackers >> static_cast<unsigned>(index) & 1U) == 0) continue;
    const Row& row = kRows[static_cast<std::size_t>(index)];
    const Vec3 place = scale * positions[static_cast<std::size_t>(row.at)];
    vrchat::Put(vrchat::Tracker{index, false, ToUnity(place)}, writer);
    std::array<float, 3> euler = ToEuler(rotations[static_cast<std::size_t>(row.turns_as)]);
    if (head) euler = {0, euler[1], 0};
    if (!head || turn_) vrchat::Put(vrchat::Tracker{index, true, euler}, writer);
  }
  writer.EndBundle();
  turn_ = false;
  return std::span(buffer_).first(writer.ok() ? writer.size() : 0);
}

}  // namespace styled::stylevmc
