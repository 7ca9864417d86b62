// Fuzzes the BVH reader: what it accepts is finite, can be resampled, and can be written to a file
// that reads back with the same skeleton and number of frames.
#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "model/clip/clip.h"

namespace {

using namespace styled;

void Require(bool condition) {
  if (!condition) std::abort();
}

void RequireFinite(const clip::Clip& clip) {
  for (const auto& frame : clip.frames) {
    for (const auto& rotation : frame.rotations) Require(rotation.coeffs().allFinite());
    for (const auto& translation : frame.translations) Require(translation.allFinite());
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto read = clip::ParseBvh({reinterpret_cast<const char*>(data), size}, "fuzz.bvh");
  if (!read.ok()) {
    Require(read.status().message().starts_with("fuzz.bvh"));
    return 0;
  }
  const clip::Clip& clip = read.value();
  RequireFinite(clip);
  // Limited to be quick: a clip at 1 Hz becomes sixty times as many frames.
  if (clip.frames.size() * clip.skeleton.names.size() < 500) {
    RequireFinite(clip::Resample(clip, 60));
  }
  const auto again = clip::ParseBvh(clip::FormatBvh(clip), "again.bvh");
  Require(again.ok());
  Require(again.value().frames.size() == clip.frames.size());
  Require(again.value().skeleton.names.size() == clip.skeleton.names.size());
  return 0;
}
