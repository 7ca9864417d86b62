#pragma once

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "proto/styled/v1/frame.pb.h"

namespace styled::fuzz {

// Ends the program, which is a finding, where `condition` is false.
inline void Require(bool condition, const char* what) {
  if (condition) return;
  std::fprintf(stderr, "not so: %s\n", what);
  std::abort();
}
#define REQUIRE(condition) Require(condition, #condition)

// Finite, and rotations of unit length.
inline void RequireSane(const v1::Frame& frame) {
  for (const float value : frame.root_position()) REQUIRE(std::isfinite(value));
  REQUIRE(frame.rotations_size() % 4 == 0);
  for (int i = 0; i < frame.rotations_size(); i += 4) {
    double length2 = 0;
    for (int k = 0; k < 4; ++k) length2 += std::pow(frame.rotations(i + k), 2);
    REQUIRE(std::abs(length2 - 1) < 2e-3);
  }
  REQUIRE(frame.props_size() <= 16);
  for (const v1::Prop& prop : frame.props()) {
    REQUIRE(prop.position_size() == 3 && prop.rotation_size() == 4 && !prop.name().empty());
    double length2 = 0;
    for (const float value : prop.position()) REQUIRE(std::isfinite(value));
    for (const float value : prop.rotation()) length2 += std::pow(value, 2);
    REQUIRE(std::abs(length2 - 1) < 2e-3);
  }
}

}  // namespace styled::fuzz
