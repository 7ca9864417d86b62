#pragma once

#include <optional>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/body/pose.h"
#include "model/clip/clip.h"
#include "model/clip/manifest.h"
#include "model/rig/binding.h"

namespace styled::clip {

// The poses of a loop (its last frame equals the first), repeated with a continued path until there
// are at least `frames`.
std::vector<body::Pose> RepeatLoop(const std::vector<body::Pose>& loop, int frames);

// Reads the clips of a manifest as canonical poses. Keeps the last skeleton's binding, since most
// sets have only one. Allocates; one thread at a time.
class EntryReader {
 public:
  // The part of the clip that the entry means, at `rate_hz`. Errors name the file.
  Result<std::vector<body::Pose>> Read(const ManifestEntry& entry, double rate_hz);

 private:
  Result<const rig::Binding*> Bind(const Clip& clip, const std::string& dialect);

  std::optional<rig::Binding> binding_;
  std::string dialect_;
};

}  // namespace styled::clip
