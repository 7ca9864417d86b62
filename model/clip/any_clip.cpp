#include "model/clip/any_clip.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "model/clip/read_file.h"

namespace styled::clip {
namespace {

constexpr const char* kExpectedClip = ", expected BVH, glTF binary (.glb) or VRMA";

// Names the format of bytes that begin like another one's; "" if unknown.
std::string_view OtherFormat(std::string_view bytes) {
  if (bytes.starts_with("Kaydara FBX")) return "FBX";
  if (bytes.starts_with("{")) return "glTF as text";
  if (bytes.starts_with("PK")) return "a ZIP archive";
  return "";
}

Result<AnyClip> Of(Result<Clip>&& bvh) {
  if (!bvh.ok()) return bvh.status();
  AnyClip clip;
  clip.clip = std::move(bvh.value());
  return clip;
}

}  // namespace

Result<AnyClip> ParseAnyClip(std::string_view bytes, const std::string& name,
                             const ReadLimits& limits, const rig::JointNames& joints) {
  if (const std::string_view other = OtherFormat(bytes); !other.empty()) {
    return Status::Error(name + ": found " + std::string(other) + kExpectedClip);
  }
  if (!IsGltfBinary(bytes)) return Of(ParseBvh(bytes, name, limits));
  auto gltf = ParseGltfClip(bytes, name, limits, joints);
  if (!gltf.ok()) return gltf.status();
  return AnyClip{std::move(gltf.value()), true};
}

Result<AnyClip> ReadAnyClip(const std::filesystem::path& file, const ReadLimits& limits,
                            const rig::JointNames& joints) {
  constexpr std::size_t kFirstBytes = 16, kMaxBytes = std::size_t{1} << 31;
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return Of(ReadBvh(file, limits));
  const auto opened = InputFile::Open(file, kExpectedClip);
  if (!opened.ok()) return opened.status();
  const auto first = opened.value().Read(0, kFirstBytes);
  if (!first.ok()) return first.status();
  if (!IsGltfBinary(first.value()) && OtherFormat(first.value()).empty()) {
    const std::string kind = file.extension().string();
    const bool is_bvh = std::string_view(first.value()).find("HIERARCHY") != std::string_view::npos;
    if ((kind == ".glb" || kind == ".vrma") && !is_bvh) {
      return Status::Error(file.string() + ": found a " + kind + " that does not begin as glTF" +
                           kExpectedClip);
    }
    return Of(ReadBvh(file, limits));
  }
  const auto bytes = opened.value().Read(0, kMaxBytes);
  if (!bytes.ok()) return bytes.status();
  return ParseAnyClip(bytes.value(), file.string(), limits, joints);
}

Result<BoundClip> BindAnyClip(const AnyClip& clip, const BindOptions& options) {
  if (!clip.is_gltf) return BindClip(clip.clip, options);
  if (options.rest.kind != RestPose::Kind::kAuto || options.up) {
    return Status::Error(
        "found a rest pose or an up axis by hand, expected auto for both: glTF states them");
  }
  auto binding = BindGltf(clip, options.dialect);
  if (!binding.ok()) return binding.status();
  const bool named = options.dialect != "auto" && !options.dialect.empty() && !clip.skeleton.t_pose;
  rig::HumanoidMap map{binding.value().spec().source_joint, 1, "by its nodes", ""};
  return BoundClip{std::move(binding.value()),
                   named                  ? options.dialect
                   : clip.skeleton.t_pose ? "vrm"
                                          : "gltf",
                   "", std::move(map), ""};
}

Clip AsBvh(Clip clip, const rig::Binding& binding) {
  Clip straight = WithTPose(std::move(clip), binding);
  straight.skeleton.offsets[0].setZero();
  for (std::string& name : straight.skeleton.names) {
    std::replace_if(
        name.begin(), name.end(), [](char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }, '_');
  }
  return straight;
}

}  // namespace styled::clip
