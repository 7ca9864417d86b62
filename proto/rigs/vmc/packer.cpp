#include "proto/rigs/vmc/packer.h"

#include <algorithm>
#include <cassert>

namespace styled::vmc {
namespace {

constexpr std::size_t kBundleHead = 16, kSizeField = 4;
// Blend/Apply, OK and T, each with its size field.
constexpr std::size_t kEnd = kSizeField + 28 + kSizeField + 36 + kSizeField + 20;
constexpr std::size_t kRoom = Packer::kMaxPacketSize - kBundleHead;

constexpr std::size_t PaddedText(std::size_t size) noexcept { return (size + 4) & ~std::size_t{3}; }

std::size_t Size(const Blend& blend) noexcept {
  return kSizeField + 20 + 4 + PaddedText(blend.name.size()) + 4;
}
std::size_t Size(const Device& device) noexcept {
  return kSizeField + 20 + 12 + PaddedText(device.serial.size()) + 28;
}
std::size_t Size(const Thru& thru) noexcept { return kSizeField + thru.bytes.size(); }

// Writes what fits into `room` bytes and removes it from the front of `list`.
template <typename T>
void PutWhatFits(std::span<const T>& list, std::size_t& room, osc::Writer& writer) noexcept {
  for (; !list.empty(); list = list.subspan(1)) {
    const std::size_t size = Size(list.front());
    if (size > kRoom) continue;
    if (size > room) return;
    room -= size;
    Put(list.front(), writer);
  }
}

template <typename T>
std::size_t TotalSize(std::span<const T> list) noexcept {
  std::size_t total = 0;
  for (const T& message : list) total += Size(message) > kRoom ? 0 : Size(message);
  return total;
}

}  // namespace

std::size_t Packer::NextBones(std::span<std::byte> out) noexcept {
  osc::Writer writer(out);
  writer.BeginBundle();
  if (!root_sent_) Put(frame_.root, writer);
  root_sent_ = true;
  const auto bones = frame_.bones.first(std::min(frame_.bones.size(), kMaxBonesPerPacket));
  frame_.bones = frame_.bones.subspan(bones.size());
  for (const Bone& bone : bones) Put(bone, writer);
  writer.EndBundle();
  return writer.ok() ? writer.size() : 0;
}

std::size_t Packer::NextRest(std::span<std::byte> out) noexcept {
  finished_ =
      TotalSize(frame_.blends) + TotalSize(frame_.thrus) + TotalSize(frame_.devices) + kEnd <=
      kRoom;
  osc::Writer writer(out);
  writer.BeginBundle();
  std::size_t room = finished_ ? kRoom - kEnd : kRoom;
  PutWhatFits(frame_.thrus, room, writer);
  PutWhatFits(frame_.blends, room, writer);
  PutWhatFits(frame_.devices, room, writer);
  if (finished_) {
    Put(BlendApply(), writer);
    Put(frame_.available, writer);
    Put(Time{frame_.time_s}, writer);
  }
  writer.EndBundle();
  return writer.ok() ? writer.size() : 0;
}

std::size_t Packer::Next(std::span<std::byte> out) noexcept {
  assert(out.size() >= kMaxPacketSize);
  if (!root_sent_ || !frame_.bones.empty()) return NextBones(out);
  return finished_ ? 0 : NextRest(out);
}

}  // namespace styled::vmc
