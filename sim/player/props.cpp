#include "sim/player/props.h"

#include <cstdio>

#include "proto/styled/props.h"

namespace styled::player {

Result<PropSpec> ParseProp(const std::string& text) {
  const Status wrong = Status::Error("'" + text +
                                     "': expected NAME=right_hand, NAME=left_hand or NAME=X,Y,Z in "
                                     "metres (left, up, forward), and "
                                     "a NAME of 1 to " +
                                     std::to_string(kMaxPropName) + " bytes");
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals > kMaxPropName) return wrong;
  PropSpec prop;
  prop.name = text.substr(0, equals);
  const std::string where = text.substr(equals + 1);
  if (where == "right_hand" || where == "left_hand") {
    prop.wrist = where == "right_hand" ? rig::kRightWrist : rig::kLeftWrist;
    return prop;
  }
  int end = -1;
  rig::Vec3& p = prop.place_m;
  const int read = std::sscanf(where.c_str(), "%f,%f,%f%n", &p.x(), &p.y(), &p.z(), &end);
  if (read != 3 || end != static_cast<int>(where.size()) || !p.allFinite()) return wrong;
  return prop;
}

std::optional<rig::Placed> PlaceOf(const PropSpec& prop, const rig::WristPair& wrists) {
  if (!prop.wrist) return rig::Placed{prop.place_m, rig::Quat::Identity()};
  const auto& wrist = wrists[*prop.wrist];
  if (!wrist) return {};
  constexpr float kGrip_m = 0.1F;
  const float out_m = *prop.wrist == rig::kLeftWrist ? kGrip_m : -kGrip_m;
  return rig::Placed{wrist->position_m + wrist->rotation * rig::Vec3(out_m, 0, 0), wrist->rotation};
}

}  // namespace styled::player
