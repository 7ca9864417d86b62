// Fuzzes styled::vmc: the input as one OSC datagram (read, decoded, written again), and as a
// sequence of datagrams for the assembler, each preceded by two bytes: the milliseconds since the
// previous one, and a quarter of its size. Seeds: the unit tests' case tables.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <span>
#include <vector>

#include "proto/rigs/vmc/assembler.h"
#include "proto/rigs/vmc/device.h"
#include "proto/rigs/vmc/packer.h"

namespace {

namespace vmc = styled::vmc;
namespace osc = styled::vmc::osc;
using Span = std::span<const std::byte>;

void Require(bool condition) {
  if (!condition) std::abort();
}

// A decoded message is written with the same meaning, and read again.
void CheckMessage(const osc::Message& raw) {
  vmc::Message message;
  if (Decode(raw, message) != vmc::DecodeResult::kOk) return;
  std::vector<std::byte> buffer(raw.bytes.size() + 64);
  osc::Writer writer(buffer);
  std::visit(
      [&writer](const auto& decoded) {
        if constexpr (requires { vmc::Put(decoded, writer); }) vmc::Put(decoded, writer);
      },
      message);
  Require(writer.ok());
  osc::Reader reader({buffer.data(), writer.size()});
  osc::Message again_raw;
  Require(reader.Next(again_raw) == osc::Reader::Step::kMessage);
  vmc::Message again;
  Require(Decode(again_raw, again) == vmc::DecodeResult::kOk);
  Require(again.index() == message.index());
}

// The same for devices.
void CheckDevice(const osc::Message& raw) {
  vmc::Device device;
  if (Decode(raw, device) != vmc::DecodeResult::kOk) return;
  std::vector<std::byte> buffer(raw.bytes.size() + 64);
  osc::Writer writer(buffer);
  Put(device, writer);
  Require(writer.ok());
  osc::Reader reader({buffer.data(), writer.size()});
  osc::Message again_raw;
  Require(reader.Next(again_raw) == osc::Reader::Step::kMessage);
  vmc::Device again;
  Require(Decode(again_raw, again) == vmc::DecodeResult::kOk);
  Require(again.kind == device.kind && again.serial == device.serial);
}

void CheckDatagram(Span bytes) {
  osc::Reader reader(bytes);
  osc::Message message;
  while (reader.Next(message) == osc::Reader::Step::kMessage) {
    Require(message.bytes.data() >= bytes.data());
    Require(message.bytes.data() + message.bytes.size() <= bytes.data() + bytes.size());
    CheckMessage(message);
    CheckDevice(message);
  }
  Require(reader.result() == osc::Check(bytes));
  if (reader.result() != osc::Result::kOk) return;
  std::vector<std::byte> copy(bytes.size());
  osc::Writer writer(copy);
  writer.Raw(bytes);
  Require(writer.ok() && std::ranges::equal(copy, bytes));
}

// A packed frame reads back the same.
void CheckPacking(const vmc::Frame& frame) {
  std::vector<vmc::Bone> bones;
  std::vector<vmc::Blend> blends;
  std::vector<vmc::Thru> thrus;
  for (int bone = 0; bone < vmc::kBoneCount; ++bone) {
    const auto at = static_cast<std::size_t>(bone);
    if (vmc::Has(frame.bones, bone)) {
      bones.push_back({vmc::kBones[at].name, frame.transforms[at]});
    }
  }
  for (std::size_t i = 0; i < frame.blend_count; ++i) {
    blends.push_back({frame.blends[i].name(), frame.blends[i].value});
  }
  for (std::size_t i = 0; i < frame.thru_count; ++i) thrus.push_back({frame.thrus[i].bytes()});
  vmc::Packed packed;
  packed.bones = bones;
  packed.blends = blends;
  packed.thrus = thrus;
  vmc::Packer packer(packed);
  std::vector<std::byte> buffer(vmc::Packer::kMaxPacketSize);
  std::size_t messages = 0;
  while (const std::size_t size = packer.Next(buffer)) {
    osc::Reader reader({buffer.data(), size});
    osc::Message message;
    while (reader.Next(message) == osc::Reader::Step::kMessage) ++messages;
    Require(reader.result() == osc::Result::kOk);
  }
  Require(messages == 4 + bones.size() + blends.size() + thrus.size());
}

void CheckFrame(const vmc::Frame& frame, float& last_time_s) {
  Require((frame.bones & ~vmc::kAllBones) == 0);
  Require((frame.missing & frame.bones) == 0);
  Require((frame.stale & ~frame.missing) == 0);
  if (frame.has_time) {
    Require(frame.restarted || frame.time_s > last_time_s);
    last_time_s = frame.time_s;
  }
  for (std::size_t i = 0; i < frame.blend_count; ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      Require(frame.blends[i].name() != frame.blends[k].name());
    }
  }
  CheckPacking(frame);
}

void CheckSequence(Span bytes) {
  const auto assembler = std::make_unique<vmc::Assembler>();
  float last_time_s = -1e30F;
  std::int64_t now_ns = 0;
  while (bytes.size() > 2) {
    now_ns += std::to_integer<std::int64_t>(bytes[0]) * 1'000'000;
    const auto wanted = 4 * std::to_integer<std::size_t>(bytes[1]);
    bytes = bytes.subspan(2);
    const Span part = bytes.first(std::min(wanted, bytes.size()));
    bytes = bytes.subspan(part.size());
    if (assembler->Flush(now_ns)) CheckFrame(assembler->frame(), last_time_s);
    // An exact-size copy, so that ASan detects reads past the end.
    const std::vector<std::byte> datagram(part.begin(), part.end());
    if (assembler->Begin(datagram, now_ns) != osc::Result::kOk) continue;
    while (assembler->Next()) CheckFrame(assembler->frame(), last_time_s);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  CheckDatagram(bytes);
  CheckSequence(bytes);
  return 0;
}
