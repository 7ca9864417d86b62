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
  std::uint64_t seed = 1;          // of everything that varies: order, amplitudes, places
  double speed = 1;                // of the gait's tempo, 0.7 .. 1.4; clamped
  double phase = 0;                // 0 .. 1, where in the first gait cycle it begins
  std::vector<ScriptItem> script;  // repeated for ever; empty = random order
};

// Options of the k-th of several performers: each its own tempo and phase.
Options Vary(std::uint64_t seed, std::uint64_t k, std::vector<ScriptItem> script);

// A synthetic human on the canonical humanoid, endless and deterministic: the same options give the
// same motion on one build, at whatever times it is looked at. Starts at the origin facing +Z; in
// random order it stays within some metres of it. The lowest foot is on the floor (y = 0) but in
// the flight of a run. Motion: gait as Fourier series and gestures as splines (motion_tables.h),
// blended in C2; feet are held where they stand. One thread; allocates in the constructor only.
// Pinned by tests/unit/synthetic/performer_test.cpp.
class Performer {
 public:
  explicit Performer(Options options);
  ~Performer();
  Performer(Performer&&) noexcept;
  Performer& operator=(Performer&&) noexcept;

  // The pose at `time_s` >= 0, which must not go back from call to call (clamped to the last).
  void Pose(double time_s, body::Pose& pose) noexcept;

  // What is being done at the time of the last Pose(): changes when a transition begins.
  synthetic::Motion motion() const noexcept;

  // How firmly the left and the right foot stand then: 1 held to its place, 0 in the air.
  std::array<double, 2> contacts() const noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Body sizes relative to the canonical humanoid; 0.8 .. 1.25 each.
struct Proportions {
  float height = 1;  // everything
  float torso = 1, arms = 1;
};

Proportions VaryProportions(std::uint64_t seed, std::uint64_t k);

// The canonical humanoid of other proportions: names, parents, offsets (m), identity rest.
rig::Skeleton MakeSkeleton(const Proportions& proportions);

}  // namespace styled::synthetic
