#include "proto/rigs/vrchat/vrchat.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "proto/rigs/result_name.h"

namespace styled::vrchat {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
// The addresses of all trackers, [2 * index + is_rotation].
constexpr std::array<std::string_view, 2 * (kTrackers + 1)> kTrackerAddresses{
    "/tracking/trackers/head/position", "/tracking/trackers/head/rotation",
    "/tracking/trackers/1/position",    "/tracking/trackers/1/rotation",
    "/tracking/trackers/2/position",    "/tracking/trackers/2/rotation",
    "/tracking/trackers/3/position",    "/tracking/trackers/3/rotation",
    "/tracking/trackers/4/position",    "/tracking/trackers/4/rotation",
    "/tracking/trackers/5/position",    "/tracking/trackers/5/rotation",
    "/tracking/trackers/6/position",    "/tracking/trackers/6/rotation",
    "/tracking/trackers/7/position",    "/tracking/trackers/7/rotation",
    "/tracking/trackers/8/position",    "/tracking/trackers/8/rotation"};
constexpr std::array<std::string_view, 3> kSystemAddresses{"/tracking/vrsystem/head/pose",
                                                           "/tracking/vrsystem/leftwrist/pose",
                                                           "/tracking/vrsystem/rightwrist/pose"};

DecodeResult ReadFloats(osc::Arguments& arguments, std::span<float> values) noexcept {
  for (float& value : values) {
    if (arguments.Float(value)) continue;
    return arguments.AtEnd() ? DecodeResult::kTooFewArguments : DecodeResult::kWrongType;
  }
  return DecodeResult::kOk;
}

}  // namespace

std::string_view Name(DecodeResult result) noexcept {
  return rigs::ResultName(result, {"ok", "unknown_address", "too_few_arguments", "wrong_type"});
}

DecodeResult Decode(const osc::Message& bytes, Message& message) noexcept {
  osc::Arguments arguments(bytes);
  const auto tracker = std::ranges::find(kTrackerAddresses, bytes.address);
  if (tracker != kTrackerAddresses.end()) {
    const auto at = static_cast<int>(tracker - kTrackerAddresses.begin());
    Tracker read{at / 2, at % 2 == 1, {}};
    const DecodeResult result = ReadFloats(arguments, read.values);
    if (result == DecodeResult::kOk) message = read;
    return result;
  }
  const auto system = std::ranges::find(kSystemAddresses, bytes.address);
  if (system == kSystemAddresses.end()) return DecodeResult::kUnknownAddress;
  SystemPose read;
  read.device = static_cast<System>(system - kSystemAddresses.begin());
  DecodeResult result = ReadFloats(arguments, read.position);
  if (result == DecodeResult::kOk) result = ReadFloats(arguments, read.euler);
  if (result == DecodeResult::kOk) message = read;
  return result;
}

void Put(const Tracker& message, osc::Writer& writer) noexcept {
  const auto at = static_cast<std::size_t>(2 * message.index + (message.is_rotation ? 1 : 0));
  writer.BeginMessage(kTrackerAddresses[at], "fff");
  for (const float value : message.values) writer.Float(value);
  writer.EndMessage();
}

void Put(const SystemPose& message, osc::Writer& writer) noexcept {
  writer.BeginMessage(kSystemAddresses[static_cast<std::size_t>(message.device)], "ffffff");
  for (const float value : message.position) writer.Float(value);
  for (const float value : message.euler) writer.Float(value);
  writer.EndMessage();
}

// In double: angles of thousands of degrees are still turned exactly.
std::array<float, 4> QuaternionOf(const std::array<float, 3>& euler) noexcept {
  std::array<double, 3> sine{}, cosine{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double half_rad = double{euler[i]} / kDegrees / 2;
    sine[i] = std::sin(half_rad);
    cosine[i] = std::cos(half_rad);
  }
  const auto [sx, sy, sz] = sine;
  const auto [cx, cy, cz] = cosine;
  return {static_cast<float>(cy * sx * cz + sy * cx * sz),
          static_cast<float>(sy * cx * cz - cy * sx * sz),
          static_cast<float>(cy * cx * sz - sy * sx * cz),
          static_cast<float>(cy * cx * cz + sy * sx * sz)};
}

std::array<float, 3> EulerOf(const std::array<float, 4>& quaternion) noexcept {
  const double x = quaternion[0], y = quaternion[1], z = quaternion[2], w = quaternion[3];
  const double sine = std::clamp(2 * (w * x - y * z), -1.0, 1.0);
  constexpr double kSteep = 0.9999985;  // sine of 89.9 degrees
  double yaw = 0, roll = 0;
  if (std::abs(sine) > kSteep) {
    yaw = std::atan2(2 * (w * y - x * z), 1 - 2 * (y * y + z * z));
  } else {
    yaw = std::atan2(2 * (x * z + w * y), 1 - 2 * (x * x + y * y));
    roll = std::atan2(2 * (x * y + w * z), 1 - 2 * (x * x + z * z));
  }
  return {static_cast<float>(std::asin(sine) * kDegrees), static_cast<float>(yaw * kDegrees),
          static_cast<float>(roll * kDegrees)};
}

}  // namespace styled::vrchat
