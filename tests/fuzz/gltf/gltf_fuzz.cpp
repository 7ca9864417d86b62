// Fuzzes the reader of glTF clips: what it accepts is finite, on a sound skeleton, no longer than
// the limit, and can be bound and resampled, or is refused with a reason.
#include <cstdint>
#include <cstdlib>

#include "model/clip/gltf_clip.h"

namespace {

using namespace styled;

void Require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  auto read = clip::ParseGltfClip({reinterpret_cast<const char*>(data), size}, "fuzz.glb",
                                  {.longest_s = clip::kLongestExample_s, .work = {}});
  if (!read.ok()) {
    Require(read.status().message().starts_with("fuzz.glb: "));
    return 0;
  }
  clip::GltfClip& clip = read.value();
  const std::size_t joints = clip.clip.skeleton.names.size();
  Require(joints >= 1 && joints <= static_cast<std::size_t>(rig::kMaxSourceJoints));
  Require(!clip.clip.frames.empty() && clip.clip.rate_hz >= 1);
  Require(static_cast<double>(clip.clip.frames.size() - 1) / clip.clip.rate_hz < 60.1);
  Require(clip.clip.frames.size() * clip::FrameBytes(joints) <= 4 * size + (std::size_t{5} << 20));
  for (const rig::RigPose& frame : clip.clip.frames) {
    Require(frame.rotations.size() == joints && frame.translations.size() == joints);
    for (const auto& rotation : frame.rotations) Require(rotation.coeffs().allFinite());
    for (const auto& translation : frame.translations) Require(translation.allFinite());
  }
  const auto bound = clip::BindGltf(clip);
  if (!bound.ok()) {
    Require(!bound.status().message().empty());
    return 0;
  }
  const double rate_hz = clip.clip.rate_hz;
  const auto poses = clip::ToCanonical(std::move(clip.clip), bound.value(), {}, "fuzz.glb");
  Require(poses.ok());
  if (poses.value().size() < 500) {  // to be quick
    Require(clip::ResamplePoses(poses.value(), rate_hz, 30, {}, "fuzz.glb").ok());
  }
  return 0;
}
