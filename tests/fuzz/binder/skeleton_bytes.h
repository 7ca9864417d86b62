#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "model/clip/clip.h"

// A clip as the bytes of a fuzz input: the number of joints; per joint its parent, its offset in
// millimetres (three int16, little-endian), the length of its name, the name; then frames of four
// int8 per joint, a quaternion. Any bytes are a clip of at least one joint; missing ones are 0.
namespace styled::fuzz {

class ByteReader {
 public:
  explicit ByteReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  std::uint8_t Byte() {
    if (bytes_.empty()) return 0;
    const std::uint8_t byte = bytes_.front();
    bytes_ = bytes_.subspan(1);
    return byte;
  }
  float Metres() {
    const int low = Byte();
    return 1e-3F * static_cast<float>(static_cast<std::int16_t>(low | Byte() << 8));
  }
  std::string Text(std::size_t size) {
    std::string text;
    for (std::size_t i = 0; i < size && !bytes_.empty(); ++i) text += static_cast<char>(Byte());
    return text;
  }
  bool done() const { return bytes_.empty(); }

 private:
  std::span<const std::uint8_t> bytes_;
};

inline clip::Clip ReadClip(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kMostFrames = 12;
  ByteReader in(bytes);
  clip::Clip clip;
  const int joints = std::max<int>(1, in.Byte());
  for (int j = 0; j < joints; ++j) {
    const int parent = in.Byte();
    clip.skeleton.parents.push_back(j == 0 ? -1 : parent % j);
    const float x = in.Metres(), y = in.Metres(), z = in.Metres();
    clip.skeleton.offsets.emplace_back(x, y, z);
    clip.skeleton.names.push_back(in.Text(in.Byte() % 32));
  }
  do {
    rig::RigPose frame(clip.skeleton);
    for (rig::Quat& rotation : frame.rotations) {
      const auto number = [&in] { return static_cast<float>(static_cast<std::int8_t>(in.Byte())); };
      const float w = number(), x = number(), y = number(), z = number();
      const rig::Quat q(w, x, y, z);
      rotation = q.norm() > 0 ? q.normalized() : rig::Quat::Identity();
    }
    clip.frames.push_back(frame);
  } while (!in.done() && clip.frames.size() < kMostFrames);
  return clip;
}

inline std::vector<std::byte> WriteClip(const clip::Clip& clip) {
  std::vector<std::byte> bytes;
  const auto add = [&bytes](int value) { bytes.push_back(static_cast<std::byte>(value)); };
  add(clip.skeleton.joint_count());
  for (std::size_t j = 0; j < clip.skeleton.names.size(); ++j) {
    add(std::max(clip.skeleton.parents[j], 0));
    for (const float metres : clip.skeleton.offsets[j]) {
      const auto value = static_cast<std::int16_t>(std::clamp(metres * 1e3F, -3e4F, 3e4F));
      add(value & 0xFF);
      add(value >> 8 & 0xFF);
    }
    const std::string name = clip.skeleton.names[j].substr(0, 31);
    add(static_cast<int>(name.size()));
    for (const char c : name) add(c);
  }
  for (const rig::RigPose& frame : clip.frames) {
    for (const rig::Quat& q : frame.rotations) {
      for (const float value : {q.w(), q.x(), q.y(), q.z()}) add(static_cast<int>(value * 127));
    }
  }
  return bytes;
}

}  // namespace styled::fuzz
