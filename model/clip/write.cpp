#include "model/clip/write.h"

#include <array>
#include <cctype>

#include "model/clip/glb_write.h"
#include "model/clip/vrma_write.h"

namespace styled::clip {
namespace {

Status WriteMotionAsBvh(const Motion& motion, const std::filesystem::path& file) {
  if (motion.times_s.empty()) return WriteBvh(motion, file);
  return Status::Error(file.string() + ": found a time per frame, expected a constant rate");
}

constexpr std::array kFormats{
    Format{".bvh", "BVH file to write, in the rig's units and axes", true, WriteMotionAsBvh},
    Format{".glb", "glTF 2.0 binary to write: metres, Y up", false, WriteGlb},
    Format{".vrma", "VRM animation to write, for any VRM avatar: the body without fingers and face",
           false, WriteVrma},
};

}  // namespace

std::span<const Format> Formats() { return kFormats; }

std::string FormatNames() {
  std::string names;
  for (const Format& format : kFormats) {
    names.append(names.empty() ? "" : ", ").append(format.extension);
  }
  return names;
}

Result<const Format*> FindFormat(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const Format& format : kFormats) {
    if (format.extension == extension) return &format;
  }
  return Status::Error(file.string() + ": found " +
                       (extension.empty() ? "no extension" : "extension " + extension) +
                       ", expected one of " + FormatNames());
}

Status Write(const std::filesystem::path& file, const Motion& motion) {
  const auto format = FindFormat(file);
  return format.ok() ? format.value()->write(motion, file) : format.status();
}

}  // namespace styled::clip
