// Fuzzes styled::natnet. The input is the bitstream's major and minor number, then a packet, which
// is decoded according to its id, whether or not its header has the right size. A decoded packet
// must encode to one that decodes to the same. Seeds: the unit test's case tables.
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "proto/rigs/natnet/dialogue.h"
#include "proto/rigs/natnet/frame.h"
#include "proto/rigs/natnet/model.h"

namespace {

using namespace styled::natnet;

void Require(bool condition) {
  if (!condition) std::abort();
}

template <typename T>
bool Same(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;  // NaNs too
}

std::vector<std::byte>& Buffer() {
  static std::vector<std::byte> buffer(kMaxPacketSize);
  return buffer;
}

// The payload of the packet encoded last.
std::span<const std::byte> Encoded(std::size_t size) {
  Packet packet;
  Require(DecodePacket(std::span(Buffer()).first(size), packet) == DecodeResult::kOk);
  return packet.payload;
}

void CheckFrame(std::span<const std::byte> payload, Version version) {
  static Frame frame, again;
  if (DecodeFrame(payload, version, frame) != DecodeResult::kOk) return;
  const std::size_t size = EncodeFrame(frame, version, Buffer());
  Require(size > 0 && size <= payload.size() + kHeaderSize);
  Require(DecodeFrame(Encoded(size), version, again) == DecodeResult::kOk);
  Require(again.number == frame.number && again.skeleton_count == frame.skeleton_count &&
          Same(again.timestamp_s, frame.timestamp_s) && again.timecode == frame.timecode &&
          again.params == frame.params && again.transmit_ticks == frame.transmit_ticks);
  for (std::size_t s = 0; s < frame.skeleton_count; ++s) {
    const Skeleton &a = frame.skeletons[s], &b = again.skeletons[s];
    Require(a.id == b.id && a.bone_count == b.bone_count);
    for (std::size_t i = 0; i < a.bone_count; ++i) {
      const Bone &c = a.bones[i], &d = b.bones[i];
      Require(c.id == d.id && Same(c.position_m, d.position_m) && Same(c.rotation, d.rotation) &&
              c.tracked == d.tracked);
    }
  }
}

void CheckModel(std::span<const std::byte> payload, Version version) {
  static Model model, again;
  if (DecodeModel(payload, version, model) != DecodeResult::kOk) return;
  const std::size_t size = EncodeModel(model, version, Buffer());
  Require(size > 0 && size <= payload.size() + kHeaderSize);
  Require(DecodeModel(Encoded(size), version, again) == DecodeResult::kOk);
  Require(again.skeleton_count == model.skeleton_count && again.complete);
  for (std::size_t s = 0; s < model.skeleton_count; ++s) {
    const SkeletonDescription &a = model.skeletons[s], &b = again.skeletons[s];
    Require(a.id == b.id && a.name == b.name && a.bone_count == b.bone_count);
    for (std::size_t i = 0; i < a.bone_count; ++i) {
      const BoneDescription &c = a.bones[i], &d = b.bones[i];
      Require(c.id == d.id && c.parent == d.parent && c.name == d.name &&
              Same(c.offset_m, d.offset_m));
    }
  }
}

void CheckDialogue(MessageId id, std::span<const std::byte> payload) {
  ServerInfo info;
  Connect connect;
  Echo echo;
  switch (id) {
    case MessageId::kServerInfo:
      if (DecodeServerInfo(payload, info) != DecodeResult::kOk) return;
      Require(EncodeServerInfo(info, Buffer()) <= payload.size() + kHeaderSize);
      return;
    case MessageId::kConnect:
      DecodeConnect(payload, connect);
      Require(EncodeConnect(connect, Buffer()) > 0);
      return;
    case MessageId::kRequest:
      Require(DecodeRequest(payload).size() <= payload.size());
      return;
    case MessageId::kEchoRequest:
      Require((DecodeEchoRequest(payload, echo) == DecodeResult::kOk) == (payload.size() == 8));
      return;
    default:
      return;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2 + kHeaderSize || size > 2 + kMaxPacketSize) return 0;
  const Version version{data[0], data[1]};
  const auto bytes = std::as_bytes(std::span(data, size)).subspan(2);
  Packet packet;
  if (DecodePacket(bytes, packet) != DecodeResult::kOk) {
    packet.id = MessageId{std::to_integer<std::uint16_t>(bytes[0])};
    packet.payload = bytes.subspan(kHeaderSize);
  }
  if (packet.id == MessageId::kFrameOfData) {
    CheckFrame(packet.payload, version);
  } else if (packet.id == MessageId::kModelDef) {
    CheckModel(packet.payload, version);
  } else {
    CheckDialogue(packet.id, packet.payload);
  }
  return 0;
}
