#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "model/body/pose.h"
#include "model/rig/skeleton.h"
#include "model/synthetic/script.h"

namespace styled::synthetic {

struct Options {
  std::uint64_t seed = 1;          // for everything that varies: order, amplitudes, places
  double speed = 1;                // factor on the gait's tempo, 0.7 .. 1.4; clamped
  double phase = 0;                // 0 .. 1: start phase of the first gait cycle
  std::vector<ScriptItem> script;  // repeated forever; empty: random order
};

// Options of the k-th of several performers, each with its own seed, tempo and phase.
Options Vary(std::uint64_t seed, std::uint64_t k, std::vector<ScriptItem> script);

// A synthetic human on the canonical humanoid, endless and deterministic: on one build, the same
// options give the same motion, at whatever times it is sampled. Starts at the origin, facing +Z;
// in random order it stays within some metres of it. The lowest foot is on the floor (y = 0),
// except in the flight phase of a run. Gaits are Fourier series and gestures are splines
// (motion_tables.h), blended in C2; standing feet are held in place. One thread at a time;
// allocates in the constructor only. Pinned by tests/unit/synthetic/performer_test.cpp.
class Performer {
 public:
  explicit Performer(Options options);
  ~Performer();
  Performer(Performer&&) noexcept;
  Performer& operator=(Performer&&) noexcept;

  // The pose at `time_s` >= 0, which must not decrease from call to call (else the last tick's time
  // is used).
  void Pose(double time_s, body::Pose& pose) noexcept;

  // The motion at the time of the last Pose(); changes when a transition begins.
  synthetic::Motion motion() const noexcept;

  // The contact of the left and the right foot at that time: 1 held in place, 0 in the air.
  std::array<double, 2> contacts() const noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Body sizes relative to the canonical humanoid; 0.8 .. 1.25 each, clamped.
struct Proportions {
  float height = 1;  // scale of the whole body
  float torso = 1, arms = 1;
};

Proportions VaryProportions(std::uint64_t seed, std::uint64_t k);

// The canonical humanoid with other proportions: names, parents, offsets (m), identity rest.
rig::Skeleton MakeSkeleton(const Proportions& proportions);

}  // namespace styled::synthetic
