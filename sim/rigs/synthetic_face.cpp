#include "sim/rigs/synthetic_face.h"

#include <algorithm>
#include <cmath>

namespace styled::rigs {
namespace {

constexpr double kTurn = 6.283185307179586;

double Wave(double time_s, double period_s) { return std::sin(kTurn * time_s / period_s); }

}  // namespace

std::array<float, arkit::kShapes> SyntheticFace(double time_s) {
  std::array<float, arkit::kShapes> face{};
  const auto put = [&face](std::string_view name, double weight) {
    face[*arkit::Find(name)] = static_cast<float>(std::clamp(weight, 0.0, 1.0));
  };
  const double blink = 1 - std::abs(std::fmod(time_s, 4.0) - 0.1) / 0.1;  // 0.2 s
  for (const auto* const name : {"eyeBlinkLeft", "eyeBlinkRight"}) put(name, blink);
  const double talk = std::max(0.0, Wave(time_s, 0.3)) * std::max(0.0, Wave(time_s, 3.1));
  put("jawOpen", 0.6 * talk);
  put("mouthFunnel", 0.4 * talk * std::max(0.0, Wave(time_s, 0.7)));
  for (const auto* const name : {"mouthSmileLeft", "mouthSmileRight"}) {
    put(name, 0.8 * Wave(time_s, 7.3));
  }
  put("browInnerUp", 0.5 * Wave(time_s, 5.1));
  put("eyeLookInLeft", 0.5 * Wave(time_s, 6.1));
  put("eyeLookOutRight", 0.5 * Wave(time_s, 6.1));
  put("eyeLookOutLeft", -0.5 * Wave(time_s, 6.1));
  put("eyeLookInRight", -0.5 * Wave(time_s, 6.1));
  return face;
}

SyntheticHead HeadOfSyntheticFace(double time_s) {
  return {static_cast<float>(0.3 * Wave(time_s, 6.1)), static_cast<float>(0.1 * Wave(time_s, 4.3)),
          static_cast<float>(0.08 * Wave(time_s, 8.7))};
}

}  // namespace styled::rigs
